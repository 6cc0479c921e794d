//! The register of tracing kernels: what `list kernels` shows and `--kernel` accepts.

use super::closest::{FastTest, any_hit, closest_hit};
use super::first_leaf::{FirstLeafOptions, first_leaf};
use super::probe::TraceProbe;
use super::scratch::Scratch;
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};

/// What a kernel is called and where it comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KernelInfo {
    /// Its id on the command line and in rows.
    pub id: &'static str,
    /// The kernel.
    pub kernel: Kernel,
    /// One line on what it does.
    pub summary: &'static str,
    /// Its source.
    pub paper: &'static str,
}

/// A tracing kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// The thesis' program: ends at the first leaf that reports a hit.
    FirstLeaf(FirstLeafOptions),
    /// Closest hit with the watertight triangle test.
    Scalar,
    /// Closest hit with Möller–Trumbore in f32.
    ScalarFast,
}

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The hit with the least t; equal t: the lowest triangle id.
    Closest,
    /// Whether there is a hit at all.
    Any,
}

/// All kernels.
pub const KERNELS: &[KernelInfo] = &[
    KernelInfo {
        id: "scalar",
        kernel: Kernel::Scalar,
        summary: "closest hit, front to back, one box at a time; watertight, the default",
        paper: "Woop, Benthin and Wald 2013 (triangles); Ize 2013 (boxes)",
    },
    KernelInfo {
        id: "scalar-fast",
        kernel: Kernel::ScalarFast,
        summary: "as scalar with an f32 triangle test: rays may slip between two triangles",
        paper: "Möller and Trumbore 1997 (triangles); Ize 2013 (boxes)",
    },
    KernelInfo {
        id: "first-leaf",
        kernel: Kernel::FirstLeaf(FirstLeafOptions { tie_slip: true, linear_lookup: false }),
        summary: "the thesis' program: ends at the first leaf that reports a hit, not always the closest",
        paper: "Beick 2014",
    },
];

impl Kernel {
    /// The kernel called `id`, if there is one.
    pub fn from_id(id: &str) -> Option<Self> {
        KERNELS.iter().find(|k| k.id == id).map(|k| k.kernel)
    }

    /// Whether the kernel's answers are those of brute force; `first-leaf`'s are not.
    pub const fn is_exact(self) -> bool {
        matches!(self, Self::Scalar | Self::ScalarFast)
    }

    /// Traces one ray. For [`Query::Any`] the hit returned is [`Self::SOME_HIT`]: which triangle a search meets first
    /// depends on the tree, whether there is one does not.
    #[inline]
    pub fn trace<P: TraceProbe>(
        self,
        query: Query,
        bvh: &Bvh,
        triangles: &[Triangle],
        ray: &Ray,
        scratch: &mut Scratch,
        probe: &mut P,
    ) -> Option<Hit> {
        match (self, query) {
            (Self::Scalar, Query::Closest) => closest_hit::<WatertightRay, P>(bvh, triangles, ray, scratch, probe),
            (Self::ScalarFast, Query::Closest) => closest_hit::<FastTest, P>(bvh, triangles, ray, scratch, probe),
            (Self::FirstLeaf(options), Query::Closest) => first_leaf(bvh, triangles, ray, options, scratch, probe),
            (Self::Scalar, Query::Any) => {
                any_hit::<WatertightRay, P>(bvh, triangles, ray, scratch, probe).then_some(Self::SOME_HIT)
            }
            (Self::ScalarFast, Query::Any) => {
                any_hit::<FastTest, P>(bvh, triangles, ray, scratch, probe).then_some(Self::SOME_HIT)
            }
            (Self::FirstLeaf(options), Query::Any) => {
                first_leaf(bvh, triangles, ray, options, scratch, probe).map(|_| Self::SOME_HIT)
            }
        }
    }

    /// What stands for "yes" in answers to [`Query::Any`]: triangle 0 at t = 0.
    pub const SOME_HIT: Hit = Hit { triangle: 0, t: 0.0 };
}
