//! Rows about decisions: where costs in f32 split nodes otherwise than exact ones, and what that does to the tree.

use super::{Row, Status};
use serde::{Deserialize, Serialize};

/// One scene and arity, top-down: `rows/decisions.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DecisionRow {
    /// `published`: the only reading whose program there was.
    pub preset: String,
    /// Scene, such as `thesis:tiny`.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: usize,
    /// Hash of the triangles: a file may change under its name.
    pub scene_hash: String,
    /// 2, 4 or 8.
    pub arity: usize,
    /// How it ended; never `projected`.
    pub status: Status,
    /// Seconds that both trees together were allowed, empty for no limit.
    pub budget_s: Option<f64>,
    /// Why the cell failed or was capped; empty where there is nothing to say.
    pub note: String,
    /// Inner nodes of the exact tree at which both costs had a choice, over the same triangles.
    pub compared: Option<usize>,
    /// Nodes at which they chose other splits.
    pub different: Option<usize>,
    /// Of these, nodes at which both choices have the same f32 sum.
    pub rounded_ties: Option<usize>,
    /// Of these, nodes at which both choices have the same exact cost.
    pub same_cost: Option<usize>,
    /// Greatest excess of an f32 choice's exact cost over the least, relative to that.
    pub largest_excess: Option<f64>,
    /// Canonical hash of the tree by exact costs.
    pub exact_tree_hash: Option<String>,
    /// Canonical hash of the tree by f32 costs.
    pub f32_tree_hash: Option<String>,
    /// Surface area heuristic of the tree by exact costs, c_trav = c_isect = 1.
    pub exact_sah: Option<f64>,
    /// The same of the tree by f32 costs.
    pub f32_sah: Option<f64>,
    /// End-point overlap of the tree by exact costs.
    pub exact_epo: Option<f64>,
    /// The same of the tree by f32 costs.
    pub f32_epo: Option<f64>,
    /// Nodes per pixel of the tree by exact costs, primary rays, as `traces.csv` counts them.
    pub exact_nodes_per_pixel: Option<f64>,
    /// The same of the tree by f32 costs.
    pub f32_nodes_per_pixel: Option<f64>,
    /// Threads used to build.
    pub threads: usize,
    /// Processor and operating system.
    pub machine: String,
    /// Crate version and row format, such as `0.1.0+rows2`.
    pub version: String,
    /// Commit of the program, with a fingerprint where its sources are not that commit's.
    pub commit: String,
}

impl Row for DecisionRow {
    const FILE: &'static str = "decisions.csv";

    fn key(&self) -> String {
        format!("{} {} k={}", self.preset, self.scene, self.arity)
    }

    fn origin(&self) -> (&str, &str) {
        (&self.version, &self.commit)
    }
}
