//! The tree from its merges: nodes depth-first, siblings next to each other.

use super::clusters::each;
use super::merges::Merges;
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use arrayvec::ArrayVec;
use std::mem::MaybeUninit;

/// Subtrees with fewer leaves are laid out by one task.
const GRAIN: usize = 1 << 12;

/// A subtree to lay out below a node that is written already.
struct Subtree<'a> {
    left: u32,
    right: u32,
    nodes: &'a mut [MaybeUninit<Node>],
    first: usize,
    ids: &'a mut [MaybeUninit<u32>],
    slot: usize,
}

/// The tree over `boxes`.
pub(super) fn tree(boxes: &[Aabb], merges: &Merges) -> Bvh {
    let source = Source { boxes, merges };
    let root = source.get(merges.root());
    let total = 2 * root.leaves - 1;
    let (mut nodes, mut ids) = (Vec::with_capacity(total), Vec::with_capacity(boxes.len()));
    let (node, rest) = nodes.spare_capacity_mut()[..total].split_at_mut(1);
    let slots = &mut ids.spare_capacity_mut()[..boxes.len()];
    node[0].write(source.node(&root, 1, 0));
    if root.leaves == 1 {
        source.write_ids(merges.root(), slots);
    } else {
        let whole = Subtree { left: root.left, right: root.right, nodes: rest, first: 1, ids: slots, slot: 0 };
        each(source.parts(whole), |part| source.lay_out(part));
    }
    // SAFETY: a subtree has as many nodes and slots as it counted when it merged, and all of them are written.
    unsafe {
        nodes.set_len(total);
        ids.set_len(boxes.len());
    }
    Bvh { nodes, triangle_ids: ids, arity: 2 }
}

/// A cluster as the layout needs it.
struct Cluster {
    aabb: Aabb,
    left: u32,
    right: u32,
    triangles: usize,
    leaves: usize,
}

impl Cluster {
    /// Places of nodes below.
    fn nodes(&self) -> usize {
        2 * (self.leaves - 1)
    }
}

/// Where clusters are looked up.
#[derive(Clone, Copy)]
struct Source<'a> {
    boxes: &'a [Aabb],
    merges: &'a Merges,
}

impl Source<'_> {
    #[inline(always)]
    fn get(&self, name: u32) -> Cluster {
        match self.merges.get(name) {
            Some((merge, below)) => Cluster {
                aabb: merge.aabb,
                left: merge.left,
                right: merge.right,
                triangles: below.triangles as usize,
                leaves: below.leaves as usize,
            },
            None => Cluster { aabb: self.boxes[name as usize], left: name, right: name, triangles: 1, leaves: 1 },
        }
    }

    /// The cluster's node, with nodes below from `first` or triangles from `slot`.
    #[inline(always)]
    fn node(&self, cluster: &Cluster, first: usize, slot: usize) -> Node {
        if cluster.leaves == 1 {
            Node::leaf(cluster.aabb, slot, cluster.triangles)
        } else {
            Node::inner(cluster.aabb, first, 2)
        }
    }

    /// Writes the triangles of a leaf, as many as there are slots, left before right.
    fn write_ids(&self, leaf: u32, slots: &mut [MaybeUninit<u32>]) {
        let mut stack = ArrayVec::<u32, { super::MOST_IN_LEAF }>::new();
        stack.push(leaf);
        let mut free = slots.iter_mut();
        while let Some(name) = stack.pop() {
            match self.merges.get(name) {
                Some((merge, _)) => stack.extend([merge.right, merge.left]),
                None => drop(free.next().expect("a slot for each triangle").write(name)),
            }
        }
        assert_eq!(free.len(), 0, "triangles were miscounted");
    }

    /// Lays out the top of a subtree. Returns what is left, in parts.
    fn parts<'a>(&self, whole: Subtree<'a>) -> Vec<Subtree<'a>> {
        let (mut parts, mut large) = (Vec::new(), vec![whole]);
        while let Some(subtree) = large.pop() {
            if subtree.nodes.len() <= 2 * GRAIN {
                parts.push(subtree);
                continue;
            }
            let Subtree { nodes, ids, first, slot, .. } = subtree;
            let (left, right) = (self.get(subtree.left), self.get(subtree.right));
            let (pair, nodes) = nodes.split_at_mut(2);
            let (left_nodes, right_nodes) = nodes.split_at_mut(left.nodes());
            let (left_ids, right_ids) = ids.split_at_mut(left.triangles);
            let firsts = [first + 2, first + 2 + left.nodes()];
            let slots = [slot, slot + left.triangles];
            let sides = [(subtree.left, left, left_nodes, left_ids), (subtree.right, right, right_nodes, right_ids)];
            for (side, (name, cluster, nodes, ids)) in sides.into_iter().enumerate() {
                let (first, slot) = (firsts[side], slots[side]);
                pair[side].write(self.node(&cluster, first, slot));
                if cluster.leaves == 1 {
                    self.write_ids(name, ids);
                } else {
                    large.push(Subtree { left: cluster.left, right: cluster.right, nodes, first, ids, slot });
                }
            }
        }
        parts
    }

    /// Lays out a subtree.
    fn lay_out(&self, subtree: Subtree) {
        let Subtree { nodes, first, ids, slot, .. } = subtree;
        // Two clusters, and where their nodes and what is below them go, counted from the subtree's own places.
        let mut stack = vec![(subtree.left, subtree.right, 0, 0)];
        let (mut written, mut leaves) = (0, 0);
        while let Some((left_name, right_name, at, start)) = stack.pop() {
            let (left, right) = (self.get(left_name), self.get(right_name));
            let (left_first, right_first) = (at + 2, at + 2 + left.nodes());
            let middle = start + left.triangles;
            nodes[at].write(self.node(&left, first + left_first, slot + start));
            nodes[at + 1].write(self.node(&right, first + right_first, slot + middle));
            written += 2;
            if right.leaves == 1 {
                self.write_ids(right_name, &mut ids[middle..middle + right.triangles]);
                leaves += right.triangles;
            } else {
                stack.push((right.left, right.right, right_first, middle));
            }
            if left.leaves == 1 {
                self.write_ids(left_name, &mut ids[start..middle]);
                leaves += left.triangles;
            } else {
                stack.push((left.left, left.right, left_first, start));
            }
        }
        assert!((written, leaves) == (nodes.len(), ids.len()), "nodes or triangles were miscounted");
    }
}
