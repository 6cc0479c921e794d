//! The chain over k-d trees against the chain that scans all live clusters.

use super::build;
use crate::build::bottom_up::chain_literal;
use crate::build::bottom_up::testing::{clumps, extremes, hand_made};
use crate::build::testing::any_boxes;
use crate::build::{Brake, BuildError, Counters, Work};
use crate::bvh::{Limits, tree_hash, validate};
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use glam::Vec3;
use proptest::prelude::*;

/// The literal engine's answer, the same tree or the same circle, and its counts.
fn check(boxes: &[Aabb]) -> Result<(), TestCaseError> {
    let (mut counters, mut expected) = (Counters::default(), Counters::default());
    let tree = build(boxes, &mut counters);
    let literal = chain_literal::build(boxes, &mut expected, &mut ());
    prop_assert_eq!(tree.as_ref().map(tree_hash), literal.as_ref().map(tree_hash));
    if let Ok(bvh) = &tree {
        prop_assert!(validate(bvh, boxes, &Limits::default()).is_ok());
        prop_assert_eq!(tree_hash(bvh), tree_hash(&build(boxes, &mut ()).unwrap()));
    }
    for work in [Work::Merges, Work::BoxUnions, Work::NearestSearches] {
        prop_assert_eq!(counters.get(work), expected.get(work));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn same_tree_on_small_scenes(boxes in any_boxes(1..=60)) {
        check(&boxes)?;
    }

    #[test]
    fn same_tree_through_several_generations_of_search_trees(boxes in prop_oneof![any_boxes(200..=500), clumps(500)]) {
        check(&boxes)?;
    }

    #[test]
    fn same_tree_where_coordinates_are_huge_or_tiny(boxes in extremes(1..=200)) {
        check(&boxes)?;
    }
}

#[test]
fn same_tree_on_scenes_made_to_tie() {
    for (name, boxes) in hand_made() {
        check(&boxes).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn same_tree_on_every_family() {
    for family in FAMILIES {
        for n in [1, 2, 5, 64, 300, 3000] {
            check(&family.generate(n, 1).boxes()).unwrap_or_else(|e| panic!("{} of {n}: {e}", family.name));
        }
    }
}

#[test]
fn same_tree_on_the_smallest_thesis_scenes() {
    for scene in ["thesis:tiny", "thesis:small"] {
        check(&Scene::load(scene).unwrap().boxes()).unwrap_or_else(|e| panic!("{scene}: {e}"));
    }
}

#[test]
fn visits_stay_few_where_everything_ties() {
    for scene in ["gen:grid:20000", "gen:coincident:20000", "gen:nested:20000", "gen:spheres:20000"] {
        let boxes = Scene::load(scene).unwrap().boxes();
        let mut counters = Counters::default();
        build(&boxes, &mut counters).unwrap();
        let visits = counters.get(Work::SearchVisits);
        assert!(visits < 400 * boxes.len() as u64, "{scene}: {visits}");
        assert!(visits >= counters.get(Work::PairDistances));
    }
}

#[test]
fn a_stopped_build_says_how_many_clusters_were_left() {
    let boxes = Scene::load("gen:soup:20000").unwrap().boxes();
    let mut brake = Brake::new(Some(std::time::Instant::now()));
    let Err(BuildError::Stopped(left)) = build(&boxes, &mut brake) else {
        panic!("a deadline in the past stops the build");
    };
    assert!((2..=20_000).contains(&left.pending[0]) && left.pending.len() == 1);
}

#[test]
fn what_no_builder_takes_is_refused() {
    assert_eq!(build(&[], &mut ()), Err(BuildError::NoTriangles));
    let valid = Aabb::new(Vec3::ZERO, Vec3::ONE);
    let boxes = [valid, Aabb::EMPTY];
    assert_eq!(build(&boxes, &mut ()), Err(BuildError::InvalidBox(1)));
}

#[test]
#[ignore = "minutes: the literal engine's n²"]
fn same_tree_on_larger_scenes() {
    for scene in ["thesis:med", "thesis:large", "thesis:huge", "gen:boxes:30000", "gen:grid:30000", "gen:stadium:30000"]
    {
        check(&Scene::load(scene).unwrap().boxes()).unwrap_or_else(|e| panic!("{scene}: {e}"));
    }
}
