//! The wide kernels against brute force, against their scalar twin, and at every set of instructions.

use super::pack::Pack;
use super::search::twin;
use super::{Fast, Watertight, WideBvh};
use crate::bvh::Bvh;
use crate::bvh::testing::{Random, boxes, random_tree, soup};
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::simd::Simd;
use crate::trace::closest::{Any, Closest};
use crate::trace::slab::Slabs;
use crate::trace::testing::{any_ray, grid_ray, grid_soup, median_split, sphere};
use crate::trace::{Kernel, Query, Scratch, TraceCounters, Tracer, Width, brute_force};
use glam::Vec3;
use proptest::prelude::*;

fn bits(hit: Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|h| (h.triangle, h.t.to_bits()))
}

const WIDTHS: [Width; 2] = [Width::Four, Width::Eight];

/// What the scalar twin answers and counts; `None` where the ray is not for f32 boxes.
fn by_twin(
    width: Width,
    fast: bool,
    query: Query,
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
) -> Option<(Option<Hit>, TraceCounters)> {
    let mut work = TraceCounters::default();
    let scratch = &mut Scratch::default();
    let four = WideBvh::<4>::new(bvh, triangles);
    let eight = WideBvh::<8>::new(bvh, triangles);
    let w = &mut work;
    let hit = match (width, fast, query) {
        (Width::Four, false, Query::Closest) => twin::<4, Closest, Watertight, _>(&four, ray, scratch, w),
        (Width::Four, true, Query::Closest) => twin::<4, Closest, Fast, _>(&four, ray, scratch, w),
        (Width::Four, false, Query::Any) => twin::<4, Any, Watertight, _>(&four, ray, scratch, w),
        (Width::Four, true, Query::Any) => twin::<4, Any, Fast, _>(&four, ray, scratch, w),
        (Width::Eight, false, Query::Closest) => twin::<8, Closest, Watertight, _>(&eight, ray, scratch, w),
        (Width::Eight, true, Query::Closest) => twin::<8, Closest, Fast, _>(&eight, ray, scratch, w),
        (Width::Eight, false, Query::Any) => twin::<8, Any, Watertight, _>(&eight, ray, scratch, w),
        (Width::Eight, true, Query::Any) => twin::<8, Any, Fast, _>(&eight, ray, scratch, w),
    };
    let hit = hit.ok()?;
    Some((if query == Query::Any { hit.map(|_| Kernel::SOME_HIT) } else { hit }, work))
}

/// Trees of every arity that kernels take as they are, divide or collapse; some of them bad.
fn trees(seed: u64, triangles: &[Triangle]) -> Vec<Bvh> {
    let boxes = boxes(triangles);
    let sensible = [2, 3, 4, 8, 13].map(|arity| median_split(triangles, arity));
    let bad = [2, 4, 8, 16].map(|arity| random_tree(seed, &boxes, arity, 7));
    sensible.into_iter().chain(bad).collect()
}

/// Holds both widths, at every level, to brute force; returns the hits.
fn check(seed: u64, triangles: &[Triangle], rays: &[Ray]) -> usize {
    let expected: Vec<_> = rays.iter().map(|ray| brute_force::<WatertightRay>(triangles, ray)).collect();
    let mut scratch = Scratch::default();
    for bvh in trees(seed, triangles) {
        for width in WIDTHS {
            let tracer = Tracer::new(Kernel::Wide { width, fast: false }, &bvh, triangles);
            for level in Simd::available() {
                let tracer = tracer.clone().at_level(level);
                for (ray, expected) in rays.iter().zip(&expected) {
                    let found = tracer.trace(Query::Closest, ray, &mut scratch, &mut ());
                    assert_eq!(bits(found), bits(*expected), "{width:?} {level:?} arity {} {ray:?}", bvh.arity);
                    let any = tracer.trace(Query::Any, ray, &mut scratch, &mut ());
                    assert_eq!(any.is_some(), expected.is_some(), "{width:?} {level:?} {ray:?}");
                }
            }
        }
    }
    expected.iter().flatten().count()
}

