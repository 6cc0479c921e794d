//! Divisions of a node against all there are, and trees on hard scenes.

use super::bounds::{Bounds, Group};
use super::guillotine::Guillotine;
use super::slabs::Slabs;
use super::*;
use crate::build::Counters;
use crate::build::testing::{any_boxes, choices};
use crate::bvh::{Limits, tree_hash, validate};
use crate::cost::{SahParams, sah};
use crate::scene::Scene;
use glam::Vec3;
use proptest::prelude::*;
use std::collections::HashMap;

fn scene(name: &str) -> Vec<Aabb> {
    Scene::load(name).unwrap().boxes()
}

fn cube(corner: [usize; 3]) -> Aabb {
    let corner = Vec3::from_array(corner.map(|c| c as f32));
    Aabb::new(corner, corner + Vec3::ONE)
}

/// Every way of building there is.
fn ways(max_leaf: usize) -> impl Iterator<Item = KwaySah> {
    let guillotine = [(2, Nodes::FirstCut), (2, Nodes::Cuts), (2, Nodes::Parts), (4, Nodes::Cuts), (8, Nodes::Cuts)];
    let wide = [4, 8, 16].map(|parts| (parts, Nodes::Parts));
    let of = move |cuts| move |(parts, nodes)| KwaySah { parts, nodes, cuts, max_leaf, ..KwaySah::default() };
    guillotine
        .into_iter()
        .chain(wide)
        .map(of(Cuts::Guillotine))
        .chain([2, 4, 8, 16].map(|parts| (parts, Nodes::Parts)).map(of(Cuts::Slabs)))
}

fn checked(boxes: &[Aabb], params: &KwaySah) -> Bvh {
    let bvh = build(boxes, params, &mut ()).unwrap();
    let limits = Limits { max_leaf: params.max_leaf, ..Limits::default() };
    validate(&bvh, boxes, &limits).unwrap_or_else(|e| panic!("{params:?}: {e}"));
    bvh
}

/// Triangles at the slabs that hold their centres.
type Placed = Vec<([usize; 3], Aabb)>;

fn area_of(items: &Placed) -> f64 {
    Aabb::union_of(items.iter().map(|item| &item.1)).surface_area()
}

/// Both sides of every plane that separates some.
fn cuts_of(items: &Placed) -> Vec<[Placed; 2]> {
    let planes = (0..3).flat_map(|axis| (1..8).map(move |plane| (axis, plane)));
    let sides = planes.map(|(axis, plane)| {
        let (low, high): (Placed, Placed) = items.iter().partition(|item| item.0[axis] < plane);
        [low, high]
    });
    sides.filter(|sides| sides.iter().all(|side| !side.is_empty())).collect()
}

/// The cost of every division into at most `k` parts, one after another.
fn every_division(items: &Placed, k: usize, cuts_are_nodes: bool) -> Vec<f64> {
    let area = area_of(items);
    let mut costs = vec![area * estimate(items.len() as u32)];
    if k > 1 {
        for [low, high] in cuts_of(items) {
            for i in 1..k {
                let highs = every_division(&high, k - i, cuts_are_nodes);
                for low in every_division(&low, i, cuts_are_nodes) {
                    costs.extend(highs.iter().map(|high| low + high + if cuts_are_nodes { area } else { 0.0 }));
                }
            }
        }
    }
    costs
}

/// The best binary tree over cells, or parts of it taken as they are.
fn best_tree(items: &Placed) -> f64 {
    let area = area_of(items);
    let below = cuts_of(items).iter().map(|[low, high]| best_tree(low) + best_tree(high)).fold(f64::INFINITY, f64::min);
    (area * estimate(items.len() as u32)).min(area + below)
}

/// The least cost, if it can be cut; its parts checked.
fn solved<const K: usize>(items: &Placed, nodes: Nodes) -> Option<(f64, u64)> {
    let mut grid = Guillotine::<K>::new(nodes);
    let slabs = [0, 1, 2].map(|axis| items.iter().map(|item| item.0[axis]).max().unwrap() + 1);
    // Twice: nothing of the first may show in the second.
    grid.begin([2, 3, 1]);
    grid.cell([0, 2, 0]).add(&Bounds::of(&cube([9; 3])));
    grid.cell([1, 1, 0]).add(&Bounds::of(&cube([8; 3])));
    grid.solve().unwrap();
    grid.begin(slabs);
    items.iter().for_each(|(slab, aabb)| grid.cell(*slab).add(&Bounds::of(aabb)));
    let before = grid.steps;
    let cost = grid.solve()?;
    let (mut parts, mut is_cut) = (Vec::new(), Vec::new());
    grid.walk(cost, &mut parts, &mut is_cut);
    assert!((2..=K).contains(&parts.len()) && is_cut.len() == 2 * parts.len() - 1);
    let inside = |item: &([usize; 3], Aabb), low: [usize; 3], len: [usize; 3]| {
        (0..3).all(|a| (low[a]..low[a] + len[a]).contains(&item.0[a]))
    };
    let mut sum = 0.0;
    for (cells, group) in &parts {
        let inside: Placed = items.iter().filter(|item| inside(item, cells.low, cells.len)).copied().collect();
        assert_eq!(inside.len(), group.count as usize);
        assert_eq!(Aabb::union_of(inside.iter().map(|item| &item.1)), group.bounds.aabb());
        sum += area_of(&inside) * estimate(group.count);
    }
    assert_eq!(parts.iter().map(|(_, group)| group.count as usize).sum::<usize>(), items.len());
    assert!(nodes != Nodes::Parts || (sum - cost).abs() <= 1e-12 * sum);
    Some((cost, grid.steps - before))
}

