//! Object splits: the best of all ways to cut the order by centres on one axis in two.
//!
//! MacDonald and Booth 1990, every position of a sorted axis. Among equal costs the most even split is taken, then the
//! lowest axis, then the lowest position: so coincident boxes are halved, and no chain comes of ties.

use super::reference::Reference;
use crate::geom::Aabb;

/// A split by centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectSplit {
    /// Area times number of references, over both sides.
    pub cost: f64,
    axis: usize,
    left: usize,
    /// The last key on the left.
    last: u64,
}

/// Room for the sweep of one axis.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// Centre on top, index below.
    keys: Vec<u64>,
    /// By position: area times number from there to the end.
    right: Vec<f64>,
}

/// Where a reference stands in the order of an axis; equal centres go by index.
#[inline(always)]
fn key(reference: &Reference, axis: usize, index: usize) -> u64 {
    let centre = reference.aabb.min[axis] * 0.5 + reference.aabb.max[axis] * 0.5;
    // Zeros of either sign are the same place.
    let bits = (centre + 0.0).to_bits();
    let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    u64::from(ordered) << 32 | index as u64
}

impl Sweep {
    /// The best split on `axis` of at least two references.
    pub fn best(&mut self, references: &[Reference], axis: usize) -> ObjectSplit {
        let n = references.len();
        self.keys.clear();
        self.keys.extend(references.iter().enumerate().map(|(index, r)| key(r, axis, index)));
        self.keys.sort_unstable();
        self.right.clear();
        self.right.resize(n, 0.0);
        let at = |key: u64| &references[key as u32 as usize].aabb;
        let mut aabb = Aabb::EMPTY;
        for position in (1..n).rev() {
            aabb = aabb.union(at(self.keys[position]));
            self.right[position] = aabb.surface_area() * (n - position) as f64;
        }
        let mut aabb = Aabb::EMPTY;
        let mut best = ObjectSplit { cost: f64::INFINITY, axis, left: 0, last: 0 };
        for left in 1..n {
            let last = self.keys[left - 1];
            aabb = aabb.union(at(last));
            let cost = aabb.surface_area() * left as f64 + self.right[left];
            let split = ObjectSplit { cost, axis, left, last };
            if split.precedes(&best, n) {
                best = split;
            }
        }
        best
    }
}

impl ObjectSplit {
    /// Whether it is better than one of a later axis or position.
    #[inline(always)]
    pub fn precedes(&self, later: &Self, n: usize) -> bool {
        let uneven = |left: usize| left.abs_diff(n - left);
        self.cost < later.cost || (self.cost == later.cost && uneven(self.left) < uneven(later.left))
    }

    /// Whether the reference at `index` goes left.
    #[inline(always)]
    pub fn is_left(&self, reference: &Reference, index: usize) -> bool {
        key(reference, self.axis, index) <= self.last
    }

    /// The boxes of both sides, and how many references they have.
    pub fn sides(&self, references: &[Reference]) -> [(Aabb, usize); 2] {
        let mut sides = [(Aabb::EMPTY, 0); 2];
        for (index, reference) in references.iter().enumerate() {
            let (aabb, count) = &mut sides[usize::from(!self.is_left(reference, index))];
            *aabb = aabb.union(&reference.aabb);
            *count += 1;
        }
        sides
    }
}
