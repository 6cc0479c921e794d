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
    /// Least cost, times the area of the root; not that of a cluster which is no leaf.
    cost: f64,
    /// Its cost if it were a leaf.
    as_leaf: f64,
    triangles: u32,
    /// The first of its leaves.
    first_leaf: usize,
    /// The first of its clusters.
    first_cluster: usize,
    /// The level at its end.
    level: i16,
}

/// Triangles of a subtree that is too large: more than any leaf, and added to as often as there are levels.
const LARGE: u32 = 1 << 16;

/// The most subtrees that wait: their levels rise, and there are 64 of codes, 31 of halves, and those of the edges.
pub(super) const STACK: usize = 128;

/// What a cluster may cost at most, were it a leaf, over what its two halves would as leaves: more says that they are of
/// different sizes or far apart. An even row or sheet costs twice what its halves do, a cube one and a half times.
pub(in crate::build) const MOST_GROWTH: f64 = 3.0;

/// Subtrees that are cut off above leaves, as they are found.
pub(in crate::build) trait Clusters {
    /// The most triangles of one.
    fn most(&self) -> usize;

    /// How many there are.
    fn count(&self) -> usize;

    /// Another one, from this leaf on.
    fn push(&mut self, first_leaf: usize);

    /// From this one on, all are one.
    fn unite(&mut self, first: usize);
}

/// None.
impl Clusters for () {
    fn most(&self) -> usize {
        0
    }

    fn count(&self) -> usize {
        0
    }

    fn push(&mut self, _: usize) {}

    fn unite(&mut self, _: usize) {}
}

/// The leaves over `part` of the order, left to right, with slots as in the order. A subtree of at most `max_leaf` triangles is
/// closed where that costs no more than its best form: [`crate::refine::open_leaves`]. The largest subtrees of at most
/// [`Clusters::most`] triangles, no fewer than `max_leaf` unless there are to be none, in which nothing above leaves grows by more
/// than [`MOST_GROWTH`], are `clusters`.
pub(in crate::build) fn leaves_of(
    boxes: &[Aabb],
    order: &Order,
    part: Range<usize>,
    edges: &Edges,
    max_leaf: usize,
    clusters: &mut impl Clusters,
) -> Vec<Node> {
    let mut leaves: Vec<Node> = Vec::with_capacity(part.len());
    if max_leaf == 1 && clusters.most() == 0 {
        leaves.extend(part.map(|slot| Node::leaf(boxes[order.ids[slot] as usize], slot, 1)));
        return leaves;
    }
    let mut stack = ArrayVec::<Subtree, STACK>::new();
    // What stands before the part belongs to large subtrees, and so does what joins it.
    let large = Subtree {
        aabb: Aabb::EMPTY,
        cost: 0.0,
        as_leaf: 0.0,
        triangles: LARGE,
        first_leaf: 0,
        first_cluster: 0,
        level: edges.left,
    };
    stack.push(large);
    // Fetched before, not between, the branches that nobody can predict.
    let sorted: Vec<Aabb> = order.ids[part.clone()].iter().map(|&id| boxes[id as usize]).collect();
    for (slot, aabb) in part.clone().zip(sorted) {
        let level = if slot + 1 == part.end { edges.right } else { i16::from(order.levels[slot]) };
        let (cost, first_leaf, first_cluster) = (aabb.surface_area(), leaves.len(), clusters.count());
        let mut subtree = Subtree { aabb, cost, as_leaf: cost, triangles: 1, first_leaf, first_cluster, level };
        leaves.push(Node::leaf(aabb, slot, 1));
        clusters.push(first_leaf);
        while let Some(left) = stack.last().filter(|left| left.level > level) {
            subtree = pair(left, &subtree, &mut leaves, max_leaf, clusters);
            stack.pop();
        }
        stack.push(subtree);
    }
    leaves
}

/// The subtree over two neighbours, closed or not.
#[inline(always)]
fn pair(
    left: &Subtree,
    right: &Subtree,
    leaves: &mut Vec<Node>,
    max_leaf: usize,
    clusters: &mut impl Clusters,
) -> Subtree {
    let triangles = left.triangles + right.triangles;
    if triangles as usize > max_leaf {
        if triangles as usize > clusters.most() {
            return Subtree { triangles: LARGE, ..*right };
        }
        let aabb = left.aabb.union(&right.aabb);
        let as_leaf = aabb.surface_area() * f64::from(triangles);
        if as_leaf > MOST_GROWTH * (left.as_leaf + right.as_leaf) {
            return Subtree { triangles: LARGE, ..*right };
        }
        let (first_leaf, first_cluster) = (left.first_leaf, left.first_cluster);
        clusters.unite(first_cluster);
        return Subtree { aabb, cost: as_leaf, as_leaf, triangles, first_leaf, first_cluster, level: right.level };
    }
    let aabb = left.aabb.union(&right.aabb);
    let area = aabb.surface_area();
    let (open, closed) = (area + (left.cost + right.cost), area * f64::from(triangles));
    let (first_leaf, first_cluster) = (left.first_leaf, left.first_cluster);
    if closed <= open {
        let slot = leaves[first_leaf].range().start;
        leaves.truncate(first_leaf);
        leaves.push(Node::leaf(aabb, slot, triangles as usize));
    }
    clusters.unite(first_cluster);
    Subtree { aabb, cost: open.min(closed), as_leaf: closed, triangles, first_leaf, first_cluster, level: right.level }
}
