//! Subtrees that threads grew on their own, put together.

use crate::bvh::Node;

/// Puts the nodes of a subtree, of which the first is its root, into place `root` and behind the last node. Slots are
/// those of the whole tree already.
pub(super) fn append(nodes: &mut Vec<Node>, root: usize, subtree: &[Node]) {
    let shift = nodes.len() - 1;
    nodes[root] = moved(&subtree[0], shift);
    nodes.extend(subtree[1..].iter().map(|node| moved(node, shift)));
}

/// The node, with children so much further behind.
fn moved(node: &Node, shift: usize) -> Node {
    if node.is_leaf() { *node } else { Node::inner(node.aabb, node.range().start + shift, node.count()) }
}