fn rays(seed: u64, n: usize, make: fn(&mut Random) -> Ray) -> Vec<Ray> {
    let mut random = Random(seed);
    (0..n).map(|_| make(&mut random)).collect()
}

/// Rays at corners and middles of edges, from far and near.
fn edge_rays(triangles: &[Triangle], seed: u64, n: usize, distance: f32) -> Vec<Ray> {
    let mut random = Random(seed);
    let ray = |_| {
        let [a, b, _] = triangles[random.below(triangles.len())].v;
        let target = if random.below(2) == 0 { a } else { a * 0.5 + b * 0.5 };
        let origin = target + (random.point(2.0) - 1.0) * distance;
        Ray::new(origin, target - origin)
    };
    (0..n).map(ray).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn scattered_triangles(seed in any::<u64>(), n in 1_usize..300, size in 0.001_f32..0.5) {
        check(seed, &soup(seed, n, size), &rays(!seed, 60, any_ray));
    }

    #[test]
    fn ties_shared_planes_and_zeros_of_either_sign(seed in any::<u64>(), n in 1_usize..120) {
        check(seed, &grid_soup(seed, n), &rays(!seed, 100, grid_ray));
    }

    #[test]
    fn edges_from_any_distance(seed in any::<u64>(), exponent in -12_i32..24) {
        let triangles = soup(seed, 60, 0.3);
        check(seed, &triangles, &edge_rays(&triangles, seed, 60, 2f32.powi(exponent)));
    }

    #[test]
    fn any_scale_and_offset(seed in any::<u64>(), exponent in -140_i32..125, offset in -8_i32..8) {
        let scale = 2f32.powi(exponent.max(-126)) * 2f32.powi((exponent + 126).min(0));
        let place = |p: Vec3| (p + (offset * 1000) as f32) * scale;
        let mut triangles = soup(seed, 60, 0.3);
        for t in &mut triangles {
            t.v = t.v.map(place);
        }
        if triangles.iter().all(Triangle::is_finite) {
            let mut rays = rays(!seed, 30, any_ray);
            for ray in &mut rays {
                (ray.origin, ray.direction) = (place(ray.origin), ray.direction * scale.clamp(1e-30, 1e30));
            }
            rays.retain(|r| r.origin.is_finite() && r.direction.is_finite());
            check(seed, &triangles, &rays);
        }
    }

    #[test]
    fn every_level_answers_and_counts_as_the_scalar_twin(seed in any::<u64>(), n in 1_usize..200) {
        let triangles = soup(seed, n, 0.2);
        let bvh = median_split(&triangles, 2);
        for (width, fast, query) in WIDTHS.into_iter().flat_map(|w| {
            [false, true].into_iter().flat_map(move |f| [Query::Closest, Query::Any].map(|q| (w, f, q)))
        }) {
            let tracer = Tracer::new(Kernel::Wide { width, fast }, &bvh, &triangles);
            for ray in rays(!seed, 12, any_ray) {
                let Some(expected) = by_twin(width, fast, query, &bvh, &triangles, &ray) else { continue };
                for level in Simd::available() {
                    let mut work = TraceCounters::default();
                    let hit = tracer.clone().at_level(level).trace(query, &ray, &mut Scratch::default(), &mut work);
                    prop_assert_eq!((bits(hit), work), (bits(expected.0), expected.1), "{:?} {:?} {:?}", width, level, ray);
                }
            }
        }
    }
}

#[test]
fn there_are_hits_to_be_compared() {
    let triangles = soup(5, 300, 0.3);
    assert!(check(5, &triangles, &rays(6, 200, any_ray)) > 60);
    assert!(check(5, &triangles, &edge_rays(&triangles, 7, 200, 3.0)) > 60);
}

