//! `rotations`: nodes swap children with grandchildren, and grandchildren with each other, where that lowers the SAH.
//!
//! Source: Kensler 2008, "Tree Rotations for Improving Bounding Volume Hierarchies", hill climbing by its six rotations.
//!
//! A pass visits the inner nodes from the deepest level up, on each level from the right. At each, the rotation that makes the
//! boxes of its children smallest is made, and taken back where the SAH, with the leaves that will be made, does not fall.
//! Passes follow until one gains next to nothing.
//!
//! **Ties.** The left child with a grandchild on the right (the left one first), the right child with one on the left, then
//! grandchildren: the left one on the left with the left one on the right, then with the other.
//!
//! Deviations: no simulated annealing; children that are leaves swap as others do.

use super::Watch;
use super::dynamic::{Dynamic, Passes, Tally, Visit};
use crate::bvh::Bvh;

/// Passes end when one has lowered the cost by no more than this part.
const LEAST_GAIN: f64 = 1e-4;

/// The most passes.
const MOST_PASSES: usize = 64;

/// Rotates nodes of the binary tree as long as that lowers its SAH: the one which it has once [`super::open_leaves`] has made
/// leaves of at most `max_leaf` triangles; it never rises where no triangle stands in several leaves (see
/// [`super`]). Leaves stay as they are.
///
/// Returns the input where there is nothing to rotate: in a tree of one or two leaves, or one that is not binary. Time is
/// O(nodes) a pass.
pub fn rotate(bvh: &Bvh, max_leaf: usize, watch: &mut Watch) -> Bvh {
    climb(bvh, max_leaf, LEAST_GAIN, watch)
}

/// Passes until one lowers the cost by no more than the part `least`.
fn climb(bvh: &Bvh, max_leaf: usize, least: f64, watch: &mut Watch) -> Bvh {
    let Some(tree) = Dynamic::new(bvh, max_leaf) else { return bvh.clone() };
    let mut cost = tree.cost();
    let mut passes = Passes::<Rotations>::over(tree);
    for _ in 0..MOST_PASSES {
        let gain = passes.pass(watch);
        cost -= gain;
        if watch.stopped() || gain <= least * cost {
            break;
        }
    }
    passes.tree().finish()
}

/// Makes rotations.
struct Rotations;

impl Visit for Rotations {
    type Mark = ();

    fn since(_: u32) -> Self {
        Self
    }

    fn visit(&mut self, tree: &mut Dynamic, _: &mut [()], slot: u32) -> Tally {
        let nothing = Tally { steps: 1, ..Tally::default() };
        let Some((a, b)) = best(tree, slot) else { return nothing };
        let gain = tree.swap(a, b);
        if gain > 0.0 {
            return Tally { gain, moves: 1, ..nothing };
        }
        tree.swap(a, b);
        nothing
    }
}

