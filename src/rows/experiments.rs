//! Rows of experiments: what the thesis' findings are put to the test with.

use super::{Lighting, Row, Status};
use serde::{Deserialize, Serialize};

/// An experiment on the thesis' findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Experiment {
    /// Times per pixel with the program's linear lookup of every triangle, and without.
    Lookup,
    /// Rule Q8 on and off: nodes per pixel, triangles lost, pixels that are wrong for it.
    RuleQ8,
    /// Pixels at which the traversal that stops at the first leaf with a hit does not see the closest one.
    FirstLeaf,
    /// The collapse on its own, against the build of the binary tree.
    Collapse,
    /// The thesis' trees under secondary rays that start where they should.
    Origins,
    /// Top-down trees of higher arity with as many candidates as binary ones, against k parts and k slabs of a grid.
    Conjecture,
    /// How many candidates are enough.
    Candidates,
    /// What the text leaves open, as a grid of readings.
    Readings,
}

impl Experiment {
    /// All of them, in the order in which they are made.
    pub const ALL: [Self; 8] = [
        Self::Lookup,
        Self::RuleQ8,
        Self::FirstLeaf,
        Self::Collapse,
        Self::Origins,
        Self::Conjecture,
        Self::Candidates,
        Self::Readings,
    ];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Lookup => "lookup",
            Self::RuleQ8 => "rule-q8",
            Self::FirstLeaf => "first-leaf",
            Self::Collapse => "collapse",
            Self::Origins => "origins",
            Self::Conjecture => "conjecture",
            Self::Candidates => "candidates",
            Self::Readings => "readings",
        }
    }

    /// What it does, in one line.
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Lookup => "time per pixel with and without the program's linear lookup of every triangle",
            Self::RuleQ8 => "arity 8 with and without rule Q8: nodes, triangles lost, wrong pixels",
            Self::FirstLeaf => {
                "pixels at which the first leaf with a hit does not hold the closest one, counted and pictured"
            }
            Self::Collapse => "the time of the collapse against that of the binary build",
            Self::Origins => "what secondary rays cost when they start where they should",
            Self::Conjecture => "arity 4 and 8 with as many planes as binary trees, against the best k parts of a grid",
            Self::Candidates => "how many candidate planes are enough",
            Self::Readings => "what the text leaves open, as a grid: which reading comes closest to the printed tables",
        }
    }
}

/// One tree under one experiment: `rows/experiments.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExperimentRow {
    /// The experiment.
    pub experiment: Experiment,
    /// Scene, such as `thesis:tiny`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles: a file may change under its name.
    pub scene_hash: String,
    /// The builder's id.
    pub builder: String,
    /// Reading of the thesis; empty for builders without.
    pub preset: String,
    /// Children per inner node.
    pub arity: usize,
    /// What the experiment varies, such as `lookup=linear`.
    pub setting: String,
    /// Candidates per axis, where the builder has them.
    pub candidates: Option<usize>,
    /// Lighting case of the picture.
    pub lighting: Lighting,
    /// How it ended; never `projected`.
    pub status: Status,
    /// Seconds that the build was allowed, empty for no limit.
    pub budget_s: Option<f64>,
    /// Why the cell failed or was capped; empty where there is nothing to say.
    pub note: String,
    /// Median time in milliseconds: of the build, or of what the experiment times instead (`collapse`).
    pub build_ms: Option<f64>,
    /// Canonical hash of the tree.
    pub tree_hash: Option<String>,
    /// Inner nodes.
    pub inner: Option<usize>,
    /// Leaves, empty ones included.
    pub leaves: Option<usize>,
    /// Children per inner node.
    pub avg_degree: Option<f64>,
    /// Surface area heuristic, c_trav = c_isect = 1.
    pub sah: Option<f64>,
    /// The traversal: `first-leaf` or `scalar`; empty where nothing is traced.
    pub kernel: String,
    /// Median time in microseconds per pixel, where it is taken.
    pub us_per_pixel: Option<f64>,
    /// Least of the runs.
    pub us_per_pixel_min: Option<f64>,
    /// Greatest of the runs.
    pub us_per_pixel_max: Option<f64>,
    /// The same by the kernel that tests as many boxes at once as the tree is wide, where it is taken.
    pub wide_us_per_pixel: Option<f64>,
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
    /// See-through chains that were cut.
    pub cut: Option<u64>,
    /// Pixels that see a farther surface than the closest.
    pub farther: Option<usize>,
    /// Pixels that see nothing where there is something.
    pub missed: Option<usize>,
    /// Pixels that see something where there is nothing.
    pub extra: Option<usize>,
    /// Nodes that rule Q8 applied to.
    pub q8_nodes: Option<u64>,
    /// Triangles that stand in more than one leaf, by rule Q8.
    pub q8_duplicated: Option<usize>,
    /// Triangles some leaf of which lies outside their box, so that rays can miss them (rule Q8).
    pub q8_hidden: Option<usize>,
    /// Threads used where times were taken.
    pub threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format, such as `0.1.0+rows2`.
    pub version: String,
    /// Commit of the program, with a fingerprint where its sources are not that commit's.
    pub commit: String,
}

impl Row for ExperimentRow {
    const FILE: &'static str = "experiments.csv";

    fn key(&self) -> String {
        let candidates = self.candidates.map_or(String::new(), |n| format!(" {n} candidates"));
        format!(
            "{} {} {} {} k={}{candidates} {} {}",
            self.experiment.id(),
            self.scene,
            self.builder,
            self.preset,
            self.arity,
            self.setting,
            self.lighting.id()
        )
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}
