//! The clusters' centres, for the question which live one is nearest: kiddo's k-d trees under insertion and deletion.
//!
//! Source: kiddo 6.3 (`ImmutableKdTree`) for the search; Bentley and Saxe 1980, "Decomposable Searching Problems I", for
//! insertion into structures that do not change: the newest centres are scanned, older ones are in trees, each several
//! times as large as the next newer one. Deletion is a mark; a tree is built again when its dead outnumber its living,
//! or when searches have met more dead in it than building it again would cost.
//!
//! Answers are exact, whatever kiddo rounds. It is asked for everything within a radius somewhat larger than the best
//! distance known ([`search`] has the bounds); what it returns is scored again from the centres themselves, and equal
//! distances are decided by ids. So it is enough that kiddo loses no point that is clearly inside.
//!
//! Two things keep this fast where centres share coordinates:
//! * One point stands for all clusters with the same centre, with their ids in order. Distance 0 never reaches kiddo.
//! * kiddo sees the scene turned. Its tree halves one axis after the other, and where all coordinates on an axis are
//!   equal, as in the plane of a floor, halving separates nothing: leaves of thousands of points were measured on lines.
//!
//! Deviation from kiddo's own way to change trees: `MutableKdTree` of 6.3 refuses many points with a coordinate in
//! common and does not find others again that it was given.

mod search;
#[cfg(test)]
mod tests;

use glam::DVec3;
use kiddo::ImmutableKdTree;
use search::{Search, gap};
pub(super) use search::{distance_squared, turned};
use std::collections::BTreeSet;

/// The id or point of nothing.
const NONE: u32 = u32::MAX;
/// So many newest points are scanned instead of searched.
const NEWEST: usize = 64;
/// A tree has at least so many times the points of the next newer one.
const RATIO: usize = 4;
/// Dead points met in a tree, per point of it, that are worth building it again.
const PATIENCE: u64 = 8;

/// What a search found: of all live clusters the nearest, among equally near ones the one with the smallest id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Neighbour {
    /// Squared distance: differences and squares in f64, added x, y, z.
    pub distance: f64,
    /// The id of the cluster.
    pub id: u32,
    /// The point where it stands.
    pub point: u32,
}

/// What searches cost so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cost {
    /// Distances scored.
    pub scored: u64,
    /// Points looked at: scanned ones, and those that the trees returned.
    pub visits: u64,
}

/// Live clusters by their centres. A cluster goes by its id and by the point where it stands.
#[derive(Debug, Default)]
pub(super) struct NearestCentres {
    /// All there ever were, the newest last.
    points: Vec<Point>,
    /// Ids at points with more than one cluster.
    crowds: Vec<BTreeSet<u32>>,
    /// The largest and oldest first. Each holds a range of points; behind the last one's are those that are scanned.
    trees: Vec<Tree>,
    scanned_from: u32,
    cost: Cost,
    /// Room for building trees.
    entries: Vec<(u32, [f64; 3])>,
}

#[derive(Clone, Copy, Debug)]
struct Point {
    centre: DVec3,
    /// The smallest id of the live clusters here, or [`NONE`].
    lowest: u32,
    /// Where all ids are if there are several, or were.
    crowd: u32,
}

#[derive(Debug)]
struct Tree {
    /// Points before this one are in older trees.
    start: u32,
    tree: ImmutableKdTree<f64, 3>,
    live: usize,
    /// Points met in searches that could not be the answer: dead, or where the search was from.
    wasted: u64,
}

impl Tree {
    fn is_tired(&self) -> bool {
        let size = self.tree.size();
        2 * self.live < size || self.wasted > PATIENCE * size as u64
    }
}

impl NearestCentres {
    /// Clusters with ids 0, 1, 2, … at `centres`; also returns the point of each.
    pub fn new(centres: &[DVec3]) -> (Self, Vec<u32>) {
        let mut all = Self::default();
        let mut points = twins(centres);
        for id in 0..centres.len() {
            let twin = points[id] as usize;
            points[id] = if twin == id {
                all.points.push(Point { centre: centres[id], lowest: id as u32, crowd: NONE });
                all.points.len() as u32 - 1
            } else {
                let point = points[twin];
                all.join(point, id as u32);
                point
            };
        }
        all.build(0);
        (all, points)
    }

    /// What searches cost since this was last asked.
    pub fn take_cost(&mut self) -> Cost {
        std::mem::take(&mut self.cost)
    }

    /// The smallest id of the live clusters at `point` other than `id`.
    pub fn beside(&self, point: u32, id: u32) -> Option<u32> {
        let Point { lowest, crowd, .. } = self.points[point as usize];
        match self.crowds.get(crowd as usize) {
            None => (lowest != id && lowest != NONE).then_some(lowest),
            Some(ids) => ids.iter().copied().find(|&other| other != id),
        }
    }

