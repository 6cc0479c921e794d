//! Spatial splits: the best of some planes across each axis, references on both sides of it cut in two.
//!
//! Stich, Friedrich and Dietrich 2009, section 3: references are chopped at all planes of an axis and their pieces put
//! into bins; the box and the number of references on either side of each plane follow from a sweep over the bins.

use super::estimate::{nodes, saved};
use super::reference::{Reference, Source};
use crate::geom::{Aabb, Polygon};
use glam::DVec3;

/// A split by a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpatialSplit {
    /// Area times number of references, over both sides.
    pub cost: f64,
    /// The axis across which the plane stands.
    pub axis: usize,
    /// Where.
    pub at: f32,
}

/// What lies between two planes.
#[derive(Clone, Copy, Debug)]
struct Bin {
    aabb: Aabb,
    /// References that begin here.
    entries: usize,
    /// References that end here.
    exits: usize,
}

const EMPTY: Bin = Bin { aabb: Aabb::EMPTY, entries: 0, exits: 0 };

/// Room for the search on one axis.
#[derive(Debug, Default)]
pub(super) struct Chop {
    planes: Vec<f32>,
    bins: Vec<Bin>,
    /// By plane: the box of all that is above.
    above: Vec<Aabb>,
}

impl Chop {
    /// The best plane across `axis` that adds at most `budget` references, if any separates something.
    ///
    /// `aabb` is the box of all references. The planes cut it into `bins` equal slabs, or, where there are few
    /// references, are the faces of their boxes.
    pub fn best(
        &mut self,
        source: &Source,
        references: &[Reference],
        aabb: &Aabb,
        axis: usize,
        bins: usize,
        budget: usize,
    ) -> Option<SpatialSplit> {
        self.place_planes(references, aabb, axis, bins);
        if self.planes.is_empty() {
            return None;
        }
        self.bins.clear();
        self.bins.resize(self.planes.len() + 1, EMPTY);
        for reference in references {
            let (first, last) = span(&self.planes, reference, axis);
            self.bins[first].entries += 1;
            self.bins[last].exits += 1;
            if first == last {
                let bin = &mut self.bins[first];
                bin.aabb = bin.aabb.union(&reference.aabb);
            } else if let Some(polygon) = source.part(reference) {
                self.chop(&polygon, axis, first, last);
            } else {
                self.chop_box(&reference.aabb, axis, first, last);
            }
        }
        self.sweep(references.len(), axis, budget)
    }

    /// Planes tried last.
    pub fn planes(&self) -> usize {
        self.planes.len()
    }

    fn place_planes(&mut self, references: &[Reference], aabb: &Aabb, axis: usize, bins: usize) {
        let (low, high) = (aabb.min[axis], aabb.max[axis]);
        let planes = &mut self.planes;
        planes.clear();
        if 2 * references.len() <= bins {
            planes.extend(references.iter().flat_map(|r| [r.aabb.min[axis], r.aabb.max[axis]]));
            planes.sort_unstable_by(f32::total_cmp);
        } else {
            let (start, width) = (f64::from(low), f64::from(high) - f64::from(low));
            planes.extend((1..bins).map(|k| (start + width * (k as f64 / bins as f64)) as f32));
        }
        planes.retain(|&at| low < at && at < high);
        planes.dedup();
    }

    /// Puts the pieces of a polygon that spans the bins `first ..= last` into them.
    ///
    /// A piece is the hull of corners and of points where edges meet planes.
    fn chop(&mut self, polygon: &Polygon, axis: usize, first: usize, last: usize) {
        let Self { planes, bins, .. } = self;
        let bin_of = |p: DVec3| planes[first..last].partition_point(|&at| f64::from(at) < p[axis]) + first;
        let mut grow = |bin: usize, p: DVec3| {
            let p = p.as_vec3();
            bins[bin].aabb = bins[bin].aabb.union(&Aabb::new(p, p));
        };
        let Some(&before) = polygon.last() else { return };
        let (mut from, mut from_bin) = (before, bin_of(before));
        for &to in polygon {
            let to_bin = bin_of(to);
            grow(to_bin, to);
            for plane in from_bin.min(to_bin)..from_bin.max(to_bin) {
                let at = f64::from(planes[plane]);
                let mut crossing = from + (to - from) * ((at - from[axis]) / (to[axis] - from[axis]));
                crossing[axis] = at;
                grow(plane, crossing);
                grow(plane + 1, crossing);
            }
            (from, from_bin) = (to, to_bin);
        }
    }