fn close(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
}

/// Cells of a small grid with a box in each that is in use, now and then two.
fn placed(slabs: [usize; 3]) -> impl Strategy<Value = Placed> {
    let place = (0..slabs[0], 0..slabs[1], 0..slabs[2], 0u8..4, 0u8..4, 1u8..4);
    let item = place.prop_map(|(x, y, z, dx, dy, size)| {
        let corner = Vec3::new(x as f32, y as f32, z as f32) + Vec3::new(dx.into(), dy.into(), 0.0) * 0.25;
        ([x, y, z], Aabb::new(corner, corner + Vec3::splat(f32::from(size) * 0.5)))
    });
    proptest::collection::vec(item, 2..14)
}

proptest! {
    #[test]
    fn the_cheapest_of_all_divisions(items in placed([3, 3, 2])) {
        let cut_at_all = !cuts_of(&items).is_empty();
        let area = area_of(&items);
        // The whole is the first of all divisions, and no division of a root.
        let least = |k, nodes| {
            let all = every_division(&items, k, nodes == Nodes::Cuts);
            let least = all[1..].iter().copied().fold(f64::INFINITY, f64::min);
            least - if nodes == Nodes::Cuts { area } else { 0.0 }
        };
        for nodes in [Nodes::Parts, Nodes::Cuts] {
            let found = [solved::<2>(&items, nodes), solved::<4>(&items, nodes)];
            for (found, k) in found.into_iter().zip([2, 4]) {
                prop_assert_eq!(found.is_some(), cut_at_all);
                if let Some((cost, _)) = found {
                    prop_assert!((cost - least(k, nodes)).abs() <= 1e-9 * area, "{} {}", cost, least(k, nodes));
                }
            }
        }
    }

    #[test]
    fn the_cheapest_of_all_divisions_into_eight(items in placed([2, 2, 2])) {
        if let Some((cost, _)) = solved::<8>(&items, Nodes::Parts) {
            let all = every_division(&items, 8, false);
            let least = all[1..].iter().copied().fold(f64::INFINITY, f64::min);
            prop_assert!(close(cost, least), "{} {}", cost, least);
        }
    }

    #[test]
    fn the_best_tree_over_cells(items in placed([3, 2, 2])) {
        if let Some((cost, _)) = solved::<2>(&items, Nodes::FirstCut) {
            let cuts = cuts_of(&items);
            let below = cuts.iter().map(|[low, high]| best_tree(low) + best_tree(high));
            let least = below.fold(f64::INFINITY, f64::min);
            prop_assert!(close(cost, least), "{} {}", cost, least);
        }
    }

    #[test]
    fn more_parts_never_cost_more_and_slabs_never_less(items in placed([5, 4, 4])) {
        let cost = |found: Option<(f64, u64)>| found.map_or(f64::INFINITY, |f| f.0);
        let parts = [cost(solved::<2>(&items, Nodes::Parts)), cost(solved::<4>(&items, Nodes::Parts)),
            cost(solved::<8>(&items, Nodes::Parts)), cost(solved::<16>(&items, Nodes::Parts))];
        prop_assert!(parts.is_sorted_by(|a, b| b <= a), "{:?}", parts);
        let cuts = [cost(solved::<2>(&items, Nodes::Cuts)), cost(solved::<4>(&items, Nodes::Cuts)),
            cost(solved::<8>(&items, Nodes::Cuts)), cost(solved::<2>(&items, Nodes::FirstCut))];
        prop_assert!(cuts.is_sorted_by(|a, b| *b <= *a * (1.0 + 1e-12)), "{:?}", cuts);
        for axis in 0..3 {
            for planes in choices(&[1, 2, 3, 4], 3) {
                let slab = |item: &([usize; 3], Aabb)| planes.iter().filter(|&&plane| plane <= item.0[axis]).count();
                let slabs = (0..4).map(|s| items.iter().filter(|item| slab(item) == s).copied().collect::<Placed>());
                let used = slabs.filter(|slab| !slab.is_empty());
                let (n, sum) = used.fold((0, 0.0), |(n, sum), s| (n + 1, sum + area_of(&s) * estimate(s.len() as u32)));
                prop_assert!(n < 2 || parts[1] <= sum * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn slabs_are_the_cheapest_of_all_choices(boxes in any_boxes(1..=9), most in 1usize..6) {
        let groups: Vec<_> = boxes.iter().map(|b| Group { bounds: Bounds::of(b), count: 1 }).collect();
        let (mut slabs, mut starts) = (Slabs::default(), Vec::new());
        let cost = slabs.divide(&groups, most, &mut starts);
        let n = boxes.len();
        let parts = most.min(n);
        let sum = |starts: &[usize]| -> f64 {
            let ends = starts[1..].iter().copied().chain([n]);
            starts.iter().zip(ends).map(|(&s, e)| Aabb::union_of(&boxes[s..e]).surface_area() * (e - s) as f64).sum()
        };
        let positions: Vec<_> = (1..n).collect();
        let all = choices(&positions, parts - 1);
        let least = all.iter().map(|c| sum(&[&[0], &c[..]].concat())).fold(f64::INFINITY, f64::min);
        prop_assert_eq!(starts.len(), parts);
        prop_assert!(close(cost, least) && close(sum(&starts), least));
    }

    #[test]
    fn few_triangles_get_the_cheapest_subtree(boxes in any_boxes(1..=7), max_leaf in 1usize..5) {
        for arity in [2, 4, 8] {
            let bvh = checked(&boxes, &KwaySah { max_leaf, ..KwaySah::at_arity(arity) });
            let Some(cost) = sah(&bvh, SahParams::default()) else { continue };
            // Each triangle at the rank of its centre.
            let rank = |aabb: &Aabb, axis: usize| {
                let mut below: Vec<_> = boxes.iter().map(|b| b.centre()[axis] + 0.0).collect();
                below.sort_by(f64::total_cmp);
                below.dedup();
                below.iter().filter(|&&c| c < aabb.centre()[axis] + 0.0).count()
            };
            let items: Placed = boxes.iter().map(|b| ([0, 1, 2].map(|axis| rank(b, axis)), *b)).collect();
            let mut cheapest = Cheapest { items: &items, arity, max_leaf, known: HashMap::new() };
            let least = cheapest.cost((1 << items.len()) - 1, 1);
            if least.is_finite() {
                let cost = cost * bvh.root().aabb.surface_area();
                prop_assert!((cost - least).abs() <= 1e-9 * least, "{} {} {}", arity, cost, least);
            }
        }
    }

    #[test]
    fn every_way_builds_a_valid_tree(boxes in any_boxes(1..=70), max_leaf in 1usize..7) {
        ways(max_leaf).for_each(|params| drop(checked(&boxes, &params)));
    }
}

/// The best subtrees by cuts, by the mask of their triangles and their number.
struct Cheapest<'a> {
    items: &'a Placed,
    arity: usize,
    max_leaf: usize,
    known: HashMap<(usize, usize), f64>,
}

impl Cheapest<'_> {
    /// The cost of a set in at most `k` subtrees; infinite where triangles that no cut separates are too many for a leaf.
    fn cost(&mut self, set: usize, k: usize) -> f64 {
        if let Some(&known) = self.known.get(&(set, k)) {
            return known;
        }
        let items: Placed = (0..self.items.len()).filter(|i| set >> i & 1 == 1).map(|i| self.items[i]).collect();
        let (n, area) = (items.len(), area_of(&items));
        let mut cost = if n <= self.max_leaf { area * n as f64 } else { f64::INFINITY };
        cost = cost.min(area + self.cut(set, self.arity));
        if k > 1 {
            cost = cost.min(self.cut(set, k));
        }
        self.known.insert((set, k), cost);
        cost
    }

    /// The cost of a set in 2 to `k` subtrees.
    fn cut(&mut self, set: usize, k: usize) -> f64 {
        let mut least = f64::INFINITY;
        for axis in 0..3 {
            for plane in 1..8 {
                let below = (0..self.items.len()).filter(|&i| self.items[i].0[axis] < plane).map(|i| 1 << i);
                let low = set & below.sum::<usize>();
                if low != 0 && low != set {
                    (1..k).for_each(|i| least = least.min(self.cost(low, i) + self.cost(set ^ low, k - i)));
                }
            }
        }
        least
    }
}

#[test]
fn a_cube_is_divided_into_blocks_and_not_into_slabs() {
    let corners = (0..512).map(|i| [i % 8, i / 8 % 8, i / 64]);
    let boxes: Vec<_> = corners.map(cube).collect();
    let children = |cuts| {
        let bvh = checked(&boxes, &KwaySah { cuts, bins: 8, ..KwaySah::default() });
        let areas: f64 = bvh.nodes[bvh.children(0)].iter().map(|child| child.aabb.surface_area()).sum();
        let side = bvh.root().aabb.surface_area() / 6.0;
        (bvh.children(0).len(), areas / side)
    };
    assert_eq!(children(Cuts::Guillotine), (8, 12.0));
    assert_eq!(children(Cuts::Slabs), (8, 20.0));
}

#[test]
fn steps_are_those_of_the_recurrence() {
    let corners = (0..8).map(|i| [i % 2, i / 2 % 2, i / 4]);
    let full: Placed = corners.map(|corner| (corner, cube(corner))).collect();
    let steps = |found: Option<(f64, u64)>| found.unwrap().1;
    // The whole has 3 planes; 6 halves have 2 each; 12 quarters have 1. In k parts, k (k − 1) / 2 a plane.
    assert_eq!(steps(solved::<2>(&full, Nodes::Parts)), 3);
    assert_eq!(steps(solved::<4>(&full, Nodes::Parts)), 3 * 6 + 6 * 2 * 3 + 12);
    assert_eq!(steps(solved::<8>(&full, Nodes::Parts)), 3 * 28 + 6 * 2 * 21 + 12 * 15);
    assert_eq!(steps(solved::<2>(&full, Nodes::FirstCut)), 3 + 6 * 2 + 12);
    // Four cells on a diagonal: 3 axes with the same 3, 2, 2, 1, 1, 1 planes.
    let diagonal: Placed = (0..4).map(|i| ([i; 3], cube([i; 3]))).collect();
    assert_eq!(steps(solved::<2>(&diagonal, Nodes::FirstCut)), 3 * (3 + 2 * 2 + 3));
}

#[test]
fn the_same_tree_and_work_on_any_number_of_threads() {
    for (name, arity) in [("gen:spheres:40000", 2), ("gen:stadium:40000", 8), ("gen:coincident:40000", 4)] {
        let boxes = scene(name);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut counters = Counters::default();
                (build(&boxes, &KwaySah::at_arity(arity), &mut counters).unwrap(), counters)
            })
        };
        let one = on(1);
        assert!(one == on(2) && one == on(7), "{name}");
        assert_eq!(one.1.get(Work::DpSteps) > 10_000, arity != 4, "{name}");
    }
}

