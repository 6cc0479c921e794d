//! Leaves over triangles in Morton order: subtrees that the cost wants closed.

use super::join::Edges;
use crate::build::morton::Order;
use crate::bvh::Node;
use crate::geom::Aabb;
use arrayvec::ArrayVec;
use std::ops::Range;

/// A subtree that may become a leaf, or one that is too large for that.
#[derive(Clone, Copy)]
struct Subtree {
    aabb: Aabb,
    /// Least cost, times the area of the root.
    cost: f64,
    triangles: u32,
    /// The first of its leaves.
    first_leaf: usize,
    /// The level at its end.
    level: i16,
}

/// Triangles of a subtree that is too large: more than any leaf, and added to as often as there are levels.
const LARGE: u32 = 1 << 16;

/// The most subtrees that wait: their levels rise, and there are 64 of codes, 31 of halves, and those of the edges.
pub(super) const STACK: usize = 128;

/// The leaves over `part` of the order, left to right, with slots as in the order. A subtree of at most `max_leaf` triangles is
/// closed where that costs no more than its best form: [`crate::refine::open_leaves`].
pub(super) fn leaves_of(
    boxes: &[Aabb],
    order: &Order,
    part: Range<usize>,
    edges: &Edges,
    max_leaf: usize,
) -> Vec<Node> {
    let mut leaves: Vec<Node> = Vec::with_capacity(part.len());
    if max_leaf == 1 {
        leaves.extend(part.map(|slot| Node::leaf(boxes[order.ids[slot] as usize], slot, 1)));
        return leaves;
    }
    let mut stack = ArrayVec::<Subtree, STACK>::new();
    // What stands before the part belongs to large subtrees, and so does what joins it.
    stack.push(Subtree { aabb: Aabb::EMPTY, cost: 0.0, triangles: LARGE, first_leaf: 0, level: edges.left });
    // Fetched before, not between, the branches that nobody can predict.
    let sorted: Vec<Aabb> = order.ids[part.clone()].iter().map(|&id| boxes[id as usize]).collect();
    for (slot, aabb) in part.clone().zip(sorted) {
        let level = if slot + 1 == part.end { edges.right } else { i16::from(order.levels[slot]) };
        let (cost, first_leaf) = (aabb.surface_area(), leaves.len());
        let mut subtree = Subtree { aabb, cost, triangles: 1, first_leaf, level };
        leaves.push(Node::leaf(aabb, slot, 1));
        while let Some(left) = stack.last().filter(|left| left.level > level) {
            subtree = pair(left, &subtree, &mut leaves, max_leaf);
            stack.pop();
        }
        stack.push(subtree);
    }
    leaves
}

/// The subtree over two neighbours, closed or not.
#[inline(always)]
fn pair(left: &Subtree, right: &Subtree, leaves: &mut Vec<Node>, max_leaf: usize) -> Subtree {
    let triangles = left.triangles + right.triangles;
    if triangles as usize > max_leaf {
        return Subtree { triangles: LARGE, ..*right };
    }
    let aabb = left.aabb.union(&right.aabb);
    let area = aabb.surface_area();
    let (open, closed) = (area + (left.cost + right.cost), area * f64::from(triangles));
    let first_leaf = left.first_leaf;
    if closed <= open {
        let slot = leaves[first_leaf].range().start;
        leaves.truncate(first_leaf);
        leaves.push(Node::leaf(aabb, slot, triangles as usize));
    }
    Subtree { aabb, cost: open.min(closed), triangles, first_leaf, level: right.level }
}
