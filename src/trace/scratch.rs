//! Working memory of the kernels, kept from ray to ray so that no ray allocates.

/// Explicit stacks of all kernels: they grow with the depth of the tree, the call stack does not.
///
/// One per thread; what it holds between two rays is of no meaning.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Nodes still to be entered, for kernel `scalar`.
    pub(super) open: Vec<OpenNode>,
    /// The stacks of the wide kernels, one behind the other.
    entries: Vec<f32>,
    names: Vec<u32>,
    /// Inner nodes being worked on, for `first-leaf`.
    pub(super) frames: Vec<Frame>,
    /// Hit children of those nodes, frame after frame.
    pub(super) children: Vec<HitChild>,
}

/// Nodes still to be entered, for the wide kernels: where each is entered, and which it is.
pub(super) struct Stack<'a> {
    pub(super) entries: &'a mut [f32],
    pub(super) names: &'a mut [u32],
}

impl Scratch {
    /// Stacks of `room` entries each.
    #[inline(always)]
    pub(super) fn stacks<const N: usize>(&mut self, room: usize) -> [Stack<'_>; N] {
        if self.entries.len() < N * room {
            self.entries.resize(N * room, 0.0);
            self.names.resize(N * room, 0);
        }
        let mut parts = self.entries.chunks_exact_mut(room).zip(self.names.chunks_exact_mut(room));
        std::array::from_fn(|_| {
            let (entries, names) = parts.next().expect("room for all");
            Stack { entries, names }
        })
    }
}

impl Stack<'_> {
    /// Room for the children of a node behind the first `top` entries.
    ///
    /// # Safety
    /// There are at least `top + W` entries.
    #[inline(always)]
    pub(super) unsafe fn room_behind<const W: usize>(&mut self, top: usize) -> (&mut [f32; W], &mut [u32; W]) {
        debug_assert!(top + W <= self.entries.len() && self.entries.len() == self.names.len());
        // SAFETY: the caller's promise; `names` has as many as `entries`.
        unsafe {
            (
                &mut *self.entries.as_mut_ptr().add(top).cast::<[f32; W]>(),
                &mut *self.names.as_mut_ptr().add(top).cast::<[u32; W]>(),
            )
        }
    }
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