#[test]
fn extremes_build_fast_and_at_any_scale() {
    for name in ["gen:coincident:100000", "gen:nested:100000", "gen:slivers:3000", "gen:stadium:5000"] {
        let boxes = scene(name);
        for arity in [2, 8] {
            let params = KwaySah::at_arity(arity);
            let hash = tree_hash(&checked(&boxes, &params));
            for scale in [1e19f32, 2f32.powi(40)] {
                let scaled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
                if scaled.iter().all(Aabb::is_valid) {
                    let other = tree_hash(&checked(&scaled, &params));
                    assert!(scale == 1e19 || other == hash, "{name} {scale}");
                }
            }
        }
    }
    // Along a line no box has an area: all cuts cost the same.
    let line: Vec<_> = (0..50_000).map(|i| Aabb::around([Vec3::X * i as f32])).collect();
    for arity in [2, 8] {
        checked(&line, &KwaySah::at_arity(arity));
    }
}

#[test]
fn binary_trees_are_better_than_those_of_single_splits() {
    for (name, most) in [("gen:spheres:8000", 0.995), ("gen:stadium:8000", 0.97)] {
        let boxes = scene(name);
        let sweep = crate::build::sweep_sah::build(&boxes, &Default::default(), &mut ()).unwrap();
        let ahead = checked(&boxes, &KwaySah::at_arity(2));
        let [sweep, ahead] = [sweep, ahead].map(|bvh| sah(&bvh, SahParams::default()).unwrap());
        assert!(ahead < most * sweep, "{name}: {ahead} {sweep}");
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let boxes = [cube([0; 3]), cube([1; 3])];
    let refused = |params: KwaySah| matches!(build(&boxes, &params, &mut ()), Err(BuildError::Parameter(_)));
    let fine = KwaySah::default();
    for bins in [0, 1, 9] {
        assert!(refused(KwaySah { bins, ..fine }));
    }
    assert!(refused(KwaySah { runs: 65, ..fine }) && refused(KwaySah { parts: 3, ..fine }));
    assert!(refused(KwaySah { nodes: Nodes::FirstCut, ..fine }) && !refused(fine));
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
    for steps in [1, 60_000, 90_000] {
        let stopped = build(&boxes, &KwaySah::at_arity(2), &mut Until(steps));
        let Err(BuildError::Stopped(Unfinished { pending })) = stopped else { panic!("{steps}") };
        assert!(!pending.is_empty() && pending.iter().sum::<usize>() <= boxes.len());
    }
}
