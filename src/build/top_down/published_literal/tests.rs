//! The engine against the specification written down word by word, its counts against the closed form.

use super::super::{Costs, Published};
use super::{build, build_by};
use crate::build::testing::{any_boxes, choices, inner_sizes, six_in_a_row};
use crate::build::{Brake, BuildError, ChildCost, Counters, Work};
use crate::bvh::{Bvh, Limits, tree_hash, validate};
use crate::geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;

/// The tree as the specification's recursion describes it: each node's box, as taken when its turn came, and content.
struct Spec(Aabb, Content);

enum Content {
    Leaf { start: usize, n: usize },
    Inner(Vec<Spec>),
}

/// `build(start, n)` of the specification, every combination uniting all boxes again.
fn specified(boxes: &[Aabb], order: &mut [u32], start: usize, n: usize, p: &Published, costs: Costs) -> Spec {
    let union = |slots: &[u32]| Aabb::union_of(slots.iter().map(|&t| &boxes[t as usize]));
    let node = union(&order[start..start + n]);
    if n <= 4 {
        return Spec(node, Content::Leaf { start, n });
    }
    let sort = |order: &mut [u32], axis: usize| {
        order[start..start + n].sort_by(|&a, &b| {
            let key = |t: u32| boxes[t as usize].min[axis];
            key(a).total_cmp(&key(b)).then(a.cmp(&b))
        });
    };
    let mut d = p.candidates;
    while n / d == 0 {
        d /= 2;
    }
    let spaced = |stride: usize| (1..).map(|i| i * stride).take_while(|&c| c < n).collect();
    let mut candidates: Vec<usize> = spaced(n / d);
    if candidates.len() < p.arity - 1 {
        // Only with other numbers of candidates than the thesis', or when not even every rank is enough.
        candidates = spaced(1);
    }
    let mut best: Option<((i64, f32), usize, Vec<usize>)> = None;
    for axis in 0..3 {
        sort(order, axis);
        for choice in choices(&candidates, p.arity - 1) {
            let children: Vec<_> = ranges(&choice, n)
                .into_iter()
                .map(|(from, to)| (union(&order[start + from..start + to]), to - from))
                .collect();
            let total = match costs {
                Costs::Exact => (exact_cost(&node, &children), 0.0),
                Costs::Single => (0, single_cost(&node, &children)),
            };
            if best.as_ref().is_none_or(|b| total < b.0) {
                best = Some((total, axis, choice));
            }
        }
    }
    let own_box = |order: &[u32], slot: usize| boxes[order[slot] as usize];
    let children = match best {
        Some((_, axis, choice)) => {
            sort(order, axis);
            let children = ranges(&choice, n);
            children.into_iter().map(|(a, b)| specified(boxes, order, start + a, b - a, p, costs)).collect()
        }
        None if !p.q8 || start == 0 => {
            (start..start + n).map(|slot| Spec(own_box(order, slot), Content::Leaf { start: slot, n: 1 })).collect()
        }
        None => {
            let empty = |slot| Spec(own_box(order, slot), Content::Leaf { start, n: 0 });
            let mut children = vec![empty(start)];
            children.extend((0..6).map(|_| empty(start - 1)));
            children.push(specified(boxes, order, start - 1, n + 1, p, costs));
            children
        }
    };
    Spec(node, Content::Inner(children))
}

/// The cost of children with so many triangles each, as integers.
fn exact_cost(node: &Aabb, children: &[(Aabb, usize)]) -> i64 {
    let n = children.iter().map(|c| c.1).sum();
    children.iter().map(|(aabb, n_child)| ChildCost::new(node, n).term(aabb, n_child - 1)).sum()
}

