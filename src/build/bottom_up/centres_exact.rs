//! `bottom-up`, preset `text`, engine `exact`: the globally closest pair of centres, from a heap of nearest neighbours.
//!
//! Source: Beick 2014, "Construction Algorithms"; the same tree as [`super::all_pairs_literal`] by distance of centres.
//! The heap is that of the "generic algorithm" of Müllner 2011, "Modern hierarchical, agglomerative clustering
//! algorithms": it does not ask distances to be reducible, and those of centres are not (a merged cluster can be nearer
//! to a third one than both its parts were).
//!
//! State: each live cluster, the *owner*, has one entry in the heap: a lower bound of the keys (distance, smaller id,
//! larger id) of all pairs of it and an older cluster, and mostly the pair that attains it. Take the least entry.
//! * The owner is gone: drop it.
//! * It has no pair, or the partner is gone: search for the owner's nearest again. Clusters only go, so until then the
//!   old key bounds the pairs with older clusters from below; newer ones looked for theirs when they were made.
//! * Otherwise merge the pair. Of every live pair the newer cluster owns an entry with no larger key than the pair's,
//!   and none is less than this one. Ids are unique among the living, so no other pair has the same key.
//!
//! Of two equally near neighbours the one with the smaller id makes the pair with the smaller ids, whatever the owner's
//! own id is.
//!
//! The heap also keeps searches small. All live clusters are at least as far from each other as the least entry says,
//! d. So at most 5³ of them are within 2d of any point (balls of radius d/2 around them are disjoint and inside one of
//! radius 5d/2), and a search that looks no further is cheap wherever a new centre falls, in a dense part of the scene,
//! too. If it finds nothing, 2d is a lower bound, and the search goes on when that comes up; until then most owners
//! have been merged by others.

use super::merges::Merges;
use super::nearest_centres::{NearestCentres, Neighbour};
use crate::build::{BuildError, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The handle of nothing.
const NONE: u32 = u32::MAX;
/// A search looks twice as far as the least distance; this is its square.
const FARTHER: f64 = 4.0;

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut state = State::new(boxes);
    let mut live = boxes.len();
    while live > 1 {
        let Reverse(entry) = *state.heap.peek().expect("every live cluster owns an entry");
        if !state.alive[entry.owner as usize] {
            state.heap.pop();
        } else if entry.partner == NONE || !state.alive[entry.partner as usize] {
            let steps = state.search_again(entry, probe);
            if !probe.go_on(steps) {
                return Err(BuildError::Stopped(Unfinished { pending: vec![live] }));
            }
        } else {
            let steps = state.merge(entry, probe);
            live -= 1;
            if !probe.go_on(steps) {
                return Err(BuildError::Stopped(Unfinished { pending: vec![live] }));
            }
        }
    }
    Ok(state.merges.into_tree(boxes))
}

/// Compared by distance, then ids, then handles: a total order, so that the heap's choice is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// Bits of the squared distance: those of numbers that are not negative are ordered as the numbers are.
    distance: u64,
    /// Smaller and larger id; both 0, before all pairs, where there is none.
    ids: [u32; 2],
    owner: u32,
    partner: u32,
}

impl Entry {
    fn distance(&self) -> f64 {
        f64::from_bits(self.distance)
    }
}

struct State {
    heap: BinaryHeap<Reverse<Entry>>,
    centres: NearestCentres,
    merges: Merges,
    /// By handle: the id, the point where it stands, whether it is live.
    id: Vec<u32>,
    point: Vec<u32>,
    alive: Vec<bool>,
    /// By id, of live clusters: the handle and the box.
    handle: Vec<u32>,
    aabb: Vec<Aabb>,
}

