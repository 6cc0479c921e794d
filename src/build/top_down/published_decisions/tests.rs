//! Both searches against the literal engine, the counts against a second account of every node.

use super::{Decisions, SAME, build_single, compare};
use crate::build::testing::{any_boxes, choices, six_in_a_row};
use crate::build::top_down::{Costs, Published, published_literal};
use crate::build::{Brake, BuildError, ChildCost, Counters, Work};
use crate::bvh::tree_hash;
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use proptest::prelude::*;

/// Both trees are the literal engine's.
fn check(boxes: &[Aabb], p: &Published) -> Decisions {
    let literal = |costs| tree_hash(&published_literal::build_by(boxes, p, costs, &mut ()).unwrap());
    let (exact, decisions) = compare(boxes, p, &mut ()).unwrap();
    assert_eq!(tree_hash(&exact), literal(Costs::Exact), "{p:?} {boxes:?}");
    assert_eq!(tree_hash(&build_single(boxes, p, &mut ()).unwrap()), literal(Costs::Single), "{p:?} {boxes:?}");
    let Decisions { compared, different, rounded_ties, same_cost, largest_excess } = decisions;
    assert!(rounded_ties <= different && same_cost <= different && different <= compared);
    assert_eq!(largest_excess > SAME, same_cost < different, "an excess is where the costs differ");
    if different == 0 {
        assert_eq!(literal(Costs::Exact), literal(Costs::Single));
    }
    decisions
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn trees_are_those_of_the_literal_engine(boxes in any_boxes(1..=120), few in 4usize..9) {
        for p in [
            Published::at_arity(2),
            Published { candidates: few, ..Published::at_arity(2) },
            Published { candidates: few, ..Published::at_arity(4) },
            Published { candidates: few + 4, ..Published::at_arity(8) },
            Published { candidates: few + 4, q8: false, ..Published::at_arity(8) },
        ] {
            check(&boxes, &p);
        }
    }

    #[test]
    fn trees_of_few_triangles_with_all_candidates(boxes in any_boxes(5..=30)) {
        for arity in [2, 4, 8] {
            check(&boxes[..boxes.len().min(if arity == 8 { 16 } else { 30 })], &Published::at_arity(arity));
        }
    }

    #[test]
    fn scaled_scenes_of_many_magnitudes(boxes in any_boxes(5..=60), power in -90i32..120) {
        // Areas underflow and overflow f32 at the ends.
        let scale = 2.0f32.powi(power);
        let scaled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
        for p in [Published::at_arity(2), Published { candidates: 9, ..Published::at_arity(4) }] {
            check(&scaled, &p);
        }
    }
}

#[test]
fn trees_of_every_family_and_of_the_smallest_scene() {
    let mut different = 0;
    let names = FAMILIES.iter().flat_map(|f| [40, 300].map(|n| format!("gen:{}:{n}", f.name)));
    for name in names.chain(["thesis:tiny".into(), "thesis:small".into()]) {
        let boxes = Scene::load(&name).unwrap().boxes();
        for p in [
            Published::at_arity(2),
            Published { candidates: 20, ..Published::at_arity(4) },
            Published { candidates: 9, ..Published::at_arity(8) },
        ] {
            different += check(&boxes, &p).different;
        }
    }
    assert!(different > 50, "{different}: scenes on which both agree test nothing");
}

#[test]
fn hand_made_nodes_of_each_kind() {
    let decide = |pitch, steps_lower| {
        let p = Published { arity: 2, candidates: 3, q8: true };
        let d = check(&six_in_a_row(pitch, steps_lower), &p);
        assert_eq!(d.compared, 1);
        (d.different, d.rounded_ties, d.reversals(), d.same_cost, d.largest_excess)
    };
    assert_eq!(decide(3.0, 0), (0, 0, 0, 0, 0.0));
    // An exact tie that f32 breaks towards the second choice.
    assert_eq!(decide(12.75, 0), (1, 0, 1, 1, 0.0));
    // A better second choice that f32 cannot tell from the first.
    let (different, ties, reversals, same_cost, excess) = decide(3.0, 1);
    assert_eq!((different, ties, reversals, same_cost), (1, 1, 0, 0));
    assert!((excess / (9.03100669e-9 / 2.306818172787175) - 1.0).abs() < 1e-6, "{excess:e}");
    // A better second choice that f32 holds for worse.
    let (different, ties, reversals, same_cost, excess) = decide(5.0, 1);
    assert_eq!((different, ties, reversals, same_cost), (1, 0, 1, 0));
    assert!(excess > 1e-9 && excess < 1e-8, "{excess:e}");
}

/// A second account of every node, from enumerations with sums written out.
#[derive(Default)]
struct Account {
    compared: usize,
    different: usize,
    rounded_ties: usize,
    largest_excess: f64,
}

