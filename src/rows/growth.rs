//! Rows about growth: times and work against size, and the work of the thesis' program in closed form.

use super::{Construction, Row, Status};
use serde::{Deserialize, Serialize};

/// One build, or one collapse, at one size: `rows/scaling.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScalingRow {
    /// Scene, such as `gen:spheres:1000`.
    pub scene: String,
    /// What scenes of a series share, such as `gen:spheres`.
    pub family: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles.
    pub scene_hash: String,
    /// A builder's id, or `collapse`: the binary tree of `bottom-up` made wider, the building left out.
    pub builder: String,
    /// Reading of the thesis.
    pub preset: String,
    /// Children per inner node.
    pub arity: usize,
    /// `exact` or `literal`; empty for `collapse`, which has one.
    pub engine: String,
    /// How it ended.
    pub status: Status,
    /// Seconds that it was allowed.
    pub budget_s: Option<f64>,
    /// Median time in milliseconds.
    pub build_ms: Option<f64>,
    /// Least of the runs.
    pub build_ms_min: Option<f64>,
    /// Greatest of the runs.
    pub build_ms_max: Option<f64>,
    /// How many runs.
    pub runs: usize,
    /// Projected time in milliseconds where capped.
    pub projected_ms: Option<f64>,
    /// What the projection rests on, or why there is no figure; empty where there is nothing to say.
    pub note: String,
    /// Canonical hash of the tree.
    pub tree_hash: Option<String>,
    /// Combinations evaluated.
    pub combinations: u64,
    /// Costs of one child computed.
    pub child_costs: u64,
    /// Box unions done.
    pub box_unions: u64,
    /// Box unions that the thesis' program would have done, counted at work (literal top-down engines).
    pub original_unions: u64,
    /// Cluster distances computed.
    pub pair_distances: u64,
    /// Searches for a nearest cluster.
    pub nearest_searches: u64,
    /// Merges of two clusters.
    pub merges: u64,
    /// Transitions of a dynamic program.
    pub dp_steps: u64,
    /// Entries of search structures looked at.
    pub search_visits: u64,
    /// Combinations or distances of a literal build by the model that projections use: it knows the size alone.
    pub model_steps: Option<f64>,
    /// Combinations or distances of a literal build of this very tree, in closed form per node.
    pub literal_steps: Option<f64>,
    /// Box unions that the thesis' program would have done for this very tree, in closed form per node.
    pub literal_unions: Option<f64>,
    /// Threads used.
    pub threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format.
    pub version: String,
    /// Commit of the program.
    pub commit: String,
}

/// What the thesis' program had to do for one of its builds: `rows/work.csv`. Nothing here is a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkRow {
    /// Reading of the thesis.
    pub preset: String,
    /// Scene, such as `thesis:tiny`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles.
    pub scene_hash: String,
    /// Top-down or bottom-up.
    pub construction: Construction,
    /// 2, 4 or 8; bottom-up always 2: the collapse adds next to nothing.
    pub arity: usize,
    /// The tree that the work belongs to.
    pub tree_hash: Option<String>,
    /// Combinations or distances by the model that knows the size alone.
    pub model_steps: f64,
    /// Combinations or distances in closed form per node of the tree.
    pub literal_steps: Option<f64>,
    /// Triangles times combinations, in closed form per node of the tree: the program's box unions.
    pub literal_unions: Option<f64>,
    /// One search of the program's kd-tree in so many was replayed, the rest taken by proportion (bottom-up `published`).
    pub original_every: Option<u64>,
    /// Searches of the program's kd-tree.
    pub original_queries: Option<u64>,
    /// Nodes that these searches would have visited.
    pub original_visits: Option<u64>,
    /// Entries of sorted lists that they would have passed.
    pub original_list_steps: Option<u64>,
    /// All elementary steps of the kd-tree together: visits, list walks, insertions, removals.
    pub original_steps: Option<u64>,
    /// Seconds that the replay and the tree were allowed, empty for no limit.
    pub budget_s: Option<f64>,
    /// Why a count is not there; empty where all are.
    pub note: String,
    /// Crate version and row format.
    pub version: String,
    /// Commit of the program.
    pub commit: String,
}

impl ScalingRow {
    /// What identifies the series: everything but the size.
    pub fn series(&self) -> (&str, &str, &str, usize, &str) {
        (&self.family, &self.builder, &self.preset, self.arity, &self.engine)
    }
}

impl Row for ScalingRow {
    const FILE: &'static str = "scaling.csv";

    fn key(&self) -> String {
        format!("{} {} {} k={} {}", self.preset, self.scene, self.builder, self.arity, self.engine)
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}

impl Row for WorkRow {
    const FILE: &'static str = "work.csv";

    fn key(&self) -> String {
        format!("{} {} {} k={}", self.preset, self.scene, self.construction.id(), self.arity)
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}
