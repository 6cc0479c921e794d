//! A few f32 numbers side by side, by whatever instructions there are: all give the same results, NaN included.
//!
//! Nothing here multiplies and adds in one rounding. `lesser` and `greater` are what SSE's `min` and `max` do: the second
//! operand where one is NaN, or where both are zeros.

/// `W` numbers.
///
/// # Safety
/// A type may be used only where the processor has its instructions; all but [`Portable`] and the SSE2 of x86-64 ask for
/// run-time detection.
pub(in crate::trace) unsafe trait Pack<const W: usize>: Copy {
    fn splat(x: f32) -> Self;
    fn load(from: &[f32; W]) -> Self;
    /// Whole numbers.
    fn of_u8(from: &[u8; W]) -> Self;
    /// Whole numbers.
    fn of_u16(from: &[u16; W]) -> Self;
    fn store(self, to: &mut [f32; W]);
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    /// `self < other ? self : other`, each.
    fn lesser(self, other: Self) -> Self;
    /// `self > other ? self : other`, each.
    fn greater(self, other: Self) -> Self;
    /// One bit each, the first lowest: `self <= other`.
    fn at_most(self, other: Self) -> u32;
    /// One bit each: `self < other`.
    fn below(self, other: Self) -> u32;
}

/// Plain Rust: the twin of all others, and what other processors run.
#[cfg(any(test, not(target_arch = "x86_64")))]
#[derive(Clone, Copy, Debug)]
pub(in crate::trace) struct Portable<const W: usize>([f32; W]);

#[cfg(any(test, not(target_arch = "x86_64")))]
impl<const W: usize> Portable<W> {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..W).map(|i| u32::from(f(self.0[i], other.0[i])) << i).sum()
    }
}

