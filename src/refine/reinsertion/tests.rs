//! Reinsertion held to brute force, move by move, and on trees of every shape.

use super::search::search;
use super::*;
use crate::bvh::testing::{boxes, median_split, random_tree, soup, tighten};
use crate::bvh::{Limits, Node, tree_hash, validate};
use crate::geom::Aabb;
use crate::refine::open_leaves;
use crate::refine::testing::{cost, hard_cases_end_soon};
use glam::Vec3;
use proptest::prelude::*;

fn refined(bvh: &Bvh, max_leaf: usize, params: &Reinsertion) -> Bvh {
    let mut go_on = |_| true;
    reinsert(bvh, max_leaf, params, &mut Watch::new(&mut go_on))
}

/// Half areas of the inner nodes of a tree of one triangle a leaf.
fn inner_half_areas(bvh: &Bvh) -> f64 {
    bvh.nodes.iter().filter(|node| !node.is_leaf()).map(|node| 0.5 * node.aabb.surface_area()).sum()
}

/// Boxes in a cube of 2⁰, so that scaling leaves them as they are.
fn in_a_unit_cube(seed: u64, n: usize, size: f32) -> Vec<Aabb> {
    let mut boxes = boxes(&soup(seed, n, size));
    boxes.iter_mut().for_each(|b| *b = Aabb::new(b.min * 0.5, b.max * 0.5));
    boxes.push(Aabb::new(Vec3::ZERO, Vec3::ONE));
    boxes
}

proptest! {
    /// Every move's gain is what the tree loses, taking it back gives the same tree, and no place is better than the one found.
    #[test]
    fn the_best_of_all_places(seed: u64, n in 2usize..24, size in 0.05f32..0.6) {
        let boxes = in_a_unit_cube(seed, n, size);
        let bvh = random_tree(seed, &boxes, 2, 1);
        let mut tree = Dynamic::new(&bvh, 1).unwrap();
        let before = tree_hash(&tree.finish());
        prop_assert_eq!(before, tree_hash(&bvh));
        let old = inner_half_areas(&bvh);
        let mut stack = Vec::new();
        for from in tree.all_but_root() {
            let mut best = 0.0f64;
            for to in std::iter::once(ROOT).chain(tree.all_but_root()) {
                let Some(moved) = tree.reinsert(from, to) else { continue };
                let new = tree.finish();
                prop_assert!(validate(&new, &boxes, &Limits::default()).is_ok());
                prop_assert!((old - inner_half_areas(&new) - moved.gain).abs() < 1e-9 * old);
                best = best.max(moved.gain);
                tree.take_back(&moved);
                prop_assert_eq!(tree_hash(&tree.finish()), before);
            }
            let found = search(&tree, from, 0.0, &mut stack);
            let gain = if found.to == NONE { 0.0 } else { f64::from(found.gain) };
            prop_assert!((gain - best).abs() < 1e-5 * old, "{} {}", gain, best);
        }
    }

    /// The tree stays valid, its SAH with leaves never rises, and the cost kept is the cost that is.
    #[test]
    fn never_above_the_input(seed: u64, n in 1usize..150, size in 0.01f32..0.5, max_leaf in 1usize..6, in_leaf in 1usize..3) {
        let boxes = boxes(&soup(seed, n, size));
        for bvh in [random_tree(seed, &boxes, 2, in_leaf), median_split(&boxes, in_leaf)] {
            for params in [Reinsertion::default(), Reinsertion::PAIRS] {
                let better = refined(&bvh, max_leaf, &params);
                let limits = Limits { max_leaf: in_leaf, ..Limits::default() };
                prop_assert!(validate(&better, &boxes, &limits).is_ok());
                let (old, new) = (open_leaves(&bvh, max_leaf), open_leaves(&better, max_leaf));
                prop_assert!(cost(&new) <= cost(&old) * (1.0 + 1e-12), "{} {}", cost(&new), cost(&old));
                let kept = |bvh| Dynamic::new(bvh, max_leaf).map_or(0.0, |tree| tree.cost());
                let (lost, saved) = (kept(&bvh) - kept(&better), cost(&old) - cost(&new));
                let area = Dynamic::new(&bvh, 1).map_or(1.0, |tree| f64::from(tree.at(ROOT).wide().half_area()));
                prop_assert!((lost / area - saved).abs() < 1e-5 * cost(&old), "{} {saved}", lost / area);
            }
        }
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn threads_scale_and_repetition_change_nothing(seed: u64, n in 100usize..300) {
        let boxes = boxes(&soup(seed, n, 0.2));
        let bvh = random_tree(seed, &boxes, 2, 1);
        let mut scaled = bvh.clone();
        scaled.nodes.iter_mut().for_each(|node| {
            node.aabb = Aabb::new(node.aabb.min * 2f32.powi(-40), node.aabb.max * 2f32.powi(-40));
        });
        for params in [Reinsertion::default(), Reinsertion::PAIRS] {
            let hash = tree_hash(&refined(&bvh, 4, &params));
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                prop_assert_eq!(tree_hash(&pool.install(|| refined(&bvh, 4, &params))), hash);
            }
            prop_assert_eq!(tree_hash(&refined(&scaled, 4, &params)), hash);
        }
    }
}