/// The cost as the thesis' program added it up, written out.
fn single_cost(node: &Aabb, children: &[(Aabb, usize)]) -> f32 {
    let area = |b: &Aabb| -> f32 {
        let (x, y, z) = (b.max.x - b.min.x, b.max.y - b.min.y, b.max.z - b.min.z);
        2.0 * (x * y + y * z + z * x)
    };
    let mut sum: f32 = 0.125;
    for (aabb, n_child) in children {
        let share: f32 = if area(node) == 0.0 || !area(node).is_finite() { 0.0 } else { area(aabb) / area(node) };
        sum += share * (n_child - 1) as f32;
    }
    sum
}

fn ranges(splits: &[usize], n: usize) -> Vec<(usize, usize)> {
    let starts = [0].into_iter().chain(splits.iter().copied());
    starts.zip(splits.iter().copied().chain([n])).collect()
}

fn same(spec: &Spec, order: &[u32], bvh: &Bvh, index: usize) -> bool {
    let Spec(aabb, content) = spec;
    let content_is_same = match content {
        Content::Leaf { start, n } => {
            let sorted = |ids: &[u32]| {
                let mut ids = ids.to_vec();
                ids.sort();
                ids
            };
            bvh.nodes[index].is_leaf() && sorted(bvh.leaf_triangles(index)) == sorted(&order[*start..start + n])
        }
        Content::Inner(children) => {
            children.len() == bvh.children(index).len()
                && children.iter().zip(bvh.children(index)).all(|(spec, child)| same(spec, order, bvh, child))
        }
    };
    bvh.nodes[index].aabb == *aabb && content_is_same
}

