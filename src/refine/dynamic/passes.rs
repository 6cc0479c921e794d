//! Passes over a changing tree from the leaves to the root, by all threads.
//!
//! What a step does at a node stays below it: the node's box is the union of the same leaves before and after. So does what
//! the leaves to come make of it, where more triangles are below than a leaf may hold. Disjoint subtrees of that kind can
//! therefore be changed at the same time, and the tree is the one that comes of any other order in which children are
//! visited before their parents. A pass cuts the tree into subtrees of a few thousand nodes. Each is copied out, so that it stands close
//! together; its nodes are visited, and it is put into its stretch of the next pass's memory. The few nodes above
//! are visited at the end. Where the cuts are does not depend on the number of threads.

use super::{Dynamic, NONE, ROOT, Slot, Sum};
use crate::refine::Watch;
use rayon::prelude::*;

/// Slots of a subtree at most: what it takes fits into a core's cache.
const MOST: u32 = 1 << 13;

/// And at least: smaller ones are left to the nodes above.
const FEWEST: u32 = 1 << 6;

/// Subtrees between two looks at the watch.
const BATCH: usize = 128;

/// Nodes above the subtrees between two looks at the watch.
const BATCH_ABOVE: usize = 1 << 10;

/// A step that goes from node to node.
pub trait Visit {
    /// What it remembers of every slot from pass to pass. Marks stay with the place in the tree, not with what moves there.
    type Mark: Copy + Default + Send + Sync;

    /// A visitor of a subtree; the changes before its first one have numbers up to `clock`. One number may belong to changes
    /// in several subtrees, but to none above them.
    fn since(clock: u32) -> Self;

    /// Changes the tree below an inner node, or leaves it as it is.
    fn visit(&mut self, tree: &mut Dynamic, marks: &mut [Self::Mark], slot: u32) -> Tally;
}

/// What visits did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// What the cost of the tree, in half areas, has lost.
    pub gain: f64,
    /// Changes that were kept.
    pub moves: u32,
    /// Elementary steps.
    pub steps: u64,
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.gain += other.gain;
        self.moves += other.moves;
        self.steps += other.steps;
    }
}

/// A tree that a step passes over.
pub struct Passes<'a, V: Visit> {
    tree: Dynamic<'a>,
    marks: Vec<V::Mark>,
    /// The memory of the pass before.
    spare: Memory<V::Mark>,
    /// Changes so far, those at the same time counted once; the tree as it comes is the first.
    clock: u32,
    most: u32,
}

/// Everything there is of a slot, slot by slot.
struct Memory<M> {
    slots: Vec<Slot>,
    sums: Vec<Sum>,
    marks: Vec<M>,
}

/// A subtree to be visited.
struct Part {
    /// Its root, where it is.
    from: u32,
    /// Its root, where it will be.
    to: u32,
    /// Its slots without the root.
    below: usize,
}

/// Where the slots below a subtree's root will be, and the first one's number.
struct Stretch<'m, M> {
    part: Part,
    first: u32,
    slots: &'m mut [Slot],
    sums: &'m mut [Sum],
    marks: &'m mut [M],
}

impl<'a, V: Visit> Passes<'a, V> {
    /// Before the first pass.
    pub fn over(tree: Dynamic<'a>) -> Self {
        Self::in_parts_of(MOST, tree)
    }

    fn in_parts_of(most: u32, tree: Dynamic<'a>) -> Self {
        let marks = vec![V::Mark::default(); tree.slots.len()];
        let spare = Memory { slots: Vec::new(), sums: Vec::new(), marks: Vec::new() };
        Self { tree, marks, spare, clock: 1, most }
    }

