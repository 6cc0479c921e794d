//! The record of a clustering by an exact engine: which clusters merged, and the tree that they make.
//!
//! Clusters go by handles: `0 … n − 1` are the triangles, `n + k` is what the k-th merge made.

use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;

/// Merges in an order in which parts come before what is made of them.
#[derive(Clone, Debug)]
pub(in crate::build) struct Merges {
    triangles: usize,
    parts: Vec<[u32; 2]>,
}

impl Merges {
    /// No merges yet among `triangles` triangles, with room for all.
    pub fn new(triangles: usize) -> Self {
        Self { triangles, parts: Vec::with_capacity(triangles.saturating_sub(1)) }
    }

    /// Records a merge, the part with the smaller smallest triangle first, and returns the new cluster's handle.
    pub fn push(&mut self, first: u32, second: u32) -> u32 {
        let handle = self.triangles + self.parts.len();
        self.parts.push([first, second]);
        handle as u32
    }

    /// Merges so far.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// The handle of what the next merge makes.
    pub fn next(&self) -> u32 {
        (self.triangles + self.parts.len()) as u32
    }

    /// Records merges that were made apart from others, in their order. Their record took handles from `next` on for
    /// what it made; here they get handles from the returned one on.
    pub fn append(&mut self, next: u32, parts: &[[u32; 2]]) -> u32 {
        let first = self.next();
        let renamed = |handle: u32| if handle < next { handle } else { handle - next + first };
        self.parts.extend(parts.iter().map(|both| both.map(renamed)));
        first
    }

    /// The binary tree below the last cluster, siblings next to each other, in depth-first order. Clusters of at most
    /// `max_leaf` triangles are leaves.
    ///
    /// `boxes` are those of the triangles. All triangles must have merged into one cluster.
    pub fn into_tree(self, boxes: &[Aabb], max_leaf: usize) -> Bvh {
        let n = self.triangles;
        debug_assert_eq!(self.parts.len() + 1, n);
        debug_assert!(max_leaf < usize::from(u8::MAX / 2));
        // Triangles of a merged cluster, as far as it matters for leaves.
        let mut size: Vec<u8> = Vec::with_capacity(self.parts.len());
        for parts in &self.parts {
            let of = |&handle: &u32| (handle as usize).checked_sub(n).map_or(1, |merge| size[merge]);
            let both = parts.iter().map(of).sum::<u8>();
            size.push(both.min(max_leaf as u8 + 1));
        }
        let is_leaf = |handle: u32| {
            let merge = (handle as usize).checked_sub(n);
            merge.is_none_or(|merge| usize::from(size[merge]) <= max_leaf)
        };
        let mut nodes = Vec::with_capacity(n.max(1));
        nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
        let mut triangle_ids = Vec::with_capacity(n);
        let mut pending = vec![(0, (n + self.parts.len() - 1) as u32)];
        let mut below = Vec::new();
        while let Some((node, handle)) = pending.pop() {
            if is_leaf(handle) {
                let first = triangle_ids.len();
                below.push(handle);
                while let Some(handle) = below.pop() {
                    match (handle as usize).checked_sub(n) {
                        None => triangle_ids.push(handle),
                        Some(merge) => below.extend(self.parts[merge].iter().rev()),
                    }
                }
                nodes[node] = Node::leaf(Aabb::EMPTY, first, triangle_ids.len() - first);
            } else {
                let [a, b] = self.parts[handle as usize - n];
                let first = nodes.len();
                nodes[node] = Node::inner(Aabb::EMPTY, first, 2);
                nodes.resize(first + 2, Node::leaf(Aabb::EMPTY, 0, 0));
                pending.extend([(first + 1, b), (first, a)]);
            }
        }
        // Children stand behind their parents.
        for index in (0..nodes.len()).rev() {
            let range = nodes[index].range();
            nodes[index].aabb = if nodes[index].is_leaf() {
                Aabb::union_of(triangle_ids[range].iter().map(|&t| &boxes[t as usize]))
            } else {
                Aabb::union_of(nodes[range].iter().map(|child| &child.aabb))
            };
        }
        Bvh { nodes, triangle_ids, arity: 2 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::MAX_LEAF;
    use crate::build::bottom_up::clusters::{Dead, clusters};
    use crate::build::testing::scattered;
    use crate::bvh::{Limits, tree_hash, validate};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_same_merges_make_the_literal_clusters_tree(boxes in scattered(1..60), picks: u64) {
            let mut live = clusters(&boxes);
            let mut dead = Dead::default();
            let mut merges = Merges::new(boxes.len());
            let mut handles: Vec<u32> = (0..boxes.len() as u32).collect();
            let mut picks = picks;
            while live.len() > 1 {
                picks = picks.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let j = 1 + (picks >> 33) as usize % (live.len() - 1);
                let i = (picks >> 20) as usize % j;
                let second = live.remove(j);
                live[i] = live[i].clone().merge(second, &mut dead);
                let second = handles.remove(j);
                handles[i] = merges.push(handles[i], second);
            }
            let literal = live.remove(0).into_tree(&dead);
            let tree = merges.into_tree(&boxes, MAX_LEAF);
            prop_assert!(validate(&tree, &boxes, &Limits::default()).is_ok());
            prop_assert_eq!(tree_hash(&tree), tree_hash(&literal));
        }
    }
}