impl State {
    fn new(boxes: &[Aabb]) -> Self {
        let n = boxes.len();
        let centres: Vec<DVec3> = boxes.iter().map(Aabb::centre).collect();
        let (centres, mut point) = NearestCentres::new(&centres);
        point.reserve(n - 1);
        let mut id = Vec::with_capacity(2 * n - 1);
        id.extend(0..n as u32);
        let mut alive = Vec::with_capacity(2 * n - 1);
        alive.resize(n, true);
        let entry = |owner| Reverse(Entry { distance: 0, ids: [0, 0], owner, partner: NONE });
        let heap = (0..n as u32).map(entry).collect::<Vec<_>>().into();
        Self { heap, centres, merges: Merges::new(n), handle: id.clone(), id, point, alive, aabb: boxes.to_vec() }
    }

    /// The nearest cluster to the one with this id, at `centre` and in or beside the point `own`, if it is not too far
    /// to be looked for now, and the entry that follows. `least` is the least distance of all.
    fn search<P: Probe>(
        &mut self,
        handle: u32,
        centre: DVec3,
        own: Option<u32>,
        least: f64,
        probe: &mut P,
    ) -> (Entry, Option<Neighbour>) {
        probe.add(Work::NearestSearches, 1);
        let id = self.id[handle as usize];
        let beside =
            own.and_then(|point| Some(Neighbour { distance: 0.0, id: self.centres.beside(point, id)?, point }));
        let limit = FARTHER * least;
        let found = match beside {
            Some(_) => beside,
            None if limit > 0.0 => self.centres.within(centre, own, limit),
            None => self.centres.nearest(centre, own),
        };
        let entry = match found {
            Some(Neighbour { distance, id: other, .. }) => Entry {
                distance: distance.to_bits(),
                ids: [id.min(other), id.max(other)],
                owner: handle,
                partner: self.handle[other as usize],
            },
            None => Entry { distance: limit.to_bits(), ids: [0, 0], owner: handle, partner: NONE },
        };
        (entry, found)
    }

    /// Counts what searches cost and returns the steps.
    fn count<P: Probe>(&mut self, probe: &mut P) -> u64 {
        let cost = self.centres.take_cost();
        probe.add(Work::PairDistances, cost.scored);
        probe.add(Work::SearchVisits, cost.visits);
        1 + cost.visits
    }

    /// Searches for what the least entry's owner is nearest to now; returns the steps that took.
    fn search_again<P: Probe>(&mut self, entry: Entry, probe: &mut P) -> u64 {
        let id = self.id[entry.owner as usize];
        let centre = self.aabb[id as usize].centre();
        let point = self.point[entry.owner as usize];
        let (entry, _) = self.search(entry.owner, centre, Some(point), entry.distance(), probe);
        *self.heap.peek_mut().expect("the entry is still there") = Reverse(entry);
        self.count(probe)
    }

    /// Merges the pair of the least entry; returns the steps of the search for the new cluster's nearest.
    fn merge<P: Probe>(&mut self, entry: Entry, probe: &mut P) -> u64 {
        let [first, second] = entry.ids;
        let parts = [first, second].map(|id| self.handle[id as usize]);
        for (id, handle) in [first, second].into_iter().zip(parts) {
            self.alive[handle as usize] = false;
            self.centres.remove(id, self.point[handle as usize]);
        }
        let merged = self.merges.push(parts[0], parts[1]);
        probe.add(Work::Merges, 1);
        probe.add(Work::BoxUnions, 1);
        let aabb = self.aabb[first as usize].union(&self.aabb[second as usize]);
        self.aabb[first as usize] = aabb;
        self.handle[first as usize] = merged;
        self.id.push(first);
        self.alive.push(true);
        let centre = aabb.centre();
        let (entry, found) = self.search(merged, centre, None, entry.distance(), probe);
        let twin = found.filter(|found| found.distance == 0.0).map(|found| found.point);
        let point = self.centres.insert(first, centre, twin);
        self.point.push(point);
        *self.heap.peek_mut().expect("the entry is still there") = Reverse(entry);
        self.count(probe)
    }
}

#[cfg(test)]
mod tests;
