//! The bins of the two children of a node, filled while the node is divided, and the best plane between them.

use super::MOST_BINS;
use super::lanes::{Lanes, Span};
use super::parting::RUN;
use glam::{BVec4A, Vec4};

/// What [`Grid`] says where all axes have bins.
const EVERY_AXIS: usize = 3;

/// Where the bins of a node lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    /// Doubled centre at the lower end of bin 0.
    low: Vec4,
    /// Bins per doubled scene unit; 0 on an axis on which nothing can be told apart.
    scale: Vec4,
    /// Index of the last bin.
    last: Vec4,
    /// The only axis with bins; [`EVERY_AXIS`] where all have them.
    axis: usize,
}

impl Grid {
    /// No bins to speak of: everything falls into bin 0.
    pub const NONE: Self = Self { low: Vec4::ZERO, scale: Vec4::ZERO, last: Vec4::ZERO, axis: EVERY_AXIS };

    /// `bins` bins of equal width over `span`: on each axis, or, if `widest`, on the one on which it is widest, the lowest
    /// of equals.
    #[inline(always)]
    pub fn over(span: &Span, bins: usize, widest: bool) -> Self {
        let widths = span.high - span.low;
        let scale = bins as f32 / widths;
        let usable = scale.cmpgt(Vec4::ZERO) & scale.cmplt(Vec4::INFINITY);
        let scale = Vec4::select(usable, scale, Vec4::ZERO);
        let [x, y, z, _] = widths.to_array();
        let (axis, width) = if y > x { (1, y) } else { (0, x) };
        let axis = if z > width { 2 } else { axis };
        let axis = if widest { axis } else { EVERY_AXIS };
        Self { low: span.low, scale, last: Vec4::splat((bins - 1) as f32), axis }
    }

    /// Number of bins.
    #[inline(always)]
    pub fn bins(&self) -> usize {
        self.last.x as usize + 1
    }

    /// The bin of a reference on each axis, and a number that means nothing.
    #[inline(always)]
    fn bins_of(&self, reference: &Lanes) -> [i32; 4] {
        let at = ((reference.centre() - self.low) * self.scale).max(Vec4::ZERO).min(self.last);
        // SAFETY: between 0 and `last`, which is below `MOST_BINS`; of NaN, `max` makes 0.
        at.to_array().map(|t| unsafe { t.to_int_unchecked() })
    }

    /// The bin of a reference on one axis.
    #[inline(always)]
    fn bin_on(&self, axis: usize, reference: &Lanes) -> usize {
        let above = (reference.centre_on(axis).x - self.low.as_ref()[axis]) * self.scale.as_ref()[axis];
        let above = if above > 0.0 { above } else { 0.0 };
        let above = if above < self.last.x { above } else { self.last.x };
        // SAFETY: between 0 and `last`, which is below `MOST_BINS`; a comparison with NaN makes 0 of it.
        unsafe { above.to_int_unchecked::<i32>() as usize }
    }