#[test]
fn a_filter_that_passes_little_never_leaves_out_a_hit_and_is_right_where_it_is_sure() {
    // Counted by the exact tests that it lets through, over closed spheres seen from outside.
    let triangles = sphere(Vec3::ZERO, 1.0, 64);
    let bvh = median_split(&triangles, 8);
    let wide = WideBvh::<8>::new(&bvh, &triangles);
    let mut random = Random(3);
    let (mut passed, mut hit, mut sure, mut tested) = (0, 0, 0, 0);
    for _ in 0..2000 {
        let origin = (random.point(2.0) - 1.0).normalize() * 3.0;
        let ray = Ray::new(origin, random.point(1.2) - 0.6 - origin);
        let slabs = Slabs::new(&ray, &bvh.root().aabb).unwrap();
        let filter = super::filter::FilterRay::new(&ray, &slabs, wide.reach);
        let exact = WatertightRay::new(&ray);
        for block in &wide.blocks {
            let sides = filter.sides::<super::pack::Portable<4>>(block);
            let candidates = sides.candidates(block);
            let bounds = filter.bounds(&sides);
            let (mut least, mut most) = ([0.0; 4], [0.0; 4]);
            bounds.least.store(&mut least);
            bounds.most.store(&mut most);
            for lane in 0..block.count as usize {
                let meets = exact.meets(&block.triangle(lane));
                let passes = candidates >> lane & 1 == 1;
                assert!(passes || meets.is_none(), "{ray:?}");
                if bounds.sure >> lane & 1 == 1 {
                    let t = meets.expect("f32 was sure");
                    assert_eq!(t.to_bits(), exact.meets_surely(&block.triangle(lane)).to_bits());
                    assert!(least[lane] <= t && t <= most[lane], "{} {t} {}", least[lane], most[lane]);
                    assert!(most[lane] - least[lane] < 1e-2 * t, "{} {}", least[lane], most[lane]);
                    sure += 1;
                }
                (passed, hit, tested) = (passed + u32::from(passes), hit + u32::from(meets.is_some()), tested + 1);
            }
        }
    }
    assert!(hit > 2000 && passed < hit + tested / 1000, "{passed} of {tested} pass for {hit} hits");
    assert!(sure > hit * 9 / 10, "{sure} of {hit}");
}

#[test]
fn no_ray_leaves_a_closed_sphere_and_the_fast_mode_is_nearly_as_good() {
    for (centre, radius) in [(Vec3::ZERO, 1.0), (Vec3::new(148376.0, 1234.0, -223423.0), 1.0)] {
        let triangles = sphere(centre, radius, 24);
        let bvh = median_split(&triangles, 8);
        let mut random = Random(17);
        let at_features = triangles.iter().flat_map(|t| {
            let [a, b, c] = t.v;
            [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5]
        });
        let directions: Vec<_> =
            at_features.map(|p| p - centre).chain((0..200_000).map(|_| random.point(2.0) - 1.0)).collect();
        for width in WIDTHS {
            let mut missed = [0, 0];
            for (fast, missed) in [false, true].into_iter().zip(&mut missed) {
                let tracer = Tracer::new(Kernel::Wide { width, fast }, &bvh, &triangles);
                let mut scratch = Scratch::default();
                for direction in &directions {
                    let ray = Ray::new(centre, *direction);
                    *missed += usize::from(tracer.trace(Query::Closest, &ray, &mut scratch, &mut ()).is_none());
                }
            }
            assert_eq!(missed[0], 0, "{width:?}");
            assert!(missed[1] < directions.len() / 50, "{width:?}: {}", missed[1]);
        }
    }
}

#[test]
fn the_fast_mode_finds_what_the_exact_one_finds_but_at_edges() {
    let triangles = soup(8, 2000, 0.1);
    let bvh = median_split(&triangles, 2);
    let [exact, fast] =
        [false, true].map(|fast| Tracer::new(Kernel::Wide { width: Width::Eight, fast }, &bvh, &triangles));
    let mut scratch = Scratch::default();
    let (mut hits, mut different) = (0, 0);
    for ray in rays(9, 20_000, any_ray) {
        let expected = exact.trace(Query::Closest, &ray, &mut scratch, &mut ());
        let found = fast.trace(Query::Closest, &ray, &mut scratch, &mut ());
        hits += usize::from(expected.is_some());
        different += usize::from(expected.map(|h| h.triangle) != found.map(|h| h.triangle));
    }
    assert!(hits > 5000 && different < hits / 500, "{different} of {hits}");
}
