//! A tree written anew: in depth-first order, siblings next to each other, leaves' slots in the order of the leaves.

use crate::bvh::{Bvh, Node};

/// Writes the tree that `below` describes with nodes of `bvh`. `below` is told a node and an empty list, and fills in the
/// nodes that are to be its children, left to right; where it leaves the list empty, the node becomes a leaf over all
/// triangles below it.
///
/// Boxes are those of `bvh`. A triangle that stands in several leaves of a subtree (spatial splits) stands once in the leaf
/// that replaces it. Time is O(nodes).
pub(super) fn depth_first(bvh: &Bvh, arity: usize, mut below: impl FnMut(usize, &mut Vec<usize>)) -> Bvh {
    let mut nodes = Vec::with_capacity(bvh.nodes.len());
    let mut triangle_ids: Vec<u32> = Vec::with_capacity(bvh.triangle_ids.len());
    let (mut pending, mut children, mut leaves) = (Vec::new(), Vec::new(), Vec::new());
    if let Some(root) = bvh.nodes.first() {
        nodes.push(*root);
        pending.push((0, 0));
    }
    while let Some((place, index)) = pending.pop() {
        let aabb = bvh.nodes[index].aabb;
        children.clear();
        below(index, &mut children);
        if children.is_empty() {
            let first = triangle_ids.len();
            leaves.push(index);
            while let Some(index) = leaves.pop() {
                leaves.extend(bvh.children(index).rev());
                for &id in bvh.leaf_triangles(index) {
                    if !triangle_ids[first..].contains(&id) {
                        triangle_ids.push(id);
                    }
                }
            }
            nodes[place] = Node::leaf(aabb, first, triangle_ids.len() - first);
        } else {
            let first = nodes.len();
            nodes[place] = Node::inner(aabb, first, children.len());
            nodes.extend(children.iter().map(|&child| bvh.nodes[child]));
            // The leftmost child is to come off first.
            pending.extend((first..nodes.len()).zip(children.iter().copied()).rev());
        }
    }
    Bvh { nodes, triangle_ids, arity }
}