    /// Puts cluster `id` at `centre`, where `twin` stands if that point has this centre, and returns its point.
    /// No other point may have it.
    pub fn insert(&mut self, id: u32, centre: DVec3, twin: Option<u32>) -> u32 {
        if let Some(point) = twin {
            self.join(point, id);
            return point;
        }
        if self.points.len() - self.scanned_from as usize >= NEWEST {
            self.tidy();
        }
        self.points.push(Point { centre, lowest: id, crowd: NONE });
        self.points.len() as u32 - 1
    }

    /// Takes cluster `id` away from `point`.
    pub fn remove(&mut self, id: u32, point: u32) {
        let p = &mut self.points[point as usize];
        p.lowest = match self.crowds.get_mut(p.crowd as usize) {
            None => NONE,
            Some(ids) => {
                ids.remove(&id);
                ids.first().copied().unwrap_or(NONE)
            }
        };
        if p.lowest == NONE && point < self.scanned_from {
            let tree = self.trees.iter_mut().rfind(|tree| tree.start <= point);
            tree.expect("older points are in trees").live -= 1;
        }
    }

    /// How many points there have been: those that come are younger than this age.
    pub fn age(&self) -> u32 {
        self.points.len() as u32
    }

    /// For each of the points there are at first a lower bound of the squared distance to any other one.
    pub fn gaps(&self) -> impl Iterator<Item = f64> {
        let tree = self.trees.first().map(|oldest| &oldest.tree);
        self.points.iter().map(move |p| tree.map_or(0.0, |tree| gap(tree, p.centre)))
    }

    /// The nearest cluster to `centre` with at most this squared distance, but for those at the point
    /// `except`: of all that came before `age`, and of some later ones.
    pub fn within(&mut self, centre: DVec3, except: Option<u32>, age: u32, limit: f64) -> Option<Neighbour> {
        let mut search = Search::new(&self.points, centre, except, limit);
        search.scan(self.scanned_from, age);
        for Tree { tree, wasted, .. } in self.trees.iter_mut().rev().filter(|tree| tree.start < age) {
            *wasted += search.within(tree);
        }
        search.finish(&mut self.cost)
    }

    /// The nearest cluster to `centre`, but for those at the point `except`: of all that came before `age`, and
    /// of some later ones.
    pub fn nearest(&mut self, centre: DVec3, except: Option<u32>, age: u32) -> Option<Neighbour> {
        let mut search = Search::new(&self.points, centre, except, f64::INFINITY);
        search.scan(self.scanned_from, age);
        for Tree { tree, wasted, .. } in self.trees.iter_mut().rev().filter(|tree| tree.start < age) {
            *wasted += search.approach(tree);
        }
        search.finish(&mut self.cost)
    }

    fn join(&mut self, point: u32, id: u32) {
        let p = &mut self.points[point as usize];
        if p.crowd == NONE {
            p.crowd = self.crowds.len() as u32;
            self.crowds.push(BTreeSet::from([p.lowest]));
        }
        self.crowds[p.crowd as usize].insert(id);
        p.lowest = p.lowest.min(id);
    }

    /// Puts the scanned points into a tree, together with those of newer trees that are not much larger or tired.
    fn tidy(&mut self) {
        let newest = self.points[self.scanned_from as usize..].iter().filter(|p| p.lowest != NONE).count();
        let mut live = newest;
        let mut keep = self.trees.len();
        while keep > 0 && self.trees[keep - 1].live < RATIO * live {
            keep -= 1;
            live += self.trees[keep].live;
        }
        let tired = self.trees.iter().position(Tree::is_tired).unwrap_or(keep);
        self.build(keep.min(tired));
    }

    /// Builds one tree of the live points that are not in the oldest `keep` trees.
    fn build(&mut self, keep: usize) {
        let start = self.trees.get(keep).map_or(self.scanned_from, |tree| tree.start);
        self.trees.truncate(keep);
        self.entries.clear();
        let live = (start..).zip(&self.points[start as usize..]).filter(|(_, p)| p.lowest != NONE);
        self.entries.extend(live.map(|(point, p)| (point, turned(p.centre))));
        self.scanned_from = self.points.len() as u32;
        if !self.entries.is_empty() {
            let tree = ImmutableKdTree::new_from_entries(&self.entries).expect("only mutable trees can fail");
            self.trees.push(Tree { start, tree, live: self.entries.len(), wasted: 0 });
        }
    }
}

/// For each centre the index of the first that equals it.
fn twins(centres: &[DVec3]) -> Vec<u32> {
    let bits = |index: u32| centres[index as usize].to_array().map(|x| (x + 0.0).to_bits());
    let hash =
        |index| bits(index).into_iter().fold(0u64, |h, b| (h.rotate_left(23) ^ b).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mut order: Vec<(u64, u32)> = (0..centres.len() as u32).map(|index| (hash(index), index)).collect();
    order.sort_unstable();
    let mut first: Vec<u32> = (0..centres.len() as u32).collect();
    for run in order.chunk_by_mut(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        run.sort_by_key(|&(_, index)| bits(index));
        for same in run.chunk_by(|a, b| bits(a.1) == bits(b.1)) {
            same.iter().for_each(|&(_, index)| first[index as usize] = same[0].1);
        }
    }
    first
}
