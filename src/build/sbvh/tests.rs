//! Splits against enumeration, cuts against sampled points, the budget, and rays against brute force.

use super::object::Sweep;
use super::spatial::Chop;
use super::*;
use crate::build::sweep_sah::{self, SweepSah};
use crate::build::{Brake, Counters, Work};
use crate::bvh::testing::{Random, boxes, soup};
use crate::bvh::{Limits, tree_hash, validate, validate_parts};
use crate::cost::{SahParams, epo, sah};
use crate::geom::{Ray, Triangle, WatertightRay};
use crate::trace::testing::{any_ray, grid_ray, grid_soup};
use crate::trace::{Scratch, any_hit, brute_force, closest_hit};
use glam::{DVec3, Vec3};
use proptest::prelude::*;

/// Limits of a tree with single references in its leaves.
const ONE: Limits = Limits { max_leaf: 1, q8: false, spatial: true };

fn build_with(triangles: &[Triangle], params: &Sbvh) -> Bvh {
    let boxes = boxes(triangles);
    let bvh = build(Input::of_triangles(triangles, &boxes), params, &mut ()).unwrap();
    validate_parts(&bvh, triangles, &boxes, &Limits { max_leaf: params.max_leaf, ..ONE }).unwrap();
    bvh
}

fn cost(bvh: &Bvh) -> f64 {
    sah(bvh, SahParams::default()).unwrap()
}

fn references(boxes: &[Aabb]) -> Vec<Reference> {
    (0u32..).zip(boxes).map(|(id, &aabb)| Reference { aabb, id }).collect()
}

/// Needles through the cube in all directions, the longer the more there is to cut.
fn slivers(seed: u64, n: usize) -> Vec<Triangle> {
    let mut random = Random(seed);
    (0..n)
        .map(|_| {
            let (a, b) = (random.point(1.0), random.point(1.0));
            Triangle::new(a, b, a + (b - a) * 0.4 + random.point(1e-3))
        })
        .collect()
}

#[test]
fn small_nodes_and_those_that_references_reach_through_have_few_slabs() {
    let slabs = |n: usize, size: f32, bins: usize| {
        let corner = |i: usize| Vec3::splat(i as f32 / (n - 1) as f32 * (1.0 - size));
        let boxes: Vec<_> = (0..n).map(|i| Aabb::new(corner(i), corner(i) + size)).collect();
        let mut chop = Chop::default();
        let references = references(&boxes);
        chop.best(&Source(Input::of_boxes(&boxes)), &references, &union(&references), bins, n);
        // As many on each of three axes.
        chop.planes() / 3 + 1
    };
    assert_eq!([0.01, 0.099, 0.4, 1.0].map(|size| slabs(1000, size, 128)), [128, 80, 32, 8]);
    assert_eq!([300, 200, 100].map(|n| slabs(n, 0.01, 128)), [75, 50, 32]);
    assert_eq!([256, 128, 32, 16, 4].map(|bins| slabs(1000, 0.01, bins)), [250, 128, 32, 16, 4]);
}

