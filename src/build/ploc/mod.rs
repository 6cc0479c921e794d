//! `ploc`: clusters in Morton order merge with the nearest of their neighbours, all at once, round by round.
//!
//! Sources: Meister and Bittner 2018, "Parallel Locally-Ordered Clustering for Bounding Volume Hierarchy Construction";
//! Benthin et al. 2022, "PLOC++", for distances computed once for both of a pair.
//!
//! **Rounds.** The clusters stand in a row, at first the triangles in Morton order. Each looks at the `radius` clusters before
//! and behind it for the one with which it has the smallest union, and where two have chosen each other they merge. The new
//! cluster takes the place of the left one, the row closes up, and the next round begins (`round`).
//!
//! **Ties.** Every cluster has a number, the place of its first triangle in Morton order. Of clusters equally near to the one
//! with number i, the nearest is the one whose number j has the least i xor j. That order is the same seen from either side, has
//! no ties, and does not change with what merges elsewhere. Every round merges at least one pair; and where everything is equally
//! near, the row is merged like the tree of the numbers' bits, whose leaves disappear two by two: in 31 rounds at most. (With
//! the lowest number instead, everybody in reach would choose that, and all but one wait.)
//!
//! **Distances** are half areas in f32, of extents that a power of two brought to the upper half of what squares of f32 can
//! hold: nothing overflows, next to nothing underflows, and a scene scaled by a power of two has the same tree. Where the extent
//! of the scene itself overflows f32 they are areas in f64.
//!
//! **Leaves.** A merge of at most `max_leaf` triangles knows whether it costs less as a leaf, as in
//! [`crate::refine::open_leaves`], and every merge how many leaves are below: the tree is laid out depth-first at once.
//!
//! **Few merges.** Rows like nested boxes let one pair merge a round. Such rounds visit only clusters in reach of the last
//! merges (`sparse`), and find the same pairs as if they had visited all.
//!
//! **Radius.** Means over thesis:huge, spheres, terrain and stadium of about 100,000 triangles, bunny, classroom, staircase and teapot
//! in a stadium, one thread: the time relative to radius 8, the cost relative to `sweep-sah`.
//!
//! | radius | 1 | 2 | 3 | 4 | 6 | 8 | 12 | 16 | 32 |
//! | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
//! | time | 0.70 | 0.75 | 0.79 | 0.83 | 0.92 | 1 | 1.16 | 1.34 | 2.06 |
//! | cost | 1.103 | 1.012 | 1.003 | 0.999 | 0.993 | 0.991 | 0.991 | 0.988 | 0.991 |
//!
//! So 2 is the fast setting, and beyond 8, the default, time buys next to nothing.
//!
//! Deviations: none in the method; the paper leaves ties open.

mod clusters;
mod layout;
mod merges;
mod round;
mod search;
mod sparse;
#[cfg(test)]
mod tests;

use super::morton::Order;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use crate::simd::Simd;
use merges::Merges;
use round::Scratch;
use search::Search;

/// The most clusters looked at on either side.
pub const MOST_RADIUS: usize = 128;

/// The most triangles that a leaf may be asked to hold.
const MOST_IN_LEAF: usize = 64;

/// Parameters of [`build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ploc {
    /// Clusters looked at on either side, from 1 to [`MOST_RADIUS`].
    pub radius: usize,
    /// The most triangles a leaf holds, from 1 to 64.
    pub max_leaf: usize,
}

impl Default for Ploc {
    /// Radius 8, beyond which time buys next to nothing.
    fn default() -> Self {
        Self { radius: 8, max_leaf: MAX_LEAF }
    }
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`super::check_boxes`] refuses, a radius or leaf size out of range, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Ploc, probe: &mut P) -> Result<Bvh, BuildError> {
    build_at(boxes, params, Simd::detect(), probe)
}

/// [`build`] with vector instructions of the caller's choice.
fn build_at<P: Probe>(boxes: &[Aabb], params: &Ploc, simd: Simd, probe: &mut P) -> Result<Bvh, BuildError> {
    let &Ploc { radius, max_leaf } = params;
    if !(1..=MOST_RADIUS).contains(&radius) {
        return Err(BuildError::Parameter(format!("the radius is 1 to {MOST_RADIUS}")));
    }
    if !(1..=MOST_IN_LEAF).contains(&max_leaf) {
        return Err(BuildError::Parameter(format!("a leaf holds 1 to {MOST_IN_LEAF} triangles")));
    }
    let order = Order::new(boxes, simd)?;
    probe.add(Work::KeysSorted, order.moved);
    let search = Search::new(&order.around, radius, simd);
    let mut clusters = clusters::of_triangles(boxes, &order.ids);
    drop(order);
    let mut merges = Merges::new(boxes.len(), max_leaf);
    let (mut nearest, mut scratch) = (Vec::new(), Scratch::default());
    while clusters.len() > 1 {
        let mut pairs = search.nearest(&clusters, &mut nearest);
        let merged = round::merge(simd, &mut clusters, &nearest, radius, &mut scratch, &mut merges);
        probe.add(Work::Rounds, 1);
        let mut go_on = probe.go_on(pairs);
        if go_on && sparse::few(merged, clusters.len(), radius) {
            let effort = sparse::rounds(&mut clusters, &search, radius, &mut merges, |pairs| {
                go_on = probe.go_on(pairs);
                go_on
            });
            probe.add(Work::Rounds, effort.rounds);
            pairs += effort.pairs;
        }
        probe.add(Work::PairDistances, pairs);
        probe.add(Work::BoxUnions, pairs);
        if !go_on {
            return Err(BuildError::Stopped(Unfinished { pending: vec![clusters.len()] }));
        }
    }
    probe.add(Work::Merges, boxes.len() as u64 - 1);
    probe.add(Work::BoxUnions, boxes.len() as u64 - 1);
    drop((clusters, nearest, scratch));
    Ok(layout::tree(boxes, &merges))
}
