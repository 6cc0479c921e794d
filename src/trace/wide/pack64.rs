//! Four f64 numbers side by side, by whatever instructions there are: all give the same results, as those of `pack.rs` do.

/// Four numbers.
///
/// # Safety
/// A type may be used only where the processor has its instructions; all but [`Portable64`] and the SSE2 of x86-64 ask for
/// run-time detection.
pub(in crate::trace) unsafe trait Pack64: Copy {
    fn splat(x: f64) -> Self;
    fn load(from: &[f32; 4]) -> Self;
    /// Rounded to f32.
    fn store(self, to: &mut [f32; 4]);
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    /// `self < other ? self : other`, each.
    fn lesser(self, other: Self) -> Self;
    /// `self > other ? self : other`, each.
    fn greater(self, other: Self) -> Self;
    /// The sign taken off.
    fn magnitude(self) -> Self;
    /// One bit each, the first lowest: `self < other`.
    fn below(self, other: Self) -> u32;
}

/// Plain Rust: the twin of all others, and what other processors run.
#[cfg(any(test, not(target_arch = "x86_64")))]
#[derive(Clone, Copy, Debug)]
pub(in crate::trace) struct Portable64([f64; 4]);

#[cfg(any(test, not(target_arch = "x86_64")))]
impl Portable64 {
    #[inline(always)]
    fn each(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

// SAFETY: plain Rust.
#[cfg(any(test, not(target_arch = "x86_64")))]
unsafe impl Pack64 for Portable64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; 4])
    }
    #[inline(always)]
    fn load(from: &[f32; 4]) -> Self {
        Self(from.map(f64::from))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32; 4]) {
        *to = self.0.map(|x| x as f32);
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
    fn over(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
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
    fn magnitude(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        (0..4).map(|i| u32::from(self.0[i] < other.0[i]) << i).sum()
    }
}

#[cfg(target_arch = "x86_64")]
pub(in crate::trace) use x86::{Avx64, TwoSse64};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Pack64;
    use std::arch::x86_64::*;

    /// Four by AVX.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::trace) struct Avx64(__m256d);

    /// Four by SSE2, which every x86-64 has: two and two.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::trace) struct TwoSse64(__m128d, __m128d);

    // SAFETY: the trait's users vouch for AVX where they name this type.
    unsafe impl Pack64 for Avx64 {
        #[inline(always)]
        fn splat(x: f64) -> Self {
            // SAFETY: whoever names this type has AVX; so below.
            Self(unsafe { _mm256_set1_pd(x) })
        }
        #[inline(always)]
        fn load(from: &[f32; 4]) -> Self {
            // SAFETY: as above; four numbers are there.
            Self(unsafe { _mm256_cvtps_pd(_mm_loadu_ps(from.as_ptr())) })
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 4]) {
            // SAFETY: as above; four numbers have room.
            unsafe { _mm_storeu_ps(to.as_mut_ptr(), _mm256_cvtpd_ps(self.0)) }
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_add_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn minus(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_sub_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn times(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_mul_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn over(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_div_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn lesser(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_min_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn greater(self, other: Self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_max_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn magnitude(self) -> Self {
            // SAFETY: as above.
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)) as u32 }
        }
    }

    // SAFETY: SSE2 is part of x86-64.
    unsafe impl Pack64 for TwoSse64 {
        #[inline(always)]
        fn splat(x: f64) -> Self {
            // SAFETY: SSE2 is part of x86-64; so below.
            let two = unsafe { _mm_set1_pd(x) };
            Self(two, two)
        }
        #[inline(always)]
        fn load(from: &[f32; 4]) -> Self {
            // SAFETY: as above; four numbers are there.
            unsafe {
                let four = _mm_loadu_ps(from.as_ptr());
                Self(_mm_cvtps_pd(four), _mm_cvtps_pd(_mm_movehl_ps(four, four)))
            }
        }
        #[inline(always)]
        fn store(self, to: &mut [f32; 4]) {
            // SAFETY: as above; four numbers have room.
            unsafe { _mm_storeu_ps(to.as_mut_ptr(), _mm_movelh_ps(_mm_cvtpd_ps(self.0), _mm_cvtpd_ps(self.1))) }
        }
        #[inline(always)]
        fn plus(self, other: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm_add_pd(self.0, other.0), _mm_add_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn minus(self, other: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm_sub_pd(self.0, other.0), _mm_sub_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn times(self, other: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm_mul_pd(self.0, other.0), _mm_mul_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn over(self, other: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm_div_pd(self.0, other.0), _mm_div_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn lesser(self, other: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm_min_pd(self.0, other.0), _mm_min_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn greater(self, other: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm_max_pd(self.0, other.0), _mm_max_pd(self.1, other.1)) }
        }
        #[inline(always)]
        fn magnitude(self) -> Self {
            // SAFETY: as above.
            unsafe {
                let sign = _mm_set1_pd(-0.0);
                Self(_mm_andnot_pd(sign, self.0), _mm_andnot_pd(sign, self.1))
            }
        }
        #[inline(always)]
        fn below(self, other: Self) -> u32 {
            // SAFETY: as above.
            let bits = |a, b| unsafe { _mm_movemask_pd(_mm_cmplt_pd(a, b)) as u32 };
            bits(self.0, other.0) | bits(self.1, other.1) << 2
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(target_arch = "x86_64")]
    use crate::simd::Simd;

    const ODD: [f32; 8] = [f32::NAN, 0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, 1.5, -2.5, 1e-42];

    fn all<P: Pack64>() -> Vec<[u32; 4]> {
        let mut results = Vec::new();
        for turn in 0..8 {
            for shift in [0, 4] {
                let a = P::load(&std::array::from_fn(|i| ODD[i + shift]));
                let b = P::load(&std::array::from_fn(|i| ODD[(i + turn) % 8]));
                let mut put = |p: P| {
                    let mut out = [0.0; 4];
                    p.store(&mut out);
                    // Which NaN it is does not matter.
                    results.push(out.map(|x| if x.is_nan() { 1 } else { x.to_bits() }));
                };
                let third = P::splat(1.0).over(P::splat(3.0));
                for p in [a.plus(b), a.minus(b), a.times(b), a.over(b), a.lesser(b), a.greater(b), a.times(third)] {
                    put(p);
                    put(p.magnitude());
                }
                results.push([a.below(b); 4]);
            }
        }
        results
    }

    #[test]
    fn all_instructions_agree_on_odd_numbers() {
        #[cfg(target_arch = "x86_64")]
        {
            assert_eq!(all::<Portable64>(), all::<TwoSse64>());
            if Simd::detect() >= Simd::Avx2 {
                assert_eq!(all::<Portable64>(), all::<Avx64>());
            }
        }
        assert_eq!(all::<Portable64>().len(), 240);
    }
}