fn check(boxes: &[Aabb], p: &Published) {
    for costs in Costs::ALL {
        let bvh = build_by(boxes, p, costs, &mut ()).unwrap();
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let spec = specified(boxes, &mut order, 0, boxes.len(), p, costs);
        assert!(same(&spec, &order, &bvh, 0), "{costs:?} {p:?} {boxes:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn binary_is_as_specified(boxes in any_boxes(1..=150)) {
        check(&boxes, &Published::at_arity(2));
    }

    #[test]
    fn quaternary_is_as_specified(boxes in any_boxes(1..=40)) {
        check(&boxes, &Published::at_arity(4));
    }

    #[test]
    fn octonary_is_as_specified_with_and_without_q8(boxes in any_boxes(1..=16)) {
        check(&boxes, &Published::at_arity(8));
        check(&boxes, &Published { q8: false, ..Published::at_arity(8) });
    }

    #[test]
    fn octonary_with_few_candidates_and_overlapping_q8_nodes(boxes in any_boxes(17..=120)) {
        check(&boxes, &Published { arity: 8, candidates: 9, q8: true });
    }

    #[test]
    fn counts_equal_the_closed_form(boxes in any_boxes(5..=60), few in 4usize..9) {
        for p in [
            Published { arity: 2, candidates: few, q8: true },
            Published { arity: 4, candidates: few, q8: true },
            Published { arity: 8, candidates: few + 4, q8: false },
        ] {
            let mut counters = Counters::default();
            let bvh = build(&boxes, &p, &mut counters).unwrap();
            let sizes = inner_sizes(&bvh);
            let combinations: u64 = sizes.iter().map(|&n| p.combinations(n)).sum();
            prop_assert_eq!(counters.get(Work::Combinations), combinations);
            let unions: u64 = sizes.iter().map(|&n| p.combinations(n) * n as u64).sum();
            prop_assert_eq!(counters.get(Work::OriginalUnions), unions);
            prop_assert_eq!(tree_hash(&bvh), tree_hash(&build(&boxes, &p, &mut ()).unwrap()));
        }
    }
}

/// A row of unit cubes; cube i spans i … i + 1 on x.
fn row(n: usize) -> Vec<Aabb> {
    (0..n).map(|i| Aabb::new(Vec3::new(i as f32, 0.0, 0.0), Vec3::new(i as f32 + 1.0, 1.0, 1.0))).collect()
}

#[test]
fn rule_q8_at_the_start_makes_leaves_of_one_and_is_counted() {
    for n in 5..=7 {
        let mut counters = Counters::default();
        let bvh = build(&row(n), &Published::at_arity(8), &mut counters).unwrap();
        assert_eq!(bvh.children(0).len(), n);
        assert!(bvh.children(0).all(|c| bvh.leaf_triangles(c).len() == 1));
        assert_eq!((counters.get(Work::Q8AtStart), counters.get(Work::Q8Nodes)), (1, 0));
    }
}

#[test]
fn rule_q8_reaches_back_into_its_left_neighbour() {
    let boxes = crate::scene::Scene::load("gen:soup:70").unwrap().boxes();
    let p = Published { arity: 8, candidates: 9, q8: true };
    let mut counters = Counters::default();
    let bvh = build(&boxes, &p, &mut counters).unwrap();
    let q8 = counters.get(Work::Q8Nodes);
    assert!(q8 > 0, "a scene without such a node tests nothing");
    let empty = bvh.nodes.iter().filter(|n| n.is_leaf() && n.count() == 0).count();
    assert_eq!(empty as u64, 7 * q8);
    let coverage = validate(&bvh, &boxes, &Limits { max_leaf: 4, q8: true, ..Limits::default() }).unwrap();
    assert!(coverage.duplicated > 0);
    assert_eq!(coverage.q8_nodes as u64, q8);
    check(&boxes, &p);
}

#[test]
fn a_stopped_build_says_what_was_left() {
    let mut brake = Brake::new(Some(std::time::Instant::now()));
    let boxes = row(3000);
    let Err(BuildError::Stopped(unfinished)) = build(&boxes, &Published::at_arity(4), &mut brake) else {
        panic!("a deadline in the past stops the build");
    };
    let left: usize = unfinished.pending.iter().sum();
    assert!(left > 0 && left <= boxes.len());
    assert!(brake.steps() > 0);
}

#[test]
fn bad_parameters_and_boxes_are_refused() {
    let refused = |arity, candidates| build(&row(9), &Published { arity, candidates, q8: true }, &mut ()).is_err();
    assert!(refused(1, 100) && refused(9, 100) && refused(4, 3));
    assert_eq!(build(&[], &Published::at_arity(2), &mut ()), Err(BuildError::NoTriangles));
    let nan = [Aabb::new(Vec3::NAN, Vec3::ONE)];
    assert_eq!(build(&nan, &Published::at_arity(2), &mut ()), Err(BuildError::InvalidBox(0)));
}

#[test]
fn f32_sums_turn_decisions_round() {
    let p = Published { arity: 2, candidates: 3, q8: true };
    let sizes = |boxes: &[Aabb], costs| -> Vec<usize> {
        let bvh = build_by(boxes, &p, costs, &mut ()).unwrap();
        bvh.children(0).map(|c| bvh.leaf_triangles(c).len()).collect()
    };
    // Equal boxes, an exact tie: the first wins. In f32 (0.125 + a) + b is above (0.125 + b) + a.
    let equal = six_in_a_row(12.75, 0);
    assert_eq!((sizes(&equal, Costs::Exact), sizes(&equal, Costs::Single)), (vec![2, 4], vec![4, 2]));
    // Lower boxes at the end: the second choice is better by 4e-9, which f32 cannot tell: the first wins.
    let lower = six_in_a_row(3.0, 1);
    assert_eq!((sizes(&lower, Costs::Exact), sizes(&lower, Costs::Single)), (vec![4, 2], vec![2, 4]));
}

#[test]
fn nodes_whose_areas_overflow_f32_are_split_at_the_first_choice() {
    let boxes: Vec<_> = row(9).iter().map(|b| Aabb::new(b.min * 3e37, b.max * 3e37)).collect();
    let bvh = build_by(&boxes, &Published::at_arity(2), Costs::Single, &mut ()).unwrap();
    let first: Vec<usize> = bvh.children(0).map(|c| if bvh.nodes[c].is_leaf() { 1 } else { 8 }).collect();
    assert_eq!(first, [1, 8]);
    check(&boxes, &Published::at_arity(2));
    check(&boxes, &Published::at_arity(4));
}
