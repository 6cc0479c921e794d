//! In which order the children of a node are entered: near before far, as the octant of the ray's direction has it.
//!
//! The order is worked out once a node and octant, from the middles of the boxes along the octant's diagonal, and kept with
//! the node. Sorting by where a ray really enters would visit a few nodes less, but costs branches that no processor can
//! guess; this way all children that are met go to the stack at once, moved together by a table of permutations.
//!
//! Where any hit is enough, leaves are looked at before nodes that are nearer, for they may be the end of the search: that saves
//! much where large triangles stand high up in a tree, as walls do, and nothing is lost elsewhere.

use super::layout::LEAF;
use super::pack::Pack;

/// Bits of a child's place in an order.
const BITS: u32 = 3;

/// For each octant (bit 0: x falls along the ray, bit 1: y, bit 2: z) the children from near to far, [`BITS`] each, the first
/// lowest.
pub(super) fn orders<const W: usize>(bounds: &[[[f32; W]; 2]; 3]) -> [u32; 8] {
    std::array::from_fn(|octant| {
        let along = |lane: usize| -> f64 {
            let middle = |axis: usize| f64::from(bounds[axis][0][lane]) + f64::from(bounds[axis][1][lane]);
            (0..3).map(|axis| if octant >> axis & 1 == 1 { -middle(axis) } else { middle(axis) }).sum()
        };
        let mut lanes: [usize; W] = std::array::from_fn(|lane| lane);
        // Stable: of two as far the last comes first. Children that are not there have no middle (∞ − ∞).
        lanes.sort_by(|&a, &b| along(b).total_cmp(&along(a)));
        lanes.iter().fold(0, |order, &lane| order << BITS | lane as u32)
    })
}

/// How children are put on a stack in an order.
pub(in crate::trace) trait Push<const W: usize, P: Pack<W>> {
    /// Of the children whose `entry` is no more than their `exit`, writes all but one to the front of `entries` and `names`, far
    /// before near; what is behind them is of no meaning. Returns how many they are and that one, if any is met: the first in
    /// `order`, or the first leaf if there is one and `leaf_first`.
    fn push(
        entry: P,
        exit: P,
        child: &[u32; W],
        order: u32,
        leaf_first: bool,
        entries: &mut [f32; W],
        names: &mut [u32; W],
    ) -> Option<(usize, u32)>;
}

/// One by one, without branches, by any instructions.
pub(in crate::trace) struct ByEach;

impl<const W: usize, P: Pack<W>> Push<W, P> for ByEach {
    #[inline(always)]
    fn push(
        entry: P,
        exit: P,
        child: &[u32; W],
        order: u32,
        leaf_first: bool,
        entries: &mut [f32; W],
        names: &mut [u32; W],
    ) -> Option<(usize, u32)> {
        let met = entry.at_most(exit);
        let mut from = [0.0; W];
        entry.store(&mut from);
        let lane = |place: u32| (order >> (BITS * place)) as usize % W;
        let places = |lanes: u32| (0..W as u32).map(|place| (lanes >> lane(place) & 1) << place).sum::<u32>();
        let leaves = (0..W).map(|lane| u32::from(leaf_first && child[lane] & LEAF != 0) << lane).sum();
        let met = places(met);
        let first = first_of(met, places(leaves))?;
        let mut n = 0;
        for place in (0..W as u32).rev() {
            (entries[n % W], names[n % W]) = (from[lane(place)], child[lane(place)]);
            n += usize::from(met >> place & 1 == 1 && place != first);
        }
        Some((n, child[lane(first)]))
    }
}

/// The place to begin with, of the set of those that are met: the first of `leaves`, if there is one.
#[inline(always)]
fn first_of(met: u32, leaves: u32) -> Option<u32> {
    let preferred = if met & leaves != 0 { met & leaves } else { met };
    (met != 0).then(|| preferred.trailing_zeros())
}

