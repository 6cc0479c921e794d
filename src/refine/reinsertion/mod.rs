//! `reinsertion`: subtrees are taken out of the tree and put in where they enlarge it least.
//!
//! Source: Meister and Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization"; Bittner, Hapala and
//! Havran 2013, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", for the search and for reinserting two
//! subtrees at once.
//!
//! A pass goes through the subtrees from the largest area to the smallest, in batches. The best place of every subtree of a
//! batch is searched for in the tree as it is then, in parallel; then the moves are made one after the other, in the order
//! of the batch. Each is measured in the tree that it meets, in f64, and taken back where it does not lower the SAH, so
//! that moves made before it in the batch do no harm. Searches go by the areas of inner nodes alone; measured is the SAH with
//! the leaves that will be made. The tree depends on no number of threads.
//!
//! The first pass takes the largest subtrees only, the next ones twice as many each, until one takes all: most of what there is
//! to gain is above, and what was wrong there is wrong in all that is below. Passes over all follow while they gain.
//!
//! `reinsertion-pairs` goes on with passes that move two subtrees at once where one alone gains nothing: first one to its best
//! other place, though the tree gets worse; then its old sibling, or else its new one, if that makes up for it.
//!
//! Deviations: measured moves in a stated order instead of locks on nodes and atomic operations; a growing number of
//! subtrees; in the second step, pairs of siblings by area instead of the children of a node by its measures of inefficiency.

mod search;
#[cfg(test)]
mod tests;

use super::Watch;
use super::dynamic::{Dynamic, NONE, ROOT};
use crate::bvh::Bvh;
use rayon::prelude::*;
use search::{Found, search};

/// Searches that one thread makes at a time.
const CHUNK: usize = 32;

/// A single move is to gain at least this part of its old parent's area: below are roundings of f32.
const LEAST_MOVE: f32 = 1e-5;

/// A first move of two may lose as much as half the area of its old parent.
const MOST_LOSS: f32 = 0.5;

/// How far `reinsertion` goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reinsertion {
    /// The part of all subtrees that the first pass takes; twice as many at each pass after it.
    pub first_share: f64,
    /// Passes over all subtrees end when one has lowered the cost, all but that of leaves that stay, by less than this part.
    pub least_gain: f64,
    /// The part of all subtrees that are then tried in pairs, as often as that gains so much; 0 for none.
    pub pair_share: f64,
    /// The most passes of either kind.
    pub most_passes: usize,
}

impl Default for Reinsertion {
    /// Nearly all of the gain for about two passes over all subtrees.
    fn default() -> Self {
        Self { first_share: 1.0 / 16.0, least_gain: 0.01, pair_share: 0.0, most_passes: 16 }
    }
}

impl Reinsertion {
    /// To the end, pairs included.
    pub const PAIRS: Self = Self { first_share: 1.0 / 16.0, least_gain: 1e-4, pair_share: 1.0, most_passes: 64 };
}

/// Moves subtrees of the binary tree to where they lower its SAH, as long as that gains. That is the SAH which it has once
/// [`super::open_leaves`] has made leaves of at most `max_leaf` triangles; it never rises where no triangle stands in several leaves (see
/// [`super`]). Leaves stay as they are, so trees whose
/// leaves hold one triangle gain most.
///
/// Returns the input where there is nothing to move: in a tree of one or two leaves, or one that is not binary. Near-linear
/// time: no search looks at more than a thousand nodes.
pub fn reinsert(bvh: &Bvh, max_leaf: usize, params: &Reinsertion, watch: &mut Watch) -> Bvh {
    let Some(tree) = Dynamic::new(bvh, max_leaf) else { return bvh.clone() };
    let mut cost = tree.cost();
    let mut work = Optimizer { tree, stack: Vec::new() };
    let mut share = params.first_share;
    for _ in 0..params.most_passes {
        let gain = work.pass(share, Moves::One, watch);
        cost -= gain;
        if watch.stopped() || (share >= 1.0 && gain < params.least_gain * cost) {
            break;
        }
        share *= 2.0;
    }
    for _ in 0..params.most_passes {
        if watch.stopped() || params.pair_share <= 0.0 {
            break;
        }
        let gain = work.pass(params.pair_share, Moves::Two, watch);
        cost -= gain;
        if gain < params.least_gain * cost {
            break;
        }
    }
    work.tree.finish()
}

