//! The heap against the scan of all pairs.

use super::build;
use crate::build::bottom_up::all_pairs_literal::{self, Distance};
use crate::build::bottom_up::testing::{clumps, extremes, hand_made};
use crate::build::testing::any_boxes;
use crate::build::{Brake, BuildError, Counters, Work};
use crate::bvh::{Limits, tree_hash, validate};
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use glam::Vec3;
use proptest::prelude::*;

fn check(boxes: &[Aabb]) -> Result<(), TestCaseError> {
    let mut counters = Counters::default();
    let bvh = build(boxes, &mut counters).unwrap();
    let literal = all_pairs_literal::build(boxes, Distance::Centres, &mut ()).unwrap();
    prop_assert!(validate(&bvh, boxes, &Limits::default()).is_ok());
    prop_assert_eq!(tree_hash(&bvh), tree_hash(&literal));
    prop_assert_eq!(tree_hash(&bvh), tree_hash(&build(boxes, &mut ()).unwrap()));
    let n = boxes.len() as u64;
    prop_assert_eq!(counters.get(Work::Merges), n - 1);
    prop_assert_eq!(counters.get(Work::BoxUnions), n - 1);
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
        for n in [1, 2, 5, 64, 300, 700] {
            check(&family.generate(n, 1).boxes()).unwrap_or_else(|e| panic!("{} of {n}: {e}", family.name));
        }
    }
}

#[test]
fn same_tree_on_the_smallest_thesis_scene() {
    check(&Scene::load("thesis:tiny").unwrap().boxes()).unwrap();
}

#[test]
fn searches_are_linear_in_number_where_everything_ties() {
    for (scene, most) in [("gen:grid:20000", 6), ("gen:coincident:20000", 4), ("gen:nested:20000", 4)] {
        let boxes = Scene::load(scene).unwrap().boxes();
        let mut counters = Counters::default();
        build(&boxes, &mut counters).unwrap();
        let searches = counters.get(Work::NearestSearches);
        assert!(searches < most * boxes.len() as u64, "{scene}: {searches}");
        let visits = counters.get(Work::SearchVisits);
        assert!(visits < 200 * boxes.len() as u64, "{scene}: {visits}");
    }
}

#[test]
fn work_is_counted_where_it_is_done() {
    let boxes: Vec<Aabb> = (0..3).map(|i| Aabb::new(Vec3::splat(i as f32), Vec3::splat(i as f32 + 0.5))).collect();
    let mut counters = Counters::default();
    build(&boxes, &mut counters).unwrap();
    assert_eq!(counters.get(Work::Merges), 2);
    assert!(counters.get(Work::NearestSearches) >= 3);
    assert!(counters.get(Work::PairDistances) >= 3);
    assert!(counters.get(Work::SearchVisits) >= counters.get(Work::PairDistances));
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
#[ignore = "minutes: the literal engine's n³"]
fn same_tree_on_larger_scenes() {
    for scene in
        ["thesis:small", "gen:boxes:3000", "gen:grid:3000", "gen:stadium:3000", "gen:terrain:3000", "thesis:med"]
    {
        check(&Scene::load(scene).unwrap().boxes()).unwrap_or_else(|e| panic!("{scene}: {e}"));
    }
}