proptest! {
    #[test]
    fn object_splits_are_the_best_of_all(seed: u64, n in 2usize..30, on_grid: bool) {
        let triangles = if on_grid { grid_soup(seed, n) } else { soup(seed, n, 0.5) };
        let references = references(&boxes(&triangles));
        for axis in 0..3 {
            let mut order: Vec<usize> = (0..n).collect();
            order.sort_by(|&a, &b| {
                let centre = |i: usize| references[i].aabb.min[axis] * 0.5 + references[i].aabb.max[axis] * 0.5;
                centre(a).total_cmp(&centre(b)).then(a.cmp(&b))
            });
            let side = |side: &[usize]| {
                Aabb::union_of(side.iter().map(|&i| &references[i].aabb)).surface_area() * side.len() as f64
            };
            let costs: Vec<f64> = (1..n).map(|k| side(&order[..k]) + side(&order[k..])).collect();
            let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
            let best = Sweep::default().best(&references, axis);
            prop_assert_eq!(best.cost, least);
            let of_least = (1..n).filter(|&k| costs[k - 1] == least).min_by_key(|&k| k.abs_diff(n - k)).unwrap();
            for (position, &index) in order.iter().enumerate() {
                prop_assert_eq!(best.is_left(&references[index], index), position < of_least);
            }
        }
    }

    #[test]
    fn spatial_splits_are_the_best_of_all(seed: u64, n in 2usize..12, budget in 0usize..12, known: bool) {
        let triangles = soup(seed, n, 0.9);
        let all = boxes(&triangles);
        let references = references(&all);
        let root = union(&references);
        let input = if known { Input::of_triangles(&triangles, &all) } else { Input::of_boxes(&all) };
        let mut best = None;
        for axis in 0..3 {
            let mut planes: Vec<f32> = all.iter().flat_map(|b| [b.min[axis], b.max[axis]]).collect();
            planes.sort_by(f32::total_cmp);
            for &at in planes.iter().filter(|&&at| root.min[axis] < at && at < root.max[axis]) {
                let sides = [-1.0, 1.0].map(|side| {
                    let parts: Vec<_> = (0..n).filter_map(|i| {
                        let part = if known { half(&triangles[i], axis, at, side) } else { half_box(&all[i], axis, at, side) };
                        part.filter(|(low, high)| high[axis] > low[axis])
                    }).collect();
                    let low = parts.iter().fold(DVec3::INFINITY, |low, p| low.min(p.0));
                    let high = parts.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(p.1));
                    (crate::geom::area_of_extent(high - low), parts.len())
                });
                let [(left_area, left), (right_area, right)] = sides;
                if left > 0 && right > 0 && left + right <= n + budget {
                    let cost = left_area * left as f64 + right_area * right as f64;
                    best = Some(best.map_or(cost, |best: f64| best.min(cost)));
                }
            }
        }
        let found = Chop::default().best(&Source(input), &references, &root, 64, budget).map(|s| s.cost);
        match (found, best) {
            (Some(found), Some(best)) => prop_assert!((found / best - 1.0).abs() < 1e-5, "{found} {best}"),
            (found, best) => prop_assert_eq!(found, best),
        }
    }

    #[test]
    fn cuts_lose_no_point(seed: u64, axes in proptest::collection::vec((0usize..3, 0.0f32..1.0, any::<bool>()), 1..6)) {
        let triangle = soup(seed, 1, 1.0);
        let all = boxes(&triangle);
        let source = Source(Input::of_triangles(&triangle, &all));
        let mut random = Random(seed);
        let mut points: Vec<DVec3> = (0..40).map(|_| {
            let (u, v) = (f64::from(random.unit()), f64::from(random.unit()));
            let [a, b, c] = triangle[0].v.map(|p| p.as_dvec3());
            if u + v < 1.0 { a + (b - a) * u + (c - a) * v } else { a + (b - a) * (1.0 - u) + (c - a) * (1.0 - v) }
        }).chain(triangle[0].v.map(|p| p.as_dvec3())).collect();
        let mut part = Reference { aabb: all[0], id: 0 };
        for (axis, where_, above) in axes {
            let at = part.aabb.min[axis] + where_ * (part.aabb.max[axis] - part.aabb.min[axis]);
            let sides = source.cut(&part, axis, at);
            for side in &sides {
                prop_assert!(part.aabb.contains(side));
            }
            let holds = |side: &Aabb, p: DVec3| p.cmpge(side.min.as_dvec3()).all() && p.cmple(side.max.as_dvec3()).all();
            for &p in &points {
                let side = &sides[usize::from(p[axis] > f64::from(at))];
                prop_assert!(holds(side, p) || (side.is_empty() && sides.iter().any(|s| holds(s, p))));
            }
            let next = sides[usize::from(above)];
            if next.is_empty() {
                break;
            }
            points.retain(|p| if above { p[axis] > f64::from(at) } else { p[axis] <= f64::from(at) });
            part.aabb = next;
        }
    }

    #[test]
    fn any_triangles_any_budget(seed: u64, n in 1usize..120, budget in 0usize..150, bins in 2usize..40, kind in 0..3) {
        let triangles = match kind {
            0 => soup(seed, n, 0.7),
            1 => grid_soup(seed, n),
            _ => slivers(seed, n),
        };
        let bvh = build_with(&triangles, &Sbvh { budget, bins, max_leaf: 1, ..Sbvh::default() });
        prop_assert!(bvh.triangle_ids.len() <= n + n * budget / 100);
        let all = boxes(&triangles);
        let of_boxes = build(Input::of_boxes(&all), &Sbvh { budget, bins, ..Sbvh::default() }, &mut ()).unwrap();
        let limits = Limits { max_leaf: MAX_LEAF, ..ONE };
        prop_assert!(validate(&of_boxes, &all, &limits).is_ok());
    }

    #[test]
    fn without_a_budget_it_is_the_sweep(seed: u64, n in 1usize..200) {
        // Centres are f32 in one and f64 in the other: so let them be numbers of both.
        let whole = |p: Vec3| (p * 1048576.0).round() / 1048576.0;
        let triangles: Vec<_> = soup(seed, n, 0.2).iter().map(|t| Triangle { v: t.v.map(whole) }).collect();
        // And the sweep does not look at an axis on which all centres are the same, where this one goes by index: so let no two be.
        for axis in 0..3 {
            let mut centres: Vec<f64> = boxes(&triangles).iter().map(|aabb| aabb.centre()[axis]).collect();
            centres.sort_unstable_by(f64::total_cmp);
            prop_assume!(centres.is_sorted_by(|a, b| a < b));
        }
        let bvh = build_with(&triangles, &Sbvh { budget: 0, max_leaf: 1, ..Sbvh::default() });
        let sweep = sweep_sah::build(&boxes(&triangles), &SweepSah { max_leaf: 1 }, &mut ()).unwrap();
        prop_assert_eq!(tree_hash(&bvh), tree_hash(&sweep));
        prop_assert_eq!(bvh.triangle_ids.len(), n);
    }
}