/// A tree being changed, and memory for searches.
struct Optimizer<'a> {
    tree: Dynamic<'a>,
    stack: Vec<(u32, f32)>,
}

/// How many subtrees move together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moves {
    One,
    Two,
}

impl Optimizer<'_> {
    /// Goes through the largest `share` of all subtrees. What the cost of the tree lost.
    fn pass(&mut self, share: f64, moves: Moves, watch: &mut Watch) -> f64 {
        let order = self.largest(share);
        let batch = (self.tree.all_but_root().len() / 64).clamp(16, 4096);
        let least = if moves == Moves::One { LEAST_MOVE } else { -MOST_LOSS };
        let mut gain = 0.0;
        for batch in order.chunks(batch) {
            let tree = &self.tree;
            let chunk = |slots: &[u32]| {
                let mut stack = Vec::new();
                let one = |&slot: &u32| search(tree, slot, least * tree.above(slot).half_area(), &mut stack);
                slots.iter().map(one).collect::<Vec<_>>()
            };
            let found: Vec<Found> = batch.par_chunks(CHUNK).flat_map_iter(chunk).collect();
            for found in &found {
                watch.searched(found.visits);
                gain += match moves {
                    _ if found.to == NONE => 0.0,
                    Moves::One => self.one(found, watch),
                    Moves::Two => self.two(found, watch),
                };
            }
            if !watch.go_on() {
                break;
            }
        }
        gain
    }

    /// Slots of the largest `share` of all subtrees, the largest first, of equal ones the first.
    fn largest(&self, share: f64) -> Vec<u32> {
        let all = self.tree.all_but_root();
        let count = ((all.len() as f64 * share) as usize).clamp(1, all.len());
        // Bits of numbers that are not negative are in the numbers' order.
        let key = |slot: u32| u64::from(!self.tree.at(slot).wide().half_area().to_bits()) << 32 | u64::from(slot);
        let mut keys: Vec<u64> = all.map(key).collect();
        if count < keys.len() {
            keys.select_nth_unstable(count);
            keys.truncate(count);
        }
        keys.par_sort_unstable();
        keys.into_iter().map(|key| key as u32).collect()
    }

    /// Makes a move, and takes it back where it gains nothing. The gain.
    fn one(&mut self, found: &Found, watch: &mut Watch) -> f64 {
        match self.tree.reinsert(found.from, found.to) {
            Some(moved) if moved.gain > 0.0 => {
                watch.moves += 1;
                moved.gain
            }
            Some(moved) => {
                self.tree.take_back(&moved);
                0.0
            }
            None => 0.0,
        }
    }

    /// Makes a move, and where it gains nothing a second one of the subtree's old or new sibling. Takes both back where they
    /// gain nothing together. The gain.
    fn two(&mut self, found: &Found, watch: &mut Watch) -> f64 {
        let Some(first) = self.tree.reinsert(found.from, found.to) else { return 0.0 };
        if first.gain > 0.0 {
            watch.moves += 1;
            return first.gain;
        }
        for sibling in [first.old, first.now ^ 1] {
            if sibling == ROOT {
                continue;
            }
            let least = LEAST_MOVE * self.tree.above(sibling).half_area() - first.gain as f32;
            let found = search(&self.tree, sibling, least, &mut self.stack);
            watch.searched(found.visits);
            let second = if found.to == NONE { None } else { self.tree.reinsert(found.from, found.to) };
            let Some(second) = second else { continue };
            if first.gain + second.gain > 0.0 {
                watch.moves += 2;
                return first.gain + second.gain;
            }
            self.tree.take_back(&second);
        }
        self.tree.take_back(&first);
        0.0
    }
}
