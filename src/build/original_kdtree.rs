//! The kd-tree of the thesis' bottom-up builder, replayed to count what it cost: why its builds grew as they did.
//!
//! The program keeps the centres of clusters in a kd-tree that is never balanced. A centre is inserted where a walk from
//! the root ends; a cluster that was merged away is only marked, and every later query still visits it. The nearest
//! cluster is found by a range query of radius 10, a constant that spans most of the thesis' scenes, so a query visits
//! most of the tree; and it puts every live cluster in range into a linked list sorted by distance, each by a walk from
//! the head of the list. The walks are quadratic in the clusters in range, which makes the whole build cubic.
//!
//! Here the same nodes are visited, in the same order. The walks along the list are not made but counted: an entry walks
//! past those that came before it and are nearer, so the steps of one list are the pairs in rising order, which a merge
//! sort counts in m log m.
//!
//! Assumed, where the thesis and the specification of its program leave it open:
//! - The axis of a node is x, y, z, x, … by depth; a smaller coordinate goes left, an equal one right.
//! - A query goes to the query point's own side first (an equal coordinate: right), then to the other side when the
//!   splitting plane is no farther than the radius.
//! - The querying cluster itself, live and at distance 0, is put into the list like every other, and then passed over.
//! - An entry is put before those of equal distance; a step is one entry passed.
//! - A radius that finds nothing else is doubled and the query made again, its visits and its list counted again.
//! - Centres are f32; differences, squares and distances are f64. Between equally near clusters the lowest id is taken
//!   (the program takes the last one met).

use glam::Vec3;
use std::cmp::Ordering;

/// The first radius of a query, in scene units.
const FIRST_RADIUS: f64 = 10.0;

/// No node.
const NONE: u32 = u32::MAX;

/// What the program would have done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OriginalWork {
    /// Calls of [`OriginalKdTree::nearest`].
    pub queries: u64,
    /// Range queries made for them: one, and one more for each doubling of the radius.
    pub range_queries: u64,
    /// Nodes visited by range queries, marked ones included.
    pub visited: u64,
    /// Clusters put into the sorted lists.
    pub listed: u64,
    /// Entries passed while these were put there.
    pub list_steps: u64,
    /// Nodes passed by insertions, from the root.
    pub insert_steps: u64,
    /// Nodes looked at by the walks that find an entry to mark, the entry included.
    pub find_steps: u64,
    /// Insertions.
    pub inserts: u64,
}

impl OriginalWork {
    /// Elementary steps of every kind together: what a time can be fitted to.
    pub fn steps(&self) -> u64 {
        self.visited + self.list_steps + self.insert_steps + self.find_steps
    }
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    centre: Vec3,
    id: u32,
    /// Left and right child.
    children: [u32; 2],
    axis: u8,
    live: bool,
}

impl Entry {
    /// Which child `centre` belongs to.
    fn side(&self, centre: Vec3) -> usize {
        let axis = usize::from(self.axis);
        usize::from(centre[axis] >= self.centre[axis])
    }

    fn distance_squared(&self, centre: Vec3) -> f64 {
        (self.centre.as_dvec3() - centre.as_dvec3()).length_squared()
    }
}

/// The nearest cluster to another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Its id.
    pub id: u32,
    /// The squared distance of the centres, in f64.
    pub distance_squared: f64,
}

/// An unbalanced kd-tree of cluster centres that counts the original's work. At most one live entry has a given id.
#[derive(Clone, Debug, Default)]
pub struct OriginalKdTree {
    entries: Vec<Entry>,
    live: usize,
    work: OriginalWork,
    /// Buffers of queries, kept between them.
    stack: Vec<u32>,
    list: Vec<f64>,
    merged: Vec<f64>,
}

impl OriginalKdTree {
    /// A tree without entries.
    pub fn new() -> Self {
        Self::default()
    }

    /// What was counted so far.
    pub fn work(&self) -> OriginalWork {
        self.work
    }

    /// Live entries.
    pub fn len(&self) -> usize {
        self.live
    }

    /// Whether no entry is live.
    pub fn is_empty(&self) -> bool {
        self.live == 0
    }

    /// Inserts a cluster. Time is the depth at which it ends up: up to the number of entries.
    ///
    /// # Panics
    /// At 2³² − 1 entries: a build of n triangles makes fewer than 2n.
    pub fn insert(&mut self, id: u32, centre: Vec3) {
        self.work.inserts += 1;
        self.live += 1;
        let new = u32::try_from(self.entries.len()).ok().filter(|&n| n != NONE).expect("more than 2³² − 1 entries");
        let mut axis = 0;
        let mut at = 0;
        while let Some(entry) = self.entries.get(at) {
            self.work.insert_steps += 1;
            axis = (entry.axis + 1) % 3;
            let side = entry.side(centre);
            match entry.children[side] {
                NONE => {
                    self.entries[at].children[side] = new;
                    break;
                }
                child => at = child as usize,
            }
        }
        self.entries.push(Entry { centre, id, children: [NONE; 2], axis, live: true });
    }

