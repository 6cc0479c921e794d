//! The nearest cluster along a Morton curve, by a choice that is given from outside.
//!
//! The candidates of `ploc` (Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction",
//! 2018): in every round each cluster chooses among those at most [`RADIUS`] places away, by the area of the union; who has chosen
//! each other merges, at the place of the first. Candidates come by place, so of equal ones the pair with the lower places counts, for
//! both: the least pair of all has always chosen each other, and no round is without a merge.

use super::Candidate;
use crate::build::bottom_up::merges::Merges;
use crate::build::morton::Order;
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use crate::simd::Simd;

/// Places to either side that a cluster looks at.
pub const RADIUS: usize = 16;

/// A cluster on the curve.
#[derive(Clone, Copy)]
struct Cluster {
    aabb: Aabb,
    handle: u32,
}

/// Builds the binary tree over `boxes`; `choose` says which of a cluster's candidates it takes for its nearest.
///
/// # Errors
/// Boxes that [`check_boxes`](crate::build::check_boxes) refuses, or the probe's stop.
pub fn build<P: Probe>(
    boxes: &[Aabb],
    mut choose: impl FnMut(&[Candidate]) -> usize,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    let order = Order::new(boxes, Simd::detect())?;
    let mut row: Vec<Cluster> = order.ids.iter().map(|&id| Cluster { aabb: boxes[id as usize], handle: id }).collect();
    let mut merges = Merges::new(boxes.len());
    let mut candidates = Vec::new();
    while row.len() > 1 {
        if !probe.go_on(2 * RADIUS as u64 * row.len() as u64) {
            return Err(BuildError::Stopped(Unfinished { pending: vec![row.len()] }));
        }
        let nearest: Vec<usize> = (0..row.len())
            .map(|i| {
                let (from, to) = (i.saturating_sub(RADIUS), (i + RADIUS + 1).min(row.len()));
                candidates.clear();
                let others = (from..to).filter(|&j| j != i);
                candidates.extend(others.map(|j| Candidate::of_one(row[i].aabb.union(&row[j].aabb))));
                let place = from + choose(&candidates);
                if place < i { place } else { place + 1 }
            })
            .collect();
        let mut next = Vec::with_capacity(row.len());
        for (i, &j) in nearest.iter().enumerate() {
            if nearest[j] != i {
                next.push(row[i]);
            } else if i < j {
                let handle = merges.push(row[i].handle, row[j].handle);
                next.push(Cluster { aabb: row[i].aabb.union(&row[j].aabb), handle });
            }
        }
        row = next;
    }
    Ok(merges.into_tree(boxes, MAX_LEAF))
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
        fn trees_are_whole_and_without_flips_the_same(boxes in scattered(1..80)) {
            for rounding in Rounding::ALL {
                let bvh = build(&boxes, |c| rounding.least(c), &mut ()).unwrap();
                prop_assert!(validate(&bvh, &boxes, &Limits::default()).is_ok());
                let mut flips = Flips::default();
                let exact = build(&boxes, |c| flips.note(rounding, c), &mut ()).unwrap();
                prop_assert!(flips.compared >= boxes.len().saturating_sub(2));
                prop_assert!(flips.different > 0 || tree_hash(&bvh) == tree_hash(&exact));
            }
        }
    }
}
