//! What has merged with what, and what a merge knows about the tree below it.

use super::clusters::Cluster;
use crate::geom::{Aabb, area_of_extent};
use std::mem::MaybeUninit;

/// Two clusters that became one. Names below the number of triangles are triangles, the others merges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merge {
    pub aabb: Aabb,
    pub left: u32,
    pub right: u32,
}

/// What is below a cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Below {
    /// The least cost, times the area of the root; of a merge, and of use only where there are few enough triangles for a leaf.
    cost: f64,
    pub triangles: u32,
    /// Leaves of the cheapest tree; 1 where the cluster is a leaf itself.
    pub leaves: u32,
}

/// What is below a triangle; its cost is the area of its box.
const TRIANGLE: Below = Below { cost: 0.0, triangles: 1, leaves: 1 };

/// All merges, in the order of rounds and places.
#[derive(Debug)]
pub(super) struct Merges {
    triangles: usize,
    max_leaf: usize,
    merges: Vec<Merge>,
    /// Of merges, behind what stands for all triangles.
    below: Vec<Below>,
}

/// Memory for some of the merges to come.
pub(super) struct Coming<'a> {
    merges: &'a mut [MaybeUninit<Merge>],
    below: &'a mut [MaybeUninit<Below>],
    /// The name of the first.
    first: u32,
}

impl<'a> Coming<'a> {
    /// The first `n`; `self` keeps the others.
    pub fn split_off(&mut self, n: usize) -> Coming<'a> {
        let first = self.first;
        self.first += n as u32;
        Coming {
            merges: self.merges.split_off_mut(..n).expect("enough merges"),
            below: self.below.split_off_mut(..n).expect("enough merges"),
            first,
        }
    }

    pub fn len(&self) -> usize {
        self.merges.len()
    }
}

/// What was known before a round.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    triangles: usize,
    max_leaf: usize,
    below: &'a [Below],
}

impl Known<'_> {
    #[inline(always)]
    fn below(&self, cluster: &Cluster) -> Below {
        let below = self.below[(cluster.name as usize + 1).saturating_sub(self.triangles)];
        let area = area_of_extent(cluster.aabb().extent());
        Below { cost: if (cluster.name as usize) < self.triangles { area } else { below.cost }, ..below }
    }

    /// Writes the merge of two clusters, and returns the new one. No branch depends on them: whether clusters are triangles and
    /// leaves close cannot be guessed.
    #[inline(always)]
    pub fn merge(&self, coming: &mut Coming, index: usize, clusters: [&Cluster; 2]) -> Cluster {
        let merged = clusters[0].with(clusters[1], coming.first + index as u32);
        let merge = Merge { aabb: merged.aabb(), left: clusters[0].name, right: clusters[1].name };
        let (left, right) = (self.below(clusters[0]), self.below(clusters[1]));
        let triangles = left.triangles + right.triangles;
        let area = area_of_extent(merge.aabb.extent());
        let (closed, open) = (area * f64::from(triangles), area + (left.cost + right.cost));
        let closes = (triangles as usize <= self.max_leaf) & (closed <= open);
        let cost = if closes { closed } else { open };
        let leaves = if closes { 1 } else { left.leaves + right.leaves };
        coming.merges[index].write(merge);
        coming.below[index].write(Below { cost, triangles, leaves });
        merged
    }
}

impl Merges {
    pub fn new(triangles: usize, max_leaf: usize) -> Self {
        let mut below = Vec::with_capacity(triangles);
        below.push(TRIANGLE);
        Self { triangles, max_leaf, merges: Vec::with_capacity(triangles - 1), below }
    }

    /// Makes `n` merges, all of which `write` writes.
    pub fn add(&mut self, n: usize, write: impl FnOnce(Known, Coming)) {
        let first = (self.triangles + self.merges.len()) as u32;
        let (_, merges) = with_spare(&mut self.merges, n);
        let (known, below) = with_spare(&mut self.below, n);
        let known = Known { triangles: self.triangles, max_leaf: self.max_leaf, below: known };
        write(known, Coming { merges, below, first });
        // SAFETY: `write` has written all.
        unsafe {
            self.merges.set_len(self.merges.len() + n);
            self.below.set_len(self.below.len() + n);
        }
    }

    /// The name of the root once everything has merged.
    pub fn root(&self) -> u32 {
        (self.triangles + self.merges.len() - 1) as u32
    }

    /// The merge called `name`, and what is below; `None` for a triangle.
    #[inline(always)]
    pub fn get(&self, name: u32) -> Option<(&Merge, &Below)> {
        let merge = (name as usize).checked_sub(self.triangles)?;
        Some((&self.merges[merge], &self.below[merge + 1]))
    }
}

/// What a vector holds, and room for `n` more.
fn with_spare<T>(vec: &mut Vec<T>, n: usize) -> (&[T], &mut [MaybeUninit<T>]) {
    vec.reserve(n);
    let (start, len) = (vec.as_mut_ptr(), vec.len());
    // SAFETY: the first `len` are initialised, and there is capacity for `n` more behind them; the two do not overlap, and
    // both borrow the vector.
    unsafe { (std::slice::from_raw_parts(start, len), std::slice::from_raw_parts_mut(start.add(len).cast(), n)) }
}
