//! What the search asks of a node, however the node keeps the boxes of its children.

use super::layout::{NONE, WideNode};
use super::pack::Pack;

/// One of the two planes of a box across an axis, in a type that needs no check as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Side {
    /// At the lesser coordinate.
    Lower,
    /// At the greater.
    Upper,
}

/// A node of at most `W` children.
pub trait Node<const W: usize> {
    /// How many children there are; they come before the places that are empty.
    fn count(&self) -> usize;

    /// Index of a node, or [`LEAF`](super::layout::LEAF) and that of a block; [`NONE`].
    fn child(&self) -> &[u32; W];

    /// For each octant of directions, the children from near to far ([`super::order`]).
    fn order(&self) -> &[u32; 8];

    /// Of each child's box, a plane across an axis.
    fn planes<P: Pack<W>>(&self, axis: usize, side: Side) -> P;

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
    fn planes<P: Pack<W>>(&self, axis: usize, side: Side) -> P {
        P::load(&self.bounds[axis][side as usize])
    }
    #[inline(always)]
    fn ends<P: Pack<W>>(&self) -> P {
        // Empty boxes keep every ray out.
        P::splat(f32::INFINITY)
    }
}
