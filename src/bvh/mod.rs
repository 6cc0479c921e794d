//! The tree: one node layout for every arity, and what can be asked of a finished tree.

mod export;
pub mod file;
mod hash;
mod quantise;
#[cfg(test)]
pub(crate) mod testing;
mod validate;

pub use export::{ExportError, export_boxes, export_json};
pub use hash::{TreeHash, tree_hash};
pub use quantise::{quantised, stored_bytes};
pub use validate::{Coverage, Limits, Violation, Violations, validate, validate_parts};

use crate::geom::Aabb;

/// Set in [`Node::tagged_count`] of a leaf.
const LEAF: u32 = 1 << 31;

/// One node, 32 bytes. The children of an inner node stand next to each other, always behind their parent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Node {
    /// Bounding box of everything below.
    pub aabb: Aabb,
    /// Inner: index of the first child in [`Bvh::nodes`]. Leaf: first slot in [`Bvh::triangle_ids`].
    first: u32,
    /// Number of children or of triangles; the top bit marks a leaf.
    tagged_count: u32,
}

/// What a node is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// Children: a range of [`Bvh::nodes`].
    Inner(std::ops::Range<usize>),
    /// Triangles: a range of [`Bvh::triangle_ids`], possibly empty.
    Leaf(std::ops::Range<usize>),
}

impl Node {
    /// An inner node over the nodes `first .. first + children`.
    #[inline]
    pub fn inner(aabb: Aabb, first: usize, children: usize) -> Self {
        debug_assert!(children > 0);
        Self {
            aabb,
            first: u32::try_from(first).expect("more than 2³² nodes"),
            tagged_count: u32::try_from(children).expect("too many children"),
        }
    }

    /// A leaf over the slots `first .. first + triangles`.
    #[inline]
    pub fn leaf(aabb: Aabb, first: usize, triangles: usize) -> Self {
        debug_assert!(triangles < LEAF as usize);
        Self {
            aabb, first: u32::try_from(first).expect("more than 2³² slots"), tagged_count: triangles as u32 | LEAF
        }
    }

    /// Whether the node is a leaf.
    #[inline(always)]
    pub fn is_leaf(&self) -> bool {
        self.tagged_count & LEAF != 0
    }

    /// Number of children of an inner node, of triangles of a leaf.
    #[inline(always)]
    pub fn count(&self) -> usize {
        (self.tagged_count & !LEAF) as usize
    }

    /// The range of nodes or slots below.
    #[inline(always)]
    pub fn range(&self) -> std::ops::Range<usize> {
        let first = self.first as usize;
        first..first + self.count()
    }

    /// The node's kind with its range.
    #[inline(always)]
    pub fn kind(&self) -> NodeKind {
        if self.is_leaf() { NodeKind::Leaf(self.range()) } else { NodeKind::Inner(self.range()) }
    }
}

/// A bounding volume hierarchy. Node 0 is the root; every child stands behind its parent, so a walk over the nodes
/// from the last to the first meets children before parents and needs no stack.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// Triangle ids in the order of the leaves' slots.
    pub triangle_ids: Vec<u32>,
    /// The greatest number of children a node of this tree was allowed to have.
    pub arity: usize,
}

impl Bvh {
    /// The root node.
    ///
    /// # Panics
    /// On a tree without nodes; no builder returns one.
    pub fn root(&self) -> &Node {
        &self.nodes[0]
    }

    /// Indices of the children of node `index`; empty for a leaf.
    pub fn children(&self, index: usize) -> std::ops::Range<usize> {
        match self.nodes[index].kind() {
            NodeKind::Inner(children) => children,
            NodeKind::Leaf(_) => 0..0,
        }
    }

    /// Triangle ids of the leaf `index`; empty for an inner node.
    pub fn leaf_triangles(&self, index: usize) -> &[u32] {
        match self.nodes[index].kind() {
            NodeKind::Inner(_) => &[],
            NodeKind::Leaf(slots) => &self.triangle_ids[slots],
        }
    }

    /// Bytes of nodes and triangle ids, without the triangles themselves.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.triangle_ids.as_slice())
    }
}
