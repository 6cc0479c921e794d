//! Sweep SAH against brute force.

use super::*;
use crate::build::Counters;
use crate::build::testing::any_boxes;
use crate::bvh::{Limits, tree_hash, validate};
use crate::scene::Scene;
use proptest::prelude::*;

fn scene(name: &str) -> Vec<Aabb> {
    Scene::load(name).unwrap().boxes()
}

fn checked(boxes: &[Aabb], max_leaf: usize) -> Bvh {
    let bvh = build(boxes, &SweepSah { max_leaf }, &mut ()).unwrap();
    validate(&bvh, boxes, &Limits { max_leaf, ..Limits::default() }).unwrap();
    bvh
}

/// Every split of every axis, each node sorted anew and each side's box taken anew.
fn brute_force(boxes: &[Aabb], mut ids: Vec<u32>, max_leaf: usize) -> String {
    let centre = |id: u32, axis: usize| boxes[id as usize].centre()[axis];
    let area = |ids: &[u32]| Aabb::union_of(ids.iter().map(|&id| &boxes[id as usize])).surface_area();
    let n = ids.len();
    let mut best: Option<(f64, usize, Vec<u32>, usize)> = None;
    let mut consider = |ids: &[u32], i: usize| {
        let cost = area(&ids[..i]) * i as f64 + area(&ids[i..]) * (n - i) as f64;
        let uneven = i.abs_diff(n - i);
        if best.as_ref().is_none_or(|b| (cost, uneven) < (b.0, b.1)) {
            best = Some((cost, uneven, ids.to_vec(), i));
        }
    };
    let mut separable = false;
    for axis in 0..3 {
        ids.sort_by(|&a, &b| centre(a, axis).partial_cmp(&centre(b, axis)).unwrap().then(a.cmp(&b)));
        if centre(ids[0], axis) < centre(ids[n - 1], axis) {
            separable = true;
            (1..n).for_each(|i| consider(&ids, i));
        }
    }
    ids.sort_unstable();
    if n > 1 && !separable {
        consider(&ids, n / 2);
    }
    match best {
        Some((cost, _, order, i)) if n > max_leaf || area(&ids) * n as f64 > area(&ids) + cost => {
            let sides = [&order[..i], &order[i..]].map(|side| brute_force(boxes, side.to_vec(), max_leaf));
            format!("({}{})", sides[0], sides[1])
        }
        _ => format!("{ids:?}"),
    }
}

fn text(bvh: &Bvh, index: usize) -> String {
    if bvh.nodes[index].is_leaf() {
        let mut ids = bvh.leaf_triangles(index).to_vec();
        ids.sort_unstable();
        return format!("{ids:?}");
    }
    let below: String = bvh.children(index).map(|child| text(bvh, child)).collect();
    format!("({below})")
}

proptest! {
    #[test]
    fn the_cheapest_of_all_splits_at_every_node(boxes in any_boxes(1..=40), max_leaf in 1usize..7) {
        let all = (0..boxes.len() as u32).collect();
        prop_assert_eq!(text(&checked(&boxes, max_leaf), 0), brute_force(&boxes, all, max_leaf));
    }
}

#[test]
fn the_same_tree_and_work_on_any_number_of_threads() {
    for name in ["gen:spheres:40000", "gen:coincident:40000"] {
        let boxes = scene(name);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut counters = Counters::default();
                (build(&boxes, &SweepSah::default(), &mut counters).unwrap(), counters)
            })
        };
        let one = on(1);
        assert!(one == on(2) && one == on(7), "{name}");
        assert!(one.1.get(Work::SplitCosts) >= 10_000);
    }
}

#[test]
fn extremes_build_fast_and_at_any_scale() {
    for name in ["gen:coincident:100000", "gen:nested:100000", "gen:grid:20000"] {
        let boxes = scene(name);
        let hash = tree_hash(&checked(&boxes, MAX_LEAF));
        for scale in [1e19f32, 2f32.powi(40)] {
            let scaled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
            if scaled.iter().all(Aabb::is_valid) {
                let other = tree_hash(&checked(&scaled, MAX_LEAF));
                assert!(scale == 1e19 || other == hash, "{name} {scale}");
            }
        }
    }
    // Along a line no box has an area: all splits cost the same.
    let line: Vec<_> = (0..100_000).map(|i| Aabb::around([glam::Vec3::X * i as f32])).collect();
    checked(&line, MAX_LEAF);
}

#[test]
fn stops_are_errors_that_say_what_is_left() {
    struct Until(u64);
    impl Probe for Until {
        fn go_on(&mut self, steps: u64) -> bool {
            self.0 = self.0.saturating_sub(steps);
            self.0 > 0
        }
    }
    let boxes = scene("gen:soup:40000");
    for steps in [1, 100_000] {
        let stopped = build(&boxes, &SweepSah::default(), &mut Until(steps));
        let Err(BuildError::Stopped(Unfinished { pending })) = stopped else { panic!("{steps}") };
        assert!(!pending.is_empty() && pending.iter().sum::<usize>() <= boxes.len());
    }
}
