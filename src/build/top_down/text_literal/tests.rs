//! The engine against the specification written down word by word, its counts against the closed form.

use super::super::{Text, binomial};
use super::build;
use crate::build::testing::any_boxes;
use crate::build::{Brake, BuildError, ChildCost, Counters, MAX_LEAF, Work};
use crate::bvh::{Bvh, tree_hash};
use crate::geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;

enum Spec {
    Leaf(Vec<u32>),
    Inner(Vec<Spec>),
}

fn specified(boxes: &[Aabb], ids: Vec<u32>, p: &Text, combinations: &mut u64) -> Spec {
    if ids.len() <= MAX_LEAF {
        return Spec::Leaf(ids);
    }
    let union = |ids: &[u32]| Aabb::union_of(ids.iter().map(|&t| &boxes[t as usize]));
    let node = union(&ids);
    let cost = ChildCost::new(&node, p.arity);
    // Takes what is below plane q out of `left`, in exact arithmetic of the coordinates' differences.
    let take = |left: &mut Vec<u32>, q: usize| -> Vec<u32> {
        let (axis, i) = (q / p.planes, q % p.planes);
        let below = |t: &u32| {
            let offset = boxes[*t as usize].centre()[axis] - f64::from(node.min[axis]);
            offset * (p.planes + 1) as f64 * 1.0 < (i + 1) as f64 * node.extent()[axis]
        };
        let (taken, rest) = left.iter().partition(|t| below(t));
        *left = rest;
        taken
    };
    for r in (1..p.arity).rev() {
        let mut best: Option<(i64, Vec<Vec<u32>>)> = None;
        let mut choice: Vec<usize> = (0..r).collect();
        while choice.last().is_some_and(|&q| q < 3 * p.planes) {
            *combinations += 1;
            let mut left = ids.clone();
            let mut children: Vec<_> = choice.iter().map(|&q| take(&mut left, q)).collect();
            children.push(left);
            if children.iter().all(|c| !c.is_empty()) {
                let total = children.iter().map(|c| cost.term(&union(c), 1)).sum();
                if best.as_ref().is_none_or(|b| total < b.0) {
                    best = Some((total, children));
                }
            }
            // The next choice in lexicographic order.
            let limit = |k: usize| 3 * p.planes - r + k;
            match (0..r).rev().find(|&k| choice[k] < limit(k)) {
                Some(k) => {
                    choice[k] += 1;
                    (k + 1..r).for_each(|j| choice[j] = choice[j - 1] + 1);
                }
                None => break,
            }
        }
        if let Some((_, children)) = best {
            return Spec::Inner(children.into_iter().map(|c| specified(boxes, c, p, combinations)).collect());
        }
    }
    let (a, b) = ids.split_at(ids.len() / 2);
    Spec::Inner([a, b].map(|half| specified(boxes, half.to_vec(), p, combinations)).into())
}

fn same(spec: &Spec, bvh: &Bvh, index: usize) -> bool {
    match spec {
        Spec::Leaf(ids) => bvh.nodes[index].is_leaf() && bvh.leaf_triangles(index) == ids,
        Spec::Inner(children) => {
            children.len() == bvh.children(index).len()
                && children.iter().zip(bvh.children(index)).all(|(spec, child)| same(spec, bvh, child))
        }
    }
}

fn check(boxes: &[Aabb], p: &Text) {
    let mut counters = Counters::default();
    let bvh = build(boxes, p, &mut counters).unwrap();
    let mut combinations = 0;
    let spec = specified(boxes, (0..boxes.len() as u32).collect(), p, &mut combinations);
    assert!(same(&spec, &bvh, 0), "{p:?} {boxes:?}");
    assert_eq!(counters.get(Work::Combinations), combinations);
    assert_eq!(tree_hash(&bvh), tree_hash(&build(boxes, p, &mut ()).unwrap()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn binary_is_as_specified(boxes in any_boxes(1..=60)) {
        check(&boxes, &Text { arity: 2, planes: 20 });
    }

    #[test]
    fn quaternary_is_as_specified(boxes in any_boxes(1..=40)) {
        check(&boxes, &Text { arity: 4, planes: 6 });
    }

    #[test]
    fn octonary_is_as_specified(boxes in any_boxes(1..=24)) {
        check(&boxes, &Text { arity: 8, planes: 4 });
    }

    #[test]
    fn counts_equal_the_closed_form_where_nothing_falls_back(boxes in any_boxes(5..=60)) {
        let p = Text { arity: 2, planes: 30 };
        let mut counters = Counters::default();
        let bvh = build(&boxes, &p, &mut counters).unwrap();
        let inner = bvh.nodes.iter().filter(|n| !n.is_leaf()).count() as u64;
        prop_assert_eq!(counters.get(Work::Combinations), inner * p.combinations(1));
    }
}

#[test]
fn closed_form_counts_every_failed_number_of_planes() {
    let p = Text { arity: 4, planes: 5 };
    assert_eq!(p.combinations(3), binomial(15, 3));
    assert_eq!(p.combinations(1), binomial(15, 3) + binomial(15, 2) + 15);
    // Coincident boxes: nothing separates them, so every node tries 3, 2 and 1 planes and is halved.
    let boxes = [Aabb::new(Vec3::ZERO, Vec3::ONE); 9];
    let mut counters = Counters::default();
    let bvh = build(&boxes, &p, &mut counters).unwrap();
    let inner = bvh.nodes.iter().filter(|n| !n.is_leaf()).count() as u64;
    assert_eq!((inner, counters.get(Work::Fallbacks)), (2, 2));
    assert_eq!(counters.get(Work::Combinations), 2 * p.combinations(0));
    assert_eq!(bvh.leaf_triangles(bvh.children(0).start), [0, 1, 2, 3]);
}

#[test]
fn moving_and_doubling_the_scene_changes_no_split() {
    let boxes: Vec<Aabb> = (0..64)
        .map(|i| {
            let corner = Vec3::new((i % 4) as f32, (i / 4 % 4) as f32, (i / 16) as f32);
            Aabb::new(corner, corner + 0.5)
        })
        .collect();
    let p = Text { arity: 4, planes: 7 };
    let hash = |map: &dyn Fn(Vec3) -> Vec3| {
        let moved: Vec<_> = boxes.iter().map(|b| Aabb::new(map(b.min), map(b.max))).collect();
        tree_hash(&build(&moved, &p, &mut ()).unwrap())
    };
    let here = hash(&|v| v);
    assert_eq!(here, hash(&|v| v + 1e6));
    assert_eq!(here, hash(&|v| v * 1024.0));
}

#[test]
fn a_stopped_build_says_what_was_left() {
    let boxes: Vec<Aabb> = (0..500).map(|i| Aabb::new(Vec3::splat(i as f32), Vec3::splat(i as f32 + 1.0))).collect();
    let mut brake = Brake::new(Some(std::time::Instant::now()));
    let Err(BuildError::Stopped(left)) = build(&boxes, &Text::at_arity(8), &mut brake) else {
        panic!("a deadline in the past stops the build");
    };
    assert_eq!(left.pending, [500]);
}
