//! Working memory of the kernels, kept from ray to ray so that no ray allocates.

/// Explicit stacks of all kernels: they grow with the depth of the tree, the call stack does not.
///
/// One per thread; what it holds between two rays is of no meaning.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Nodes still to be entered, for kernel `scalar`.
    pub(super) open: Vec<OpenNode>,
    /// The same for the wide kernels, side by side: where each is entered, and which it is.
    pub(super) entries: Vec<f32>,
    pub(super) names: Vec<u32>,
    /// Inner nodes being worked on, for `first-leaf`.
    pub(super) frames: Vec<Frame>,
    /// Hit children of those nodes, frame after frame.
    pub(super) children: Vec<HitChild>,
}

/// A node whose box was hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenNode {
    pub(super) entry: f32,
    pub(super) node: u32,
}

/// An inner node that `first-leaf` is in the midst of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Where its hit children start in [`Scratch::children`]; they reach up to the next frame's.
    pub(super) start: usize,
    /// Node index of child 0.
    pub(super) first_child: u32,
    /// Boxes hit, less the visits that failed.
    pub(super) counter: usize,
}

/// A child whose box was hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct HitChild {
    pub(super) entry: f32,
    pub(super) exit: f32,
    pub(super) node: u32,
    pub(super) pending: bool,
}
