//! The canonical hash of a tree: equal for the same tree, whatever the memory layout.

use super::Bvh;
use std::fmt;

/// 128 bits of BLAKE3 over the tree's canonical form; prints as 32 hex digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TreeHash([u8; 16]);

impl fmt::Display for TreeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|b| write!(f, "{b:02x}"))
    }
}

/// Hashes topology, child order and the *set* of triangles of every leaf.
///
/// The canonical form is the preorder sequence of nodes, each a tag (0 inner, 1 leaf) and a count, a leaf followed by its
/// ids in rising order, all as little-endian u32. Node positions, slot order and boxes do not enter. Boxes follow from the
/// triangles, but for those of parts of triangles (spatial splits).
pub fn tree_hash(bvh: &Bvh) -> TreeHash {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = Vec::with_capacity(1 << 14);
    let mut word = |hasher: &mut blake3::Hasher, w: u32| {
        buffer.extend_from_slice(&w.to_le_bytes());
        if buffer.len() == buffer.capacity() {
            hasher.update(&buffer);
            buffer.clear();
        }
    };
    let mut stack = vec![0];
    let mut ids = Vec::new();
    while let Some(index) = stack.pop() {
        let node = &bvh.nodes[index];
        word(&mut hasher, u32::from(node.is_leaf()));
        word(&mut hasher, node.count() as u32);
        if node.is_leaf() {
            ids.clear();
            ids.extend_from_slice(bvh.leaf_triangles(index));
            ids.sort_unstable();
            ids.iter().for_each(|&id| word(&mut hasher, id));
        } else {
            stack.extend(bvh.children(index).rev());
        }
    }
    hasher.update(&buffer);
    let mut out = [0; 16];
    out.copy_from_slice(&hasher.finalize().as_bytes()[..16]);
    TreeHash(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Node;
    use crate::geom::Aabb;

    fn tree(nodes: Vec<Node>, triangle_ids: Vec<u32>) -> Bvh {
        Bvh { nodes, triangle_ids, arity: 2 }
    }
    const B: Aabb = Aabb::EMPTY;

    #[test]
    fn same_tree_in_another_layout_has_the_same_hash() {
        let a = tree(vec![Node::inner(B, 1, 2), Node::leaf(B, 0, 2), Node::leaf(B, 2, 1)], vec![0, 1, 2]);
        let b = tree(
            vec![
                Node::inner(B, 3, 2),
                Node::leaf(B, 0, 0),
                Node::leaf(B, 0, 0),
                Node::leaf(B, 1, 2),
                Node::leaf(B, 0, 1),
            ],
            vec![2, 1, 0],
        );
        assert_eq!(tree_hash(&a), tree_hash(&b));
        assert_eq!(tree_hash(&a).to_string().len(), 32);
    }

    #[test]
    fn topology_sets_and_child_order_all_count() {
        let base = tree(vec![Node::inner(B, 1, 2), Node::leaf(B, 0, 2), Node::leaf(B, 2, 1)], vec![0, 1, 2]);
        let swapped_children =
            tree(vec![Node::inner(B, 1, 2), Node::leaf(B, 2, 1), Node::leaf(B, 0, 2)], vec![0, 1, 2]);
        let other_sets = tree(base.nodes.clone(), vec![0, 2, 1]);
        let other_sizes = tree(vec![Node::inner(B, 1, 2), Node::leaf(B, 0, 1), Node::leaf(B, 1, 2)], vec![0, 1, 2]);
        let one_leaf = tree(vec![Node::leaf(B, 0, 3)], vec![0, 1, 2]);
        let hashes = [&base, &swapped_children, &other_sets, &other_sizes, &one_leaf].map(tree_hash);
        for (i, a) in hashes.iter().enumerate() {
            assert!(hashes[..i].iter().all(|b| a != b));
        }
    }
}
