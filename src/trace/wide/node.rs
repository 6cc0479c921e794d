//! What the search asks of a node, however the node keeps the boxes of its children.

use super::layout::{NONE, WideNode};
use super::pack::Pack;

/// A node of at most `W` children.
pub trait Node<const W: usize> {
    /// How many children there are; they come before the places that are empty.
    fn count(&self) -> usize;

    /// Index of a node, or [`LEAF`](super::layout::LEAF) and that of a block; [`NONE`].
    fn child(&self) -> &[u32; W];

    /// For each octant of directions, the children from near to far ([`super::order`]).
    fn order(&self) -> &[u32; 8];

    /// Of each child's box, the lower (0) or upper (1) plane across an axis.
    fn planes<P: Pack<W>>(&self, axis: usize, side: usize) -> P;

    /// Beyond which no ray is inside a child: ∞, or −∞ where there is no child and the planes do not say so.
    fn ends<P: Pack<W>>(&self) -> P;
}

impl<const W: usize> Node<W> for WideNode<W> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.child.iter().filter(|&&child| child != NONE).count()
    }
    #[inline(always)]
    fn child(&self) -> &[u32; W] {
        &self.child
    }
    #[inline(always)]
    fn order(&self) -> &[u32; 8] {
        &self.order
    }
    #[inline(always)]
    fn planes<P: Pack<W>>(&self, axis: usize, side: usize) -> P {
        P::load(&self.bounds[axis][side])
    }
    #[inline(always)]
    fn ends<P: Pack<W>>(&self) -> P {
        // Empty boxes keep every ray out.
        P::splat(f32::INFINITY)
    }
}