#[test]
fn a_leaf_far_from_its_sibling_by_hand() {
    // Two clusters of three along x, the third of each in the other's subtree.
    let at = [0.0, 1.0, 20.0, 22.0, 21.0, 2.0].map(|x| Aabb::new(Vec3::X * x, Vec3::X * x + Vec3::ONE));
    let inner = |first| Node::inner(Aabb::EMPTY, first, 2);
    let leaf = |slot| Node::leaf(Aabb::EMPTY, slot, 1);
    // Root over ((0, 1), 2) and ((3, 4), 5).
    let nodes =
        vec![inner(1), inner(3), inner(5), inner(7), leaf(2), inner(9), leaf(5), leaf(0), leaf(1), leaf(3), leaf(4)];
    let mut bvh = Bvh { nodes, triangle_ids: (0..6).collect(), arity: 2 };
    tighten(&mut bvh, &at);
    let better = refined(&bvh, 1, &Reinsertion::default());
    assert!(validate(&better, &at, &Limits::default()).is_ok());
    // Each side of the root is one cluster, and in each the pair is of neighbours.
    let mut areas: Vec<f64> = better.nodes.iter().filter(|n| !n.is_leaf()).map(|n| n.aabb.surface_area()).collect();
    areas.sort_by(f64::total_cmp);
    assert_eq!(areas, [10.0, 10.0, 14.0, 14.0, 94.0]);
}

#[test]
fn hard_cases() {
    hard_cases_end_soon(|bvh, max_leaf, watch| reinsert(bvh, max_leaf, &Reinsertion::default(), watch));
    hard_cases_end_soon(|bvh, max_leaf, watch| reinsert(bvh, max_leaf, &Reinsertion::PAIRS, watch));
}

#[test]
fn equal_boxes_are_not_searched() {
    let boxes = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 2000];
    let bvh = median_split(&boxes, 1);
    let mut go_on = |_| true;
    let mut watch = Watch::new(&mut go_on);
    let same = reinsert(&bvh, 4, &Reinsertion::default(), &mut watch);
    assert_eq!((watch.moves, tree_hash(&same)), (0, tree_hash(&bvh)));
    assert!(watch.searches > 4000 && watch.visits <= 2 * watch.searches);
}

#[test]
fn a_step_ends_when_told_to() {
    let boxes = boxes(&soup(5, 2000, 0.1));
    let bvh = random_tree(5, &boxes, 2, 1);
    let mut asked = 0;
    let mut go_on = |_| {
        asked += 1;
        false
    };
    let mut watch = Watch::new(&mut go_on);
    let some = reinsert(&bvh, 4, &Reinsertion::PAIRS, &mut watch);
    assert!(watch.stopped() && watch.searches < 4000);
    assert!(validate(&some, &boxes, &Limits::default()).is_ok());
    assert!(asked <= 2);
}