/// The two slots whose swap makes the boxes of the node's children smallest, if any makes them smaller.
fn best(tree: &Dynamic, slot: u32) -> Option<(u32, u32)> {
    let left = tree.at(slot).pair()?;
    let right = left + 1;
    let area_of_both = |a: u32, b: u32| tree.at(a).wide().union(&tree.at(b).wide()).half_area();
    let area = |slot: u32| tree.at(slot).wide().half_area();
    let mut best = (0.0, None);
    let mut offer = |gain: f32, swap: (u32, u32)| {
        if gain > best.0 {
            best = (gain, Some(swap));
        }
    };
    for (child, other) in [(left, right), (right, left)] {
        for grandchild in tree.at(other).pair().into_iter().flat_map(|pair| [pair, pair + 1]) {
            offer(area(other) - area_of_both(child, grandchild ^ 1), (child, grandchild));
        }
    }
    if let (Some(on_left), Some(on_right)) = (tree.at(left).pair(), tree.at(right).pair()) {
        for grandchild in [on_right, on_right + 1] {
            let new = area_of_both(grandchild, on_left + 1) + area_of_both(on_left, grandchild ^ 1);
            offer(area(left) + area(right) - new, (on_left, grandchild));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, random_tree, soup, tighten};
    use crate::bvh::{Limits, Node, tree_hash, validate};
    use crate::geom::Aabb;
    use crate::refine::dynamic::ROOT;
    use crate::refine::testing::{applied, hard_cases_end_soon, never_above_the_input};
    use glam::Vec3;
    use proptest::prelude::*;

    /// Root over ((a, b), (c, d)), a box on the x axis at each place.
    fn four(places: [f32; 4]) -> (Bvh, Vec<Aabb>) {
        let boxes: Vec<_> = places.map(|x| Aabb::new(Vec3::X * x, Vec3::X * x + Vec3::ONE)).into();
        let inner = [1, 3, 5].map(|first| Node::inner(Aabb::EMPTY, first, 2));
        let leaves = (0..4).map(|slot| Node::leaf(Aabb::EMPTY, slot, 1));
        let nodes = inner.into_iter().chain(leaves).collect();
        let mut bvh = Bvh { nodes, triangle_ids: (0..4).collect(), arity: 2 };
        tighten(&mut bvh, &boxes);
        (bvh, boxes)
    }

    #[test]
    fn grandchildren_by_hand() {
        // Neighbours in either order of the second pair.
        for places in [[0.0, 8.0, 1.0, 9.0], [0.0, 8.0, 9.0, 1.0], [8.0, 0.0, 9.0, 1.0], [8.0, 0.0, 1.0, 9.0]] {
            let (bvh, boxes) = four(places);
            let better = applied(rotate, &bvh, 1);
            assert!(validate(&better, &boxes, &Limits::default()).is_ok());
            let areas: Vec<_> = better.children(0).map(|child| better.nodes[child].aabb.surface_area()).collect();
            assert_eq!(areas, [10.0, 10.0]);
        }
        let (best, _) = four([0.0, 1.0, 8.0, 9.0]);
        assert_eq!(tree_hash(&applied(rotate, &best, 1)), tree_hash(&best));
    }

    #[test]
    fn a_child_and_a_grandchild_by_hand() {
        // Root over (0, (1, 2)): 0 and 1 are neighbours, or 0 and 2; and the same the other way round.
        for (places, mirrored) in
            [([0.0, 1.0, 9.0], false), ([0.0, 9.0, 1.0], false), ([0.0, 1.0, 9.0], true), ([0.0, 9.0, 1.0], true)]
        {
            let boxes: Vec<_> = places.map(|x| Aabb::new(Vec3::X * x, Vec3::X * x + Vec3::ONE)).into();
            let (alone, pair) = (Node::leaf(Aabb::EMPTY, 0, 1), Node::inner(Aabb::EMPTY, 3, 2));
            let [left, right] = if mirrored { [pair, alone] } else { [alone, pair] };
            let leaves = [1, 2].map(|slot| Node::leaf(Aabb::EMPTY, slot, 1));
            let nodes = vec![Node::inner(Aabb::EMPTY, 1, 2), left, right, leaves[0], leaves[1]];
            let mut bvh = Bvh { nodes, triangle_ids: vec![0, 1, 2], arity: 2 };
            tighten(&mut bvh, &boxes);
            let better = applied(rotate, &bvh, 1);
            assert!(validate(&better, &boxes, &Limits::default()).is_ok());
            let inner = better.children(0).find(|&child| !better.nodes[child].is_leaf()).unwrap();
            assert_eq!(better.nodes[inner].aabb.surface_area(), 10.0);
        }
    }

    proptest! {
        #[test]
        fn never_above(seed: u64, n in 1usize..200, size in 0.01f32..0.5, max_leaf in 1usize..6) {
            never_above_the_input(rotate, seed, (n, size), max_leaf)?;
        }

        /// No swap of any child and grandchild that remains would gain more than rounding hides.
        #[test]
        fn ends_where_no_rotation_gains(seed: u64, n in 3usize..40) {
            let boxes = boxes(&soup(seed, n, 0.2));
            let mut go_on = |_| true;
            let bvh = climb(&random_tree(seed, &boxes, 2, 1), 1, 0.0, &mut Watch::new(&mut go_on));
            let mut tree = Dynamic::new(&bvh, 1).unwrap();
            let enough = 1e-6 * tree.cost();
            let hash = tree_hash(&bvh);
            for slot in std::iter::once(ROOT).chain(tree.all_but_root()) {
                let Some(pair) = tree.at(slot).pair() else { continue };
                for child in [pair, pair + 1] {
                    for grandchild in tree.at(child ^ 1).pair().into_iter().flat_map(|pair| [pair, pair + 1]) {
                        prop_assert!(tree.swap(child, grandchild) <= enough);
                        tree.swap(child, grandchild);
                        prop_assert_eq!(tree_hash(&tree.finish()), hash);
                    }
                }
            }
        }
    }

    #[test]
    fn hard_cases() {
        hard_cases_end_soon(rotate);
    }
}
