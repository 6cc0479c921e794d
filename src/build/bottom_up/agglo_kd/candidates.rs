//! Candidates of all clusters: those with the nearest centres, by kiddo's k-d tree.
//!
//! kiddo sees the scene turned: its tree halves one axis after the other, which separates nothing where all coordinates on
//! an axis are equal, as in a floor. Clusters whose turned centres are equal share one point of the tree. They are
//! candidates of each other in a ring, and of their neighbours in turn.

use super::super::nearest_centres::turned;
use super::{Cluster, Effort};
use crate::build::{BuildError, Probe};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use std::num::NonZeroUsize;

/// No candidate.
pub(super) const NONE: u32 = u32::MAX;

/// Points searched from between two looks at the budget.
const BATCH: usize = 1 << 16;

/// A cluster's place on a curve, its turned centre, and where it stood.
type Placed = (u64, [f64; 3], u32);

/// Sorts clusters along a curve through space and finds candidates for each: `neighbours` entries a cluster, indices of
/// others with [`NONE`] where there are no more.
pub(super) fn search<P: Probe>(
    clusters: &mut Vec<Cluster>,
    neighbours: usize,
    effort: &mut Effort,
    probe: &mut P,
) -> Result<Vec<u32>, BuildError> {
    let placed = sort(clusters);
    // Where each point's clusters start, and the end.
    let mut starts = vec![0];
    starts.extend((1..placed.len()).filter(|&i| placed[i].1 != placed[i - 1].1).map(|i| i as u32));
    let entries: Vec<_> = (0u32..).zip(&starts).map(|(point, &start)| (point, placed[start as usize].1)).collect();
    starts.push(clusters.len() as u32);
    drop(placed);
    let tree: ImmutableKdTree<f64, 3> =
        ImmutableKdTree::new_from_entries(&entries).expect("only mutable trees can fail");
    let mut lists = vec![NONE; clusters.len() * neighbours];
    let mut rest = lists.as_mut_slice();
    for batch in entries.chunks(BATCH) {
        let mut rooms = Vec::with_capacity(batch.len());
        for &(point, _) in batch {
            let members = (starts[point as usize + 1] - starts[point as usize]) as usize;
            let (room, others) = rest.split_at_mut(members * neighbours);
            rest = others;
            rooms.push(room);
        }
        // One more, for the point finds itself.
        let most = NonZeroUsize::MIN.saturating_add(neighbours);
        batch.par_iter().zip(rooms).with_min_len(64).for_each(|(&(point, at), room)| {
            let found = tree.query(&at).nearest_n::<SquaredEuclidean<f64>>(most).execute();
            let others = || found.iter().map(|f| f.item).filter(|&other| other != point);
            fill(room, neighbours, point, &starts, others);
        });
        effort.searches += batch.len() as u64;
        effort.tell(clusters.len(), probe)?;
    }
    Ok(lists)
}

/// Fills the lists of a point's clusters: up to half with others of the point, if there are other points, and then with
/// one cluster of each of these.
fn fill<I: Iterator<Item = u32>>(
    room: &mut [u32],
    neighbours: usize,
    point: u32,
    starts: &[u32],
    others: impl Fn() -> I,
) {
    let members = |point: u32| starts[point as usize]..starts[point as usize + 1];
    let own = members(point);
    let here = own.len();
    let mates = (here - 1).min(if starts.len() > 2 { neighbours.div_ceil(2) } else { neighbours });
    for (k, list) in room.chunks_exact_mut(neighbours).enumerate() {
        let ring = (1..=mates).map(|step| own.start + ((k + step) % here) as u32);
        let beyond = others().map(|other| members(other).start + (k % members(other).len()) as u32);
        list.iter_mut().zip(ring.chain(beyond)).for_each(|(entry, candidate)| *entry = candidate);
    }
}

/// Brings clusters into the order of a Morton curve, those with equal turned centres side by side in the order of
/// their ids.
fn sort(clusters: &mut Vec<Cluster>) -> Vec<Placed> {
    let centres: Vec<[f64; 3]> =
        // Zeros of either sign are the same place.
        clusters.par_iter().map(|c| turned(c.aabb.centre()).map(|x| x + 0.0)).collect();
    let bound = |pick: fn(f64, f64) -> f64| {
        centres.iter().copied().reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default()
    };
    let (low, high) = (bound(f64::min), bound(f64::max));
    let cells = f64::from(1 << 21);
    let code = |centre: &[f64; 3]| {
        let spread = |axis: usize| {
            let width = high[axis] - low[axis];
            let part = if width > 0.0 { (centre[axis] - low[axis]) / width } else { 0.0 };
            every_third_bit(((part * cells) as u64).min((1 << 21) - 1)) << axis
        };
        spread(0) | spread(1) | spread(2)
    };
    let mut placed: Vec<Placed> =
        centres.par_iter().zip(0u32..clusters.len() as u32).map(|(c, index)| (code(c), *c, index)).collect();
    placed.par_sort_unstable_by(|a, b| {
        let by_centre = || a.1.partial_cmp(&b.1).unwrap_or(std::cmp::Ordering::Equal);
        let by_id = || clusters[a.2 as usize].id.cmp(&clusters[b.2 as usize].id);
        a.0.cmp(&b.0).then_with(by_centre).then_with(by_id)
    });
    *clusters = placed.par_iter().map(|p| clusters[p.2 as usize]).collect();
    placed
}

/// The lowest 21 bits of `x`, with two zeros before each.
fn every_third_bit(mut x: u64) -> u64 {
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
