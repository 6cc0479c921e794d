//! Against a scan of all pairs where every cluster is a candidate, and against exact clustering by cost where few are;
//! boxes that are all alike, nested or in one place; threads.

use super::*;
use crate::build::bottom_up::clusters::{Dead, clusters};
use crate::build::bottom_up::union_area;
use crate::build::testing::any_boxes;
use crate::build::{Brake, Counters};
use crate::bvh::testing::{boxes, soup};
use crate::bvh::{Limits, tree_hash, validate};
use crate::cost::{SahParams, sah};
use crate::refine::open_leaves;
use glam::Vec3;
use proptest::prelude::*;

const ONE: Limits = Limits { max_leaf: 1, q8: false, spatial: false };

fn build_with(boxes: &[Aabb], neighbours: usize) -> Bvh {
    let bvh = build(boxes, &AggloKd { neighbours }, &mut ()).unwrap();
    validate(&bvh, boxes, &ONE).unwrap();
    bvh
}

/// Every pair at every step by area alone; `None` where two pairs tie.
fn literal(boxes: &[Aabb]) -> Option<Bvh> {
    let mut live = clusters(boxes);
    let mut dead = Dead::default();
    while live.len() > 1 {
        let mut pairs: Vec<_> = (1..live.len()).flat_map(|j| (0..j).map(move |i| (i, j))).collect();
        let area = |&(i, j): &(usize, usize)| live[i].aabb.union(&live[j].aabb).surface_area();
        pairs.sort_by(|a, b| area(a).total_cmp(&area(b)));
        if pairs.len() > 1 && area(&pairs[0]) == area(&pairs[1]) {
            return None;
        }
        let second = live.remove(pairs[0].1);
        live[pairs[0].0] = live[pairs[0].0].clone().merge(second, &mut dead);
    }
    Some(live.remove(0).into_tree(&dead))
}

#[test]
fn with_everybody_a_candidate_it_is_the_scan_of_all_pairs() {
    let mut compared = 0;
    for seed in 0..60 {
        let boxes = boxes(&soup(seed, 2 + seed as usize / 2, 0.01));
        let Some(expected) = literal(&boxes) else { continue };
        let merges = {
            let mut live: Vec<Cluster> =
                (0u32..).zip(&boxes).map(|(id, &aabb)| Cluster { aabb, id, handle: id }).collect();
            let mut merges = Merges::new(boxes.len());
            while live.len() > 1 {
                let all = live.len() - 1;
                let lists = search(&mut live, all, &mut Effort::default(), &mut ()).unwrap();
                live = Phase::new(live, lists, all).halve(&mut merges, &mut Effort::default(), &mut ()).unwrap();
            }
            merges
        };
        assert_eq!(tree_hash(&merges.into_tree(&boxes, crate::build::MAX_LEAF)), tree_hash(&expected), "{seed}");
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
}

#[test]
fn few_candidates_cost_little() {
    for (seed, size) in [(1, 0.02), (2, 0.1), (3, 0.4)] {
        let boxes = boxes(&soup(seed, 4000, size));
        let cost = |bvh: &Bvh| sah(&open_leaves(bvh, 4), SahParams::default()).unwrap();
        let exact = cost(&union_area::build_with_leaves(&boxes, 1, &mut ()).unwrap());
        let few = cost(&build_with(&boxes, 8));
        assert!((few / exact - 1.0).abs() < 0.03, "{size}: {few} {exact}");
    }
}

/// Edges between the root and the deepest node.
fn depth(bvh: &Bvh) -> usize {
    crate::cost::stats(bvh).max_depth
}

#[test]
fn boxes_that_are_all_alike_merge_many_at_a_time() {
    let n = 20_000;
    let alike = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); n];
    assert!(depth(&build_with(&alike, 8)) < 40);
    let row: Vec<_> = (0..n).map(|i| Vec3::X * i as f32).map(|at| Aabb::new(at, at + Vec3::ONE)).collect();
    assert!(depth(&build_with(&row, 8)) < 40);
    let floor: Vec<_> = (0..n)
        .map(|i| Vec3::new((i % 141) as f32, 0.0, (i / 141) as f32))
        .map(|at| Aabb::new(at, at + Vec3::new(1.0, 0.0, 1.0)))
        .collect();
    assert!(depth(&build_with(&floor, 8)) < 40);
}

#[test]
fn growing_boxes_merge_one_by_one_in_linear_work() {
    // All around one centre, and each on the edge of the one before.
    for shift in [0.0, 1.0] {
        let size = |i: usize| 1.0005f32.powi(i as i32);
        let boxes: Vec<_> = (0..20_000)
            .map(|i| Aabb::new(Vec3::splat(-size(i)), Vec3::splat(size(i))))
            .map(|b| Aabb::new(b.min + b.max * shift, b.max + b.max * shift))
            .collect();
        let mut counters = Counters::default();
        let bvh = build(&boxes, &AggloKd::default(), &mut counters).unwrap();
        validate(&bvh, &boxes, &ONE).unwrap();
        assert!(counters.get(Work::PairDistances) < 200 * boxes.len() as u64, "{counters:?}");
        assert_eq!(counters.get(Work::Merges), boxes.len() as u64 - 1);
    }
}

#[test]
fn centres_that_only_rounding_makes_equal_share_a_point() {
    // Apart in y, but not beside such an x, once turned.
    let boxes: Vec<_> = (0..3000).map(|i| Vec3::new(1e30, i as f32, 0.0)).map(|p| Aabb::new(p, p)).collect();
    build_with(&boxes, 8);
    let huge: Vec<_> =
        crate::bvh::testing::boxes(&soup(4, 500, 0.2)).iter().map(|b| Aabb::new(b.min * 1e19, b.max * 1e19)).collect();
    build_with(&huge, 8);
}

#[test]
fn threads_change_no_tree() {
    let boxes = boxes(&soup(5, 30_000, 0.05));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        tree_hash(&pool.install(|| build_with(&boxes, 8)))
    };
    assert!(with(1) == with(2) && with(2) == with(5));
}

#[test]
fn stops_when_told_to_and_refuses_what_it_cannot_do() {
    let boxes = boxes(&soup(6, 5000, 0.05));
    struct Stop(u32);
    impl Probe for Stop {
        fn go_on(&mut self, _: u64) -> bool {
            self.0 = self.0.saturating_sub(1);
            self.0 > 0
        }
    }
    let pending = |after| match build(&boxes, &AggloKd::default(), &mut Stop(after)) {
        Err(BuildError::Stopped(Unfinished { pending })) => pending[0],
        other => panic!("{other:?}"),
    };
    assert_eq!(pending(1), 5000);
    assert!((1..4000).contains(&pending(6)));
    for neighbours in [0, MOST_NEIGHBOURS + 1] {
        let error = build(&boxes, &AggloKd { neighbours }, &mut Brake::default()).unwrap_err();
        assert!(matches!(error, BuildError::Parameter(_)));
    }
}

proptest! {
    #[test]
    fn any_boxes_make_a_valid_tree(boxes in any_boxes(1..=80), neighbours in 1usize..12) {
        let bvh = build_with(&boxes, neighbours);
        prop_assert_eq!(bvh.nodes.len(), 2 * boxes.len() - 1);
    }
}