    /// The tree as it is.
    pub fn tree(&self) -> &Dynamic<'a> {
        &self.tree
    }

    /// Visits every inner node once, children before parents. What the cost lost.
    pub fn pass(&mut self, watch: &mut Watch) -> f64 {
        let n = self.tree.slots.len();
        let (above, parts) = self.cut();
        let mut next =
            std::mem::replace(&mut self.spare, Memory { slots: Vec::new(), sums: Vec::new(), marks: Vec::new() });
        next.slots.resize(n, Slot::EMPTY);
        next.sums.resize(n, Sum::default());
        next.marks.resize(n, V::Mark::default());
        self.copy_above(&above, &mut next);
        let roots: Vec<u32> = parts.iter().map(|part| part.to).collect();
        let (gain, latest) = self.visit_parts(parts, &above, &mut next, watch);
        std::mem::swap(&mut self.tree.slots, &mut next.slots);
        std::mem::swap(&mut self.tree.sums, &mut next.sums);
        std::mem::swap(&mut self.marks, &mut next.marks);
        self.spare = next;
        self.clock = latest;
        gain + self.visit_above(above.len() as u32, &roots, watch)
    }

    /// The slots above the subtrees, their roots included, level by level, each at its new number; and the subtrees.
    fn cut(&self) -> (Vec<u32>, Vec<Part>) {
        let tree = &self.tree;
        let sizes = tree.sizes();
        let (mut above, mut parts, mut place) = (vec![ROOT, 1], Vec::new(), 0);
        while place < above.len() {
            let slot = above[place];
            let size = sizes[slot as usize];
            let alone = tree.sums[slot as usize].triangles > tree.max_leaf
                && (FEWEST.min(self.most)..=self.most).contains(&size);
            match tree.at(slot).pair() {
                Some(_) if alone => parts.push(Part { from: slot, to: place as u32, below: size as usize - 1 }),
                Some(pair) => above.extend([pair, pair + 1]),
                None => {}
            }
            // The slot behind the root's is none.
            place += if place == 0 { 2 } else { 1 };
        }
        (above, parts)
    }

    /// Copies what is above the subtrees to its new places.
    fn copy_above(&self, above: &[u32], next: &mut Memory<V::Mark>) {
        next.slots[ROOT as usize].parent = NONE;
        let mut first = 2;
        for (to, &from) in above.iter().enumerate().filter(|&(to, _)| to != 1) {
            let mut slot = Slot { parent: next.slots[to].parent, ..*self.tree.at(from) };
            // The roots of subtrees have none of their children here; they come back with other links.
            let child = slot.pair().filter(|&pair| above.get(first) == Some(&pair));
            if child.is_some() {
                slot.link = first as u32;
                next.slots[first].parent = to as u32;
                next.slots[first + 1].parent = to as u32;
                first += 2;
            }
            (next.slots[to], next.sums[to], next.marks[to]) =
                (slot, self.tree.sums[from as usize], self.marks[from as usize]);
        }
    }

    /// Visits the subtrees and puts them into their places. What the cost lost, and the number of the latest change.
    fn visit_parts(
        &self,
        parts: Vec<Part>,
        above: &[u32],
        next: &mut Memory<V::Mark>,
        watch: &mut Watch,
    ) -> (f64, u32) {
        let (top, slots) = next.slots.split_at_mut(above.len());
        let (top_sums, sums) = next.sums.split_at_mut(above.len());
        let (top_marks, marks) = next.marks.split_at_mut(above.len());
        let mut rest = (above.len() as u32, slots, sums, marks);
        let mut stretches = Vec::with_capacity(parts.len());
        for part in parts {
            let (slots, behind) = rest.1.split_at_mut(part.below);
            let (sums, sums_behind) = rest.2.split_at_mut(part.below);
            let (marks, marks_behind) = rest.3.split_at_mut(part.below);
            let first = rest.0;
            rest = (first + part.below as u32, behind, sums_behind, marks_behind);
            stretches.push(Stretch { part, first, slots, sums, marks });
        }
        let (mut gain, mut moves) = (0.0, 0);
        for batch in stretches.chunks_mut(BATCH) {
            let go_on = !watch.stopped();
            let one = |copy: &mut Copied<'a, V>, stretch: &mut Stretch<V::Mark>| copy.visited(self, stretch, go_on);
            let done: Vec<_> = batch.par_iter_mut().with_max_len(1).map_init(|| Copied::new(&self.tree), one).collect();
            for (stretch, (root, sum, mark, tally)) in batch.iter().zip(done) {
                let to = stretch.part.to as usize;
                top[to] = Slot { parent: top[to].parent, ..root };
                (top_sums[to], top_marks[to]) = (sum, mark);
                gain += tally.gain;
                moves = moves.max(tally.moves);
                watch.stepped(tally.steps);
                watch.moves += u64::from(tally.moves);
            }
            watch.go_on();
        }
        (gain, self.clock + moves)
    }

    /// Visits the first `above` slots but those of `roots`, which are in order. What the cost lost.
    fn visit_above(&mut self, above: u32, roots: &[u32], watch: &mut Watch) -> f64 {
        let mut all = Tally::default();
        let mut visitor = V::since(self.clock);
        let slots: Vec<u32> =
            (2..above).rev().chain([ROOT]).filter(|slot| roots.binary_search(slot).is_err()).collect();
        for batch in slots.chunks(BATCH_ABOVE) {
            if watch.stopped() {
                break;
            }
            let mut tally = Tally::default();
            for &slot in batch {
                if self.tree.at(slot).pair().is_some() {
                    tally += visitor.visit(&mut self.tree, &mut self.marks, slot);
                }
            }
            watch.stepped(tally.steps);
            watch.moves += u64::from(tally.moves);
            watch.go_on();
            all += tally;
        }
        self.clock += all.moves;
        all.gain
    }
}

