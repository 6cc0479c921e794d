//! Subtrees that one thread makes, and the tree that they make together.

use super::reference::Reference;
use super::split::{Effort, Splitter, Workspace};
use super::{Upper, union};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use crate::refine::open_leaves;

/// A finished subtree; node 0 is its root.
pub(super) struct Subtree {
    nodes: Vec<Node>,
    triangle_ids: Vec<u32>,
    pub effort: Effort,
}

/// A node not yet split. Its references are on top of the pool when its turn comes.
struct Open {
    node: usize,
    references: usize,
    budget: usize,
}

impl Subtree {
    /// Splits down to single references, and makes leaves of at most `max_leaf` triangles of them where the cost wants that.
    /// `pool` holds the root's.
    pub fn grow(
        splitter: &Splitter,
        mut pool: Vec<Reference>,
        budget: usize,
        max_leaf: usize,
        room: &mut Workspace,
    ) -> Self {
        room.effort = Effort::default();
        let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
        let mut triangle_ids = Vec::with_capacity(pool.len());
        let mut open = vec![Open { node: 0, references: pool.len(), budget }];
        while let Some(Open { node, references, budget }) = open.pop() {
            let start = pool.len() - references;
            let aabb = union(&pool[start..]);
            if references == 1 {
                nodes[node] = Node::leaf(aabb, triangle_ids.len(), 1);
                triangle_ids.push(pool[start].id);
                pool.truncate(start);
                continue;
            }
            let budgets = splitter.split(&pool[start..], &aabb, budget, room);
            pool.truncate(start);
            let first = nodes.len();
            nodes[node] = Node::inner(aabb, first, 2);
            nodes.resize(first + 2, nodes[0]);
            // The left one comes next.
            for (child, side) in [(1, &room.right), (0, &room.left)] {
                pool.extend_from_slice(side);
                open.push(Open { node: first + child, references: side.len(), budget: budgets[child] });
            }
        }
        let mut bvh = Bvh { nodes, triangle_ids, arity: 2 };
        if max_leaf > 1 {
            // Here, not in the whole tree: what waits for the last subtree is half as large.
            bvh = open_leaves(&bvh, max_leaf);
        }
        let Bvh { mut nodes, mut triangle_ids, .. } = bvh;
        nodes.shrink_to_fit();
        triangle_ids.shrink_to_fit();
        Self { nodes, triangle_ids, effort: room.effort }
    }
}

/// The tree, in depth-first order with siblings next to each other. Subtrees go as they find their place.
pub(super) fn assemble(upper: &[Upper], subtrees: Vec<Subtree>) -> Bvh {
    let nodes: usize = subtrees.iter().map(|s| s.nodes.len()).sum();
    let mut bvh = Bvh {
        nodes: Vec::with_capacity(nodes + upper.len()),
        triangle_ids: Vec::with_capacity(subtrees.iter().map(|s| s.triangle_ids.len()).sum()),
        arity: 2,
    };
    bvh.nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
    let mut subtrees: Vec<_> = subtrees.into_iter().map(Some).collect();
    let mut open = vec![(0, 0)];
    while let Some((node, place)) = open.pop() {
        match upper[place] {
            Upper::Inner(aabb, [left, right]) => {
                let first = bvh.nodes.len();
                bvh.nodes[node] = Node::inner(aabb, first, 2);
                bvh.nodes.resize(first + 2, Node::leaf(Aabb::EMPTY, 0, 0));
                open.extend([(first + 1, right), (first, left)]);
            }
            Upper::Subtree(number) => {
                let Subtree { nodes, triangle_ids, .. } = subtrees[number].take().expect("it has one place");
                // The root takes the place that is kept for it, all others follow.
                let (first_node, first_slot) = (bvh.nodes.len() - 1, bvh.triangle_ids.len());
                bvh.nodes[node] = moved(&nodes[0], first_node, first_slot);
                bvh.nodes.extend(nodes[1..].iter().map(|n| moved(n, first_node, first_slot)));
                bvh.triangle_ids.extend(triangle_ids);
            }
        }
    }
    bvh
}

/// The node, with children or slots so much further behind.
fn moved(node: &Node, nodes: usize, slots: usize) -> Node {
    match node.is_leaf() {
        true => Node::leaf(node.aabb, node.range().start + slots, node.count()),
        false => Node::inner(node.aabb, node.range().start + nodes, node.count()),
    }
}
