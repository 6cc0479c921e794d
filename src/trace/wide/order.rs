//! In which order the children of a node are entered: near before far, as the octant of the ray's direction has it.
//!
//! The order is worked out once a node and octant, from the middles of the boxes along the octant's diagonal, and kept with
//! the node. Sorting by where a ray really enters would visit a few nodes less, but costs branches that no processor can
//! guess; this way all children that are met go to the stack at once, moved together by a table of permutations.

use super::layout::NONE;
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
pub(super) trait Push<const W: usize, P: Pack<W>> {
    /// Of the children whose `entry` is no more than their `exit`, writes all but the first in `order` to the front of `entries`
    /// and `names`, far before near; what is behind them is of no meaning. Returns how many they are and the first one, or
    /// [`NONE`].
    fn push(
        entry: P,
        exit: P,
        child: &[u32; W],
        order: u32,
        entries: &mut [f32; W],
        names: &mut [u32; W],
    ) -> (usize, u32);
}

/// One by one, without branches, by any instructions.
pub(super) struct ByEach;

impl<const W: usize, P: Pack<W>> Push<W, P> for ByEach {
    #[inline(always)]
    fn push(
        entry: P,
        exit: P,
        child: &[u32; W],
        order: u32,
        entries: &mut [f32; W],
        names: &mut [u32; W],
    ) -> (usize, u32) {
        let met = entry.at_most(exit);
        let mut from = [0.0; W];
        entry.store(&mut from);
        let (mut n, mut first) = (0, NONE);
        for place in (0..W as u32).rev() {
            let lane = (order >> (BITS * place)) as usize % W;
            (entries[n % W], names[n % W]) = (from[lane], child[lane]);
            let is_met = met >> lane & 1 == 1;
            n += usize::from(is_met);
            first = if is_met { child[lane] } else { first };
        }
        (n.saturating_sub(1), first)
    }
}

#[cfg(target_arch = "x86_64")]
pub(super) use x86::ByPermutation;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::pack::{Avx, Sse};
    use super::{BITS, NONE, Push};
    use std::arch::x86_64::*;

    /// All at once, by AVX2.
    pub(in super::super) struct ByPermutation;

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

    /// The first of the children that are met, and the set of the others; both by their places in the order.
    #[inline(always)]
    fn split_first<const W: usize>(met: u32, child: &[u32; W], order: u32) -> (u32, usize) {
        let place = met.trailing_zeros();
        // Looked up on its own: what is done with it next must not wait for the stack.
        (child[(order >> (BITS * place)) as usize % W], (met & (met - 1)) as usize)
    }

    impl Push<8, Avx> for ByPermutation {
        #[inline(always)]
        fn push(
            entry: Avx,
            exit: Avx,
            child: &[u32; 8],
            order: u32,
            entries: &mut [f32; 8],
            names: &mut [u32; 8],
        ) -> (usize, u32) {
            const B: i32 = BITS as i32;
            // SAFETY: whoever names `Avx` has AVX2; the arrays have eight numbers.
            unsafe {
                let shifts = _mm256_setr_epi32(0, B, 2 * B, 3 * B, 4 * B, 5 * B, 6 * B, 7 * B);
                // Permutations look at the lowest three bits only.
                let lanes = _mm256_srlv_epi32(_mm256_set1_epi32(order as i32), shifts);
                let met = _mm256_cmp_ps::<_CMP_LE_OQ>(entry.0, exit.0);
                let met = _mm256_movemask_ps(_mm256_permutevar8x32_ps(met, lanes)) as u32;
                if met == 0 {
                    return (0, NONE);
                }
                let (first, others) = split_first(met, child, order);
                let members = _mm256_cvtepu8_epi32(_mm_loadl_epi64(MEMBERS[others].as_ptr().cast()));
                let lanes = _mm256_permutevar8x32_epi32(lanes, members);
                let child = _mm256_loadu_si256(child.as_ptr().cast());
                _mm256_storeu_ps(entries.as_mut_ptr(), _mm256_permutevar8x32_ps(entry.0, lanes));
                _mm256_storeu_si256(names.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(child, lanes));
                (others.count_ones() as usize, first)
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
            entries: &mut [f32; 4],
            names: &mut [u32; 4],
        ) -> (usize, u32) {
            const B: i32 = BITS as i32;
            // SAFETY: whoever names this type has AVX2; the arrays have four numbers.
            unsafe {
                let shifts = _mm_setr_epi32(0, B, 2 * B, 3 * B);
                // Permutations look at the lowest two bits only.
                let lanes = _mm_srlv_epi32(_mm_set1_epi32(order as i32), shifts);
                let met = _mm_cmple_ps(entry.0, exit.0);
                let met = _mm_movemask_ps(_mm_permutevar_ps(met, lanes)) as u32;
                if met == 0 {
                    return (0, NONE);
                }
                let (first, others) = split_first(met, child, order);
                let members = _mm_cvtepu8_epi32(_mm_loadl_epi64(MEMBERS[others].as_ptr().cast()));
                let lanes = _mm_castps_si128(_mm_permutevar_ps(_mm_castsi128_ps(lanes), members));
                let child = _mm_loadu_ps(child.as_ptr().cast());
                _mm_storeu_ps(entries.as_mut_ptr(), _mm_permutevar_ps(entry.0, lanes));
                _mm_storeu_ps(names.as_mut_ptr().cast(), _mm_permutevar_ps(child, lanes));
                (others.count_ones() as usize, first)
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
    ) -> Vec<(f32, u32)> {
        let child = std::array::from_fn(|lane| 100 + lane as u32);
        let (mut entries, mut names) = ([0.0; W], [0; W]);
        let (n, last) = O::push(P::load(entry), P::load(exit), &child, order, &mut entries, &mut names);
        let last = (last != NONE).then(|| (entry[last as usize - 100], last));
        entries.into_iter().zip(names).take(n).chain(last).collect()
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
                let found = pushed::<W, P, O>(&entry, &exit, order);
                let mut expected: Vec<_> = (0..W).filter(|&lane| entry[lane] <= exit[lane]).collect();
                expected.sort_by(|&a, &b| far(b).total_cmp(&far(a)));
                let expected: Vec<_> = expected.into_iter().map(|lane| (entry[lane], 100 + lane as u32)).collect();
                assert_eq!(found, expected, "octant {octant}");
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
