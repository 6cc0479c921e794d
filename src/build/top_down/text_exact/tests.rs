//! The engine against the literal one, where ties are everywhere.

use super::super::{Text, text_literal};
use super::build;
use crate::build::testing::any_boxes;
use crate::build::{Brake, BuildError, Counters, Probe, Work};
use crate::bvh::tree_hash;
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use glam::Vec3;
use proptest::prelude::*;

fn check(boxes: &[Aabb], p: &Text) {
    let (mut work, mut literal_work) = (Counters::default(), Counters::default());
    let exact = build(boxes, p, &mut work).unwrap();
    let literal = text_literal::build(boxes, p, &mut literal_work).unwrap();
    assert_eq!(tree_hash(&exact), tree_hash(&literal), "{p:?} {boxes:?}");
    assert_eq!(exact, literal, "{p:?}");
    assert_eq!(work.get(Work::Fallbacks), literal_work.get(Work::Fallbacks), "{p:?}");
    assert_eq!(exact, build(boxes, p, &mut ()).unwrap());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn few_planes_of_every_arity(boxes in any_boxes(1..=60), arity in 2usize..=8, planes in 1usize..=4) {
        check(&boxes, &Text { arity, planes });
    }

    #[test]
    fn binary(boxes in any_boxes(1..=80), planes in 1usize..=255) {
        check(&boxes, &Text { arity: 2, planes });
    }

    #[test]
    fn quaternary(boxes in any_boxes(1..=60), planes in 1usize..=20) {
        check(&boxes, &Text { arity: 4, planes });
    }
}

/// Points on a grid and a few boxes: many children cost nothing, so many choices cost the same.
fn mostly_points() -> impl Strategy<Value = Vec<Aabb>> {
    let corner = (0u8..5, 0u8..5, 0u8..6).prop_map(|(x, y, z)| Vec3::new(x.into(), y.into(), z.into()));
    let size = prop_oneof![4 => Just(0.0f32), 1 => Just(2.0)];
    let aabb = (corner, size).prop_map(|(corner, size)| Aabb::new(corner, corner + size));
    proptest::collection::vec(aabb, 5..=16)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn children_without_area(boxes in mostly_points(), arity in 3usize..=6) {
        check(&boxes, &Text { arity, planes: 5 });
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn octonary(boxes in any_boxes(5..=40), planes in 3usize..=6) {
        check(&boxes, &Text { arity: 8, planes });
    }
}

#[test]
fn every_family() {
    for family in FAMILIES {
        for n in [5, 9, 33, 120, 500] {
            let boxes = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap().boxes();
            for (arity, planes) in [(2, 100), (3, 20), (4, 12), (5, 6), (8, 4)] {
                check(&boxes, &Text { arity, planes });
            }
        }
    }
}

#[test]
fn thesis_scenes() {
    for (scene, arity, planes) in
        [("tiny", 2, 100), ("med", 2, 100), ("large", 2, 100), ("tiny", 4, 50), ("med", 4, 8), ("tiny", 8, 6)]
    {
        check(&Scene::load(&format!("thesis:{scene}")).unwrap().boxes(), &Text { arity, planes });
    }
}

/// What the literal engine built with all the thesis' planes, in hours where there are eight children.
#[test]
fn thesis_scenes_with_all_planes() {
    for (scene, arity, hash) in
        [("tiny", 4, "50c5230e"), ("med", 4, "1558198e"), ("large", 4, "509f12a1"), ("tiny", 8, "49856e6c")]
    {
        let boxes = Scene::load(&format!("thesis:{scene}")).unwrap().boxes();
        let bvh = build(&boxes, &Text::at_arity(arity), &mut ()).unwrap();
        assert!(tree_hash(&bvh).to_string().starts_with(hash), "{scene} {arity}");
    }
}

#[test]
fn of_equally_cheap_planes_the_first() {
    // Points at the corners of a cube, two each: every axis separates them equally well, and so do many planes.
    let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let boxes: Vec<Aabb> = (0..16).map(|i| Aabb::new(corner(i / 2), corner(i / 2))).collect();
    for arity in 2..=8 {
        check(&boxes, &Text { arity, planes: 3 });
    }
    // Reaching over the middle, so that planes far apart cut the same.
    let long: Vec<Aabb> = boxes.iter().map(|b| Aabb::new(b.min * 0.5, b.max + 1.0)).collect();
    for arity in 2..=8 {
        check(&long, &Text { arity, planes: 4 });
    }
}

#[test]
fn children_that_cost_nothing() {
    // Points on a line along each axis, alone and with a box at the end that gives the node an area.
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        let mut boxes: Vec<Aabb> = (0..12).map(|i| Aabb::new(axis * i as f32, axis * i as f32)).collect();
        for arity in 2..=8 {
            check(&boxes, &Text { arity, planes: 6 });
        }
        boxes.push(Aabb::new(axis * 12.0 - Vec3::ONE, axis * 12.0 + Vec3::ONE));
        for arity in 2..=8 {
            check(&boxes, &Text { arity, planes: 6 });
        }
    }
}

