//! The bins of the two children of a node, filled while the node is divided, and the best plane between them.

use super::lanes::{Lanes, Span};
use super::MOST_BINS;
use glam::Vec4;

/// Where the bins of a node lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Doubled centre at the lower end of bin 0.
    low: Vec4,
    /// Bins per doubled scene unit; 0 on an axis on which nothing can be told apart.
    scale: Vec4,
    /// Index of the last bin.
    last: Vec4,
}

impl Grid {
    /// No bins to speak of: everything falls into bin 0.
    pub const NONE: Self = Self { low: Vec4::ZERO, scale: Vec4::ZERO, last: Vec4::ZERO };

    /// `bins` bins an axis, of equal width, over `span`.
    #[inline(always)]
    pub fn over(span: &Span, bins: usize) -> Self {
        let scale = bins as f32 / (span.high - span.low);
        let usable = scale.cmpgt(Vec4::ZERO) & scale.cmplt(Vec4::INFINITY);
        Self {
            low: span.low,
            scale: Vec4::select(usable, scale, Vec4::ZERO),
            last: Vec4::splat((bins - 1) as f32),
        }
    }

    /// Number of bins.
    #[inline(always)]
    pub fn bins(&self) -> usize {
        self.last.x as usize + 1
    }

    /// The bin of a reference on each axis.
    #[inline(always)]
    fn bins_of(&self, reference: &Lanes) -> [usize; 3] {
        let at = ((reference.centre() - self.low) * self.scale).max(Vec4::ZERO).min(self.last);
        // SAFETY: between 0 and `last`, which is below `MOST_BINS`; finite numbers make no NaN.
        let [x, y, z, _] = at.to_array().map(|t| unsafe { t.to_int_unchecked::<i32>() });
        [x as usize, y as usize, z as usize]
    }

    /// Whether a reference lies in bin `plane` or beyond.
    #[inline(always)]
    pub fn is_right(&self, reference: &Lanes, axis: usize, plane: f32) -> bool {
        (reference.centre_on(axis) - self.low.as_ref()[axis]) * self.scale.as_ref()[axis] >= plane
    }

    /// The parts of `span`, which the bins cover, below and above a plane.
    #[inline(always)]
    pub fn cut(&self, span: &Span, axis: usize, plane: f32) -> [Span; 2] {
        let at = self.low.as_ref()[axis] + plane / self.scale.as_ref()[axis];
        let (mut below, mut above) = (*span, *span);
        below.high.as_mut()[axis] = at;
        above.low.as_mut()[axis] = at;
        [below, above]
    }
}

/// A plane between two bins, and what lies on its sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Half area times references, of both sides together.
    pub cost: f32,
    pub axis: usize,
    /// First bin of the right side.
    pub bin: usize,
    /// References of the left side.
    pub left: usize,
    /// Boxes of the sides.
    pub boxes: [Lanes; 2],
}

/// Entries of a bin: three axes of the left child and a gap, the same of the right child.
const ROW: usize = 8;
const ENTRIES: usize = MOST_BINS * ROW;

/// The bins of two nodes.
pub(super) struct Bins {
    boxes: [Lanes; ENTRIES],
    counts: [u32; ENTRIES],
    /// Half areas above each plane of the axis that is being looked at.
    above: [f32; MOST_BINS],
}

impl Bins {
    /// Bins with nothing in them.
    pub fn new() -> Box<Self> {
        Box::new(Self { boxes: [Lanes::EMPTY; ENTRIES], counts: [0; ENTRIES], above: [0.0; MOST_BINS] })
    }

    /// Empties the first `bins` bins of a side.
    #[inline(always)]
    pub fn clear(&mut self, side: usize, bins: usize) {
        for bin in 0..bins {
            let row = (bin * ROW + side * 4) & (ENTRIES - 1);
            for axis in 0..3 {
                self.boxes[(row + axis) & (ENTRIES - 1)] = Lanes::EMPTY;
                self.counts[(row + axis) & (ENTRIES - 1)] = 0;
            }
        }
    }

    /// Puts a reference into its bins.
    #[inline(always)]
    pub fn add(&mut self, side: usize, grid: &Grid, reference: &Lanes) {
        let bins = grid.bins_of(reference);
        for (axis, bin) in bins.into_iter().enumerate() {
            let entry = (bin * ROW + side * 4 + axis) & (ENTRIES - 1);
            self.boxes[entry] = self.boxes[entry].union(reference);
            self.counts[entry] += 1;
        }
    }

    /// Adds what is in the first `bins` bins of a side of `other`.
    pub fn merge(&mut self, other: &Self, side: usize, bins: usize) {
        for bin in 0..bins {
            for axis in 0..3 {
                let entry = bin * ROW + side * 4 + axis;
                self.boxes[entry] = self.boxes[entry].union(&other.boxes[entry]);
                self.counts[entry] += other.counts[entry];
            }
        }
    }

    /// The cheapest plane with references on both sides: of equals the lowest axis and there the lowest plane.
    #[inline(always)]
    pub fn best(&mut self, side: usize, bins: usize, references: usize, costs: &mut u64) -> Option<Plane> {
        let mut best = (f32::INFINITY, 0, 0, 0);
        for axis in 0..3 {
            let entry = |bin: usize| (bin * ROW + side * 4 + axis) & (ENTRIES - 1);
            let mut right = Lanes::EMPTY;
            for bin in (1..bins).rev() {
                right = right.union(&self.boxes[entry(bin)]);
                self.above[bin & (MOST_BINS - 1)] = right.half_area();
            }
            let (mut left, mut count) = (Lanes::EMPTY, 0);
            for bin in 1..bins {
                left = left.union(&self.boxes[entry(bin - 1)]);
                count += self.counts[entry(bin - 1)] as usize;
                if count == 0 || count == references {
                    continue;
                }
                *costs += 1;
                let cost = left.half_area() * count as f32
                    + self.above[bin & (MOST_BINS - 1)] * (references - count) as f32;
                if cost < best.0 {
                    best = (cost, axis, bin, count);
                }
            }
        }
        let (cost, axis, bin, left) = best;
        if bin == 0 {
            return None;
        }
        let around = |from: usize, to: usize| {
            (from..to).fold(Lanes::EMPTY, |b, bin| b.union(&self.boxes[(bin * ROW + side * 4 + axis) & (ENTRIES - 1)]))
        };
        Some(Plane { cost, axis, bin, left, boxes: [around(0, bin), around(bin, bins)] })
    }
}
