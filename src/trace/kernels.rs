//! The register of tracing kernels: what `list kernels` shows and `--kernel` accepts.

use super::first_leaf::FirstLeafOptions;
use crate::geom::Hit;

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
    /// Several boxes and triangles at a time.
    Wide {
        /// Boxes at a time.
        width: Width,
        /// Triangles by Möller–Trumbore in f32 alone; else the watertight test has the last word.
        fast: bool,
    },
    /// Eight boxes at a time, stored in fewer bits; triangles by the watertight test.
    Quantised(Bits),
}

/// Bits of a stored box's coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bits {
    /// 256 places an axis.
    Eight,
    /// 65,536 places an axis.
    Sixteen,
}

/// How many boxes a wide kernel tests at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Nodes of four children.
    Four,
    /// Nodes of eight.
    Eight,
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
        id: "bvh4",
        kernel: Kernel::Wide { width: Width::Four, fast: false },
        summary: "as scalar, hit for hit, by four boxes and four triangles at a time",
        paper: "Wald, Benthin and Boulos 2008; Woop, Benthin and Wald 2013",
    },
    KernelInfo {
        id: "bvh8",
        kernel: Kernel::Wide { width: Width::Eight, fast: false },
        summary: "as scalar, hit for hit, by eight boxes and four triangles at a time",
        paper: "Wald, Benthin and Boulos 2008; Woop, Benthin and Wald 2013",
    },
    KernelInfo {
        id: "bvh8-q16",
        kernel: Kernel::Quantised(Bits::Sixteen),
        summary: "as bvh8, hit for hit, with nodes of 192 bytes for 256: boxes in 16 bits, rounded outwards",
        paper: "Ylitie, Karras and Laine 2017; Mahovsky and Wyvill 2006",
    },
    KernelInfo {
        id: "bvh8-q8",
        kernel: Kernel::Quantised(Bits::Eight),
        summary: "as bvh8, hit for hit, with nodes of 128 bytes for 256: boxes in 8 bits, rounded outwards",
        paper: "Ylitie, Karras and Laine 2017; Mahovsky and Wyvill 2006",
    },
    KernelInfo {
        id: "bvh4-fast",
        kernel: Kernel::Wide { width: Width::Four, fast: true },
        summary: "as bvh4 with an f32 triangle test: rays may slip between two triangles",
        paper: "Wald, Benthin and Boulos 2008; Möller and Trumbore 1997",
    },
    KernelInfo {
        id: "bvh8-fast",
        kernel: Kernel::Wide { width: Width::Eight, fast: true },
        summary: "as bvh8 with an f32 triangle test: rays may slip between two triangles",
        paper: "Wald, Benthin and Boulos 2008; Möller and Trumbore 1997",
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

    /// Whether the kernel's answers are those of brute force with the watertight test, bit for bit.
    pub const fn is_exact(self) -> bool {
        matches!(self, Self::Scalar | Self::Wide { fast: false, .. } | Self::Quantised(_))
    }

    /// Whether the kernel tests several boxes at a time, by a layout of its own.
    pub const fn is_wide(self) -> bool {
        matches!(self, Self::Wide { .. } | Self::Quantised(_))
    }

    /// What stands for "yes" in answers to [`Query::Any`]: triangle 0 at t = 0.
    pub const SOME_HIT: Hit = Hit { triangle: 0, t: 0.0 };
}
