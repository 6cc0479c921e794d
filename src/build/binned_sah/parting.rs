//! References on their way to the two sides of a plane, and into the bins there.

use super::bins::{Bins, Grid, SideOf};
use super::lanes::Lanes;
use crate::simd::Simd;
use std::mem::MaybeUninit;

/// References that are parted before they go into bins, so that what either loop does for one of them overlaps with what
/// it does for others.
pub(super) const RUN: usize = 64;

/// From so many references on, every other one has bins of its own.
const ALTERNATELY: usize = 256;

/// References that have been written.
///
/// # Safety
/// All of them have.
#[inline(always)]
pub(super) unsafe fn written(references: &[MaybeUninit<Lanes>]) -> &[Lanes] {
    // SAFETY: the same layout; the caller's.
    unsafe { &*(std::ptr::from_ref(references) as *const [Lanes]) }
}

/// Where references go to.
///
/// # Safety
/// [`Self::is_full`] only where every place has been written.
pub(super) unsafe trait Target {
    /// Puts one behind those of its side.
    fn put(&mut self, side: usize, reference: &Lanes);

    /// Those put to each side since the last call.
    fn latest(&mut self) -> [&[Lanes]; 2];

    /// Whether every place has one.
    fn is_full(&self) -> bool;
}

/// Both sides, next to each other.
pub(super) struct Whole<'a> {
    to: &'a mut [MaybeUninit<Lanes>],
    /// References on the left so far.
    left: usize,
    first_right: usize,
    /// References on both sides so far.
    moved: usize,
    /// `left` and `moved` at the last call of [`Target::latest`].
    last: (usize, usize),
}

impl<'a> Whole<'a> {
    /// Places for all, of which so many are those of the left side.
    #[inline(always)]
    pub fn new(to: &'a mut [MaybeUninit<Lanes>], lefts: usize) -> Self {
        Self { to, left: 0, first_right: lefts, moved: 0, last: (0, 0) }
    }
}

// SAFETY: either side is written from its first place on, and is full when it has as many as it has places.
unsafe impl Target for Whole<'_> {
    #[inline(always)]
    fn put(&mut self, side: usize, reference: &Lanes) {
        // Without a branch, which would be guessed wrong often.
        let right = self.first_right + (self.moved - self.left);
        let at = self.left ^ ((self.left ^ right) & side.wrapping_neg());
        self.to[at].write(*reference);
        self.left += 1 - side;
        self.moved += 1;
    }

    #[inline(always)]
    fn latest(&mut self) -> [&[Lanes]; 2] {
        let (left, moved) = std::mem::replace(&mut self.last, (self.left, self.moved));
        let right = self.first_right + (moved - left)..self.first_right + (self.moved - self.left);
        // SAFETY: `put` wrote from either first place on, without a gap.
        [&self.to[left..self.left], &self.to[right]].map(|latest| unsafe { written(latest) })
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        (self.left, self.moved) == (self.first_right, self.to.len())
    }
}

/// A part of each side.
pub(super) struct Parted<'a> {
    to: [&'a mut [MaybeUninit<Lanes>]; 2],
    at: [usize; 2],
    /// `at` at the last call of [`Target::latest`].
    last: [usize; 2],
}

impl<'a> Parted<'a> {
    /// Places of either side.
    pub fn new(to: [&'a mut [MaybeUninit<Lanes>]; 2]) -> Self {
        Self { to, at: [0; 2], last: [0; 2] }
    }
}

// SAFETY: as above.
unsafe impl Target for Parted<'_> {
    #[inline(always)]
    fn put(&mut self, side: usize, reference: &Lanes) {
        self.to[side][self.at[side]].write(*reference);
        self.at[side] += 1;
    }

    #[inline(always)]
    fn latest(&mut self) -> [&[Lanes]; 2] {
        let last = std::mem::replace(&mut self.last, self.at);
        // SAFETY: `put` wrote to these places, one after the other.
        [0, 1].map(|side| unsafe { written(&self.to[side][last[side]..self.at[side]]) })
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.at == [self.to[0].len(), self.to[1].len()]
    }
}

/// How the references of a node part, and into which bins they go.
pub(super) struct Cut {
    pub side_of: SideOf,
    /// The bins of the two children; none for a child that needs none.
    pub grids: [Option<Grid>; 2],
}

impl Cut {
    /// Moves each reference to its side, in the order in which they are, and into the bins of that side.
    ///
    /// # Panics
    /// Unless as many as were counted are on either side.
    ///
    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    pub unsafe fn pass<const WIDE: bool>(&self, from: &[Lanes], mut to: impl Target, bins: &mut Bins) {
        let alternately = from.len() >= ALTERNATELY;
        for (side, grid) in self.grids.iter().enumerate() {
            if let Some(grid) = grid {
                bins.clear(side, grid.bins(), alternately);
            }
        }
        for run in from.chunks(RUN) {
            for reference in run {
                to.put(self.side_of.is_right(reference).bitmask() as usize & 1, reference);
            }
            let latest = to.latest();
            for (side, (grid, latest)) in self.grids.iter().zip(latest).enumerate() {
                if let Some(grid) = grid {
                    // SAFETY: the caller's.
                    unsafe { bins.add::<WIDE>(side, grid, latest, alternately) };
                }
            }
        }
        assert!(to.is_full(), "references were miscounted");
        if alternately {
            for (side, grid) in self.grids.iter().enumerate() {
                bins.merge_others(side, grid.as_ref().map_or(0, Grid::bins));
            }
        }
    }

    /// [`Self::pass`] by the instructions of `simd`.
    pub fn pass_with(&self, simd: Simd, from: &[Lanes], to: impl Target, bins: &mut Bins) {
        #[cfg(target_arch = "x86_64")]
        if simd >= Simd::Avx2 {
            // SAFETY: `Simd` says that the processor has AVX2.
            return unsafe { self.pass_avx2(from, to, bins) };
        }
        // SAFETY: without AVX.
        unsafe { self.pass::<false>(from, to, bins) };
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn pass_avx2(&self, from: &[Lanes], to: impl Target, bins: &mut Bins) {
        // SAFETY: AVX2 includes AVX.
        unsafe { self.pass::<true>(from, to, bins) };
    }

    /// References on the left side.
    pub fn lefts(&self, from: &[Lanes]) -> usize {
        from.iter().filter(|reference| self.side_of.is_right(reference).bitmask() == 0).count()
    }
}
