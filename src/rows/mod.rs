//! Rows: one measured cell each, as CSV. What the laboratory writes and the report reads; nothing else passes between them.

mod accuracy;
mod compare;
mod decisions;
mod experiments;
mod growth;
mod store;

pub use accuracy::AccuracyRow;
pub use compare::CompareRow;
pub use decisions::DecisionRow;
pub use experiments::{Experiment, ExperimentRow};
pub use growth::{ScalingRow, WorkRow};
pub use store::{Row, RowError, RowFile, read, read_file, write_whole};

use serde::{Deserialize, Serialize};

/// How a cell ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Finished and verified.
    Ok,
    /// Stopped by, or known to pass, its budget; no figure.
    Capped,
    /// Capped, with a time projected from counted work.
    Projected,
    /// Failed its verification; carries no figure.
    Error,
}

impl Status {
    /// Its name in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Capped => "capped",
            Self::Projected => "projected",
            Self::Error => "error",
        }
    }
}

/// The thesis' two ways to build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, PartialOrd, Ord, Hash)]
#[serde(rename_all = "kebab-case")]
pub enum Construction {
    /// Exhaustive multi-plane search.
    TopDown,
    /// Naive agglomerative clustering, then collapse.
    BottomUp,
}

impl Construction {
    /// The builder's id on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::TopDown => "top-down",
            Self::BottomUp => "bottom-up",
        }
    }
}

/// The thesis' three lighting cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, PartialOrd, Ord, Hash)]
#[serde(rename_all = "lowercase")]
pub enum Lighting {
    /// Depth 1, opacity 0: primary rays only (Tables 4 and 5).
    Primary,
    /// Depth 2, opacity 0: one mirror reflection per hit (Tables 6 and 7).
    Reflection,
    /// Depth 1, opacity 0.5: the ray goes on behind each hit (Tables 8 and 9).
    Opacity,
}

impl Lighting {
    /// All three, in the order of the tables.
    pub const ALL: [Self; 3] = [Self::Primary, Self::Reflection, Self::Opacity];

    /// Its name in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Reflection => "reflection",
            Self::Opacity => "opacity",
        }
    }
}

/// Median and spread of repeated measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The middle one.
    pub median: f64,
    /// The least.
    pub min: f64,
    /// The greatest.
    pub max: f64,
    /// How many.
    pub runs: usize,
}

/// One build: `rows/builds.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuildRow {
    /// `published`, `text` or `walter`.
    pub preset: String,
    /// Scene, such as `thesis:tiny`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles: a file may change under its name.
    pub scene_hash: String,
    /// Top-down or bottom-up.
    pub construction: Construction,
    /// 2, 4 or 8.
    pub arity: usize,
    /// `literal` or `exact`.
    pub engine: String,
    /// How it ended.
    pub status: Status,
    /// Seconds the cell was allowed, empty for no limit.
    pub budget_s: Option<f64>,
    /// Median build time in milliseconds, whole build; warm, unless `runs` is 1 because the first took long.
    pub build_ms: Option<f64>,
    /// Least of the runs.
    pub build_ms_min: Option<f64>,
    /// Greatest of the runs.
    pub build_ms_max: Option<f64>,
    /// How many runs.
    pub runs: usize,
    /// Projected build time in milliseconds where capped.
    pub projected_ms: Option<f64>,
    /// What the projection rests on, or why the cell failed; empty where there is nothing to say.
    pub note: String,
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
    /// Surface area heuristic, c_trav = c_isect = 1.
    pub sah: Option<f64>,
    /// End-point overlap (Aila, Karras and Laine 2013).
    pub epo: Option<f64>,
    /// Bytes of nodes and ids.
    pub bytes: Option<usize>,
    /// Combinations evaluated.
    pub combinations: u64,
    /// Box unions done.
    pub box_unions: u64,
    /// Box unions that the thesis' program would have done.
    pub original_unions: u64,
    /// Cluster distances computed.
    pub pair_distances: u64,
    /// Searches for a nearest cluster.
    pub nearest_searches: u64,
    /// Transitions of a dynamic program (engine `exact`, top-down).
    pub dp_steps: u64,
    /// Entries of search structures looked at (engine `exact`, bottom-up).
    pub search_visits: u64,
    /// Nodes that the original's kd-tree would have visited (bottom-up `published`, arity 2, where the replay fits its
    /// budget).
    pub original_visits: Option<u64>,
    /// List entries that the original would have passed in sorting what its queries found.
    pub original_list_steps: Option<u64>,
    /// Nodes that rule Q8 applied to.
    pub q8_nodes: u64,
    /// Triangles that stand in more than one leaf, by rule Q8: no builder of the study has spatial splits.
    pub q8_duplicated: Option<usize>,
    /// Triangles some leaf of which lies outside their box, so that rays can miss them (rule Q8).
    pub q8_hidden: Option<usize>,
    /// Threads used.
    pub threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format, such as `0.1.0+rows2`.
    pub version: String,
    /// Commit of the program, with a fingerprint where its sources are not that commit's.
    pub commit: String,
}

/// One traversal: `rows/traces.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceRow {
    /// `published` or `text`.
    pub preset: String,
    /// Scene, such as `thesis:tiny`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Top-down or bottom-up.
    pub construction: Construction,
    /// 2, 4 or 8.
    pub arity: usize,
    /// Lighting case.
    pub lighting: Lighting,
    /// How it ended; `capped` where there was no tree.
    pub status: Status,
    /// Median time in microseconds per pixel.
    pub us_per_pixel: Option<f64>,
    /// Least of the runs.
    pub us_per_pixel_min: Option<f64>,
    /// Greatest of the runs.
    pub us_per_pixel_max: Option<f64>,
    /// How many runs.
    pub runs: usize,
    /// Entered nodes, inner and leaf, per pixel.
    pub nodes_per_pixel: Option<f64>,
    /// Box tests per pixel.
    pub box_tests_per_pixel: Option<f64>,
    /// Triangle tests per pixel.
    pub triangle_tests_per_pixel: Option<f64>,
    /// Fraction of the pixels whose primary ray hits something.
    pub hit_fraction: Option<f64>,
    /// Rays cast over the whole picture.
    pub rays: Option<u64>,
    /// See-through chains cut at 100.
    pub cut: Option<u64>,
    /// Hash of the tree traced.
    pub tree_hash: Option<String>,
    /// Why the cell failed or was capped; empty where there is nothing to say.
    pub note: String,
    /// Threads used.
    pub threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format, such as `0.1.0+rows2`.
    pub version: String,
    /// Commit of the program, with a fingerprint where its sources are not that commit's.
    pub commit: String,
}

impl BuildRow {
    /// What identifies the builder and its options, whatever the scene.
    pub fn build_key(&self) -> (&str, Construction, usize, &str) {
        (&self.preset, self.construction, self.arity, &self.engine)
    }
}

impl Row for BuildRow {
    const FILE: &'static str = "builds.csv";

    fn key(&self) -> String {
        format!("{} {} {} k={} {}", self.preset, self.scene, self.construction.id(), self.arity, self.engine)
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}

impl Row for TraceRow {
    const FILE: &'static str = "traces.csv";

    fn key(&self) -> String {
        format!("{} {} {} k={} {}", self.preset, self.scene, self.construction.id(), self.arity, self.lighting.id())
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}