#[test]
fn coincident_boxes_are_halved_without_a_search() {
    let boxes = [Aabb::new(Vec3::ZERO, Vec3::ONE); 9];
    let mut counters = Counters::default();
    let bvh = build(&boxes, &Text::at_arity(8), &mut counters).unwrap();
    assert_eq!(bvh.leaf_triangles(bvh.children(0).start), [0, 1, 2, 3]);
    assert_eq!(counters.nonzero().collect::<Vec<_>>(), [("box_unions", 9 + 9 + 5), ("fallbacks", 2)]);
}

#[test]
fn counts_of_one_sweep() {
    // Five boxes in a row with the first plane the best: below it one box, above it the others.
    let row = [0.0, 6.0, 7.0, 8.0, 9.0].map(|x| Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 1.0, 1.0)));
    let mut counters = Counters::default();
    build(&row, &Text { arity: 2, planes: 9 }, &mut counters).unwrap();
    // Four planes separate something; all are swept from both sides but where the first finds end the sweep.
    assert!((4..=9).contains(&counters.get(Work::ChildCosts)), "{counters:?}");
    assert!((1..=4).contains(&counters.get(Work::DpSteps)), "{counters:?}");
    // The root's box, three axes' slabs, and the children's boxes; then the sweeps.
    let swept = counters.get(Work::BoxUnions) - 5 - 15 - 5;
    assert!((1..=8).contains(&swept), "{counters:?}");
}

#[test]
fn steps_stay_far_below_the_combinations() {
    let boxes = Scene::load("gen:soup:2000").unwrap().boxes();
    let p = Text::at_arity(8);
    let mut counters = Counters::default();
    let bvh = build(&boxes, &p, &mut counters).unwrap();
    let inner = bvh.nodes.iter().filter(|n| !n.is_leaf()).count() as u64;
    assert!(counters.get(Work::DpSteps) / inner < p.combinations(7) / 10_000, "{counters:?}");
    assert_eq!(counters.get(Work::Combinations), 0);
}

#[test]
fn parameters_out_of_range_are_refused_as_by_the_literal_engine() {
    let boxes = [Aabb::new(Vec3::ZERO, Vec3::ONE); 9];
    for (arity, planes) in [(1, 5), (9, 5), (2, 0), (2, 256), (0, 0)] {
        let p = Text { arity, planes };
        let refused = build(&boxes, &p, &mut ());
        assert!(refused.is_err());
        assert_eq!(refused, text_literal::build(&boxes, &p, &mut ()));
    }
    assert_eq!(build(&[], &Text::at_arity(2), &mut ()), Err(BuildError::NoTriangles));
}

/// Lets so many calls pass.
struct Calls(u64);

impl Probe for Calls {
    fn go_on(&mut self, _: u64) -> bool {
        self.0 = self.0.saturating_sub(1);
        self.0 > 0
    }
}

#[test]
fn a_stopped_build_says_what_was_left() {
    let boxes = Scene::load("gen:soup:3000").unwrap().boxes();
    for arity in [2, 4, 8] {
        let mut brake = Brake::new(Some(std::time::Instant::now()));
        let stopped = build(&boxes, &Text::at_arity(arity), &mut brake);
        assert!(matches!(stopped, Err(BuildError::Stopped(_))), "{arity}");
        let Err(BuildError::Stopped(left)) = build(&boxes, &Text::at_arity(arity), &mut Calls(1)) else {
            panic!("the first call stops the build");
        };
        assert_eq!(left.pending, [3000]);
        // Later calls stop it later, in the end beyond the root.
        let stopped_at = |calls| match build(&boxes, &Text::at_arity(arity), &mut Calls(calls)) {
            Err(BuildError::Stopped(left)) => left,
            other => panic!("{calls} calls end the build: {other:?}"),
        };
        let left = (2..1000).map(stopped_at).find(|left| left.pending.len() > 1).expect("a split root");
        assert!(left.pending.iter().sum::<usize>() <= 3000, "{arity} {left:?}");
    }
}