/// A subtree on its own, in memory that the next one gets.
struct Copied<'a, V: Visit> {
    tree: Dynamic<'a>,
    marks: Vec<V::Mark>,
}

impl<'a, V: Visit> Copied<'a, V> {
    fn new(of: &Dynamic<'a>) -> Self {
        let tree = Dynamic { input: of.input, slots: Vec::new(), sums: Vec::new(), max_leaf: of.max_leaf };
        Self { tree, marks: Vec::new() }
    }

    /// Visits the nodes of a subtree, if it is to, and puts it into its stretch. Its root as it is to be, and what was done.
    fn visited(
        &mut self,
        of: &Passes<'a, V>,
        stretch: &mut Stretch<V::Mark>,
        visit: bool,
    ) -> (Slot, Sum, V::Mark, Tally) {
        self.copy(of, stretch.part.from);
        let mut tally = Tally::default();
        if visit {
            let mut visitor = V::since(of.clock);
            // They were copied level by level.
            for slot in (2..self.tree.slots.len() as u32).rev().chain([ROOT]) {
                if self.tree.at(slot).pair().is_some() {
                    tally += visitor.visit(&mut self.tree, &mut self.marks, slot);
                }
            }
        }
        let shift = stretch.first - 2;
        let moved = |slot: &Slot| match slot.pair() {
            Some(pair) => Slot { link: pair + shift, ..*slot },
            None => *slot,
        };
        for (to, slot) in stretch.slots.iter_mut().zip(&self.tree.slots[2..]) {
            let parent = if slot.parent == ROOT { stretch.part.to } else { slot.parent + shift };
            *to = Slot { parent, ..moved(slot) };
        }
        stretch.sums.copy_from_slice(&self.tree.sums[2..]);
        stretch.marks.copy_from_slice(&self.marks[2..]);
        (moved(self.tree.at(ROOT)), self.tree.sums[0], self.marks[0], tally)
    }

    /// Copies the subtree level by level.
    fn copy(&mut self, of: &Passes<'a, V>, root: u32) {
        let Dynamic { slots, sums, .. } = &mut self.tree;
        slots.clear();
        sums.clear();
        self.marks.clear();
        let mut put = |slots: &mut Vec<Slot>, from: u32, parent: u32| {
            slots.push(Slot { parent, ..*of.tree.at(from) });
            sums.push(of.tree.sums[from as usize]);
            self.marks.push(of.marks[from as usize]);
        };
        put(slots, root, NONE);
        put(slots, 1, NONE);
        let mut place = 0;
        while place < slots.len() {
            if let Some(pair) = slots[place].pair() {
                slots[place].link = slots.len() as u32;
                put(slots, pair, place as u32);
                put(slots, pair + 1, place as u32);
            }
            place += if place == 0 { 2 } else { 1 };
        }
    }
}

