//! `agglo-kd`: agglomerative clustering in which a cluster knows only a few candidates, the nearest centres.
//!
//! Walter, Bala, Kulkarni and Pingali 2008, "Fast Agglomerative Clustering for Rendering": every triangle is a cluster,
//! and two clusters that are nearest to each other, by the area of the box around both, merge until one is left.
//!
//! Deviations:
//! - A cluster is compared with [`AggloKd::neighbours`] candidates instead of all others. The idea that a few are enough
//!   is that of Gu, He, Fatahalian and Blelloch 2013, "Efficient BVH Construction via Approximate Agglomerative
//!   Clustering", which take what a Morton curve brings together. Here they are the clusters whose boxes have the nearest
//!   centres, found in kiddo's k-d tree (`candidates`).
//! - When two clusters merge, the new one keeps the best of both their candidates. The k-d tree is built, and candidates
//!   are searched, again when half of the clusters are gone: two searches a triangle in all.
//! - Clusters merge in rounds, all pairs of a round at once, or one pair after the other where rounds bring little
//!   (`phase`). Both choose from the same candidates by the same key, so that it makes little difference which it is.
//!
//! **Order.** The key of a pair is the area of its union, then a hash of both smallest triangles: no two pairs share one.
//! With ids themselves in place of their hash the lowest one would be everybody's nearest among boxes that are all alike,
//! and a round would merge a single pair.

mod candidates;
mod phase;
#[cfg(test)]
mod tests;

use super::merges::Merges;
use crate::build::{BuildError, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use candidates::search;
use phase::Phase;

/// How clusters find each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AggloKd {
    /// Candidates of a cluster, 1 to [`MOST_NEIGHBOURS`].
    pub neighbours: usize,
}

/// The most candidates of a cluster: lists of all clusters are kept at once.
pub const MOST_NEIGHBOURS: usize = 128;

impl Default for AggloKd {
    /// Eight: with twice as many the cost changes by one percent, up in some scenes and down in others.
    fn default() -> Self {
        Self { neighbours: 8 }
    }
}

/// A cluster that has not merged yet.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    aabb: Aabb,
    /// Its smallest triangle.
    id: u32,
    /// What [`Merges`] calls it.
    handle: u32,
}

/// The order in which pairs merge: the area of the union, then a number that no other pair has.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Key(f64, u64);

impl Cluster {
    #[inline(always)]
    fn key(&self, other: &Self) -> Key {
        let (low, high) = if self.id < other.id { (self.id, other.id) } else { (other.id, self.id) };
        // The finaliser of SplitMix64 (Steele, Lea, Flood 2014) maps no two numbers to one.
        let mut hash = u64::from(low) << 32 | u64::from(high);
        hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Key(self.aabb.union(&other.aabb).surface_area(), hash ^ (hash >> 31))
    }

    /// Both as one.
    fn merge(&self, other: &Self, merges: &mut Merges) -> Self {
        let (first, second) = if self.id < other.id { (self, other) } else { (other, self) };
        let handle = merges.push(first.handle, second.handle);
        Self { aabb: first.aabb.union(&second.aabb), id: first.id, handle }
    }
}

/// What was done since the probe was last told.
#[derive(Clone, Copy, Debug, Default)]
struct Effort {
    searches: u64,
    distances: u64,
    merges: u64,
}

impl Effort {
    /// Tells the probe; an error where it does not want to go on with so many clusters left.
    fn tell<P: Probe>(&mut self, live: usize, probe: &mut P) -> Result<(), BuildError> {
        let Self { searches, distances, merges } = std::mem::take(self);
        probe.add(Work::NearestSearches, searches);
        probe.add(Work::PairDistances, distances);
        probe.add(Work::Merges, merges);
        // A search costs some ten distances.
        match probe.go_on(10 * searches + distances) {
            true => Ok(()),
            false => Err(BuildError::Stopped(Unfinished { pending: vec![live] })),
        }
    }
}

/// Builds the binary tree over `boxes`, one per triangle, with a leaf for each.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, neighbours out of their range, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &AggloKd, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    if !(1..=MOST_NEIGHBOURS).contains(&params.neighbours) {
        return Err(BuildError::Parameter(format!("a cluster has 1 to {MOST_NEIGHBOURS} candidates")));
    }
    let mut live: Vec<Cluster> = (0u32..).zip(boxes).map(|(id, &aabb)| Cluster { aabb, id, handle: id }).collect();
    let mut merges = Merges::new(boxes.len());
    let mut effort = Effort::default();
    while live.len() > 1 {
        let neighbours = params.neighbours.min(live.len() - 1);
        let lists = search(&mut live, neighbours, &mut effort, probe)?;
        live = Phase::new(live, lists, neighbours).halve(&mut merges, &mut effort, probe)?;
    }
    // What is done is not stopped.
    effort.tell(live.len(), probe).ok();
    Ok(merges.into_tree(boxes, 1))
}