impl Account {
    /// Takes all nodes below `ids` at arity 2, 4 or 8 without rule Q8, as the exact choice divides them.
    fn take(&mut self, boxes: &[Aabb], ids: &mut [u32], p: &Published) {
        let n = ids.len();
        if n <= 4 || p.combinations(n) == 0 {
            return;
        }
        let union = |ids: &[u32]| Aabb::union_of(ids.iter().map(|&t| &boxes[t as usize]));
        let node = union(ids);
        let mut all = Vec::new();
        for axis in 0..3 {
            ids.sort_by(|&a, &b| {
                let key = |t: u32| boxes[t as usize].min[axis];
                key(a).total_cmp(&key(b)).then(a.cmp(&b))
            });
            let stride = p.stride(n);
            let candidates: Vec<_> = (1..=p.positions(n)).map(|s| s * stride).collect();
            for splits in choices(&candidates, p.arity - 1) {
                let ends: Vec<_> = [0].into_iter().chain(splits).chain([n]).collect();
                let children = ends.windows(2).map(|w| (union(&ids[w[0]..w[1]]), w[1] - w[0] - 1));
                let (mut exact, mut single) = (0i64, 0.125f32);
                for (child, weight) in children {
                    exact += ChildCost::new(&node, n).term(&child, weight);
                    let e = (child.max - child.min).to_array();
                    let area = 2.0 * (e[0] * e[1] + e[1] * e[2] + e[2] * e[0]);
                    let e = (node.max - node.min).to_array();
                    let whole = 2.0 * (e[0] * e[1] + e[1] * e[2] + e[2] * e[0]);
                    if whole > 0.0 {
                        single += area / whole * weight as f32;
                    }
                }
                all.push((axis, ends, exact, single));
            }
        }
        let least = all.iter().map(|c| c.2).min().unwrap();
        let exact = all.iter().position(|c| c.2 == least).unwrap();
        let rounded = all.iter().map(|c| c.3).fold(f32::INFINITY, f32::min);
        let single = all.iter().position(|c| c.3 == rounded).unwrap();
        self.compared += 1;
        if exact != single {
            self.different += 1;
            self.rounded_ties += usize::from(all[exact].3 == rounded);
            let unit = ChildCost::new(&node, n).term(&node, 1);
            self.largest_excess = self.largest_excess.max((all[single].2 - least) as f64 / (least + unit / 8) as f64);
        }
        let (axis, ends, ..) = all.swap_remove(exact);
        ids.sort_by(|&a, &b| {
            let key = |t: u32| boxes[t as usize].min[axis];
            key(a).total_cmp(&key(b)).then(a.cmp(&b))
        });
        for w in ends.windows(2) {
            self.take(boxes, &mut ids[w[0]..w[1]], p);
        }
    }
}

#[test]
fn the_counts_are_those_of_a_second_account() {
    let mut different = 0;
    for (name, arity, candidates) in [
        ("thesis:tiny", 2, 100),
        ("thesis:tiny", 4, 20),
        ("gen:spheres:200", 2, 100),
        ("gen:spheres:200", 4, 16),
        ("gen:grid:150", 4, 16),
        ("gen:soup:120", 8, 10),
        ("gen:spheres:120", 8, 10),
    ] {
        let boxes = Scene::load(name).unwrap().boxes();
        let p = Published { arity, candidates, q8: false };
        let (_, decisions) = compare(&boxes, &p, &mut ()).unwrap();
        let mut account = Account::default();
        account.take(&boxes, &mut (0..boxes.len() as u32).collect::<Vec<_>>(), &p);
        let Decisions { compared, rounded_ties, largest_excess, .. } = decisions;
        assert_eq!(
            (compared, decisions.different, rounded_ties),
            (account.compared, account.different, account.rounded_ties),
            "{name} {arity}"
        );
        let error = (largest_excess - account.largest_excess).abs();
        assert!(error < 1e-12, "{name} {arity}: {largest_excess:e} {:e}", account.largest_excess);
        different += compared.min(decisions.different);
    }
    assert!(different > 20, "{different}");
}

#[test]
fn work_is_counted_and_a_budget_stops_it() {
    let boxes = Scene::load("gen:soup:3000").unwrap().boxes();
    let p = Published::at_arity(4);
    let mut counters = Counters::default();
    let (bvh, _) = compare(&boxes, &p, &mut counters).unwrap();
    assert_eq!(tree_hash(&bvh), tree_hash(&compare(&boxes, &p, &mut ()).unwrap().0));
    assert!(counters.get(Work::DpSteps) > 0 && counters.get(Work::BoxUnions) > 0);
    let mut alone = Counters::default();
    build_single(&boxes, &p, &mut alone).unwrap();
    // Two arithmetics have two terms a run, and nearly the same nodes.
    let ratio = counters.get(Work::ChildCosts) as f64 / alone.get(Work::ChildCosts) as f64;
    assert!((1.9..2.1).contains(&ratio), "{ratio}");
    for result in [
        compare(&boxes, &p, &mut Brake::new(Some(std::time::Instant::now()))).map(|_| ()),
        build_single(&boxes, &p, &mut Brake::new(Some(std::time::Instant::now()))).map(|_| ()),
    ] {
        let Err(BuildError::Stopped(left)) = result else { panic!("a deadline in the past stops the build") };
        assert!((1..=boxes.len()).contains(&left.pending.iter().sum()));
    }
}