    fn chop_box(&mut self, aabb: &Aabb, axis: usize, first: usize, last: usize) {
        for bin in first..=last {
            let mut piece = *aabb;
            if bin > first {
                piece.min[axis] = self.planes[bin - 1];
            }
            if bin < last {
                piece.max[axis] = self.planes[bin];
            }
            self.bins[bin].aabb = self.bins[bin].aabb.union(&piece);
        }
    }

    /// The best plane; of equally good ones the lowest.
    fn sweep(&mut self, n: usize, axis: usize, budget: usize) -> Option<SpatialSplit> {
        let planes = self.planes.len();
        self.above.clear();
        self.above.resize(planes, Aabb::EMPTY);
        let mut aabb = Aabb::EMPTY;
        for plane in (0..planes).rev() {
            aabb = aabb.union(&self.bins[plane + 1].aabb);
            self.above[plane] = aabb;
        }
        let mut best: Option<SpatialSplit> = None;
        let (mut below, mut left, mut right) = (Aabb::EMPTY, 0, n);
        for plane in 0..planes {
            below = below.union(&self.bins[plane].aabb);
            left += self.bins[plane].entries;
            right -= self.bins[plane].exits;
            if left == 0 || right == 0 || left + right - n > budget {
                continue;
            }
            let cost = below.surface_area() * left as f64 + self.above[plane].surface_area() * right as f64;
            if best.is_none_or(|b| cost < b.cost) {
                best = Some(SpatialSplit { cost, axis, at: self.planes[plane] });
            }
        }
        best
    }
}

/// The first and the last of the bins between `planes` that a reference has a part in.
///
/// A face on a plane belongs to the bin on the inner side; a flat reference in a plane to the one above.
fn span(planes: &[f32], reference: &Reference, axis: usize) -> (usize, usize) {
    let first = planes.partition_point(|&at| at <= reference.aabb.min[axis]);
    let last = planes.partition_point(|&at| at < reference.aabb.max[axis]);
    (first, last.max(first))
}

impl SpatialSplit {
    /// Parts `references` into `left` and `right`, each in its old order, and returns what both sides will cost but
    /// for what the references cost that are there already: see `estimate`. `parts` is room to work in.
    ///
    /// Where a reference would be cut, it goes whole to one side if that costs no more (Stich et al. 2009, section 4.3,
    /// "reference unsplitting"); they are looked at in order, with the boxes and numbers as they are by then.
    pub fn part(
        &self,
        source: &Source,
        references: &[Reference],
        left: &mut Vec<Reference>,
        right: &mut Vec<Reference>,
        parts: &mut Vec<[Aabb; 2]>,
    ) -> f64 {
        parts.clear();
        let (mut boxes, mut counts) = ([Aabb::EMPTY; 2], [0usize; 2]);
        for reference in references {
            let part = if reference.aabb.min[self.axis] >= self.at {
                [Aabb::EMPTY, reference.aabb]
            } else if reference.aabb.max[self.axis] <= self.at {
                [reference.aabb, Aabb::EMPTY]
            } else {
                source.cut(reference, self.axis, self.at)
            };
            for side in 0..2 {
                boxes[side] = boxes[side].union(&part[side]);
                counts[side] += usize::from(!part[side].is_empty());
            }
            parts.push(part);
        }
        let both = |boxes: [&Aabb; 2], counts: [usize; 2]| {
            nodes(boxes[0].surface_area(), counts[0]) + nodes(boxes[1].surface_area(), counts[1])
        };
        let mut saved_by_cuts = 0.0;
        for (&Reference { aabb, id }, part) in references.iter().zip(parts) {
            if !part[0].is_empty() && !part[1].is_empty() {
                let grown = boxes.map(|b| b.union(&aabb));
                let saved = saved(&aabb, part);
                let cut = both([&boxes[0], &boxes[1]], counts) - saved;
                let only_left = both([&grown[0], &boxes[1]], [counts[0], counts[1] - 1]);
                let only_right = both([&boxes[0], &grown[1]], [counts[0] - 1, counts[1]]);
                if only_left <= cut.min(only_right) {
                    (boxes[0], *part) = (grown[0], [aabb, Aabb::EMPTY]);
                    counts[1] -= 1;
                } else if only_right <= cut {
                    (boxes[1], *part) = (grown[1], [Aabb::EMPTY, aabb]);
                    counts[0] -= 1;
                } else {
                    saved_by_cuts += saved;
                }
            }
            for (side, aabb) in [left as &mut Vec<_>, right].into_iter().zip(*part) {
                if !aabb.is_empty() {
                    side.push(Reference { aabb, id });
                }
            }
        }
        both([&boxes[0], &boxes[1]], counts) - saved_by_cuts
    }
}