#[cfg(target_arch = "x86_64")]
pub(in crate::trace) use x86::ByPermutation;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::pack::{Avx, Sse};
    use super::{BITS, Push, first_of};
    use std::arch::x86_64::*;

    /// All at once, by AVX2.
    pub(in crate::trace) struct ByPermutation;

    /// For each set of lanes, its members from high to low, a byte each.
    static MEMBERS: [[u8; 8]; 256] = {
        let mut table = [[0; 8]; 256];
        let mut set = 0;
        while set < 256 {
            let (mut lane, mut n) = (8, 0);
            while lane > 0 {
                lane -= 1;
                if set >> lane & 1 == 1 {
                    table[set][n] = lane as u8;
                    n += 1;
                }
            }
            set += 1;
        }
        table
    };

    impl Push<8, Avx> for ByPermutation {
        #[inline(always)]
        fn push(
            entry: Avx,
            exit: Avx,
            child: &[u32; 8],
            order: u32,
            leaf_first: bool,
            entries: &mut [f32; 8],
            names: &mut [u32; 8],
        ) -> Option<(usize, u32)> {
            const B: i32 = BITS as i32;
            // SAFETY: whoever names `Avx` has AVX2; the arrays have eight numbers.
            unsafe {
                let shifts = _mm256_setr_epi32(0, B, 2 * B, 3 * B, 4 * B, 5 * B, 6 * B, 7 * B);
                // Permutations look at the lowest three bits only.
                let lanes = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
                let met = _mm256_cmp_ps::<_CMP_LE_OQ>(entry.0, exit.0);
                let met = _mm256_movemask_ps(_mm256_permutevar8x32_ps(met, lanes)) as u32;
                let leaves = if leaf_first {
                    let child = _mm256_loadu_ps(child.as_ptr().cast());
                    // The mark of a leaf is where f32 has its sign.
                    _mm256_movemask_ps(_mm256_permutevar8x32_ps(child, lanes)) as u32
                } else {
                    0
                };
                let first = first_of(met, leaves)?;
                let others = (met & !(1 << first)) as usize;
                // Looked up on its own: what is done with it next must not wait for the stack.
                let first = child[(order >> (BITS * first)) as usize % 8];
                let members = _mm256_cvtepu8_epi32(_mm_loadl_epi64(MEMBERS[others].as_ptr().cast()));
                let lanes = _mm256_permutevar8x32_epi32(lanes, members);
                let child = _mm256_loadu_si256(child.as_ptr().cast());
                _mm256_storeu_ps(entries.as_mut_ptr(), _mm256_permutevar8x32_ps(entry.0, lanes));
                _mm256_storeu_si256(names.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(child, lanes));
                Some((others.count_ones() as usize, first))
            }
        }
    }

    impl Push<4, Sse> for ByPermutation {
        #[inline(always)]
        fn push(
            entry: Sse,
            exit: Sse,
            child: &[u32; 4],
            order: u32,
            leaf_first: bool,
            entries: &mut [f32; 4],
            names: &mut [u32; 4],
        ) -> Option<(usize, u32)> {
            const B: i32 = BITS as i32;
            // SAFETY: whoever names this type has AVX2; the arrays have four numbers.
            unsafe {
                let shifts = _mm_setr_epi32(0, B, 2 * B, 3 * B);
                // Permutations look at the lowest two bits only.
                let lanes = _mm_srlv_epi32(_mm_set1_epi32(order as i32), shifts);
                let met = _mm_cmple_ps(entry.0, exit.0);
                let met = _mm_movemask_ps(_mm_permutevar_ps(met, lanes)) as u32;
                let leaves = if leaf_first {
                    let child = _mm_loadu_ps(child.as_ptr().cast());
                    _mm_movemask_ps(_mm_permutevar_ps(child, lanes)) as u32
                } else {
                    0
                };
                let first = first_of(met, leaves)?;
                let others = (met & !(1 << first)) as usize;
                // Looked up on its own: what is done with it next must not wait for the stack.
                let first = child[(order >> (BITS * first)) as usize % 4];
                let members = _mm_cvtepu8_epi32(_mm_loadl_epi64(MEMBERS[others].as_ptr().cast()));
                let lanes = _mm_castps_si128(_mm_permutevar_ps(_mm_castsi128_ps(lanes), members));
                let child = _mm_loadu_ps(child.as_ptr().cast());
                _mm_storeu_ps(entries.as_mut_ptr(), _mm_permutevar_ps(entry.0, lanes));
                _mm_storeu_ps(names.as_mut_ptr().cast(), _mm_permutevar_ps(child, lanes));
                Some((others.count_ones() as usize, first))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pack::Portable;
    use super::*;
    use crate::bvh::testing::Random;
    #[cfg(target_arch = "x86_64")]
    use crate::simd::Simd;

    fn pushed<const W: usize, P: Pack<W>, O: Push<W, P>>(
        entry: &[f32; W],
        exit: &[f32; W],
        order: u32,
        child: &[u32; W],
        leaf_first: bool,
    ) -> Vec<(f32, u32)> {
        let (mut entries, mut names) = ([0.0; W], [0; W]);
        let pushed = O::push(P::load(entry), P::load(exit), child, order, leaf_first, &mut entries, &mut names);
        let Some((n, last)) = pushed else { return Vec::new() };
        entries.into_iter().zip(names).take(n).chain([(entry[(last & !LEAF) as usize - 100], last)]).collect()
    }

    fn check<const W: usize, P: Pack<W>, O: Push<W, P>>(seed: u64) {
        let mut random = Random(seed);
        for _ in 0..2000 {
            let bounds = std::array::from_fn(|_| {
                let low: [f32; W] = std::array::from_fn(|_| random.below(4) as f32);
                [low, low.map(|x| x + random.below(3) as f32)]
            });
            let entry: [f32; W] = std::array::from_fn(|_| random.below(5) as f32);
            let exit: [f32; W] =
                std::array::from_fn(|_| [f32::NAN, 0.0, 1.0, 2.0, 3.0, f32::INFINITY][random.below(6)]);
            for (octant, order) in orders(&bounds).into_iter().enumerate() {
                let far = |lane: usize| {
                    let signs = [octant & 1, octant >> 1 & 1, octant >> 2].map(|s| 1.0 - 2.0 * s as f32);
                    (0..3).map(|axis| signs[axis] * (bounds[axis][0][lane] + bounds[axis][1][lane])).sum::<f32>()
                };
                let leaves = random.below(1 << W) as u32;
                let child = std::array::from_fn(|lane| (100 + lane as u32) | (leaves >> lane as u32 & 1) << 31);
                let mut expected: Vec<_> = (0..W).filter(|&lane| entry[lane] <= exit[lane]).collect();
                expected.sort_by(|&a, &b| far(b).total_cmp(&far(a)));
                let expected: Vec<_> = expected.into_iter().map(|lane| (entry[lane], child[lane])).collect();
                assert_eq!(pushed::<W, P, O>(&entry, &exit, order, &child, false), expected, "octant {octant}");
                let mut leaf_last = expected;
                if let Some(leaf) = leaf_last.iter().rposition(|(_, child)| child & LEAF != 0) {
                    let leaf = leaf_last.remove(leaf);
                    leaf_last.push(leaf);
                }
                assert_eq!(pushed::<W, P, O>(&entry, &exit, order, &child, true), leaf_last, "octant {octant}");
            }
        }
    }

    #[test]
    fn what_is_met_goes_from_far_to_near_in_every_octant() {
        check::<4, Portable<4>, ByEach>(1);
        check::<8, Portable<8>, ByEach>(2);
        #[cfg(target_arch = "x86_64")]
        {
            use super::super::pack::{Avx, Sse, TwoSse};
            check::<4, Sse, ByEach>(3);
            check::<8, TwoSse, ByEach>(4);
            if Simd::detect() >= Simd::Avx2 {
                check::<4, Sse, ByPermutation>(5);
                check::<8, Avx, ByPermutation>(6);
            }
        }
    }
}
