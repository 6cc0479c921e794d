//! Spatial splits: the best of some planes across each axis, references on both sides of it cut in two.
//!
//! Stich, Friedrich and Dietrich 2009, section 3: references are chopped at all planes of an axis and their pieces put
//! into bins; the box and the number of references on either side of each plane follow from a sweep over the bins.

use super::estimate::{nodes, saved};
use super::reference::{Reference, Source};
use crate::geom::{Aabb, Polygon};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

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

/// References of a slab, but for small nodes, which have [`FEW`]: where there are many references, large things and small ones may lie
/// side by side, and only a narrow slab parts them.
const PER_SLAB: usize = 4;

/// Pieces that a reference is chopped into on average, but where that makes fewer than [`FEW`] slabs. Twice as many make the tree
/// cheaper by 0.3 % at most, and the build longer by a sixth in hair and a quarter in slivers.
const PIECES: usize = 8;

/// Slabs that there are at least, as far as they are asked for. With half as many, planes are found that part a few references from
/// the rest, again and again.
const FEW: usize = 32;

/// References from which on they are put into bins in parallel, so many at a time.
const CHUNK: usize = 1 << 12;

/// Planes across one axis.
#[derive(Debug, Default)]
struct Planes {
    /// Where they are, rising.
    at: Vec<f32>,
    start: f64,
    per_length: f64,
}

/// Room for the search.
#[derive(Debug, Default)]
pub(super) struct Chop {
    planes: [Planes; 3],
    bins: [Vec<Bin>; 3],
    /// By plane of an axis: the box of all that is above.
    above: Vec<Aabb>,
}

impl Planes {
    /// Planes that cut the box of all references into `bins` equal slabs, at most `most`, or, where there are few
    /// references, those of the faces of their boxes.
    fn place(&mut self, references: &[Reference], aabb: &Aabb, axis: usize, mut bins: usize, most: usize) {
        let (low, high) = (aabb.min[axis], aabb.max[axis]);
        let (start, length) = (f64::from(low), f64::from(high) - f64::from(low));
        let planes = &mut self.at;
        planes.clear();
        if 2 * references.len() <= bins {
            planes.extend(references.iter().flat_map(|r| [r.aabb.min[axis], r.aabb.max[axis]]));
            planes.sort_unstable_by(f32::total_cmp);
        } else {
            bins = bins.min(most);
            planes.extend((1..bins).map(|k| (start + length * (k as f64 / bins as f64)) as f32));
        }
        planes.retain(|&at| low < at && at < high);
        planes.dedup();
        (self.start, self.per_length) = (start, if length > 0.0 { bins as f64 / length } else { 0.0 });
    }

    /// How many planes are below: those that `is_below` says so of, which are the lowest ones. The search starts where
    /// equal slabs would have the plane at `x`.
    #[inline(always)]
    fn count_below(&self, x: f64, is_below: impl Fn(f64) -> bool) -> usize {
        let is_below = |plane: usize| is_below(f64::from(self.at[plane]));
        let mut count = (((x - self.start) * self.per_length) as usize).min(self.at.len());
        while count < self.at.len() && is_below(count) {
            count += 1;
        }
        while count > 0 && !is_below(count - 1) {
            count -= 1;
        }
        count
    }

    /// The first and the last of the bins that a reference has a part in.
    ///
    /// A face on a plane belongs to the bin on the inner side; a flat reference in a plane to the one above.
    #[inline(always)]
    fn span(&self, aabb: &Aabb, axis: usize) -> (usize, usize) {
        let (min, max) = (f64::from(aabb.min[axis]), f64::from(aabb.max[axis]));
        let first = self.count_below(min, |at| at <= min);
        let last = self.count_below(max, |at| at < max);
        (first, last.max(first))
    }
}

impl Chop {
    /// The best plane that adds at most `budget` references, if any separates something; of equally good ones the
    /// lowest of the lowest axis. `aabb` is the box of all references, `bins` how many slabs it is cut into at most.
    pub fn best(
        &mut self,
        source: &Source,
        references: &[Reference],
        aabb: &Aabb,
        bins: usize,
        budget: usize,
    ) -> Option<SpatialSplit> {
        let n = references.len();
        let bins = if bins > FEW { bins.min((n / PER_SLAB).max(FEW)) } else { bins };
        let extents = references.iter().fold(DVec3::ZERO, |sum, r| sum + r.aabb.extent());
        let pieces = aabb.extent() * (PIECES * n) as f64 / extents;
        for axis in 0..3 {
            // Where nearly all of them reach from end to end, no plane parts them.
            let most = if pieces[axis] < (PIECES + 1) as f64 { PIECES } else { (pieces[axis] as usize).max(FEW) };
            self.planes[axis].place(references, aabb, axis, bins, most);
            self.bins[axis].clear();
            self.bins[axis].resize(self.planes[axis].at.len() + 1, EMPTY);
        }
        let Self { planes, bins, .. } = self;
        if references.len() <= CHUNK {
            fill(bins, planes, source, references);
        } else {
            let empty = bins.clone();
            let chunk = |chunk: &[Reference]| {
                let mut bins = empty.clone();
                fill(&mut bins, planes, source, chunk);
                bins
            };
            let filled: Vec<_> = references.par_chunks(CHUNK).map(chunk).collect();
            for part in &filled {
                for (bin, more) in bins.iter_mut().flatten().zip(part.iter().flatten()) {
                    bin.aabb = bin.aabb.union(&more.aabb);
                    bin.entries += more.entries;
                    bin.exits += more.exits;
                }
            }
        }
        let best = (0..3).filter_map(|axis| self.sweep(references.len(), axis, budget));
        best.reduce(|best, next| if next.cost < best.cost { next } else { best })
    }

