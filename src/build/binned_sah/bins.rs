//! The bins of the two children of a node, filled while the node is divided, and the best plane between them.

use super::MOST_BINS;
use super::lanes::{Lanes, Span};
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
        Self { low: span.low, scale: Vec4::select(usable, scale, Vec4::ZERO), last: Vec4::splat((bins - 1) as f32) }
    }

    /// Number of bins.
    #[inline(always)]
    pub fn bins(&self) -> usize {
        self.last.x as usize + 1
    }

    /// The bins of a reference.
    #[inline(always)]
    pub fn bins_of(&self, side: usize, reference: &Lanes) -> Where {
        let at = ((reference.centre() - self.low) * self.scale).max(Vec4::ZERO).min(self.last);
        // SAFETY: between 0 and `last`, which is below `MOST_BINS`; of NaN, `max` makes 0.
        Where(at.to_array().map(|t| 2 * unsafe { t.to_int_unchecked::<i32>() } as u32 + side as u32))
    }

    /// Whether a reference lies in the bin of a plane or beyond; `plane` is infinite on the other axes.
    #[inline(always)]
    pub fn is_right(&self, reference: &Lanes, plane: Vec4) -> bool {
        ((reference.centre() - self.low) * self.scale).cmpge(plane).bitmask() != 0
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

/// In which bins of which side a reference belongs: three indices, and one that means nothing.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct Where([u32; 4]);

impl Where {
    pub const NOWHERE: Self = Self([0; 4]);
}

/// A bin of each axis.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Bin {
    boxes: [Lanes; 3],
    counts: [u32; 8],
}

impl Bin {
    const EMPTY: Self = Self { boxes: [Lanes::EMPTY; 3], counts: [0; 8] };
}

/// The bins of the two children of a node.
pub(super) struct Bins {
    /// Alternately of the left and of the right child.
    bins: [Bin; 2 * MOST_BINS],
    /// Half areas above each plane of the axis that is being looked at.
    above: [f32; MOST_BINS],
}

/// Where a bin is: in bounds for the compiler, too.
#[inline(always)]
const fn at(side: usize, bin: usize) -> usize {
    (2 * bin + side) % (2 * MOST_BINS)
}

impl Bins {
    /// Bins with nothing in them.
    pub fn new() -> Box<Self> {
        Box::new(Self { bins: [Bin::EMPTY; 2 * MOST_BINS], above: [0.0; MOST_BINS] })
    }

    /// Empties the first `bins` bins of a side.
    #[inline(always)]
    pub fn clear(&mut self, side: usize, bins: usize) {
        (0..bins).for_each(|bin| self.bins[at(side, bin)] = Bin::EMPTY);
    }

    /// Puts a reference into its bins.
    ///
    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    pub unsafe fn add<const WIDE: bool>(&mut self, to: &Where, reference: &Lanes) {
        for axis in 0..3 {
            let bin = &mut self.bins[to.0[axis] as usize % (2 * MOST_BINS)];
            // SAFETY: the caller's.
            unsafe { bin.boxes[axis].extend::<WIDE>(reference) };
            bin.counts[axis] += 1;
        }
    }

    /// Adds what is in the first `bins` bins of a side of `other`.
    pub fn merge(&mut self, other: &Self, side: usize, bins: usize) {
        for bin in 0..bins {
            let (to, from) = (&mut self.bins[at(side, bin)], &other.bins[at(side, bin)]);
            for axis in 0..3 {
                to.boxes[axis] = to.boxes[axis].union(&from.boxes[axis]);
                to.counts[axis] += from.counts[axis];
            }
        }
    }

    /// The cheapest plane with references on both sides: of equals the lowest axis and there the lowest plane.
    #[inline(always)]
    pub fn best(&mut self, side: usize, bins: usize, references: usize, costs: &mut u64) -> Option<Plane> {
        let mut best = (f32::INFINITY, 0, 0, 0);
        for axis in 0..3 {
            let mut right = Lanes::EMPTY;
            for bin in (1..bins).rev() {
                right = right.union(&self.bins[at(side, bin)].boxes[axis]);
                self.above[bin % MOST_BINS] = right.half_area();
            }
            let (mut left, mut count) = (Lanes::EMPTY, 0);
            for bin in 1..bins {
                let below = &self.bins[at(side, bin - 1)];
                left = left.union(&below.boxes[axis]);
                count += below.counts[axis] as usize;
                if count == 0 || count == references {
                    continue;
                }
                *costs += 1;
                let cost = left.half_area() * count as f32 + self.above[bin % MOST_BINS] * (references - count) as f32;
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
            (from..to).fold(Lanes::EMPTY, |all, bin| all.union(&self.bins[at(side, bin)].boxes[axis]))
        };
        Some(Plane { cost, axis, bin, left, boxes: [around(0, bin), around(bin, bins)] })
    }
}