    /// The test whether references lie in bin `plane` of an axis or beyond.
    #[inline(always)]
    pub fn side_of(&self, axis: usize, plane: usize) -> SideOf {
        let [low, scale] = [self.low, self.scale].map(|v| Vec4::splat(v.as_ref()[axis]));
        SideOf { axis, low, scale, plane: Vec4::splat(plane as f32) }
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

/// Which side of a plane references are on.
#[derive(Clone, Copy, Debug)]
pub(super) struct SideOf {
    axis: usize,
    low: Vec4,
    scale: Vec4,
    plane: Vec4,
}

impl SideOf {
    /// All set for the right side, none for the left: the same arithmetic as [`Grid::bins_of`].
    #[inline(always)]
    pub fn is_right(&self, reference: &Lanes) -> BVec4A {
        ((reference.centre_on(self.axis) - self.low) * self.scale).cmpge(self.plane)
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

/// A bin of each axis.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
struct Bin {
    boxes: [Lanes; 3],
    counts: [i32; 4],
}

impl Bin {
    const EMPTY: Self = Self { boxes: [Lanes::EMPTY; 3], counts: [0; 4] };

    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    unsafe fn add<const WIDE: bool>(&mut self, axis: usize, reference: &Lanes) {
        // SAFETY: the caller's.
        unsafe { self.boxes[axis].extend::<WIDE>(reference) };
        self.counts[axis] += 1;
    }

    #[inline(always)]
    fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            self.boxes[axis] = self.boxes[axis].union(&other.boxes[axis]);
            self.counts[axis] += other.counts[axis];
        }
    }
}

/// Puts a reference into its bins of a side.
///
/// # Safety
/// `WIDE` only where the processor has AVX.
#[inline(always)]
unsafe fn add<const WIDE: bool>(bins: &mut [Bin; 2 * MOST_BINS], side: usize, to: &[i32; 4], reference: &Lanes) {
    for axis in 0..3 {
        // SAFETY: the caller's.
        unsafe { bins[at(side, to[axis] as usize)].add::<WIDE>(axis, reference) };
    }
}

/// The bins of the two children of a node.
pub(super) struct Bins {
    /// Alternately of the left and of the right child.
    bins: [Bin; 2 * MOST_BINS],
    /// The same for every other reference of a large node.
    others: [Bin; 2 * MOST_BINS],
    /// Half areas above each plane, an axis each.
    above: [Vec4; MOST_BINS],
    /// Bins of the references of a run.
    places: [[i32; 4]; RUN],
}

/// Where a bin is: in bounds for the compiler, too.
#[inline(always)]
const fn at(side: usize, bin: usize) -> usize {
    (2 * bin + side) % (2 * MOST_BINS)
}

impl Bins {
    /// Bins with nothing in them.
    pub fn new() -> Box<Self> {
        Box::new(Self {
            bins: [Bin::EMPTY; 2 * MOST_BINS],
            others: [Bin::EMPTY; 2 * MOST_BINS],
            above: [Vec4::ZERO; MOST_BINS],
            places: [[0; 4]; RUN],
        })
    }

    /// Empties the first `bins` bins of a side, and the others, too, where they are used.
    #[inline(always)]
    pub fn clear(&mut self, side: usize, bins: usize, alternately: bool) {
        for bin in 0..bins {
            self.bins[at(side, bin)] = Bin::EMPTY;
            if alternately {
                self.others[at(side, bin)] = Bin::EMPTY;
            }
        }
    }

    /// Puts at most [`RUN`] references into their bins; every other one into the others, if `alternately`, so that two of
    /// the same bin need not wait for each other.
    ///
    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    pub unsafe fn add<const WIDE: bool>(&mut self, side: usize, grid: &Grid, references: &[Lanes], alternately: bool) {
        // No closures from here on, which would not be for the same processor. SAFETY: the caller's.
        unsafe {
            let axis = grid.axis;
            if axis < EVERY_AXIS {
                for pair in references.chunks(2) {
                    self.bins[at(side, grid.bin_on(axis, &pair[0]))].add::<WIDE>(axis, &pair[0]);
                    if let Some(second) = pair.get(1) {
                        let bins = if alternately { &mut self.others } else { &mut self.bins };
                        bins[at(side, grid.bin_on(axis, second))].add::<WIDE>(axis, second);
                    }
                }
                return;
            }
            // Bins that are known early let the processor overlap what would otherwise wait for one maximum after another.
            for (to, reference) in self.places.iter_mut().zip(references) {
                *to = grid.bins_of(reference);
            }
            let to = &self.places[..references.len()];
            if !alternately {
                for (to, one) in to.iter().zip(references) {
                    add::<WIDE>(&mut self.bins, side, to, one);
                }
                return;
            }
            for (to, pair) in to.chunks_exact(2).zip(references.chunks_exact(2)) {
                add::<WIDE>(&mut self.bins, side, &to[0], &pair[0]);
                add::<WIDE>(&mut self.others, side, &to[1], &pair[1]);
            }
            if let (1, [.., to], [.., last]) = (references.len() % 2, to, references) {
                add::<WIDE>(&mut self.bins, side, to, last);
            }
        }
    }

    /// Adds the others to the first `bins` bins of a side.
    #[inline(always)]
    pub fn merge_others(&mut self, side: usize, bins: usize) {
        (0..bins).for_each(|bin| self.bins[at(side, bin)].merge(&self.others[at(side, bin)]));
    }

    /// Adds what is in the first `bins` bins of a side of `other`.
    pub fn merge(&mut self, other: &Self, side: usize, bins: usize) {
        (0..bins).for_each(|bin| self.bins[at(side, bin)].merge(&other.bins[at(side, bin)]));
    }

    /// The cheapest plane with references on both sides: of equals the lowest axis and there the lowest plane.
    ///
    /// All axes at once, and without branches: which of two planes is cheaper cannot be guessed.
    #[inline(always)]
    pub fn best(&mut self, side: usize, bins: usize, references: usize) -> Option<Plane> {
        let mut right = [Lanes::EMPTY; 3];
        for bin in (1..bins).rev() {
            let here = &self.bins[at(side, bin)];
            right = [0, 1, 2].map(|axis| right[axis].union(&here.boxes[axis]));
            self.above[bin % MOST_BINS] = Lanes::half_areas(&right);
        }
        let (mut left, mut count) = ([Lanes::EMPTY; 3], [0; 4]);
        let (mut best, mut planes) = (Vec4::INFINITY, Vec4::ZERO);
        for bin in 1..bins {
            let below = &self.bins[at(side, bin - 1)];
            left = [0, 1, 2].map(|axis| left[axis].union(&below.boxes[axis]));
            count = [0, 1, 2, 3].map(|i| count[i] + below.counts[i]);
            let lower = Vec4::from_array(count.map(|n| n as f32));
            let upper = Vec4::from_array(count.map(|n| (references as i32 - n) as f32));
            let cost = Lanes::half_areas(&left) * lower + self.above[bin % MOST_BINS] * upper;
            let cheaper = cost.cmplt(best) & lower.cmpgt(Vec4::ZERO) & upper.cmpgt(Vec4::ZERO);
            best = Vec4::select(cheaper, cost, best);
            planes = Vec4::select(cheaper, Vec4::splat(bin as f32), planes);
        }
        let [x, y, z, _] = best.to_array();
        let (axis, cost) = if y < x { (1, y) } else { (0, x) };
        let (axis, cost) = if z < cost { (2, z) } else { (axis, cost) };
        // SAFETY: a plane's number is one of `1..bins`, or 0.
        let bin = unsafe { planes.as_ref()[axis].to_int_unchecked::<i32>() } as usize;
        if bin == 0 {
            return None;
        }
        let around = |from: usize, to: usize| {
            (from..to).fold((Lanes::EMPTY, 0), |(all, count), bin| {
                let bin = &self.bins[at(side, bin)];
                (all.union(&bin.boxes[axis]), count + bin.counts[axis])
            })
        };
        let (lower, left) = around(0, bin);
        let (upper, _) = around(bin, bins);
        Some(Plane { cost, axis, bin, left: left as usize, boxes: [lower, upper] })
    }
}
