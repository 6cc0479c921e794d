//! Where the largest subtrees of few triangles begin.

use crate::build::lbvh::Clusters;

/// The first leaf of each cluster.
pub(super) struct Starts {
    /// The most triangles of one.
    pub most: usize,
    pub leaves: Vec<usize>,
}

impl Clusters for Starts {
    #[inline(always)]
    fn most(&self) -> usize {
        self.most
    }

    #[inline(always)]
    fn count(&self) -> usize {
        self.leaves.len()
    }

    #[inline(always)]
    fn push(&mut self, first_leaf: usize) {
        self.leaves.push(first_leaf);
    }

    #[inline(always)]
    fn unite(&mut self, first: usize) {
        self.leaves.truncate(first + 1);
    }
}
