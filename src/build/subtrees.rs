//! Subtrees that threads grew on their own, put together.

use crate::bvh::Node;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// Puts subtrees, of which the first node is the root, each into its place and behind the last node, in their order. Slots
/// are those of the whole tree already.
///
/// By all threads: a tree is large, and memory that nobody has written to yet comes slowly.
pub(super) fn append(nodes: &mut Vec<Node>, subtrees: &[(usize, &[Node])]) {
    let first = nodes.len();
    let more = subtrees.iter().map(|(_, subtree)| subtree.len() - 1).sum();
    nodes.reserve(more);
    let mut shift = first - 1;
    for (root, subtree) in subtrees {
        nodes[*root] = moved(&subtree[0], shift);
        shift += subtree.len() - 1;
    }
    let mut room = &mut nodes.spare_capacity_mut()[..more];
    let mut shift = first - 1;
    let mut parts = Vec::with_capacity(subtrees.len());
    for (_, subtree) in subtrees {
        let (part, rest) = room.split_at_mut(subtree.len() - 1);
        parts.push((part, &subtree[1..], shift));
        (room, shift) = (rest, shift + subtree.len() - 1);
    }
    let write = |(part, subtree, shift): (&mut [MaybeUninit<Node>], &[Node], usize)| {
        part.iter_mut().zip(subtree).for_each(|(to, node)| {
            to.write(moved(node, shift));
        });
    };
    parts.into_par_iter().with_max_len(1).for_each(write);
    // SAFETY: as many have been written, each part from first to last.
    unsafe { nodes.set_len(first + more) };
}

/// The node, with children so much further behind.
fn moved(node: &Node, shift: usize) -> Node {
    if node.is_leaf() { *node } else { Node::inner(node.aabb, node.range().start + shift, node.count()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    #[test]
    fn subtrees_follow_one_another_and_keep_their_children() {
        let leaf = |slot| Node::leaf(Aabb::EMPTY, slot, 1);
        let mut nodes = vec![Node::inner(Aabb::EMPTY, 1, 2), leaf(9), leaf(9)];
        let deep = [Node::inner(Aabb::EMPTY, 1, 2), leaf(0), Node::inner(Aabb::EMPTY, 3, 2), leaf(1), leaf(2)];
        let flat = [Node::inner(Aabb::EMPTY, 1, 2), leaf(3), leaf(4)];
        append(&mut nodes, &[(2, &deep), (1, &flat)]);
        let shape: Vec<_> = nodes.iter().map(|n| (n.is_leaf(), n.range().start)).collect();
        let inner = |at| (false, at);
        let slot = |at| (true, at);
        let wanted = [inner(1), inner(7), inner(3), slot(0), inner(5), slot(1), slot(2), slot(3), slot(4)];
        assert_eq!(shape, wanted);
        append(&mut nodes, &[]);
        assert_eq!(nodes.len(), 9);
        append(&mut nodes, &[(8, &[leaf(7)])]);
        assert_eq!((nodes.len(), nodes[8].range().start), (9, 7));
    }
}
