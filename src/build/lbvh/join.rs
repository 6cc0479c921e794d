//! Neighbours joined in the order of levels, the greatest first, from right to left.

use super::leaves::STACK;
use crate::bvh::Node;
use std::mem::MaybeUninit;
use std::ops::Range;

/// The levels at both ends of a part.
#[derive(Clone, Copy, Debug)]
pub(in crate::build) struct Edges {
    start: usize,
    pub left: i16,
    pub right: i16,
}

impl Edges {
    /// The level at the ends of the whole: everything joins before.
    pub const NONE: i16 = -1;

    /// Those of `part`.
    pub fn of(levels: &[u8], part: &Range<usize>) -> Self {
        let left = if part.start == 0 { Self::NONE } else { i16::from(levels[part.start - 1]) };
        Self { start: part.start, left, right: levels.get(part.end - 1).map_or(Self::NONE, |&level| level.into()) }
    }

    /// The level before a leaf of the part.
    #[inline(always)]
    pub fn before(&self, levels: &[u8], leaf: &Node) -> i16 {
        let slot = leaf.range().start;
        if slot == self.start { self.left } else { i16::from(levels[slot - 1]) }
    }
}

/// How many pairs of a part's nodes are joined within it: where neither all before nor all behind, to the edge and that
/// included, have greater levels.
pub(super) fn complete(leaves: &[Node], levels: &[u8], edges: &Edges) -> usize {
    let inner = || leaves[1..].iter().map(|leaf| edges.before(levels, leaf));
    // Falling from the left, the levels that are the least so far reach over the left edge; the same from the right. The least of
    // all, where it is below both edges, is met from either side.
    let reaching = |levels: &mut dyn Iterator<Item = i16>, edge: i16| {
        let mut least = edge;
        let lower = |&level: &i16| {
            let lower = level < least;
            least = least.min(level);
            lower
        };
        levels.filter(lower).count()
    };
    let both = usize::from(inner().min().is_some_and(|least| least < edges.left.min(edges.right)));
    leaves.len() - 1 - (reaching(&mut inner(), edges.left) + reaching(&mut inner().rev(), edges.right) - both)
}

/// Joins nodes that come with the level before them, from right to left, wherever the level between two is greater than those
/// on either side of both, and writes pairs of siblings into `region`, of which the first place has index `first`. `right` is
/// the level behind the first node.
///
/// Returns the nodes that are left, from right to left, with the level before each.
///
/// # Panics
/// Unless the pairs fill the region.
pub(in crate::build) fn join(
    nodes: impl Iterator<Item = (Node, i16)>,
    right: i16,
    region: &mut [MaybeUninit<Node>],
    first: usize,
) -> Vec<(Node, i16)> {
    let mut free = region.len();
    let mut stack: Vec<(Node, i16)> = Vec::with_capacity(STACK);
    for (mut node, before) in nodes {
        while let Some(&(next, level)) = stack.last() {
            let behind = if stack.len() < 2 { right } else { stack[stack.len() - 2].1 };
            if level <= before || level <= behind {
                break;
            }
            stack.pop();
            free -= 2;
            region[free].write(node);
            region[free + 1].write(next);
            node = Node::inner(node.aabb.union(&next.aabb), first + free, 2);
        }
        stack.push((node, before));
    }
    assert_eq!(free, 0, "pairs were miscounted");
    stack
}
