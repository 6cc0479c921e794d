//! Rows of builders side by side.

use super::{Row, Spread, Status};
use serde::{Deserialize, Serialize};

/// One contestant of a comparison, a builder with its steps or a tree from a file, on one scene: `rows/compare.csv`.
///
/// Contestants of a scene are measured in turn, in one run; a row that fails its verification has no figures. The columns of
/// `primary_` and `diffuse_` are about the two ray sets of the scene; figures are per ray.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompareRow {
    /// Scene, such as `gen:spheres:89000`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles: a file may change under its name.
    pub scene_hash: String,
    /// Builder and steps as `-b` takes them, or the path of a tree.
    pub recipe: String,
    /// The builder's id, or `file`.
    pub builder: String,
    /// Reading of the thesis; empty for modern builders.
    pub preset: String,
    /// `exact` or `literal`; empty for modern builders.
    pub engine: String,
    /// The most children of a node.
    pub arity: usize,
    /// The most triangles that a leaf may hold.
    pub leaf_limit: usize,
    /// How it ended.
    pub status: Status,
    /// Seconds that one build was allowed.
    pub budget_s: Option<f64>,
    /// Why there is no figure, or what is to be known about one; else empty.
    pub note: String,
    /// Median build time in milliseconds, from triangles to tree.
    pub build_ms: Option<f64>,
    /// Least of the runs.
    pub build_ms_min: Option<f64>,
    /// Greatest of the runs.
    pub build_ms_max: Option<f64>,
    /// How many runs.
    pub build_runs: usize,
    /// Projected build time in milliseconds where capped.
    pub projected_ms: Option<f64>,
    /// Canonical hash of the tree.
    pub tree_hash: Option<String>,
    /// Inner nodes.
    pub inner: Option<usize>,
    /// Leaves, empty ones included.
    pub leaves: Option<usize>,
    /// Leaves without triangles.
    pub empty: Option<usize>,
    /// Children per inner node.
    pub avg_degree: Option<f64>,
    /// Edges from the root to the deepest leaf.
    pub max_depth: Option<usize>,
    /// Triangles in the fullest leaf.
    pub max_leaf: Option<usize>,
    /// Triangles over all leaves, each as often as it stands there.
    pub references: Option<usize>,
    /// Triangles that stand in more than one leaf.
    pub duplicated: Option<usize>,
    /// Triangles that rays can miss (rule Q8).
    pub hidden: Option<usize>,
    /// Surface area heuristic, c_trav = c_isect = 1.
    pub sah: Option<f64>,
    /// End-point overlap (Aila, Karras and Laine 2013).
    pub epo: Option<f64>,
    /// Leaf count variability (the same), over diffuse rays.
    pub lcv: Option<f64>,
    /// Bytes of nodes and ids.
    pub bytes: Option<usize>,
    /// The most bytes that a build holds beyond the triangles, boxes and tree included.
    pub peak_bytes: Option<usize>,
    /// Work of the build, counted apart: `kind=number`, a space between two.
    pub counters: String,
    /// Tracing kernel.
    pub kernel: String,
    /// Pixels that primary rays go through, and diffuse ones start from, such as `512x512`.
    pub pixels: String,
    /// Primary rays; fewer than pixels where a pass would take minutes.
    pub primary_rays: usize,
    /// Nodes entered, inner and leaf.
    pub primary_nodes: Option<f64>,
    /// Boxes tested.
    pub primary_box_tests: Option<f64>,
    /// Triangles tested.
    pub primary_tri_tests: Option<f64>,
    /// Median of million rays per second.
    pub primary_mrays: Option<f64>,
    /// Least of the runs.
    pub primary_mrays_min: Option<f64>,
    /// Greatest of the runs.
    pub primary_mrays_max: Option<f64>,
    /// How many runs.
    pub primary_runs: usize,
    /// Hash of what the rays hit: the same for every tree of the scene.
    pub primary_hit_hash: Option<String>,
    /// Diffuse rays: one from the hit of every primary ray that has one.
    pub diffuse_rays: usize,
    /// Nodes entered, inner and leaf.
    pub diffuse_nodes: Option<f64>,
    /// Boxes tested.
    pub diffuse_box_tests: Option<f64>,
    /// Triangles tested.
    pub diffuse_tri_tests: Option<f64>,
    /// Median of million rays per second.
    pub diffuse_mrays: Option<f64>,
    /// Least of the runs.
    pub diffuse_mrays_min: Option<f64>,
    /// Greatest of the runs.
    pub diffuse_mrays_max: Option<f64>,
    /// How many runs.
    pub diffuse_runs: usize,
    /// Hash of what the rays hit.
    pub diffuse_hit_hash: Option<String>,
    /// Threads that the build used.
    pub threads: usize,
    /// Threads that traced.
    pub trace_threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format.
    pub version: String,
    /// Commit of the program.
    pub commit: String,
}

impl CompareRow {
    /// The recipe with its reading, such as `top-down+leaves text`: its name where one engine stands.
    pub fn name(&self) -> String {
        let engine = if self.engine == "literal" { " literal" } else { "" };
        let preset = if self.preset.is_empty() { String::new() } else { format!(" {}", self.preset) };
        format!("{}{preset}{engine}", self.recipe)
    }

    /// Build times, where there are any.
    pub fn build(&self) -> Option<Spread> {
        spread(self.build_ms, self.build_ms_min, self.build_ms_max, self.build_runs)
    }

    /// Million primary rays per second, where they were traced.
    pub fn primary(&self) -> Option<Spread> {
        spread(self.primary_mrays, self.primary_mrays_min, self.primary_mrays_max, self.primary_runs)
    }

    /// Million diffuse rays per second, where they were traced.
    pub fn diffuse(&self) -> Option<Spread> {
        spread(self.diffuse_mrays, self.diffuse_mrays_min, self.diffuse_mrays_max, self.diffuse_runs)
    }

    /// The kinds of counted work with their numbers.
    pub fn work(&self) -> impl Iterator<Item = (&str, u64)> {
        self.counters.split_whitespace().filter_map(|pair| {
            let (kind, number) = pair.split_once('=')?;
            Some((kind, number.parse().ok()?))
        })
    }
}

fn spread(median: Option<f64>, min: Option<f64>, max: Option<f64>, runs: usize) -> Option<Spread> {
    Some(Spread { median: median?, min: min?, max: max?, runs })
}

impl Row for CompareRow {
    const FILE: &'static str = "compare.csv";

    fn key(&self) -> String {
        format!("{}, {}, arity {}, leaves of {}", self.scene, self.name(), self.arity, self.leaf_limit)
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}
