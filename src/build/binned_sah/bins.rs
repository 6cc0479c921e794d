//! The bins of the two children of a node, filled while the node is divided, and the best plane between them.

use super::MOST_BINS;
use super::lanes::{Lanes, Span};

/// Where the bins of a node lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    axis: usize,
    /// Doubled centre at the lower end of bin 0.
    low: f32,
    /// Bins per doubled scene unit; 0 where nothing can be told apart.
    scale: f32,
    /// Index of the last bin.
    last: f32,
}

impl Grid {
    /// No bins to speak of: everything falls into bin 0.
    pub const NONE: Self = Self { axis: 0, low: 0.0, scale: 0.0, last: 0.0 };

    /// `bins` bins of equal width on the axis on which `span` is widest; the lowest of equals.
    #[inline(always)]
    pub fn over(span: &Span, bins: usize) -> Self {
        let [x, y, z, _] = (span.high - span.low).to_array();
        let (axis, width) = if y > x { (1, y) } else { (0, x) };
        let (axis, width) = if z > width { (2, z) } else { (axis, width) };
        let scale = bins as f32 / width;
        let scale = if scale > 0.0 && scale < f32::INFINITY { scale } else { 0.0 };
        Self { axis, low: span.low.as_ref()[axis], scale, last: (bins - 1) as f32 }
    }

    /// Number of bins.
    #[inline(always)]
    pub fn bins(&self) -> usize {
        self.last as usize + 1
    }

    /// How many bins a reference is above the lower end.
    #[inline(always)]
    fn above(&self, reference: &Lanes) -> f32 {
        (reference.centre_on(self.axis) - self.low) * self.scale
    }

    /// The bin of a reference.
    #[inline(always)]
    fn bin_of(&self, reference: &Lanes) -> usize {
        let above = self.above(reference);
        let above = if above > 0.0 { above } else { 0.0 };
        let above = if above < self.last { above } else { self.last };
        // SAFETY: between 0 and `last`, which is below `MOST_BINS`; a comparison with NaN makes 0 of it.
        unsafe { above.to_int_unchecked::<i32>() as usize }
    }

    /// Whether a reference lies in bin `plane`, which is not 0, or beyond: the same arithmetic as for its bin.
    #[inline(always)]
    pub fn is_right(&self, reference: &Lanes, plane: f32) -> bool {
        self.above(reference) >= plane
    }

    /// The parts of `span`, which the bins cover, below and above a plane.
    #[inline(always)]
    pub fn cut(&self, span: &Span, plane: usize) -> [Span; 2] {
        let at = self.low + plane as f32 / self.scale;
        let (mut below, mut above) = (*span, *span);
        below.high.as_mut()[self.axis] = at;
        above.low.as_mut()[self.axis] = at;
        [below, above]
    }
}

/// A plane between two bins, and what lies on its sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Half area times references, of both sides together.
    pub cost: f32,
    /// First bin of the right side.
    pub bin: usize,
    /// References of the left side.
    pub left: usize,
    /// Boxes of the sides.
    pub boxes: [Lanes; 2],
}

/// References in a part of a node.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Bin {
    aabb: Lanes,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { aabb: Lanes::EMPTY, count: 0 };

    #[inline(always)]
    fn and(&self, other: &Self) -> Self {
        Self { aabb: self.aabb.union(&other.aabb), count: self.count + other.count }
    }

    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    unsafe fn add<const WIDE: bool>(&mut self, reference: &Lanes) {
        // SAFETY: the caller's.
        unsafe { self.aabb.extend::<WIDE>(reference) };
        self.count += 1;
    }
}

/// The bins of the two children of a node.
pub(super) struct Bins {
    bins: [[Bin; MOST_BINS]; 2],
    /// The same for every other reference of a large node.
    others: [[Bin; MOST_BINS]; 2],
    /// Half areas above each plane.
    above: [f32; MOST_BINS],
}

impl Bins {
    /// Bins with nothing in them.
    pub fn new() -> Box<Self> {
        let bins = [[Bin::EMPTY; MOST_BINS]; 2];
        Box::new(Self { bins, others: bins, above: [0.0; MOST_BINS] })
    }

    /// Empties the first `bins` bins of a side, and the others, too, where they are used.
    #[inline(always)]
    pub fn clear(&mut self, side: usize, bins: usize, alternately: bool) {
        self.bins[side][..bins].fill(Bin::EMPTY);
        if alternately {
            self.others[side][..bins].fill(Bin::EMPTY);
        }
    }

    /// Puts references into their bins; every other one into the others, if `alternately`, so that two of the same bin
    /// need not wait for each other.
    ///
    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    pub unsafe fn add<const WIDE: bool>(&mut self, side: usize, grid: &Grid, references: &[Lanes], alternately: bool) {
        let (bins, others) = (&mut self.bins[side], &mut self.others[side]);
        // No closures, which would not be for the same processor. SAFETY: the caller's.
        unsafe {
            if !alternately {
                for reference in references {
                    bins[grid.bin_of(reference) % MOST_BINS].add::<WIDE>(reference);
                }
                return;
            }
            for pair in references.chunks_exact(2) {
                bins[grid.bin_of(&pair[0]) % MOST_BINS].add::<WIDE>(&pair[0]);
                others[grid.bin_of(&pair[1]) % MOST_BINS].add::<WIDE>(&pair[1]);
            }
            if let (1, [.., last]) = (references.len() % 2, references) {
                bins[grid.bin_of(last) % MOST_BINS].add::<WIDE>(last);
            }
        }
    }

    /// Adds the others to the first `bins` bins of a side.
    #[inline(always)]
    pub fn merge_others(&mut self, side: usize, bins: usize) {
        (0..bins).for_each(|bin| self.bins[side][bin] = self.bins[side][bin].and(&self.others[side][bin]));
    }

    /// Adds what is in the first `bins` bins of a side of `other`.
    pub fn merge(&mut self, other: &Self, side: usize, bins: usize) {
        (0..bins).for_each(|bin| self.bins[side][bin] = self.bins[side][bin].and(&other.bins[side][bin]));
    }

    /// The cheapest plane with references on both sides: the lowest of equals.
    #[inline(always)]
    pub fn best(&mut self, side: usize, bins: usize, references: usize) -> Option<Plane> {
        let (bins, above) = (&self.bins[side][..bins], &mut self.above[..bins]);
        let mut right = Lanes::EMPTY;
        for (bin, above) in bins.iter().zip(&mut *above).skip(1).rev() {
            right = right.union(&bin.aabb);
            *above = right.half_area();
        }
        let mut left = Bin::EMPTY;
        let (mut cost, mut plane) = (f32::INFINITY, 0);
        for (i, (bin, above)) in bins.iter().zip(&above[1..]).enumerate() {
            left = left.and(bin);
            let here = left.aabb.half_area() * left.count as f32 + above * (references - left.count) as f32;
            // Without branches: which plane is cheaper cannot be guessed.
            let cheaper = (here < cost) & (left.count > 0) & (left.count < references);
            cost = if cheaper { here } else { cost };
            plane = if cheaper { i + 1 } else { plane };
        }
        if plane == 0 {
            return None;
        }
        let [left, right] =
            [&bins[..plane], &bins[plane..]].map(|side| side.iter().fold(Bin::EMPTY, |all, bin| all.and(bin)));
        Some(Plane { cost, bin: plane, left: left.count, boxes: [left.aabb, right.aabb] })
    }
}
