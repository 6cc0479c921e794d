//! The tree against its definition: parted where the least level is.

use super::*;
use crate::build::testing::{any_boxes, same_everywhere};
use crate::bvh::{Limits, tree_hash, validate};
use crate::refine::open_leaves;
use crate::scene::Scene;
use proptest::prelude::*;

fn scene(name: &str) -> Vec<Aabb> {
    Scene::load(name).unwrap().boxes()
}

fn checked(boxes: &[Aabb], max_leaf: usize) -> Bvh {
    let bvh = build(boxes, &Lbvh { max_leaf }, &mut ()).unwrap();
    validate(&bvh, boxes, &Limits { max_leaf, ..Limits::default() }).unwrap();
    bvh
}

/// By definition: parted where the least level is.
fn literal(order: &Order, places: Range<usize>) -> String {
    if places.len() == 1 {
        return format!("{}", order.ids[places.start]);
    }
    let levels = &order.levels[places.start..places.end - 1];
    let middle = places.start + 1 + (0..levels.len()).min_by_key(|&at| levels[at]).unwrap();
    format!("({} {})", literal(order, places.start..middle), literal(order, middle..places.end))
}

fn text(bvh: &Bvh, index: usize) -> String {
    match bvh.children(index) {
        none if none.is_empty() => format!("{}", bvh.leaf_triangles(index)[0]),
        two => format!("({} {})", text(bvh, two.start), text(bvh, two.start + 1)),
    }
}

fn check(boxes: &[Aabb]) {
    let order = Order::new(boxes, Simd::detect()).unwrap();
    let triangles = checked(boxes, 1);
    assert_eq!(text(&triangles, 0), literal(&order, 0..boxes.len()));
    for max_leaf in [2, 4, 64] {
        assert_eq!(tree_hash(&checked(boxes, max_leaf)), tree_hash(&open_leaves(&triangles, max_leaf)), "{max_leaf}");
    }
    // Small parts join as one does.
    for part in [1, 100] {
        let bvh = build_with(boxes, &Lbvh::default(), Simd::detect(), part, &mut ()).unwrap();
        assert_eq!(tree_hash(&bvh), tree_hash(&checked(boxes, MAX_LEAF)));
    }
}

#[test]
fn scenes_part_where_the_definition_says() {
    for name in ["gen:soup:3000", "gen:coincident:3000", "gen:nested:1000", "gen:stadium:3000", "thesis:small"] {
        check(&scene(name));
    }
}

#[test]
fn the_same_tree_and_work_at_every_level_and_on_any_number_of_threads() {
    let boxes = scene("gen:spheres:60000");
    let (_, work) = same_everywhere(|simd, work| build_with(&boxes, &Lbvh::default(), simd, PART, work));
    assert_eq!(work.get(Work::Merges), 59_999);
}

proptest! {
    #[test]
    fn any_boxes_part_where_the_definition_says(boxes in any_boxes(1..=300)) {
        check(&boxes);
    }
}
