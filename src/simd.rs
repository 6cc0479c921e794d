//! Which vector instructions this processor has, found out at run time: binaries are for baseline x86-64 and for other
//! processors.
//!
//! A kernel is one body that is always inlined, called from one function a level with the level's target features. No
//! body multiplies and adds in one rounding, so all levels give the same results bit for bit.

/// Vector instructions, each level with those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Simd {
    /// What the target promises: SSE2 on x86-64.
    Baseline,
    /// AVX2, and the bit instructions that came with it: BMI1, BMI2, LZCNT, POPCNT.
    Avx2,
    /// AVX-512 F, VL, DQ and BW.
    Avx512,
}

impl Simd {
    /// All levels.
    pub const ALL: [Self; 3] = [Self::Baseline, Self::Avx2, Self::Avx512];

    /// The highest level of this processor. The answer is kept: asking costs a load.
    #[inline]
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            if avx2 {
                let avx512 = is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw");
                return if avx512 { Self::Avx512 } else { Self::Avx2 };
            }
        }
        Self::Baseline
    }

    /// The levels of this processor, for tests that compare them.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|&level| level <= Self::detect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_baseline_is_always_there_and_levels_have_no_gaps() {
        let levels: Vec<_> = Simd::available().collect();
        assert_eq!(levels[..], Simd::ALL[..levels.len()]);
        assert_eq!(levels.last(), Some(&Simd::detect()));
    }
}
