//! `bottom-up`, preset `published`, engine `exact`: the chain of nearest neighbours, searched for in k-d trees.
//!
//! Source: what the program of Beick 2014 does; the same tree as [`super::chain_literal`], whose words hold here, too.
//! The chain makes the same steps because each of its questions, which live cluster is nearest and among equally near
//! ones has the lowest id, has one answer, and `nearest_centres` gives it exactly.
//!
//! All but one kind of question come with a radius: B's nearest is no farther than A is. Only that of a cluster made
//! just now is open.
//!
//! Deviation: the original found nearest clusters in a kd-tree, whose walk decided ties.

use super::merges::Merges;
use super::nearest_centres::{NearestCentres, Neighbour, distance_squared};
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use glam::DVec3;

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, [`BuildError::Circling`], or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut live = boxes.len();
    let mut state = State::new(boxes);
    if live == 1 {
        return Ok(state.merges.into_tree(boxes, MAX_LEAF));
    }
    let mut a = nearest_to_origin(boxes);
    let found = state.search(a, state.point[a as usize], None, probe);
    let (mut b, mut d) = (found.id, found.distance);
    // How far A and B are apart; d may be older.
    let mut d_ab = d;
    let mut steps = 0;
    loop {
        let c = state.search(b, state.point[b as usize], Some(d_ab), probe);
        if c.id == a || d <= c.distance {
            let (merged, centre) = state.merge(a, b, probe);
            live -= 1;
            if live == 1 {
                return Ok(state.merges.into_tree(boxes, MAX_LEAF));
            }
            let found = state.search_merged(merged, centre, probe);
            (a, b, d, d_ab) = (merged, found.id, found.distance, found.distance);
            steps = 0;
        } else {
            (a, b, d_ab) = (b, c.id, c.distance);
            steps += 1;
            if steps > live as u64 {
                return Err(BuildError::Circling(steps));
            }
        }
        let looked_at = state.take_steps(probe);
        if !probe.go_on(looked_at) {
            return Err(BuildError::Stopped(Unfinished { pending: vec![live] }));
        }
    }
}

/// The centre of a box as the original's kd-tree had it.
fn centre_of(aabb: &Aabb) -> DVec3 {
    aabb.centre().as_vec3().as_dvec3()
}

fn nearest_to_origin(boxes: &[Aabb]) -> u32 {
    let distance = |b: &Aabb| distance_squared(centre_of(b), DVec3::ZERO);
    let nearest = (0..).zip(boxes.iter().map(distance)).min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.map_or(0, |(id, _)| id)
}

/// Live clusters by id.
struct State {
    centres: NearestCentres,
    merges: Merges,
    handle: Vec<u32>,
    aabb: Vec<Aabb>,
    point: Vec<u32>,
}

impl State {
    fn new(boxes: &[Aabb]) -> Self {
        let centres: Vec<DVec3> = boxes.iter().map(centre_of).collect();
        let (centres, point) = NearestCentres::new(&centres);
        let n = boxes.len();
        Self { centres, merges: Merges::new(n), handle: (0..n as u32).collect(), aabb: boxes.to_vec(), point }
    }

    /// The nearest to cluster `of`, known to be within `limit`; there is more than one cluster.
    fn search<P: Probe>(&mut self, of: u32, point: u32, limit: Option<f64>, probe: &mut P) -> Neighbour {
        probe.add(Work::NearestSearches, 1);
        if let Some(id) = self.centres.beside(point, of) {
            return Neighbour { distance: 0.0, id, point };
        }
        let centre = centre_of(&self.aabb[of as usize]);
        let age = self.centres.age();
        let found = match limit {
            Some(limit) => self.centres.within(centre, Some(point), age, limit),
            None => self.centres.nearest(centre, Some(point), age),
        };
        found.expect("another cluster is live, and within the limit")
    }

    /// The nearest to the cluster `of` made just now, which takes its place among the others.
    fn search_merged<P: Probe>(&mut self, of: u32, centre: DVec3, probe: &mut P) -> Neighbour {
        probe.add(Work::NearestSearches, 1);
        let found = self.centres.nearest(centre, None, self.centres.age()).expect("another cluster is live");
        let twin = (found.distance == 0.0).then_some(found.point);
        self.point[of as usize] = self.centres.insert(of, centre, twin);
        found
    }

    /// Merges two clusters and returns the new one's id and centre.
    fn merge<P: Probe>(&mut self, a: u32, b: u32, probe: &mut P) -> (u32, DVec3) {
        let (first, second) = (a.min(b), a.max(b));
        self.centres.remove(first, self.point[first as usize]);
        self.centres.remove(second, self.point[second as usize]);
        self.handle[first as usize] = self.merges.push(self.handle[first as usize], self.handle[second as usize]);
        self.aabb[first as usize] = self.aabb[first as usize].union(&self.aabb[second as usize]);
        probe.add(Work::Merges, 1);
        probe.add(Work::BoxUnions, 1);
        (first, centre_of(&self.aabb[first as usize]))
    }

    /// Counts what searches cost since the last call and returns the steps.
    fn take_steps<P: Probe>(&mut self, probe: &mut P) -> u64 {
        let cost = self.centres.take_cost();
        probe.add(Work::PairDistances, cost.scored);
        probe.add(Work::SearchVisits, cost.visits);
        1 + cost.visits
    }
}

#[cfg(test)]
mod tests;
