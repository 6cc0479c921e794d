//! Collapse: a binary tree becomes one of higher arity by leaving inner nodes out.

mod greedy;
mod optimal;
mod thesis;

pub use greedy::collapse_greedily;
pub use optimal::{collapse_by_leaf_cost, collapse_optimally};
pub use thesis::collapse;

use crate::bvh::Bvh;

/// How a binary tree becomes one of higher arity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collapse {
    /// [`collapse`], the thesis': wherever there is room.
    Thesis,
    /// [`collapse_greedily`]: the child of the largest area gives way to its own children.
    Greedy,
    /// [`collapse_optimally`]: the cheapest of all.
    Optimal,
}

impl Collapse {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Thesis, Self::Greedy, Self::Optimal];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::Greedy => "greedy",
            Self::Optimal => "optimal",
        }
    }

    /// From a binary tree to one of arity at most `arity`, which may make leaves of at most `max_leaf` triangles.
    pub fn apply(self, bvh: &Bvh, arity: usize, max_leaf: usize) -> Bvh {
        match self {
            Self::Thesis => collapse(bvh, arity),
            Self::Greedy => collapse_greedily(bvh, arity),
            Self::Optimal => collapse_optimally(bvh, arity, max_leaf),
        }
    }
}
