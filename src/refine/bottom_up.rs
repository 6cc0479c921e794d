//! From the leaves to the root by all threads: every node of a finished tree after its children.
//!
//! Children stand behind their parents. So each thread takes a stretch of the nodes, goes through it from the back, and does
//! those whose whole subtree lies in the stretch. What remains is done at the end, by one thread: where subtrees stand in
//! one piece, as in depth-first order, that is a path to the root for every stretch. Any other order will do, with less to share.

use crate::bvh::Node;
use crate::geom::Aabb;
use rayon::prelude::*;
use std::ops::Range;

/// Nodes in a stretch.
const STRETCH: usize = 1 << 12;

/// Calls `visit` once for every node, with its index, its `width` values, and those of all of its children, which were visited
/// before. `children` are indices behind the node's own, none for a leaf; it is told the node's index and values. What comes
/// out does not depend on the number of threads.
pub(super) fn bottom_up<T: Send>(
    values: &mut [T],
    width: usize,
    children: impl Fn(usize, &[T]) -> Range<usize> + Sync,
    visit: impl Fn(usize, &mut [T], &[T]) + Sync,
) {
    in_stretches(STRETCH, values, width, children, visit);
}

/// Gives every leaf the box that `of_leaf` says, and every inner node the union of its children's.
pub(super) fn unite(nodes: &mut [Node], of_leaf: impl Fn(&Node) -> Aabb + Sync) {
    let children = |_: usize, own: &[Node]| if own[0].is_leaf() { 0..0 } else { own[0].range() };
    bottom_up(nodes, 1, children, |_, own, below| {
        let node = &mut own[0];
        let of_children = || Aabb::union_of(below.iter().map(|child| &child.aabb));
        node.aabb = if node.is_leaf() { of_leaf(node) } else { of_children() };
    });
}

fn in_stretches<T: Send>(
    stretch: usize,
    values: &mut [T],
    width: usize,
    children: impl Fn(usize, &[T]) -> Range<usize> + Sync,
    visit: impl Fn(usize, &mut [T], &[T]) + Sync,
) {
    /// The values of a node and of those in `below`, given those of all nodes from the node on.
    fn family<T>(from: &mut [T], width: usize, index: usize, below: Range<usize>) -> (&mut [T], &[T]) {
        let (own, behind) = from.split_at_mut(width);
        let place = |node: usize| (node - index - 1) * width;
        (own, if below.is_empty() { &[] } else { &behind[place(below.start)..place(below.end)] })
    }
    let one_stretch = |(number, values): (usize, &mut [T])| {
        let (first, n) = (number * stretch, values.len() / width);
        let (mut done, mut left) = (vec![false; n], Vec::new());
        for at in (0..n).rev() {
            let index = first + at;
            let below = children(index, &values[at * width..(at + 1) * width]);
            let within = below.end <= first + n;
            if below.is_empty() || within && done[below.start - first..below.end - first].iter().all(|&done| done) {
                let (own, below) = family(&mut values[at * width..], width, index, below);
                visit(index, own, below);
                done[at] = true;
            } else {
                left.push(index);
            }
        }
        left
    };
    let left: Vec<Vec<usize>> = values.par_chunks_mut(stretch * width).enumerate().map(one_stretch).collect();
    for index in left.into_iter().rev().flatten() {
        let below = children(index, &values[index * width..(index + 1) * width]);
        let (own, below) = family(&mut values[index * width..], width, index, below);
        visit(index, own, below);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, random_tree, soup};
    use proptest::prelude::*;

    proptest! {
        /// Every node learns how many there are below it, once, however the nodes are shared out.
        #[test]
        fn every_node_once_and_after_its_children(seed: u64, n in 1usize..120, arity in 2usize..9, stretch in 1usize..40, width in 1usize..4) {
            let bvh = random_tree(seed, &boxes(&soup(seed, n, 0.3)), arity, 3);
            let children = |index: usize, _: &[usize]| bvh.children(index);
            let mut sizes = vec![0; bvh.nodes.len() * width];
            in_stretches(stretch, &mut sizes, width, children, |index, own, below| {
                assert_eq!(below.len(), bvh.children(index).len() * width);
                assert!(own.iter().all(|&size| size == 0) && below.iter().all(|&size| size > 0));
                own.fill(1 + below.iter().step_by(width).sum::<usize>());
            });
            prop_assert!(sizes[..width].iter().all(|&size| size == bvh.nodes.len()));
        }
    }
}
