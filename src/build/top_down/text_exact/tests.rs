//! The engine against the literal one, where ties are everywhere.

use super::super::{Text, text_literal};
use super::build;
use crate::build::testing::any_boxes;
use crate::build::{Counters, Work};
use crate::bvh::tree_hash;
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use proptest::prelude::*;

fn check(boxes: &[Aabb], p: &Text) {
    let (mut work, mut literal_work) = (Counters::default(), Counters::default());
    let exact = build(boxes, p, &mut work).unwrap();
    let literal = text_literal::build(boxes, p, &mut literal_work).unwrap();
    assert_eq!(tree_hash(&exact), tree_hash(&literal), "{p:?} {boxes:?}");
    assert_eq!(exact, literal);
    assert_eq!(work.get(Work::Fallbacks), literal_work.get(Work::Fallbacks));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn few_planes_of_every_arity(boxes in any_boxes(1..=60), arity in 2usize..=8, planes in 1usize..=4) {
        check(&boxes, &Text { arity, planes });
    }

    #[test]
    fn binary(boxes in any_boxes(1..=80), planes in 1usize..=100) {
        check(&boxes, &Text { arity: 2, planes });
    }

    #[test]
    fn quaternary(boxes in any_boxes(1..=50), planes in 1usize..=14) {
        check(&boxes, &Text { arity: 4, planes });
    }
}

#[test]
fn every_family() {
    for family in FAMILIES {
        for n in [5, 9, 33, 120, 300] {
            let boxes = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap().boxes();
            for (arity, planes) in [(2, 100), (4, 12), (8, 4)] {
                check(&boxes, &Text { arity, planes });
            }
        }
    }
}