/// Corners of the box around what a triangle has on one side of a plane, from its corners and edges.
fn half(triangle: &Triangle, axis: usize, at: f32, side: f64) -> Option<(DVec3, DVec3)> {
    let corners = triangle.v.map(|p| p.as_dvec3());
    let at = f64::from(at);
    let mut points: Vec<DVec3> = corners.into_iter().filter(|p| side * (p[axis] - at) >= 0.0).collect();
    for i in 0..3 {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        if (a[axis] < at) != (b[axis] < at) {
            points.push(a + (b - a) * ((at - a[axis]) / (b[axis] - a[axis])));
        }
    }
    let low = points.iter().copied().reduce(DVec3::min)?;
    Some((low, points.iter().copied().fold(low, DVec3::max)))
}

/// The same of a box.
fn half_box(aabb: &Aabb, axis: usize, at: f32, side: f64) -> Option<(DVec3, DVec3)> {
    let (mut low, mut high) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    if side < 0.0 {
        high[axis] = high[axis].min(at.into());
    } else {
        low[axis] = low[axis].max(at.into());
    }
    (low[axis] <= high[axis]).then_some((low, high))
}

#[test]
fn spatial_splits_pay_where_triangles_are_long() {
    let needles = slivers(1, 2000);
    let without = cost(&build_with(&needles, &Sbvh { budget: 0, ..Sbvh::default() }));
    let with = build_with(&needles, &Sbvh { budget: 300, ..Sbvh::default() });
    assert!(cost(&with) < 0.6 * without, "{} {without}", cost(&with));
    // A little of a budget is better than none.
    let little = cost(&build_with(&needles, &Sbvh { budget: 30, ..Sbvh::default() }));
    assert!(little < 0.98 * without, "{little} {without}");
    // Less of other subtrees' triangles lies in a node's box.
    let whole = build_with(&needles, &Sbvh { budget: 0, ..Sbvh::default() });
    assert!(epo(&with, &needles).unwrap() < 0.7 * epo(&whole, &needles).unwrap());
}

/// Asserts that the kernels answer as brute force does, in a tree in which triangles were cut.
fn same_hits(triangles: &[Triangle], rays: impl Iterator<Item = Ray>) -> usize {
    let params = Sbvh { budget: 400, overlap: 0.0, ..Sbvh::default() };
    let mut scratch = Scratch::default();
    let bvh = build_with(triangles, &params);
    assert!(bvh.triangle_ids.len() > triangles.len());
    let wide = crate::refine::Collapse::Thesis.apply(&bvh, 8, 4);
    let mut hits = 0;
    for ray in rays {
        let expected = brute_force::<WatertightRay>(triangles, &ray);
        for bvh in [&bvh, &wide] {
            let found = closest_hit::<WatertightRay, ()>(bvh, triangles, &ray, &mut scratch, &mut ());
            assert_eq!(found, expected, "{ray:?}");
            let any = any_hit::<WatertightRay, ()>(bvh, triangles, &ray, &mut scratch, &mut ());
            assert_eq!(any, expected.is_some(), "{ray:?}");
        }
        hits += usize::from(expected.is_some());
    }
    hits
}

#[test]
fn rays_meet_what_brute_force_meets() {
    for seed in 0..6 {
        let mut random = Random(!seed);
        let mut rays = |n: usize, ray: fn(&mut Random) -> Ray| (0..n).map(|_| ray(&mut random)).collect::<Vec<_>>();
        assert!(same_hits(&soup(seed, 300, 0.9), rays(400, any_ray).into_iter()) > 100);
        assert!(same_hits(&grid_soup(seed, 200), rays(800, grid_ray).into_iter()) > 100);
        let needles = slivers(seed, 300);
        same_hits(&needles, rays(400, any_ray).into_iter());
        // At points of the needles, and along them.
        let at = |k: usize| needles[k % 300].v[0] * 0.3 + needles[k % 300].v[1] * 0.3 + needles[k % 300].v[2] * 0.4;
        let towards = (0..600).map(|k| Ray::new(Vec3::splat(-1.0), at(k) + Vec3::ONE));
        assert!(same_hits(&needles, towards) > 50);
        let along =
            (0..300).map(|k| Ray::new(needles[k].v[0] * 2.0 - needles[k].v[1], needles[k].v[1] - needles[k].v[0]));
        same_hits(&needles, along);
        let away = Vec3::new(1e5, -3e4, 7e4);
        let far: Vec<_> = soup(seed, 200, 0.9).iter().map(|t| Triangle { v: t.v.map(|p| p + away) }).collect();
        let far_rays = rays(300, any_ray).into_iter().map(|r| Ray::new(r.origin + away, r.direction));
        assert!(same_hits(&far, far_rays) > 50);
    }
}

