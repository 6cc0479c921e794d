//! The sets of instructions that kernels are made of.
//!
//! Every kernel is one body, generic over its [`Instructions`]. It is compiled for the baseline of the processor's family and, on
//! x86-64, for AVX2 as well; both give the same answers and the same counts.

use super::layout::BLOCK;
use super::order::{ByEach, Push};
use super::pack::Pack;
#[cfg(any(test, not(target_arch = "x86_64")))]
use super::pack::Portable;
use super::pack64::Pack64;
#[cfg(any(test, not(target_arch = "x86_64")))]
use super::pack64::Portable64;

/// What a kernel for nodes of `W` children computes with.
pub(in crate::trace) trait Instructions<const W: usize> {
    /// A number for each child of a node.
    type Children: Pack<W>;
    /// How children are put on the stack.
    type Order: Push<W, Self::Children>;
    /// A number for each triangle of a block.
    type Four: Pack<BLOCK>;
    /// The same in f64.
    type Four64: Pack64;
}

/// What every processor of the family has: SSE2 on x86-64, plain Rust elsewhere.
#[cfg(target_arch = "x86_64")]
pub(in crate::trace) struct Baseline;
#[cfg(not(target_arch = "x86_64"))]
pub(in crate::trace) type Baseline = Plain;

/// AVX2 and what comes with it.
#[cfg(target_arch = "x86_64")]
pub(in crate::trace) struct Avx2;

/// The best there is of the processor's family; whether a processor has it is found out when the program runs.
#[cfg(target_arch = "x86_64")]
pub(in crate::trace) type Best = Avx2;
#[cfg(not(target_arch = "x86_64"))]
pub(in crate::trace) type Best = Baseline;

/// Plain Rust: the scalar twin of the others.
#[cfg(any(test, not(target_arch = "x86_64")))]
pub(in crate::trace) struct Plain;

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::order::ByPermutation;
    use super::super::pack::{Avx, Sse, TwoSse};
    use super::super::pack64::{Avx64, TwoSse64};
    use super::{Avx2, Baseline, ByEach, Instructions};

    impl Instructions<4> for Baseline {
        type Children = Sse;
        type Order = ByEach;
        type Four = Sse;
        type Four64 = TwoSse64;
    }

    impl Instructions<8> for Baseline {
        type Children = TwoSse;
        type Order = ByEach;
        type Four = Sse;
        type Four64 = TwoSse64;
    }

    impl Instructions<4> for Avx2 {
        type Children = Sse;
        type Order = ByPermutation;
        type Four = Sse;
        type Four64 = Avx64;
    }

    impl Instructions<8> for Avx2 {
        type Children = Avx;
        type Order = ByPermutation;
        type Four = Sse;
        type Four64 = Avx64;
    }
}

#[cfg(any(test, not(target_arch = "x86_64")))]
impl<const W: usize> Instructions<W> for Plain {
    type Children = Portable<W>;
    type Order = ByEach;
    type Four = Portable<BLOCK>;
    type Four64 = Portable64;
}
