//! Trace counters: a type parameter of every kernel, so that an unprobed trace pays nothing.

/// What a kernel tells while it works. `()` is the probe that costs nothing.
pub trait TraceProbe {
    /// A node was entered, inner or leaf.
    #[inline(always)]
    fn node(&mut self) {}

    /// A ray was tested against a node's box.
    #[inline(always)]
    fn box_test(&mut self) {}

    /// A ray was tested against a triangle.
    #[inline(always)]
    fn triangle_test(&mut self) {}
}

impl TraceProbe for () {}

/// A probe that counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceCounters {
    /// Nodes entered, inner and leaf.
    pub nodes: u64,
    /// Rays tested against boxes of nodes.
    pub box_tests: u64,
    /// Rays tested against triangles.
    pub triangle_tests: u64,
}

impl TraceProbe for TraceCounters {
    #[inline(always)]
    fn node(&mut self) {
        self.nodes += 1;
    }

    #[inline(always)]
    fn box_test(&mut self) {
        self.box_tests += 1;
    }

    #[inline(always)]
    fn triangle_test(&mut self) {
        self.triangle_tests += 1;
    }
}

impl std::ops::Add for TraceCounters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            box_tests: self.box_tests + other.box_tests,
            triangle_tests: self.triangle_tests + other.triangle_tests,
        }
    }
}
