//! The order against a sort by codes made bit by bit, and levels against their definition.

use super::Order;
use crate::build::testing::any_boxes;
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::simd::Simd;
use glam::Vec3;
use proptest::prelude::*;

/// The code of every box, bit by bit: x, y and z of the highest bit first.
fn codes(boxes: &[Aabb]) -> Vec<u64> {
    let twice = |b: &Aabb| b.min.as_dvec3() + b.max.as_dvec3();
    let low = boxes.iter().map(twice).reduce(|a, b| a.min(b)).unwrap();
    let high = boxes.iter().map(twice).reduce(|a, b| a.max(b)).unwrap();
    let widest = (high - low).max_element();
    let scale = if widest > 0.0 { f64::from((1 << 21) - 1) / widest } else { 0.0 };
    let code = |b: &Aabb| {
        let cells = ((twice(b) - low) * scale).to_array().map(|x| x.round_ties_even() as u64);
        (0..63).fold(0, |code, bit| code << 1 | (cells[bit % 3] >> (20 - bit / 3) & 1))
    };
    boxes.iter().map(code).collect()
}

fn check(boxes: &[Aabb]) {
    let codes = codes(boxes);
    let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
    ids.sort_by_key(|&id| (codes[id as usize], id));
    for simd in Simd::available() {
        let order = Order::new(boxes, simd).unwrap();
        assert_eq!(order.ids, ids);
        assert_eq!(order.around, Aabb::union_of(boxes));
        for (pair, &level) in ids.windows(2).zip(&order.levels) {
            let [a, b] = [pair[0], pair[1]].map(|id| codes[id as usize]);
            if a == b {
                assert!(level >= 64, "equal codes part last: {level}");
            } else {
                // The code stands in the upper 63 of 64 bits.
                assert_eq!(u32::from(level), (a << 1 ^ b << 1).leading_zeros());
            }
        }
    }
}

#[test]
fn corners_of_a_cube_in_the_order_of_their_bits() {
    let corners = (0..8u8).map(|i| Vec3::new((i >> 2).into(), (i >> 1 & 1).into(), (i & 1).into()));
    let boxes: Vec<Aabb> = corners.rev().map(|p| Aabb::new(p, p)).collect();
    assert_eq!(Order::new(&boxes, Simd::detect()).unwrap().ids, [7, 6, 5, 4, 3, 2, 1, 0]);
    check(&boxes);
}

#[test]
fn large_scenes_and_many_equal_codes() {
    for scene in ["gen:soup:50000", "gen:coincident:5000", "gen:stadium:40000", "gen:terrain:20000"] {
        check(&Scene::load(scene).unwrap().boxes());
    }
}

/// Equal codes are halved: a stretch of m has its least level between the first m / 2 and the rest, and nowhere else.
#[test]
fn equal_codes_are_halved() {
    fn halved(levels: &[u8], least: u8) {
        if !levels.is_empty() {
            let middle = levels.len().div_ceil(2) - 1;
            assert_eq!(levels[middle], least, "{levels:?}");
            halved(&levels[..middle], least + 1);
            halved(&levels[middle + 1..], least + 1);
        }
    }
    for n in 1..40 {
        let boxes = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); n];
        halved(&Order::new(&boxes, Simd::detect()).unwrap().levels, 64);
    }
}

proptest! {
    #[test]
    fn the_order_is_that_of_the_codes(boxes in any_boxes(1..=80)) {
        check(&boxes);
    }
}
