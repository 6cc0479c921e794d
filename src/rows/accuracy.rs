//! Rows about accuracy: what an exacter answer costs in time, be it a better tree, a truer hit or a tighter box.

use super::{Row, Status};
use serde::{Deserialize, Serialize};

/// One setting of one method on one scene: `rows/accuracy.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyRow {
    /// `planes`, `bins`, `clustering`, `decisions`, `intersection` or `storage`.
    pub study: String,
    /// Scene, such as `gen:spheres:20000`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles.
    pub scene_hash: String,
    /// What the setting belongs to: a builder and its reading, what is decided by costs, a tracing kernel, or an arity of
    /// stored nodes.
    pub method: String,
    /// Planes an axis, bins an axis, neighbours, or bits a coordinate or cost; empty where the method has no such number: it is
    /// exact, or a kernel.
    pub setting: Option<u32>,
    /// Children per inner node.
    pub arity: usize,
    /// `diffuse`, `primary` or `edges`.
    pub rays: String,
    /// How it ended.
    pub status: Status,
    /// Seconds that one build was allowed.
    pub budget_s: f64,
    /// Why there are no figures; empty where there is nothing to say.
    pub note: String,
    /// Median build time in milliseconds, whole build, warm.
    pub build_ms: Option<f64>,
    /// Least of the runs.
    pub build_ms_min: Option<f64>,
    /// Greatest of the runs.
    pub build_ms_max: Option<f64>,
    /// Runs of build and tracing, taken in turns with the other settings.
    pub runs: usize,
    /// Canonical hash of the tree.
    pub tree_hash: Option<String>,
    /// Surface area heuristic, c_trav = c_isect = 1.
    pub sah: Option<f64>,
    /// Bytes of nodes and ids as they are stored.
    pub bytes: Option<usize>,
    /// Rays traced.
    pub traced: Option<usize>,
    /// Millions of rays per second, median.
    pub mrays_per_s: Option<f64>,
    /// Least of the runs.
    pub mrays_per_s_min: Option<f64>,
    /// Greatest of the runs.
    pub mrays_per_s_max: Option<f64>,
    /// Nodes entered per ray.
    pub nodes_per_ray: Option<f64>,
    /// Box tests per ray.
    pub box_tests_per_ray: Option<f64>,
    /// Triangle tests per ray.
    pub tri_tests_per_ray: Option<f64>,
    /// Rays that hit something by the reference and nothing here.
    pub missed: Option<usize>,
    /// Rays that hit another triangle at another place than the reference, or something where it has nothing.
    pub other: Option<usize>,
    /// Rays that hit the reference's triangle, or one as near, at a t more than 4 units in the last place off.
    pub off: Option<usize>,
    /// The greatest such distance in units in the last place, among all rays that hit the right place.
    pub largest_ulp: Option<u32>,
    /// Rays whose reference was itself held against all triangles in f64.
    pub oracle_rays: Option<usize>,
    /// Decisions of exact costs, each with at least two candidates.
    pub compared: Option<usize>,
    /// Of these, decided otherwise by the setting's costs.
    pub different: Option<usize>,
    /// The greatest excess of such a choice's cost over the least, relative to that.
    pub largest_excess: Option<f64>,
    /// Threads used.
    pub threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format.
    pub version: String,
    /// Commit of the program.
    pub commit: String,
}

impl AccuracyRow {
    /// What identifies the series: everything but the setting.
    pub fn series(&self) -> (&str, &str, &str, usize, &str) {
        (&self.study, &self.scene, &self.method, self.arity, &self.rays)
    }
}

impl Row for AccuracyRow {
    const FILE: &'static str = "accuracy.csv";

    fn key(&self) -> String {
        let setting = self.setting.map_or_else(|| "-".into(), |s| s.to_string());
        format!("{} {} {} {setting} k={} {}", self.study, self.scene, self.method, self.arity, self.rays)
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}
