//! Ways in which a tree can be wrong.

use std::fmt;

/// One way in which a tree is not valid. Nodes, slots and triangles are named by their index.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Violation {
    /// There are no nodes.
    #[error("there is no root")]
    NoRoot,
    /// An inner node without children.
    #[error("inner node {0} has no children")]
    NoChildren(usize),
    /// Children beyond the last node.
    #[error("the children of node {0} lie beyond the last node")]
    ChildrenOutOfBounds(usize),
    /// A node that is its own child, or stands behind its child.
    #[error("node {0} does not stand before its children")]
    ChildNotBehind(usize),
    /// A node with two parents.
    #[error("node {child} is a child of node {parent} and of another one")]
    Shared {
        /// The node.
        child: usize,
        /// Its later parent.
        parent: usize,
    },
    /// A node that cannot be reached from the root.
    #[error("node {0} cannot be reached from the root")]
    Orphan(usize),
    /// More children than the tree's arity.
    #[error("node {node} has {children} children, more than the arity {arity}")]
    TooManyChildren {
        /// The node.
        node: usize,
        /// Its number of children.
        children: usize,
        /// The tree's arity.
        arity: usize,
    },
    /// Slots beyond the last one.
    #[error("the slots of leaf {0} lie beyond the last slot")]
    SlotsOutOfBounds(usize),
    /// Leaves that overlap so much that their triangles are not looked at one by one.
    #[error("the leaves claim {claimed} triangles of {slots} slots")]
    SlotsClaimed {
        /// Triangles over all leaves.
        claimed: usize,
        /// Slots there are.
        slots: usize,
    },
    /// More triangles than a leaf may hold.
    #[error("leaf {leaf} holds {triangles} triangles, more than {max_leaf}")]
    TooManyTriangles {
        /// The leaf.
        leaf: usize,
        /// Its number of triangles.
        triangles: usize,
        /// The limit.
        max_leaf: usize,
    },
    /// A leaf without triangles.
    #[error("leaf {0} is empty")]
    EmptyLeaf(usize),
    /// An id that no triangle has.
    #[error("leaf {leaf} holds triangle {triangle}, which does not exist")]
    UnknownTriangle {
        /// The leaf.
        leaf: usize,
        /// The id.
        triangle: u32,
    },
    /// A triangle held once more than it should be.
    #[error("triangle {triangle} stands in leaf {leaf} although it was held before")]
    Repeated {
        /// The later leaf.
        leaf: usize,
        /// The triangle.
        triangle: u32,
    },
    /// A triangle that no leaf holds.
    #[error("triangle {0} stands in no leaf")]
    Missing(usize),
    /// A triangle of which some part lies in no leaf that holds it.
    #[error("a part of triangle {0} lies in none of the leaves that hold it")]
    Uncovered(usize),
    /// A box that is not the union of the boxes below it.
    #[error("the box of node {0} is not the union of the boxes below it")]
    LooseBox(usize),
}

/// The first [`Violations::KEPT`] violations of a tree, and how many there are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violations {
    /// The first ones, in the order in which they were met; never empty.
    pub first: Vec<Violation>,
    /// All of them.
    pub total: usize,
}

impl Violations {
    /// How many violations are kept.
    pub const KEPT: usize = 16;
}

impl fmt::Display for Violations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let first = self.first.first().map(ToString::to_string).unwrap_or_default();
        match self.total {
            0 | 1 => write!(f, "invalid tree: {first}"),
            n => write!(f, "invalid tree: {first} (the first of {n} violations)"),
        }
    }
}

impl std::error::Error for Violations {}
