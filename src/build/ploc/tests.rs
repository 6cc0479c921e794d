//! The tree against the paper's rounds, every distance taken anew; rounds and work where few merge.

use super::*;
use crate::build::Counters;
use crate::build::testing::{any_boxes, on_a_grid, same_everywhere};
use crate::bvh::{Limits, tree_hash, validate};
use crate::refine::open_leaves;
use crate::scene::Scene;
use proptest::prelude::*;

fn scene(name: &str) -> Vec<Aabb> {
    Scene::load(name).unwrap().boxes()
}

fn checked(boxes: &[Aabb], radius: usize, max_leaf: usize) -> Bvh {
    let bvh = build(boxes, &Ploc { radius, max_leaf }, &mut ()).unwrap();
    validate(&bvh, boxes, &Limits { max_leaf, ..Limits::default() }).unwrap();
    bvh
}

/// The paper's rounds over a row, every distance taken anew in f64. Returns the tree and the number of rounds.
fn literal(boxes: &[Aabb], radius: usize) -> (String, u64) {
    let ids = Order::new(boxes, Simd::detect()).unwrap().ids;
    let mut row: Vec<(Aabb, usize, String)> =
        ids.iter().enumerate().map(|(place, &id)| (boxes[id as usize], place, id.to_string())).collect();
    let mut rounds = 0;
    while row.len() > 1 {
        let nearest: Vec<usize> = (0..row.len())
            .map(|own| {
                let others =
                    (own.saturating_sub(radius)..row.len().min(own + radius + 1)).filter(|&other| other != own);
                let key = |other: usize| {
                    let e = row[own].0.union(&row[other].0);
                    let e = e.max.as_dvec3() - e.min.as_dvec3();
                    (e.x * e.y + e.y * e.z + e.z * e.x, row[own].1 ^ row[other].1)
                };
                others.min_by(|&a, &b| key(a).partial_cmp(&key(b)).unwrap()).unwrap()
            })
            .collect();
        let mut next = Vec::new();
        for own in 0..row.len() {
            let other = nearest[own];
            if nearest[other] != own {
                next.push(row[own].clone());
            } else if own < other {
                let text = format!("({} {})", row[own].2, row[other].2);
                next.push((row[own].0.union(&row[other].0), row[own].1, text));
            }
        }
        row = next;
        rounds += 1;
    }
    (row.remove(0).2, rounds)
}

fn text(bvh: &Bvh, index: usize) -> String {
    match bvh.children(index) {
        none if none.is_empty() => format!("{}", bvh.leaf_triangles(index)[0]),
        two => format!("({} {})", text(bvh, two.start), text(bvh, two.start + 1)),
    }
}

fn rounds(boxes: &[Aabb]) -> u64 {
    let mut work = Counters::default();
    build(boxes, &Ploc::default(), &mut work).unwrap();
    work.get(Work::Rounds)
}

#[test]
fn identical_boxes_merge_like_the_bits_of_their_numbers() {
    let boxes = vec![scene("gen:soup:1")[0]; 8];
    assert_eq!(text(&checked(&boxes, 8, 1), 0), "(((0 1) (2 3)) ((4 5) (6 7)))");
    assert_eq!(rounds(&boxes), 3);
    assert_eq!(rounds(&vec![boxes[0]; 100_000]), 17);
}

#[test]
fn leaves_are_those_of_the_refinement() {
    for name in ["gen:soup:3000", "gen:spheres:3000", "gen:coincident:1000", "gen:nested:1000", "thesis:small"] {
        let boxes = scene(name);
        let triangles = checked(&boxes, 8, 1);
        for max_leaf in [2, 4, 64] {
            assert_eq!(
                tree_hash(&checked(&boxes, 8, max_leaf)),
                tree_hash(&open_leaves(&triangles, max_leaf)),
                "{name}"
            );
        }
    }
}

/// Nested boxes let few merge in a round. Distances are counted, so that it shows when a round looks at the whole row.
#[test]
fn work_is_near_linear_where_few_merge() {
    for family in ["nested", "grid", "coincident", "stadium", "slivers"] {
        let pairs = |n: usize| {
            let mut work = Counters::default();
            build(&scene(&format!("gen:{family}:{n}")), &Ploc::default(), &mut work).unwrap();
            work.get(Work::PairDistances) as f64 / n as f64
        };
        let (small, large) = (pairs(2_000), pairs(32_000));
        assert!(large < 2.0 * small, "{family}: {small} {large}");
    }
}

#[test]
fn the_same_tree_and_work_at_every_level_and_on_any_number_of_threads() {
    for name in ["gen:spheres:60000", "gen:nested:20000"] {
        let boxes = scene(name);
        same_everywhere(|simd, work| build_at(&boxes, &Ploc::default(), simd, work));
    }
}

#[test]
fn parameters_out_of_range_are_errors() {
    let boxes = scene("gen:soup:9");
    for (radius, max_leaf) in [(0, 4), (MOST_RADIUS + 1, 4), (8, 0), (8, 65)] {
        assert!(matches!(build(&boxes, &Ploc { radius, max_leaf }, &mut ()), Err(BuildError::Parameter(_))));
    }
}

proptest! {
    /// Areas on a grid are whole numbers: f32 and f64 agree, and ties are everywhere.
    #[test]
    fn equals_the_rounds_of_the_paper(boxes in on_a_grid(2..=200), radius in 1usize..20) {
        let mut work = Counters::default();
        let bvh = build(&boxes, &Ploc { radius, max_leaf: 1 }, &mut work).unwrap();
        let (expected, rounds) = literal(&boxes, radius);
        prop_assert_eq!(text(&bvh, 0), expected);
        prop_assert_eq!(work.get(Work::Rounds), rounds);
    }

    #[test]
    fn any_boxes_make_a_valid_tree(boxes in any_boxes(1..=400), radius in 1usize..130, max_leaf in 1usize..9) {
        checked(&boxes, radius.min(MOST_RADIUS), max_leaf);
    }
}
