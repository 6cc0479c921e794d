//! The thesis' collapse (2014, "Bottom-Up"): a binary tree becomes one of higher arity by dissolving nodes into their parents.
//!
//! Nodes are visited in reverse breadth-first order, so from the deepest level up and on each level from the right. It is
//! greedy and blind to geometry: a node goes wherever there is room, which gives average degrees of about 3.7 at arity 4
//! and 6.6 at arity 8.

use crate::bvh::{Bvh, Node};

/// No node: the end of a list of children.
const NONE: u32 = u32::MAX;

/// Dissolves every inner node with m children, whose parent has p, into its parent when p − 1 + m ≤ `arity`, in reverse
/// breadth-first order and with m and p as they are by then. A dissolved node's children come first among its parent's,
/// then the others as they were.
///
/// The input is a valid tree of any arity (the thesis': 2). Its boxes and slots are kept; the output stands in
/// depth-first order with siblings next to each other. Its arity is `arity`, or the input's where that is greater. Time
/// is O(nodes · arity).
pub fn collapse(bvh: &Bvh, arity: usize) -> Bvh {
    let mut lists = ChildLists::new(bvh);
    let (order, parents) = breadth_first(bvh);
    // The root, first in order, has no parent to dissolve into.
    for &node in order.iter().skip(1).rev() {
        let parent = parents[node as usize];
        let (m, p) = (lists.count[node as usize], lists.count[parent as usize]);
        if !bvh.nodes[node as usize].is_leaf() && p - 1 + m <= arity {
            lists.dissolve(node, parent);
        }
    }
    Bvh { nodes: lists.depth_first(bvh), triangle_ids: bvh.triangle_ids.clone(), arity: arity.max(bvh.arity) }
}

/// All nodes, level by level and left to right, and each node's parent ([`NONE`] for the root).
fn breadth_first(bvh: &Bvh) -> (Vec<u32>, Vec<u32>) {
    let mut order = Vec::with_capacity(bvh.nodes.len());
    let mut parents = vec![NONE; bvh.nodes.len()];
    if !bvh.nodes.is_empty() {
        order.push(0);
    }
    let mut done = 0;
    while let Some(&node) = order.get(done) {
        for child in bvh.children(node as usize) {
            parents[child] = node;
            order.push(child as u32);
        }
        done += 1;
    }
    (order, parents)
}

/// The children of every node as a linked list, so that moving them costs no more than walking them.
///
/// Children moved up keep their old parent in the visiting order's table: they were visited before and are not asked
/// for again.
struct ChildLists {
    first: Vec<u32>,
    next: Vec<u32>,
    count: Vec<usize>,
}

impl ChildLists {
    fn new(bvh: &Bvh) -> Self {
        let n = bvh.nodes.len();
        let (mut first, mut next, mut count) = (vec![NONE; n], vec![NONE; n], vec![0; n]);
        for node in 0..n {
            let children = bvh.children(node);
            count[node] = children.len();
            if !children.is_empty() {
                first[node] = children.start as u32;
                next[children.clone()]
                    .iter_mut()
                    .zip(children.skip(1))
                    .for_each(|(next, sibling)| *next = sibling as u32);
            }
        }
        Self { first, next, count }
    }