// SAFETY: plain Rust.
#[cfg(any(test, not(target_arch = "x86_64")))]
unsafe impl<const W: usize> Pack<W> for Portable<W> {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; W])
    }
    #[inline(always)]
    fn load(from: &[f32; W]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn of_u8(from: &[u8; W]) -> Self {
        Self(from.map(f32::from))
    }
    #[inline(always)]
    fn of_u16(from: &[u16; W]) -> Self {
        Self(from.map(f32::from))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; W]) {
        *to = self.0;
    }
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        self.each(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        self.each(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        self.bits(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        self.bits(other, |a, b| a < b)
    }
}

#[cfg(target_arch = "x86_64")]
pub(in crate::trace) use x86::{Avx, Sse, TwoSse};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Pack;
    use std::arch::x86_64::*;

    /// Four by SSE2, which every x86-64 has.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::trace) struct Sse(pub __m128);

    /// Eight by SSE2.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::trace) struct TwoSse(Sse, Sse);

    /// Eight by AVX2.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::trace) struct Avx(pub __m256);

    // SAFETY: SSE2 is part of x86-64.
    unsafe impl Pack<4> for Sse {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: SSE2 is part of x86-64; so below.
            Self(unsafe { _mm_set1_ps(x) })
        }
        #[inline(always)]
        fn load(from: &[f32; 4]) -> Self {
            // SAFETY: as above; four numbers are there.
            Self(unsafe { _mm_loadu_ps(from.as_ptr()) })
        }
        #[inline(always)]
        fn of_u8(from: &[u8; 4]) -> Self {
            // SAFETY: as above.
            unsafe {
                let bytes = _mm_cvtsi32_si128(i32::from_le_bytes(*from));
                let words = _mm_unpacklo_epi8(bytes, _mm_setzero_si128());
                Self(_mm_cvtepi32_ps(_mm_unpacklo_epi16(words, _mm_setzero_si128())))
            }
        }
        #[inline(always)]
        fn of_u16(from: &[u16; 4]) -> Self {
            // SAFETY: as above; four numbers are there.
            unsafe {
                let words = _mm_loadl_epi64(from.as_ptr().cast());
                Self(_mm_cvtepi32_ps(_mm_unpacklo_epi16(words, _mm_setzero_si128())))
            }
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 4]) {
            // SAFETY: as above; four numbers have room.
            unsafe { _mm_storeu_ps(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn minus(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn times(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn lesser(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn greater(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            // SAFETY: as above.
            unsafe { _mm_movemask_ps(_mm_cmple_ps(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            // SAFETY: as above.
            unsafe { _mm_movemask_ps(_mm_cmplt_ps(self.0, other.0)) as u32 }
        }
    }

    // SAFETY: SSE2 is part of x86-64.
    unsafe impl Pack<8> for TwoSse {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            Self(Sse::splat(x), Sse::splat(x))
        }
        #[inline(always)]
        fn load(from: &[f32; 8]) -> Self {
            let (low, high) = from.split_at(4);
            let four = |part: &[f32]| Sse::load(part.try_into().expect("half of eight"));
            Self(four(low), four(high))
        }
        #[inline(always)]
        fn of_u8(from: &[u8; 8]) -> Self {
            let (low, high) = from.split_at(4);
            Self(Sse::of_u8(&[low[0], low[1], low[2], low[3]]), Sse::of_u8(&[high[0], high[1], high[2], high[3]]))
        }
        #[inline(always)]
        fn of_u16(from: &[u16; 8]) -> Self {
            let (low, high) = from.split_at(4);
            Self(Sse::of_u16(&[low[0], low[1], low[2], low[3]]), Sse::of_u16(&[high[0], high[1], high[2], high[3]]))
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 8]) {
            let (low, high) = to.split_at_mut(4);
            self.0.store(low.try_into().expect("half of eight"));
            self.1.store(high.try_into().expect("half of eight"));
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            Self(self.0.plus(other.0), self.1.plus(other.1))
        }
        #[inline(always)]
        fn minus(self, other: Self) -> Self {
            Self(self.0.minus(other.0), self.1.minus(other.1))
        }
        #[inline(always)]
        fn times(self, other: Self) -> Self {
            Self(self.0.times(other.0), self.1.times(other.1))
        }
        #[inline(always)]
        fn lesser(self, other: Self) -> Self {
            Self(self.0.lesser(other.0), self.1.lesser(other.1))
        }
        #[inline(always)]
        fn greater(self, other: Self) -> Self {
            Self(self.0.greater(other.0), self.1.greater(other.1))
        }
        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            self.0.at_most(other.0) | self.1.at_most(other.1) << 4
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            self.0.below(other.0) | self.1.below(other.1) << 4
        }
    }

    // SAFETY: the trait's users vouch for AVX2 where they name this type.
    unsafe impl Pack<8> for Avx {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: whoever names this type has AVX2; so below.
            Self(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn load(from: &[f32; 8]) -> Self {
            // SAFETY: as above; eight numbers are there.
            Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
        }
        #[inline(always)]
        fn of_u8(from: &[u8; 8]) -> Self {
            // SAFETY: as above; eight numbers are there.
            Self(unsafe { _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(from.as_ptr().cast()))) })
        }
        #[inline(always)]
        fn of_u16(from: &[u16; 8]) -> Self {
            // SAFETY: as above; eight numbers are there.
            Self(unsafe { _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(from.as_ptr().cast()))) })
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 8]) {
            // SAFETY: as above; eight numbers have room.
            unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn minus(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn times(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn lesser(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn greater(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) as u32 }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(target_arch = "x86_64")]
    use crate::simd::Simd;

    const ODD: [f32; 8] = [f32::NAN, 0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, 1.5, -2.5, 1e-42];

    fn all<const W: usize, P: Pack<W>>() -> Vec<[u32; W]> {
        let mut results = Vec::new();
        for turn in 0..8 {
            let a = P::load(&std::array::from_fn(|i| ODD[i]));
            let b = P::load(&std::array::from_fn(|i| ODD[(i + turn) % 8]));
            let mut put = |p: P| {
                let mut out = [0.0; W];
                p.store(&mut out);
                // Which NaN it is does not matter.
                results.push(out.map(|x| if x.is_nan() { 1 } else { x.to_bits() }));
            };
            for p in [a.plus(b), a.minus(b), a.times(b), a.lesser(b), a.greater(b), P::splat(ODD[turn])] {
                put(p);
            }
            put(P::of_u8(&std::array::from_fn(|i| (turn * 31 + i * 77) as u8)));
            put(P::of_u16(&std::array::from_fn(|i| (turn * 9001 + i * 23456) as u16)));
            results.push([a.at_most(b); W]);
            results.push([a.below(b); W]);
        }
        results
    }

    #[test]
    fn all_instructions_agree_on_odd_numbers() {
        #[cfg(target_arch = "x86_64")]
        {
            assert_eq!(all::<4, Portable<4>>(), all::<4, Sse>());
            assert_eq!(all::<8, Portable<8>>(), all::<8, TwoSse>());
            if Simd::detect() >= Simd::Avx2 {
                assert_eq!(all::<8, Portable<8>>(), all::<8, Avx>());
            }
        }
        assert_eq!(all::<8, Portable<8>>().len(), 80);
    }
}
