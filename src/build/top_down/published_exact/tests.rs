//! The engine against its literal twin: trees and counts of rule Q8, on scenes that provoke ties.

use super::super::{Published, published_literal};
use super::build;
use crate::build::testing::{any_boxes, inner_sizes};
use crate::build::{Brake, BuildError, Counters, Work};
use crate::bvh::{Bvh, tree_hash};
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use glam::Vec3;
use proptest::prelude::*;

fn check(boxes: &[Aabb], p: &Published) -> Bvh {
    let (mut expected, mut counted) = (Counters::default(), Counters::default());
    let literal = published_literal::build(boxes, p, &mut expected).unwrap();
    let exact = build(boxes, p, &mut counted).unwrap();
    assert_eq!(tree_hash(&exact), tree_hash(&literal), "{p:?}, {} boxes: {boxes:?}", boxes.len());
    for work in [Work::Q8Nodes, Work::Q8AtStart] {
        assert_eq!(counted.get(work), expected.get(work), "{p:?} {work:?}");
    }
    same_boxes(&exact, &literal);
    exact
}

/// Boxes do not enter the hash; those of rule Q8 do not even follow from it.
fn same_boxes(a: &Bvh, b: &Bvh) {
    let mut stack = vec![(0, 0)];
    while let Some((i, j)) = stack.pop() {
        assert_eq!(a.nodes[i].aabb, b.nodes[j].aabb);
        stack.extend(a.children(i).zip(b.children(j)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn binary(boxes in any_boxes(1..=400)) {
        check(&boxes, &Published::at_arity(2));
    }

    #[test]
    fn quaternary(boxes in any_boxes(1..=150)) {
        check(&boxes, &Published::at_arity(4));
    }

    #[test]
    fn octonary(boxes in any_boxes(1..=19), q8: bool) {
        check(&boxes, &Published { q8, ..Published::at_arity(8) });
    }

    #[test]
    fn any_arity_with_few_candidates(boxes in any_boxes(1..=120), arity in 2usize..=8, more in 0usize..6, q8: bool) {
        check(&boxes, &Published { arity, candidates: arity + more, q8 });
    }
}

/// Groups of equal boxes, some of them far larger than a leaf, beside single ones.
fn groups() -> impl Strategy<Value = Vec<Aabb>> {
    (any_boxes(1..=12), proptest::collection::vec((0usize..12, 1usize..40), 1..12))
        .prop_map(|(boxes, groups)| groups.into_iter().flat_map(|(i, n)| vec![boxes[i % boxes.len()]; n]).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn groups_of_equal_boxes(boxes in groups()) {
        check(&boxes, &Published::at_arity(2));
        check(&boxes, &Published { arity: 4, candidates: 20, q8: true });
        check(&boxes, &Published { arity: 8, candidates: 9, q8: true });
    }

    #[test]
    fn work_stays_within_the_closed_form(boxes in any_boxes(5..=300), arity in 2usize..=8) {
        let p = Published { arity, candidates: 40, q8: false };
        let mut counters = Counters::default();
        let bvh = build(&boxes, &p, &mut counters).unwrap();
        let (mut steps, mut costs) = (0, 0);
        for n in inner_sizes(&bvh).into_iter().filter(|&n| n >= arity) {
            let m = p.positions(n);
            steps += 3 * (m + (arity - 2) * (m * (m - 1) / 2));
            costs += if arity == 2 { 3 * 2 * m } else { 3 * ((m + 1) * (m + 2) / 2 + m + 2 * arity) };
        }
        prop_assert!(counters.get(Work::DpSteps) <= steps as u64);
        prop_assert!(counters.get(Work::ChildCosts) <= costs as u64 + 3 * arity as u64);
        prop_assert!(steps == 0 || counters.get(Work::DpSteps) > 0);
        prop_assert_eq!(tree_hash(&bvh), tree_hash(&build(&boxes, &p, &mut ()).unwrap()));
    }
}

#[test]
fn every_family_at_small_sizes() {
    for family in FAMILIES {
        for n in (1..=33).chain([64, 100, 199, 256, 500]) {
            let boxes = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap().boxes();
            for arity in [2, 4, 8] {
                check(&boxes, &Published { arity, candidates: 9, q8: true });
                check(&boxes, &Published { arity, candidates: 16, q8: false });
            }
            check(&boxes, &Published::at_arity(2));
        }
    }
}

#[test]
fn thesis_tiny_and_small() {
    for scene in ["thesis:tiny", "thesis:small"] {
        let boxes = Scene::load(scene).unwrap().boxes();
        check(&boxes, &Published::at_arity(2));
        check(&boxes, &Published::at_arity(4));
        check(&boxes, &Published { arity: 8, candidates: 10, q8: true });
    }
}

#[test]
fn a_stopped_build_says_what_was_left() {
    let boxes = Scene::load("gen:soup:3000").unwrap().boxes();
    let mut brake = Brake::new(Some(std::time::Instant::now()));
    let Err(BuildError::Stopped(unfinished)) = build(&boxes, &Published::at_arity(8), &mut brake) else {
        panic!("a deadline in the past stops the build");
    };
    let left: usize = unfinished.pending.iter().sum();
    assert!(left > 0 && left <= boxes.len());
    assert!(brake.steps() > 0);
}

#[test]
fn bad_parameters_and_boxes_are_refused_as_by_the_literal_engine() {
    let good = Aabb::new(Vec3::ZERO, Vec3::ONE);
    let bad = Aabb::new(Vec3::NAN, Vec3::ONE);
    for (boxes, arity, candidates) in
        [(vec![good; 9], 1, 100), (vec![good; 9], 9, 100), (vec![good; 9], 4, 3), (vec![], 2, 100), (vec![bad], 2, 100)]
    {
        let p = Published { arity, candidates, q8: true };
        let refused = build(&boxes, &p, &mut ());
        assert!(refused.is_err());
        assert_eq!(refused, published_literal::build(&boxes, &p, &mut ()));
    }
}