#[test]
fn rays_at_corners_and_edges_of_a_closed_surface_slip_through_nowhere() {
    let sphere = crate::scene::Scene::load("gen:spheres:500").unwrap().triangles;
    let params = Sbvh { budget: 400, overlap: 0.0, ..Sbvh::default() };
    let bvh = build_with(&sphere, &params);
    let mut scratch = Scratch::default();
    for t in &sphere {
        let [a, b, c] = t.v;
        for target in [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
            let origin = Vec3::new(-3.0, 2.0, 1.5);
            let ray = Ray::new(origin, target - origin);
            let found = closest_hit::<WatertightRay, ()>(&bvh, &sphere, &ray, &mut scratch, &mut ());
            assert_eq!(found, brute_force::<WatertightRay>(&sphere, &ray), "{ray:?}");
        }
    }
}

#[test]
fn hard_cases_end() {
    let n = 20_000;
    let alike = vec![soup(1, 1, 1.0)[0]; n];
    build_with(&alike, &Sbvh::default());
    let nested: Vec<_> = (0..n)
        .map(|i| soup(2, 1, 1.0)[0].v.map(|p| (p - 0.3) * 1.003f32.powi(i as i32)))
        .map(|v| Triangle { v })
        .collect();
    build_with(&nested, &Sbvh::default());
    let floor: Vec<_> =
        slivers(3, n / 4).iter().map(|t| Triangle { v: t.v.map(|p| p * Vec3::new(1.0, 0.0, 1.0)) }).collect();
    build_with(&floor, &Sbvh::default());
    let points: Vec<_> = soup(4, n / 4, 0.0);
    build_with(&points, &Sbvh::default());
    for size in [1e19, 1e-30] {
        let scaled: Vec<_> = slivers(4, 500).iter().map(|t| Triangle { v: t.v.map(|p| p * size) }).collect();
        assert!(build_with(&scaled, &Sbvh::default()).triangle_ids.len() > 500);
    }
    let mut spread = slivers(5, 500);
    for (k, t) in spread.iter_mut().enumerate() {
        t.v = t.v.map(|p| p * 10f32.powi(k as i32 % 70 - 35));
    }
    build_with(&spread, &Sbvh::default());
}

#[test]
fn neither_threads_nor_scale_change_the_tree() {
    let needles = slivers(6, 6000);
    let params = Sbvh { budget: 40, ..Sbvh::default() };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        tree_hash(&pool.install(|| build_with(&needles, &params)))
    };
    assert!(with(1) == with(2) && with(2) == with(5));
    for scale in [2f32.powi(30), 2f32.powi(-30)] {
        let scaled: Vec<_> = needles.iter().map(|t| Triangle { v: t.v.map(|p| p * scale) }).collect();
        assert_eq!(tree_hash(&build_with(&scaled, &params)), with(2));
    }
}

#[test]
fn counts_and_stops_and_refuses() {
    let needles = slivers(7, 9000);
    let all = boxes(&needles);
    let input = Input::of_triangles(&needles, &all);
    let mut counters = Counters::default();
    build(input, &Sbvh::default(), &mut counters).unwrap();
    assert!(counters.get(Work::SplitCosts) > 3 * 9000 && counters.get(Work::Binned) > 3 * 9000);
    struct Stop(u32);
    impl Probe for Stop {
        fn go_on(&mut self, _: u64) -> bool {
            self.0 -= 1;
            self.0 > 0
        }
    }
    for after in [1, 3] {
        match build(input, &Sbvh::default(), &mut Stop(after)) {
            Err(BuildError::Stopped(Unfinished { pending })) => assert!(!pending.is_empty()),
            other => panic!("{other:?}"),
        }
    }
    for bins in [1, MOST_BINS + 1] {
        let error = build(input, &Sbvh { bins, ..Sbvh::default() }, &mut Brake::default()).unwrap_err();
        assert!(matches!(error, BuildError::Parameter(_)));
    }
}