    /// Planes tried last.
    pub fn planes(&self) -> usize {
        self.planes.iter().map(|planes| planes.at.len()).sum()
    }

    /// The best plane across `axis`; of equally good ones the lowest.
    fn sweep(&mut self, n: usize, axis: usize, budget: usize) -> Option<SpatialSplit> {
        let Self { planes, bins, above } = self;
        let (planes, bins) = (&planes[axis].at, &bins[axis]);
        above.clear();
        above.resize(planes.len(), Aabb::EMPTY);
        let mut aabb = Aabb::EMPTY;
        for plane in (0..planes.len()).rev() {
            aabb = aabb.union(&bins[plane + 1].aabb);
            above[plane] = aabb;
        }
        let mut best: Option<SpatialSplit> = None;
        let (mut below, mut left, mut right) = (Aabb::EMPTY, 0, n);
        for (plane, &at) in planes.iter().enumerate() {
            below = below.union(&bins[plane].aabb);
            left += bins[plane].entries;
            right -= bins[plane].exits;
            if left == 0 || right == 0 || left + right - n > budget {
                continue;
            }
            let cost = below.surface_area() * left as f64 + above[plane].surface_area() * right as f64;
            if best.is_none_or(|b| cost < b.cost) {
                best = Some(SpatialSplit { cost, axis, at });
            }
        }
        best
    }
}

/// Puts the pieces of all references into the bins of each axis.
fn fill(bins: &mut [Vec<Bin>; 3], planes: &[Planes; 3], source: &Source, references: &[Reference]) {
    let mut polygon = Polygon::new();
    for reference in references {
        let mut is_known = None;
        for axis in 0..3 {
            let (planes, bins) = (&planes[axis], &mut bins[axis]);
            let (first, last) = planes.span(&reference.aabb, axis);
            bins[first].entries += 1;
            bins[last].exits += 1;
            if first == last {
                bins[first].aabb = bins[first].aabb.union(&reference.aabb);
            } else if *is_known.get_or_insert_with(|| source.part(reference, &mut polygon)) {
                chop(bins, planes, &polygon, axis, first, last);
            } else {
                chop_box(bins, &planes.at, &reference.aabb, axis, first, last);
            }
        }
    }
}

/// Puts the pieces of a polygon that spans the bins `first ..= last` into them.
///
/// A piece is the hull of corners and of points where edges meet planes.
#[inline(always)]
fn chop(bins: &mut [Bin], planes: &Planes, polygon: &Polygon, axis: usize, first: usize, last: usize) {
    let bin_of = |p: DVec3| planes.count_below(p[axis], |at| at < p[axis]).clamp(first, last);
    let mut grow = |bin: usize, p: Vec3| bins[bin].aabb = bins[bin].aabb.union(&Aabb::new(p, p));
    let Some(&before) = polygon.last() else { return };
    let (mut from, mut from_bin) = (before, bin_of(before));
    for &to in polygon {
        let to_bin = bin_of(to);
        grow(to_bin, to.as_vec3());
        let per_length = (to - from) / (to[axis] - from[axis]);
        for plane in from_bin.min(to_bin)..from_bin.max(to_bin) {
            let at = planes.at[plane];
            let mut crossing = (from + per_length * (f64::from(at) - from[axis])).as_vec3();
            crossing[axis] = at;
            grow(plane, crossing);
            grow(plane + 1, crossing);
        }
        (from, from_bin) = (to, to_bin);
    }
}

/// The same of a box.
fn chop_box(bins: &mut [Bin], planes: &[f32], aabb: &Aabb, axis: usize, first: usize, last: usize) {
    for bin in first..=last {
        let mut piece = *aabb;
        if bin > first {
            piece.min[axis] = planes[bin - 1];
        }
        if bin < last {
            piece.max[axis] = planes[bin];
        }
        bins[bin].aabb = bins[bin].aabb.union(&piece);
    }
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