    /// The children of `node`, left to right.
    fn of(&self, node: u32) -> impl Iterator<Item = u32> + '_ {
        let known = |n: u32| (n != NONE).then_some(n);
        std::iter::successors(known(self.first[node as usize]), move |&n| known(self.next[n as usize]))
    }

    /// Takes `node` out of its parent's list and puts its children before what is left.
    fn dissolve(&mut self, node: u32, parent: u32) {
        let after = self.next[node as usize];
        let before = self.of(parent).take_while(|&n| n != node).last();
        let rest = match before {
            Some(left) => {
                self.next[left as usize] = after;
                self.first[parent as usize]
            }
            None => after,
        };
        self.first[parent as usize] = match self.of(node).last() {
            Some(last) => {
                self.next[last as usize] = rest;
                self.first[node as usize]
            }
            None => rest,
        };
        self.count[parent as usize] += self.count[node as usize];
        self.count[parent as usize] -= 1;
    }

    /// The tree that the lists describe.
    fn depth_first(&self, bvh: &Bvh) -> Vec<Node> {
        let mut nodes = Vec::with_capacity(bvh.nodes.len());
        let mut stack = Vec::new();
        if let Some(&root) = bvh.nodes.first() {
            nodes.push(root);
            stack.push((0, 0));
        }
        while let Some((place, node)) = stack.pop() {
            if bvh.nodes[node as usize].is_leaf() {
                continue;
            }
            let first = nodes.len();
            nodes[place] = Node::inner(bvh.nodes[node as usize].aabb, first, self.count[node as usize]);
            nodes.extend(self.of(node).map(|child| bvh.nodes[child as usize]));
            let old_top = stack.len();
            stack.extend((first..).zip(self.of(node)));
            // The leftmost child is to come off first.
            stack[old_top..].reverse();
        }
        nodes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{Random, boxes, median_split, random_tree, soup};
    use crate::bvh::{Limits, tree_hash, validate};
    use crate::cost::stats;
    use crate::geom::Aabb;
    use glam::Vec3;
    use proptest::prelude::*;

    /// The description taken word by word, with lists of children in vectors and parents found by looking everywhere.
    fn literal(bvh: &Bvh, arity: usize) -> Bvh {
        let mut children: Vec<Vec<usize>> = (0..bvh.nodes.len()).map(|n| bvh.children(n).collect()).collect();
        let mut order = vec![0];
        for i in 0.. {
            match order.get(i) {
                Some(&node) => order.extend(children[node].clone()),
                None => break,
            }
        }
        for &node in order.iter().rev() {
            let Some(parent) = children.iter().position(|c| c.contains(&node)) else {
                continue;
            };
            if !children[node].is_empty() && children[parent].len() - 1 + children[node].len() <= arity {
                let mut merged = std::mem::take(&mut children[node]);
                merged.extend(children[parent].iter().filter(|&&c| c != node));
                children[parent] = merged;
            }
        }
        // Breadth-first layout: another one than the real thing's.
        let mut nodes = vec![bvh.nodes[0]];
        let mut old = vec![0];
        for place in 0.. {
            let Some(&node) = old.get(place) else { break };
            if !bvh.nodes[node].is_leaf() {
                nodes[place] = Node::inner(bvh.nodes[node].aabb, nodes.len(), children[node].len());
                nodes.extend(children[node].iter().map(|&c| bvh.nodes[c]));
                old.extend(&children[node]);
            }
        }
        Bvh { nodes, triangle_ids: bvh.triangle_ids.clone(), arity }
    }

    fn unit_box(at: usize) -> Aabb {
        Aabb::new(Vec3::X * at as f32, Vec3::X * at as f32 + Vec3::ONE)
    }

    /// A binary tree from a list of node kinds: `None` a leaf with the next triangle, `Some` the first child.
    fn binary(kinds: &[Option<usize>]) -> (Bvh, Vec<Aabb>) {
        let mut ids = 0;
        let mut bvh = Bvh {
            nodes: kinds
                .iter()
                .map(|kind| match kind {
                    Some(first) => Node::inner(Aabb::EMPTY, *first, 2),
                    None => {
                        ids += 1;
                        Node::leaf(Aabb::EMPTY, ids - 1, 1)
                    }
                })
                .collect(),
            triangle_ids: (0..ids as u32).collect(),
            arity: 2,
        };
        let boxes: Vec<Aabb> = (0..ids).map(unit_box).collect();
        crate::bvh::testing::tighten(&mut bvh, &boxes);
        (bvh, boxes)
    }

    /// Inner nodes at even places, each over a leaf and the next inner node; the last one over two leaves.
    fn chain(inner: usize) -> Vec<Option<usize>> {
        let mut kinds: Vec<_> = (0..inner).flat_map(|i| [Some(2 * i + 1), None]).collect();
        kinds.push(None);
        kinds
    }

    /// Triangles of the root's children, a list for each.
    fn root_lists(bvh: &Bvh) -> Vec<Vec<u32>> {
        bvh.children(0)
            .map(|child| {
                let mut stack = vec![child];
                let mut list = Vec::new();
                while let Some(node) = stack.pop() {
                    list.extend(bvh.leaf_triangles(node));
                    stack.extend(bvh.children(node).rev());
                }
                list
            })
            .collect()
    }

    #[test]
    fn seven_nodes_by_hand() {
        // Root 0 over 1 and 2, each over two leaves: 3, 4 (triangles 0, 1) and 5, 6 (triangles 2, 3).
        let (bvh, boxes) = binary(&[Some(1), Some(3), Some(5), None, None, None, None]);
        // Node 2 goes first: 5, 6, 1. Then node 1: 3, 4, 5, 6.
        let wide = collapse(&bvh, 4);
        assert_eq!(root_lists(&wide), [[0], [1], [2], [3]]);
        assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
        // At arity 3 there is room for node 2 only, and its children come first.
        let wide = collapse(&bvh, 3);
        assert_eq!(root_lists(&wide), [vec![2], vec![3], vec![0, 1]]);
        assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
    }

    #[test]
    fn a_chain_fills_from_below() {
        // 0 over (leaf, 2), 2 over (leaf, 4), 4 over (leaf, 6), 6 over two leaves: triangles 0 … 4 downwards.
        let (bvh, boxes) = binary(&chain(4));
        // Node 6 into 4: (3, 4, 2). Node 4 into 2: (3, 4, 2, 1). Node 2 has four children by then: no room.
        let wide = collapse(&bvh, 4);
        assert_eq!(root_lists(&wide), [vec![0], vec![3, 4, 2, 1]]);
        assert_eq!(stats(&wide).degree_histogram, [0, 0, 1, 0, 1]);
        assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
        assert_eq!(root_lists(&collapse(&bvh, 5)), [[3], [4], [2], [1], [0]]);
    }

    #[test]
    fn small_and_deep_trees() {
        let leaf = Bvh { nodes: vec![Node::leaf(unit_box(0), 0, 1)], triangle_ids: vec![0], arity: 2 };
        assert_eq!(collapse(&leaf, 8).nodes, leaf.nodes);
        let none = Bvh { nodes: Vec::new(), triangle_ids: Vec::new(), arity: 2 };
        assert!(collapse(&none, 4).nodes.is_empty());
        let (deep, boxes) = binary(&chain(100_000));
        let wide = collapse(&deep, 8);
        assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
        assert!(stats(&wide).max_depth < 100_000 / 7 + 2);
    }

    proptest! {
        #[test]
        fn equals_the_literal_reading(seed: u64, n in 1usize..120, max_leaf in 1usize..5, arity in 2usize..10) {
            let boxes = boxes(&soup(seed, n, 0.1));
            let bvh = random_tree(seed, &boxes, 2, max_leaf);
            let wide = collapse(&bvh, arity);
            prop_assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
            prop_assert_eq!(wide.arity, arity);
            prop_assert_eq!(tree_hash(&wide), tree_hash(&literal(&bvh, arity)));
            if arity == 2 {
                prop_assert_eq!(tree_hash(&wide), tree_hash(&bvh));
            }
            // The layout of the input does not matter.
            let moved = collapse(&collapse(&bvh, 2), arity);
            prop_assert_eq!(tree_hash(&wide), tree_hash(&moved));
        }

        #[test]
        fn equals_the_literal_reading_on_wider_inputs(seed: u64, n in 1usize..80, input in 3usize..6, arity in 2usize..9) {
            let boxes = boxes(&soup(seed, n, 0.1));
            let bvh = random_tree(seed, &boxes, input, 2);
            let wide = collapse(&bvh, arity);
            prop_assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
            prop_assert_eq!(tree_hash(&wide), tree_hash(&literal(&bvh, arity)));
        }
    }

    #[test]
    fn degrees_come_near_the_arity_on_a_good_tree() {
        let boxes = boxes(&soup(Random(1).next(), 5000, 0.05));
        let bvh = median_split(&boxes, 4);
        for (arity, least) in [(4, 3.0), (8, 5.0)] {
            let wide = stats(&collapse(&bvh, arity));
            assert!(wide.avg_degree.unwrap() > least && wide.degree_histogram.len() == arity + 1);
        }
    }
}