    /// Marks the live entry `id` at `centre`, found by a walk from the root. Returns whether it was there.
    pub fn remove(&mut self, id: u32, centre: Vec3) -> bool {
        let mut at = 0;
        while let Some(entry) = self.entries.get_mut(at as usize) {
            self.work.find_steps += 1;
            if entry.live && entry.id == id && entry.centre == centre {
                entry.live = false;
                self.live -= 1;
                return true;
            }
            at = entry.children[entry.side(centre)];
        }
        false
    }

    /// The live cluster nearest to cluster `id` at `centre`, other than itself; among equally near ones the lowest id.
    ///
    /// `None` when no other cluster is live, where the original would double its radius for ever, or when `centre` is
    /// not finite.
    pub fn nearest(&mut self, id: u32, centre: Vec3) -> Option<Nearest> {
        self.work.queries += 1;
        if self.is_empty() || !centre.is_finite() {
            return None;
        }
        let mut radius = FIRST_RADIUS;
        // f32 centres are less than 10³⁹ apart: the radius passes any of them long before f64 overflows.
        while radius.is_finite() {
            let found = self.within(id, centre, radius);
            self.work.list_steps += count_rising_pairs(&mut self.list, &mut self.merged);
            if found.is_some() {
                return found;
            }
            // All there is was in range.
            if self.list.len() == self.live {
                return None;
            }
            radius *= 2.0;
        }
        None
    }

    /// One range query: visits what the original visits, in its order, and leaves the distances of its list in
    /// `self.list`. Returns the nearest of the list without the cluster itself.
    fn within(&mut self, id: u32, centre: Vec3, radius: f64) -> Option<Nearest> {
        self.work.range_queries += 1;
        self.list.clear();
        let mut nearest: Option<Nearest> = None;
        let mut visited = 0;
        self.stack.clear();
        self.stack.push(0);
        while let Some(at) = self.stack.pop() {
            let Some(entry) = self.entries.get(at as usize) else {
                continue;
            };
            visited += 1;
            if entry.live {
                let distance_squared = entry.distance_squared(centre);
                if distance_squared <= radius * radius {
                    self.list.push(distance_squared);
                    let here = Nearest { id: entry.id, distance_squared };
                    if entry.id != id && nearest.is_none_or(|best| here.before(&best)) {
                        nearest = Some(here);
                    }
                }
            }
            let axis = usize::from(entry.axis);
            let to_plane = f64::from(centre[axis]) - f64::from(entry.centre[axis]);
            let own = entry.side(centre);
            if to_plane.abs() <= radius {
                self.stack.push(entry.children[1 - own]);
            }
            self.stack.push(entry.children[own]);
        }
        self.work.visited += visited;
        self.work.listed += self.list.len() as u64;
        nearest
    }
}

impl Nearest {
    fn before(&self, other: &Self) -> bool {
        match self.distance_squared.total_cmp(&other.distance_squared) {
            Ordering::Less => true,
            Ordering::Equal => self.id < other.id,
            Ordering::Greater => false,
        }
    }
}

/// Length of the runs that are sorted by insertion, counting as they go.
const RUN: usize = 16;

/// Number of pairs of a value and a greater one behind it. Sorts the values; `buffer` is room to work in.
fn count_rising_pairs(values: &mut Vec<f64>, buffer: &mut Vec<f64>) -> u64 {
    let n = values.len();
    let mut rising = 0;
    for run in values.chunks_mut(RUN) {
        for i in 1..run.len() {
            let value = run[i];
            rising += run[..i].iter().map(|&earlier| u64::from(earlier < value)).sum::<u64>();
            let mut place = i;
            while place > 0 && run[place - 1] > value {
                run[place] = run[place - 1];
                place -= 1;
            }
            run[place] = value;
        }
    }
    buffer.clear();
    buffer.resize(n, 0.0);
    let mut width = RUN;
    while width < n {
        for (from, to) in values.chunks(2 * width).zip(buffer.chunks_mut(2 * width)) {
            let (left, right) = from.split_at(width.min(from.len()));
            let (mut l, mut r) = (0, 0);
            for slot in to {
                // On equal values the right one goes first: the left ones before it are then the smaller ones exactly.
                let take_right = l == left.len() || (r < right.len() && right[r] <= left[l]);
                if take_right {
                    *slot = right[r];
                    rising += l as u64;
                    r += 1;
                } else {
                    *slot = left[l];
                    l += 1;
                }
            }
        }
        std::mem::swap(values, buffer);
        width *= 2;
    }
    rising
}

#[cfg(test)]
mod tests;
