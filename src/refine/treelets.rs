//! `treelets`: small connected parts of the tree get the best of all shapes.
//!
//! Source: Karras and Aila 2013, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", section 4.
//!
//! A treelet is a node and what is opened below it, always the part of the largest area, until it has seven parts. A dynamic
//! program over the 127 sets of parts finds the tree over them with the least area, from smaller sets to larger ones. A pass
//! visits the inner nodes from the deepest level up, on each level from the right; a new shape is taken back where the SAH,
//! with the leaves that will be made, does not fall. Passes follow until one gains next to nothing.
//!
//! **Ties.** The first part of the largest area, in the order in which they were opened; of equal trees over a set the split
//! whose side with the set's last part has the highest number in binary.
//!
//! Deviations: all nodes instead of those over a least number of triangles.

use super::Watch;
use super::dynamic::{Dynamic, Passes, Tally, Visit, Wide};
use crate::bvh::Bvh;

/// Parts of a treelet.
const PARTS: usize = 7;

/// Sets of parts.
const SETS: usize = 1 << PARTS;

/// Passes end when one has lowered the cost by less than this part.
const LEAST_GAIN: f64 = 1e-3;

/// The most passes.
const MOST_PASSES: usize = 16;

/// Gives the treelets of the binary tree their best shapes as long as that lowers its SAH: the one which it has once
/// [`super::open_leaves`] has made leaves of at most `max_leaf` triangles; it never rises where no triangle stands in several leaves (see
/// [`super`]). Leaves stay as they are.
///
/// Returns the input where there is nothing to do: in a tree of one or two leaves, or one that is not binary. Time is O(nodes)
/// a pass.
pub fn restructure(bvh: &Bvh, max_leaf: usize, watch: &mut Watch) -> Bvh {
    let Some(tree) = Dynamic::new(bvh, max_leaf) else { return bvh.clone() };
    let mut cost = tree.cost();
    let mut passes = Passes::<Shaper>::over(tree);
    for _ in 0..MOST_PASSES {
        let gain = passes.pass(watch);
        cost -= gain;
        if watch.stopped() || gain < LEAST_GAIN * cost {
            break;
        }
    }
    passes.tree().finish()
}

/// What passes remember of a slot.
#[derive(Clone, Copy, Default)]
struct Mark {
    /// The number of the change that wrote it last.
    changed: u32,
    /// The changes so far when the treelet below it was looked at last; 0 where none was.
    seen: u32,
}

/// Gives treelets their best shapes.
struct Shaper {
    /// Changes so far.
    now: u32,
    table: Table,
}

impl Visit for Shaper {
    type Mark = Mark;

    fn since(clock: u32) -> Self {
        Self { now: clock, table: Table::default() }
    }

    /// Not where the treelet is as it was at the last visit.
    fn visit(&mut self, tree: &mut Dynamic, marks: &mut [Mark], root: u32) -> Tally {
        let looked = Tally { steps: 1, ..Tally::default() };
        let Some(treelet) = Treelet::below(tree, root) else { return looked };
        let slots = || treelet.pairs.iter().flat_map(|&pair| [pair, pair + 1]).chain([root]);
        let seen = std::mem::replace(&mut marks[root as usize].seen, self.now);
        if seen > 0 && slots().all(|slot| marks[slot as usize].changed <= seen) {
            return looked;
        }
        let searched = Tally { steps: 1 + (1 << treelet.parts.len()), ..looked };
        let Some(shape) = self.table.best(tree, &treelet) else { return searched };
        let gain = tree.reshape(root, &treelet.pairs, &treelet.parts, &shape);
        if gain <= 0.0 {
            return searched;
        }
        self.now += 1;
        slots().for_each(|slot| marks[slot as usize].changed = self.now);
        Tally { gain, moves: 1, ..searched }
    }
}

/// Part of a tree.
struct Treelet {
    /// The pairs of slots in it, the root's children first, parents before children.
    pairs: Vec<u32>,
    /// Slots of its parts.
    parts: Vec<u32>,
    /// Half areas of the nodes above its parts.
    area: f32,
}

impl Treelet {
    /// The treelet of a node; none where it has fewer than three parts.
    fn below(tree: &Dynamic, root: u32) -> Option<Self> {
        let area = |slot: u32| tree.at(slot).wide().half_area();
        let mut treelet = Self { pairs: Vec::with_capacity(PARTS - 1), parts: Vec::with_capacity(PARTS), area: 0.0 };
        treelet.parts.push(root);
        while treelet.parts.len() < PARTS {
            let inner = (0..treelet.parts.len()).filter(|&i| tree.at(treelet.parts[i]).pair().is_some());
            // The last of equals is taken: so from the back.
            let largest = inner.rev().max_by(|&a, &b| area(treelet.parts[a]).total_cmp(&area(treelet.parts[b])));
            let Some(place) = largest else { break };
            let opened = treelet.parts[place];
            let pair = tree.at(opened).pair()?;
            treelet.area += area(opened);
            treelet.pairs.push(pair);
            treelet.parts[place] = pair;
            treelet.parts.push(pair + 1);
        }
        (treelet.parts.len() > 2).then_some(treelet)
    }
}

