//! One body, one function a level of vector instructions.

/// Defines `fn NAME(simd, arguments)`, which runs `BODY(arguments)` compiled for the level `simd`. The body is an
/// `#[inline(always)]` function.
macro_rules! at_each_level {
    ($(#[$attribute:meta])* $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $output:ty)? = $body:path) => {
        $(#[$attribute])*
        $visibility fn $name(simd: $crate::simd::Simd, $($argument: $type),*) $(-> $output)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2($($argument: $type),*) $(-> $output)? {
                    $body($($argument),*)
                }
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
                fn avx512($($argument: $type),*) $(-> $output)? {
                    $body($($argument),*)
                }
                match simd {
                    $crate::simd::Simd::Baseline => {}
                    // SAFETY: a level is only ever had from `Simd::detect` or `Simd::available`: this processor has it.
                    $crate::simd::Simd::Avx2 => return unsafe { avx2($($argument),*) },
                    // SAFETY: as above.
                    $crate::simd::Simd::Avx512 => return unsafe { avx512($($argument),*) },
                }
            }
            let _ = simd;
            $body($($argument),*)
        }
    };
}

pub(in crate::build) use at_each_level;