impl Dynamic<'_> {
    /// For every slot, the slots of the subtree in it.
    fn sizes(&self) -> Vec<u32> {
        let (mut inner, mut pending) = (Vec::with_capacity(self.slots.len() / 2), vec![ROOT]);
        while let Some(slot) = pending.pop() {
            if let Some(pair) = self.at(slot).pair() {
                inner.push(slot);
                pending.extend([pair, pair + 1]);
            }
        }
        let mut sizes = vec![1; self.slots.len()];
        for &slot in inner.iter().rev() {
            let pair = self.at(slot).pair().expect("these are inner nodes") as usize;
            sizes[slot as usize] = 1 + sizes[pair] + sizes[pair + 1];
        }
        sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, median_split, random_tree, soup};
    use crate::bvh::{Bvh, tree_hash, validate};
    use proptest::prelude::*;

    /// Counts visits.
    struct Counter;

    impl Visit for Counter {
        type Mark = u32;

        fn since(_: u32) -> Self {
            Self
        }

        fn visit(&mut self, tree: &mut Dynamic, marks: &mut [u32], slot: u32) -> Tally {
            marks[slot as usize] += 1;
            for child in tree.at(slot).pair().into_iter().flat_map(|pair| [pair, pair + 1]) {
                let visits = if tree.at(child).pair().is_some() { marks[slot as usize] } else { 0 };
                assert_eq!(marks[child as usize], visits, "children are visited first");
            }
            Tally { steps: 1, ..Tally::default() }
        }
    }

    /// Swaps left children with nephews where that gains.
    struct Stirrer {
        now: u32,
    }

    impl Visit for Stirrer {
        /// The number of the latest change when the slot was visited.
        type Mark = u32;

        fn since(clock: u32) -> Self {
            Self { now: clock }
        }

        fn visit(&mut self, tree: &mut Dynamic, marks: &mut [u32], slot: u32) -> Tally {
            let pair = tree.at(slot).pair().unwrap();
            assert!(marks[pair as usize].max(marks[pair as usize + 1]) <= self.now, "changes above come later");
            marks[slot as usize] = self.now;
            let nothing = Tally { steps: 1, ..Tally::default() };
            let Some(nephew) = tree.at(pair + 1).pair() else { return nothing };
            let gain = tree.swap(pair, nephew);
            if gain <= 0.0 {
                tree.swap(pair, nephew);
                return nothing;
            }
            self.now += 1;
            Tally { gain, moves: 1, ..nothing }
        }
    }

    fn stirred(bvh: &Bvh, max_leaf: usize, most: u32, passes: usize) -> (Bvh, f64, u64) {
        let tree = Dynamic::new(bvh, max_leaf).unwrap();
        let before = tree.cost();
        let mut all = Passes::<Stirrer>::in_parts_of(most, tree);
        let mut go_on = |_| true;
        let mut watch = Watch::new(&mut go_on);
        let gain: f64 = (0..passes).map(|_| all.pass(&mut watch)).sum();
        assert!((before - all.tree.cost() - gain).abs() <= 1e-9 * before);
        (all.tree.finish(), gain, watch.moves)
    }

    proptest! {
        /// One after the other, or in subtrees of any size at the same time: one tree.
        #[test]
        fn the_same_tree_wherever_it_is_cut(seed: u64, n in 3usize..300, max_leaf in 1usize..5, most in 3u32..200, passes in 1usize..4) {
            let boxes = boxes(&soup(seed, n, 0.2));
            for bvh in [random_tree(seed, &boxes, 2, 1), median_split(&boxes, 1)] {
                let (whole, gain, moves) = stirred(&bvh, max_leaf, 0, passes);
                let (parts, gain_of_parts, moves_of_parts) = stirred(&bvh, max_leaf, most, passes);
                prop_assert!(validate(&parts, &boxes, &Default::default()).is_ok());
                prop_assert_eq!(tree_hash(&parts), tree_hash(&whole));
                prop_assert_eq!(moves_of_parts, moves);
                prop_assert!((gain - gain_of_parts).abs() <= 1e-9 * (1.0 + gain));
            }
        }
    }

    #[test]
    fn every_inner_node_once_a_pass() {
        let boxes = boxes(&soup(8, 500, 0.1));
        let bvh = random_tree(8, &boxes, 2, 1);
        for most in [0, 3, 50, 600, 10_000] {
            let mut all = Passes::<Counter>::in_parts_of(most, Dynamic::new(&bvh, 4).unwrap());
            for pass in 1..4 {
                all.pass(&mut Watch::new(&mut |_| true));
                let inner = (0..all.marks.len()).filter(|&slot| all.tree.at(slot as u32).pair().is_some());
                assert!(inner.clone().count() == 499 && inner.clone().all(|slot| all.marks[slot] == pass));
            }
        }
    }

    #[test]
    fn who_is_told_to_stop_leaves_a_valid_tree() {
        let boxes = boxes(&soup(5, 3000, 0.1));
        let bvh = random_tree(5, &boxes, 2, 1);
        for looks in 0..40 {
            let mut left = looks;
            let mut go_on = |_| {
                left -= 1;
                left >= 0
            };
            let mut all = Passes::<Stirrer>::in_parts_of(8, Dynamic::new(&bvh, 1).unwrap());
            all.pass(&mut Watch::new(&mut go_on));
            assert!(validate(&all.tree.finish(), &boxes, &Default::default()).is_ok());
        }
    }
}
