//! The bins of the two children of a node, filled while the node is divided, and the best plane between them.

use super::lanes::{Axes, Lanes, Span};
use super::MOST_BINS;

/// Where the bins of a node lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Doubled centre at the lower end of bin 0.
    low: Axes,
    /// Bins per doubled scene unit; 0 on an axis on which nothing can be told apart.
    scale: Axes,
    /// Index of the last bin.
    last: f32,
}

impl Grid {
    /// No bins to speak of: everything falls into bin 0.
    pub const NONE: Self = Self { low: [0.0; 4], scale: [0.0; 4], last: 0.0 };

    /// `bins` bins an axis, of equal width, over `span`.
    #[inline(always)]
    pub fn over(span: &Span, bins: usize) -> Self {
        let scale = |i: usize| {
            let scale = bins as f32 / (span.high[i] - span.low[i]);
            if scale > 0.0 && scale < f32::INFINITY { scale } else { 0.0 }
        };
        Self { low: span.low, scale: [scale(0), scale(1), scale(2), 0.0], last: (bins - 1) as f32 }
    }

    /// Number of bins.
    #[inline(always)]
    pub fn bins(&self) -> usize {
        self.last as usize + 1
    }

    /// The bin of a reference on each axis.
    #[inline(always)]
    fn bins_of(&self, reference: &Lanes) -> [usize; 3] {
        let centre = reference.centre();
        let at: [i32; 4] = std::array::from_fn(|i| {
            let t = (centre[i] - self.low[i]) * self.scale[i];
            let t = if t > 0.0 { t } else { 0.0 };
            let t = if t < self.last { t } else { self.last };
            // SAFETY: between 0 and `last`, which is below `MOST_BINS`, and never NaN: comparisons with NaN choose 0.
            unsafe { t.to_int_unchecked::<i32>() }
        });
        [at[0] as usize, at[1] as usize, at[2] as usize]
    }

    /// Whether a reference lies in bin `plane` or beyond.
    #[inline(always)]
    pub fn is_right(&self, reference: &Lanes, axis: usize, plane: f32) -> bool {
        (reference.centre_on(axis) - self.low[axis & 3]) * self.scale[axis & 3] >= plane
    }

    /// The parts of `span`, which the bins cover, below and above a plane.
    #[inline(always)]
    pub fn cut(&self, span: &Span, axis: usize, plane: f32) -> [Span; 2] {
        let at = self.low[axis & 3] + plane / self.scale[axis & 3];
        let (mut below, mut above) = (*span, *span);
        below.high[axis & 3] = at;
        above.low[axis & 3] = at;
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