/// Of every set of parts, the box, the least cost of a tree, and the split at its root.
struct Table {
    boxes: [Wide; SETS],
    costs: [f32; SETS],
    splits: [u8; SETS],
}

impl Default for Table {
    /// One to be filled.
    fn default() -> Self {
        Self { boxes: [Wide::default(); SETS], costs: [0.0; SETS], splits: [0; SETS] }
    }
}

impl Table {
    /// The splits of the best tree over the parts, each a set of parts and the half that goes left, parents before children.
    /// None where it is no better than the one that is there.
    fn best(&mut self, tree: &Dynamic, treelet: &Treelet) -> Option<Vec<[u8; 2]>> {
        let sets = 1usize << treelet.parts.len();
        for set in 1..sets {
            let (last, rest) = (set.ilog2() as usize, set & !(1 << set.ilog2()));
            let part = tree.at(treelet.parts[last]).wide();
            if rest == 0 {
                (self.boxes[set], self.costs[set]) = (part, 0.0);
                continue;
            }
            self.boxes[set] = self.boxes[rest].union(&part);
            // The side with the last part, and any but all of the rest.
            let mut best = (f32::INFINITY, 0);
            let mut others = rest;
            while others > 0 {
                others = (others - 1) & rest;
                let side = others | 1 << last;
                let cost = self.costs[side] + self.costs[set & !side];
                if cost < best.0 {
                    best = (cost, side);
                }
            }
            (self.costs[set], self.splits[set]) = (best.0 + self.boxes[set].half_area(), best.1 as u8);
        }
        if self.costs[sets - 1] >= treelet.area * (1.0 - 1e-5) {
            return None;
        }
        let mut shape = Vec::with_capacity(PARTS - 1);
        let mut open = vec![sets - 1];
        while let Some(set) = open.pop() {
            if set.count_ones() > 1 {
                let side = usize::from(self.splits[set]);
                shape.push([set as u8, side as u8]);
                open.extend([set & !side, side]);
            }
        }
        Some(shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, median_split, random_tree, soup};
    use crate::bvh::{Limits, tree_hash, validate};
    use crate::geom::Aabb;
    use crate::refine::dynamic::ROOT;
    use crate::refine::testing::{applied, hard_cases_end_soon, never_above_the_input};
    use proptest::prelude::*;

    /// The least area of the inner nodes of any tree over the boxes, by trying all.
    fn least(boxes: &[Aabb]) -> f64 {
        if boxes.len() == 1 {
            return 0.0;
        }
        let sides = |set: usize| {
            let of =
                |side| (0..boxes.len()).filter(move |i| set >> i & 1 == side).map(|i| boxes[i]).collect::<Vec<_>>();
            least(&of(0)) + least(&of(1))
        };
        // The last box is always on the side of the zeros.
        let best = (1..1 << (boxes.len() - 1)).map(sides).fold(f64::INFINITY, f64::min);
        best + Aabb::union_of(boxes).surface_area()
    }

    proptest! {
        #[test]
        fn seven_or_fewer_get_the_best_tree(seed: u64, n in 3usize..=7, size in 0.05f32..0.8) {
            let boxes = boxes(&soup(seed, n, size));
            let bvh = applied(restructure, &random_tree(seed, &boxes, 2, 1), 1);
            prop_assert!(validate(&bvh, &boxes, &Limits::default()).is_ok());
            let inner = bvh.nodes.iter().filter(|node| !node.is_leaf()).map(|node| node.aabb.surface_area());
            let (area, least) = (inner.sum::<f64>(), least(&boxes));
            prop_assert!((area - least).abs() <= 2e-5 * least, "{area} {least}");
        }

        #[test]
        fn never_above(seed: u64, n in 1usize..200, size in 0.01f32..0.5, max_leaf in 1usize..6) {
            never_above_the_input(restructure, seed, (n, size), max_leaf)?;
        }

        /// A shape that costs more is taken back without a trace, and one that is kept gains what it says.
        #[test]
        fn shapes_are_measured_and_taken_back(seed: u64, n in 8usize..40, max_leaf in 1usize..5) {
            let boxes = boxes(&soup(seed, n, 0.2));
            let bvh = median_split(&boxes, 1);
            let mut tree = Dynamic::new(&bvh, max_leaf).unwrap();
            for slot in tree.all_but_root().rev().chain([ROOT]) {
                let Some(treelet) = Treelet::below(&tree, slot) else { continue };
                // A chain of the parts from the last to the first.
                let parts = treelet.parts.len();
                let chain: Vec<_> = (2..=parts).rev().map(|n| [(1u16 << n) as u8 - 1, 1 << (n - 1)]).collect();
                let (hash, before) = (tree_hash(&tree.finish()), tree.cost());
                let gain = tree.reshape(slot, &treelet.pairs, &treelet.parts, &chain);
                prop_assert!((before - tree.cost() - gain).abs() <= 1e-9 * before);
                prop_assert!(gain > 0.0 || tree_hash(&tree.finish()) == hash);
                prop_assert!(validate(&tree.finish(), &boxes, &Limits::default()).is_ok());
            }
        }
    }

    #[test]
    fn hard_cases() {
        hard_cases_end_soon(restructure);
    }
}
