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
mod tests {
    use super::*;
    use crate::bvh::testing::Random;

    /// Centres of every awkward kind: scattered, on a grid with many ties, coincident, in one rising line, far apart.
    fn centres(kind: usize, n: usize) -> Vec<Vec3> {
        let mut random = Random(kind as u64);
        (0..n)
            .map(|i| match kind {
                0 => random.point(30.0),
                1 => (random.point(6.0)).floor(),
                2 => Vec3::ONE,
                3 => Vec3::splat(i as f32 * 0.5),
                4 => random.point(1e20),
                _ => random.point(1e-20),
            })
            .collect()
    }

    /// The original's way, word by word: recursion and a list that is walked.
    struct Literal<'a> {
        tree: &'a OriginalKdTree,
        radius: f64,
        centre: Vec3,
        list: Vec<f64>,
        visited: u64,
        list_steps: u64,
    }

    impl Literal<'_> {
        fn visit(&mut self, at: u32) {
            let Some(&entry) = self.tree.entries.get(at as usize) else {
                return;
            };
            self.visited += 1;
            let d = entry.distance_squared(self.centre);
            if entry.live && d <= self.radius * self.radius {
                let passed = self.list.iter().take_while(|&&listed| listed < d).count();
                self.list_steps += passed as u64;
                self.list.insert(passed, d);
            }
            let axis = usize::from(entry.axis);
            let dx = f64::from(self.centre[axis]) - f64::from(entry.centre[axis]);
            let [left, right] = entry.children;
            let (near, far) = if dx < 0.0 { (left, right) } else { (right, left) };
            self.visit(near);
            if dx.abs() <= self.radius {
                self.visit(far);
            }
        }
    }

    #[test]
    fn nearest_and_counts_equal_the_literal_ones_while_entries_come_and_go() {
        for kind in 0..6 {
            let mut random = Random(77);
            let mut tree = OriginalKdTree::new();
            let mut alive: Vec<(u32, Vec3)> = Vec::new();
            for (id, centre) in (0..).zip(centres(kind, 150)) {
                tree.insert(id, centre);
                alive.push((id, centre));
            }
            while alive.len() > 1 {
                let (id, centre) = alive[random.below(alive.len())];
                let brute = alive
                    .iter()
                    .filter(|(other, _)| *other != id)
                    .map(|&(other, at)| Nearest {
                        id: other,
                        distance_squared: (at.as_dvec3() - centre.as_dvec3()).length_squared(),
                    })
                    .reduce(|a, b| if b.before(&a) { b } else { a });
                let before = tree.work();
                let found = tree.nearest(id, centre);
                assert_eq!(found, brute, "kind {kind}");
                let after = tree.work();
                let (mut visited, mut steps, mut listed, mut queries) = (0, 0, 0, 0);
                let mut radius = 10.0;
                loop {
                    let mut literal =
                        Literal { tree: &tree, radius, centre, list: Vec::new(), visited: 0, list_steps: 0 };
                    literal.visit(0);
                    queries += 1;
                    visited += literal.visited;
                    steps += literal.list_steps;
                    listed += literal.list.len() as u64;
                    // The first is the cluster itself.
                    if literal.list.len() > 1 {
                        break;
                    }
                    radius *= 2.0;
                }
                assert_eq!(after.visited - before.visited, visited, "kind {kind}");
                assert_eq!(after.list_steps - before.list_steps, steps, "kind {kind}");
                assert_eq!(after.listed - before.listed, listed);
                assert_eq!(after.range_queries - before.range_queries, queries);
                // Merge the two, as the chain does; the smaller id lives on.
                let other = found.unwrap().id;
                let at = alive.iter().position(|a| a.0 == other).unwrap();
                let (_, other_centre) = alive.swap_remove(at);
                alive.retain(|a| a.0 != id);
                assert!(tree.remove(id, centre) && tree.remove(other, other_centre));
                assert!(!tree.remove(other, other_centre), "marked once only");
                let merged = (id.min(other), (centre + other_centre) * 0.5);
                tree.insert(merged.0, merged.1);
                alive.push(merged);
                assert_eq!(tree.len(), alive.len());
            }
            let (last, centre) = alive[0];
            assert_eq!(tree.nearest(last, centre), None);
        }
    }

    #[test]
    fn steps_by_hand() {
        let mut tree = OriginalKdTree::new();
        assert!(tree.is_empty() && !tree.remove(0, Vec3::ZERO) && tree.nearest(0, Vec3::ZERO).is_none());
        // A rising line is a chain to the right: 0 + 1 + 2 + 3 nodes passed.
        for id in 0..4 {
            tree.insert(id, Vec3::splat(id as f32));
        }
        assert_eq!(tree.work().insert_steps, 6);
        // Everything is in range, met in rising order of distance: the second passes 1, the third 2, the fourth 3.
        assert_eq!(tree.nearest(0, Vec3::ZERO).map(|n| n.id), Some(1));
        let work = tree.work();
        assert_eq!((work.visited, work.listed, work.list_steps, work.range_queries), (4, 4, 6, 1));
        // From the other end every entry but those goes to the head of the list.
        assert_eq!(tree.nearest(3, Vec3::splat(3.0)).map(|n| n.id), Some(2));
        assert_eq!(tree.work().list_steps, 6);
        assert!(tree.remove(2, Vec3::splat(2.0)));
        assert_eq!(tree.work().find_steps, 3);
        // Marked, still visited, no longer listed.
        let before = tree.work();
        assert_eq!(tree.nearest(3, Vec3::splat(3.0)).map(|n| n.id), Some(1));
        let after = tree.work();
        assert_eq!((after.visited - before.visited, after.listed - before.listed), (4, 3));
        assert_eq!(after.steps(), after.visited + 6 + 6 + 3);
        // At distance 15 the second radius finds it.
        let mut far = OriginalKdTree::new();
        far.insert(0, Vec3::ZERO);
        far.insert(1, Vec3::X * 15.0);
        assert_eq!(far.nearest(0, Vec3::ZERO).map(|n| n.distance_squared), Some(225.0));
        assert_eq!(far.work().range_queries, 2);
        assert_eq!(far.nearest(0, Vec3::splat(f32::NAN)), None);
    }

    #[test]
    fn rising_pairs_are_counted() {
        let mut random = Random(4);
        for n in (0..100).chain([257, 1000]) {
            let mut values: Vec<f64> = (0..n).map(|_| random.below(40) as f64).collect();
            let brute = (0..n).map(|i| (0..i).filter(|&j| values[j] < values[i]).count() as u64).sum::<u64>();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            assert_eq!(count_rising_pairs(&mut values, &mut Vec::new()), brute);
            assert_eq!(values, sorted);
        }
    }

    #[test]
    fn a_tree_as_deep_as_it_has_entries_needs_no_call_stack() {
        let mut tree = OriginalKdTree::new();
        for id in 0..20_000 {
            tree.insert(id, Vec3::ONE);
        }
        assert_eq!(tree.nearest(7, Vec3::ONE).map(|n| n.id), Some(0));
        assert_eq!(tree.work().visited, 20_000);
        assert_eq!(tree.work().list_steps, 0);
    }
}
