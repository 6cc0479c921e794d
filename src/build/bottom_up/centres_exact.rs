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

mod queue;
#[cfg(test)]
mod tests;

use super::merges::Merges;
use super::nearest_centres::{NearestCentres, Neighbour};
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use glam::DVec3;
use queue::{Entry, NONE, Queue};

/// A search looks twice as far as the least distance; this is its square.
const FARTHER: f64 = 4.0;

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut state = State::new(boxes, probe);
    let mut live = boxes.len();
    while live > 1 {
        let least = state.queue.least(&state.alive).expect("every live cluster owns an entry");
        if least.partner == NONE || !state.alive[least.partner as usize] {
            state.search_again(least, probe);
        } else {
            state.merge(least, probe);
            live -= 1;
        }
        let steps = state.take_steps(probe);
        if !probe.go_on(steps) {
            return Err(BuildError::Stopped(Unfinished { pending: vec![live] }));
        }
    }
    Ok(state.merges.into_tree(boxes, MAX_LEAF))
}

struct State {
    queue: Queue,
    centres: NearestCentres,
    merges: Merges,
    /// Of each handle.
    id: Vec<u32>,
    alive: Vec<bool>,
    /// Of each live cluster by its id.
    live: Vec<Live>,
}

#[derive(Clone, Copy, Debug)]
struct Live {
    aabb: Aabb,
    handle: u32,
    /// Where it stands among the centres.
    point: u32,
    /// How old these were when it came.
    age: u32,
}

impl State {
    fn new<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Self {
        let n = boxes.len();
        let centres: Vec<DVec3> = boxes.iter().map(Aabb::centre).collect();
        let (centres, points) = NearestCentres::new(&centres);
        let gaps: Vec<f64> = centres.gaps().collect();
        probe.add(Work::NearestSearches, gaps.len() as u64);
        let bound = |(id, &point): (u32, &u32)| {
            let alone = centres.beside(point, id).is_none();
            Entry::bound(if alone { gaps[point as usize] } else { 0.0 }, id)
        };
        let queue = Queue::new((0..).zip(&points).map(bound).collect());
        let age = centres.age();
        let live = |((handle, &aabb), point)| Live { aabb, handle, point, age };
        let live = (0..).zip(boxes).zip(points).map(live).collect();
        let mut id = Vec::with_capacity(2 * n - 1);
        id.extend(0..n as u32);
        let mut alive = Vec::with_capacity(2 * n - 1);
        alive.resize(n, true);
        Self { queue, centres, merges: Merges::new(n), id, alive, live }
    }

    /// Searches for what the least entry's owner is nearest to now.
    fn search_again<P: Probe>(&mut self, least: Entry, probe: &mut P) {
        let id = self.id[least.owner as usize];
        let Live { aabb, point, age, .. } = self.live[id as usize];
        probe.add(Work::NearestSearches, 1);
        let beside = self.centres.beside(point, id).map(|id| Neighbour { distance: 0.0, id, point });
        let limit = FARTHER * least.distance();
        let found = match beside {
            Some(_) => beside,
            None if limit > 0.0 => self.centres.within(aabb.centre(), Some(point), age, limit),
            None => self.centres.nearest(aabb.centre(), Some(point), age),
        };
        let entry = self.entry(least.owner, id, found, limit);
        self.queue.replace(least, entry);
    }

    /// Merges the pair of the least entry, and searches for what the new cluster is nearest to.
    fn merge<P: Probe>(&mut self, least: Entry, probe: &mut P) {
        let [first, second] = least.ids;
        let parts = [first, second].map(|id| self.live[id as usize]);
        for (id, part) in [first, second].into_iter().zip(parts) {
            self.alive[part.handle as usize] = false;
            self.centres.remove(id, part.point);
        }
        let handle = self.merges.push(parts[0].handle, parts[1].handle);
        let aabb = parts[0].aabb.union(&parts[1].aabb);
        probe.add(Work::Merges, 1);
        probe.add(Work::BoxUnions, 1);
        self.id.push(first);
        self.alive.push(true);
        let (centre, age) = (aabb.centre(), self.centres.age());
        probe.add(Work::NearestSearches, 1);
        let limit = FARTHER * least.distance();
        let found = if limit > 0.0 {
            self.centres.within(centre, None, age, limit)
        } else {
            self.centres.nearest(centre, None, age)
        };
        let twin = found.filter(|found| found.distance == 0.0).map(|found| found.point);
        let point = self.centres.insert(first, centre, twin);
        self.live[first as usize] = Live { aabb, handle, point, age };
        let entry = self.entry(handle, first, found, limit);
        self.queue.replace(least, entry);
    }

    /// The entry of a cluster after a search that went as far as `limit`.
    fn entry(&self, owner: u32, id: u32, found: Option<Neighbour>, limit: f64) -> Entry {
        match found {
            Some(Neighbour { distance, id: other, .. }) => {
                Entry::pair(distance, [id, other], owner, self.live[other as usize].handle)
            }
            None => Entry::bound(limit, owner),
        }
    }

    /// Counts what searches cost since the last call and returns the steps.
    fn take_steps<P: Probe>(&mut self, probe: &mut P) -> u64 {
        let cost = self.centres.take_cost();
        probe.add(Work::PairDistances, cost.scored);
        probe.add(Work::SearchVisits, cost.visits);
        1 + cost.visits
    }
}
