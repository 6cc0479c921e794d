//! Builders: from the boxes of triangles to a tree. Plain functions; they neither time nor print.

pub mod binned_sah;
pub mod bottom_up;
mod cost;
pub mod hlbvh;
mod input;
pub mod kway_sah;
pub mod lbvh;
mod morton;
mod options;
mod original_kdtree;
pub mod ploc;
mod probe;
mod registry;
pub mod rounding;
pub mod sbvh;
mod subtrees;
pub mod sweep_sah;
#[cfg(test)]
mod testing;
pub mod top_down;

pub use cost::{CHILD_COST_SCALE_BITS, ChildCost};
pub use input::Input;
pub use options::{BuildOptions, Engine, Parameter, Preset};
pub use original_kdtree::{Nearest, OriginalKdTree, OriginalWork};
pub use probe::{Brake, Counters, Probe, Work};
pub use registry::{BUILDERS, Builder, find};

/// The most triangles a leaf holds: in every tree of the thesis, and in others unless told otherwise.
pub const MAX_LEAF: usize = 4;

/// Why a builder returned no tree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    /// There is nothing to build over.
    #[error("no triangles: a tree needs at least one")]
    NoTriangles,
    /// More triangles than 32-bit ids can name.
    #[error("{0} triangles are too many: ids have 31 bits")]
    TooManyTriangles(usize),
    /// A box is empty or holds NaN or infinity; loaders drop such triangles.
    #[error("the box of triangle {0} is empty or not finite: drop the triangle before building")]
    InvalidBox(usize),
    /// The arity is not one this builder offers.
    #[error("arity {0} is not offered: use 2, 4 or 8")]
    Arity(usize),
    /// A parameter is out of its range.
    #[error("{0}")]
    Parameter(String),
    /// The probe asked to stop.
    #[error("stopped by its budget")]
    Stopped(Unfinished),
    /// The published chain went round in a circle of equal distances.
    #[error("the chain made {0} steps without an end: equal distances go round in a circle")]
    Circling(u64),
}

/// What was left to do when a builder was stopped: what a projection starts from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unfinished {
    /// Top-down: sizes of the nodes not yet split. Bottom-up: one entry, the clusters still alive.
    pub pending: Vec<usize>,
}

/// Refuses what no builder can work on.
///
/// # Errors
/// [`BuildError::NoTriangles`], [`BuildError::TooManyTriangles`] or [`BuildError::InvalidBox`].
pub fn check_boxes(boxes: &[crate::geom::Aabb]) -> Result<(), BuildError> {
    if boxes.is_empty() {
        return Err(BuildError::NoTriangles);
    }
    if boxes.len() >= 1 << 31 {
        return Err(BuildError::TooManyTriangles(boxes.len()));
    }
    match boxes.iter().position(|b| !b.is_valid()) {
        Some(index) => Err(BuildError::InvalidBox(index)),
        None => Ok(()),
    }
}
