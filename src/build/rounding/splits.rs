//! Every split of a node along three sorted orders, by a choice that is given from outside.
//!
//! The candidates of `sweep_sah.rs` (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007): triangles in the
//! order of their centres along each axis, equal centres by id, and a split before each but the first. Nodes of at most
//! [`MAX_LEAF`] triangles are leaves, whatever they cost: only the choice of a split is decided by costs.

use super::Candidate;
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;

/// Builds the binary tree over `boxes`; `choose` says which of a node's candidates divides it. Candidates come by axis, then by
/// triangles on the left.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(
    boxes: &[Aabb],
    mut choose: impl FnMut(&[Candidate]) -> usize,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Node::leaf(Aabb::union_of(boxes), 0, boxes.len())];
    let mut pending = vec![0];
    let mut candidates = Vec::new();
    while let Some(node) = pending.pop() {
        let slots = nodes[node].range();
        if slots.len() <= MAX_LEAF {
            continue;
        }
        if !probe.go_on(3 * slots.len() as u64) {
            let left = pending.iter().chain([&node]).map(|&n: &usize| nodes[n].count()).collect();
            return Err(BuildError::Stopped(Unfinished { pending: left }));
        }
        let orders = [0, 1, 2].map(|axis| sorted(boxes, &ids[slots.clone()], axis));
        candidates.clear();
        orders.iter().for_each(|order| candidates_of(boxes, order, &mut candidates));
        let chosen = choose(&candidates);
        let (axis, left) = (chosen / (slots.len() - 1), 1 + chosen % (slots.len() - 1));
        ids[slots.clone()].copy_from_slice(&orders[axis]);
        let first = nodes.len();
        let [(left_box, _), (right_box, _)] = candidates[chosen].parts;
        nodes.push(Node::leaf(left_box, slots.start, left));
        nodes.push(Node::leaf(right_box, slots.start + left, slots.len() - left));
        nodes[node] = Node::inner(nodes[node].aabb, first, 2);
        pending.extend([first + 1, first]);
    }
    Ok(Bvh { nodes, triangle_ids: ids, arity: 2 })
}

fn sorted(boxes: &[Aabb], ids: &[u32], axis: usize) -> Vec<u32> {
    let mut keys: Vec<(f64, u32)> = ids.iter().map(|&id| (boxes[id as usize].centre()[axis] + 0.0, id)).collect();
    keys.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    keys.into_iter().map(|(_, id)| id).collect()
}

fn candidates_of(boxes: &[Aabb], order: &[u32], candidates: &mut Vec<Candidate>) {
    let n = order.len();
    let first = candidates.len();
    let mut left = Aabb::EMPTY;
    for (i, &id) in order[..n - 1].iter().enumerate() {
        left = left.union(&boxes[id as usize]);
        candidates.push(Candidate { parts: [(left, i as u32 + 1), (Aabb::EMPTY, 0)] });
    }
    let mut right = Aabb::EMPTY;
    for i in (1..n).rev() {
        right = right.union(&boxes[order[i] as usize]);
        candidates[first + i - 1].parts[1] = (right, (n - i) as u32);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Flips, Rounding};
    use super::*;
    use crate::build::testing::scattered;
    use crate::bvh::{Limits, tree_hash, validate};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn trees_are_whole_and_flips_are_where_the_trees_part(boxes in scattered(1..80)) {
            let mut trees = Vec::new();
            for rounding in Rounding::ALL {
                let bvh = build(&boxes, |c| rounding.least(c), &mut ()).unwrap();
                prop_assert!(validate(&bvh, &boxes, &Limits::default()).is_ok());
                let mut flips = Flips::default();
                let exact = build(&boxes, |c| flips.note(rounding, c), &mut ()).unwrap();
                prop_assert_eq!(flips.compared, exact.nodes.iter().filter(|n| !n.is_leaf()).count());
                // The same decisions at every node make the same tree, and others another.
                prop_assert_eq!(flips.different == 0, tree_hash(&bvh) == tree_hash(&exact));
                trees.push(bvh);
            }
        }
    }
}
