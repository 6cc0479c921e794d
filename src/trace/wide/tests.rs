//! The wide kernels against brute force, against their scalar twin, and at every set of instructions.

use super::layout::Block;
use super::node::Node;
use super::pack::Portable;
use super::pack64::Portable64;
use super::search::twin;
use super::watertight::Found;
use super::{Fast, GridNode, Leaves, Watertight, WideBvh};
use crate::bvh::Bvh;
use crate::bvh::testing::{Random, boxes, random_tree, soup};
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::simd::Simd;
use crate::trace::closest::{Any, Closest, Goal, accepted, held};
use crate::trace::slab::Slabs;
use crate::trace::testing::{any_ray, grid_ray, grid_soup, median_split, sphere};
use crate::trace::{
    Bits, HitRecord, KERNELS, Kernel, Query, Scratch, TraceCounters, Tracer, Width, brute_force, leave_surface,
};
use glam::Vec3;
use proptest::prelude::*;

fn bits(hit: Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|h| (h.triangle, h.t.to_bits()))
}

const WIDTHS: [Width; 2] = [Width::Four, Width::Eight];

/// All kernels that search by these files, and those of them that answer as brute force.
fn kernels() -> impl Iterator<Item = Kernel> {
    KERNELS.iter().map(|info| info.kernel).filter(|kernel| kernel.is_wide())
}

fn exact_kernels() -> impl Iterator<Item = Kernel> {
    kernels().filter(|kernel| kernel.is_exact())
}

/// What the scalar twin answers and counts; `None` where the ray is not for f32 boxes.
fn by_twin(
    kernel: Kernel,
    query: Query,
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
) -> Option<(Option<Hit>, TraceCounters)> {
    fn answer<const W: usize, N: Node<W>, L: Leaves>(
        wide: &WideBvh<W, N>,
        query: Query,
        ray: &Ray,
    ) -> Option<(Option<Hit>, TraceCounters)> {
        let (mut work, scratch) = (TraceCounters::default(), &mut Scratch::default());
        let hit = match query {
            Query::Closest => twin::<W, N, Closest, L, _>(wide, ray, scratch, &mut work).ok()?,
            Query::Any => twin::<W, N, Any, L, _>(wide, ray, scratch, &mut work).ok()?.map(|_| Kernel::SOME_HIT),
        };
        Some((hit, work))
    }
    let four = || WideBvh::<4>::new(bvh, triangles);
    let eight = || WideBvh::<8>::new(bvh, triangles);
    match kernel {
        Kernel::Wide { width: Width::Four, fast: false } => answer::<4, _, Watertight>(&four(), query, ray),
        Kernel::Wide { width: Width::Four, fast: true } => answer::<4, _, Fast>(&four(), query, ray),
        Kernel::Wide { width: Width::Eight, fast: false } => answer::<8, _, Watertight>(&eight(), query, ray),
        Kernel::Wide { width: Width::Eight, fast: true } => answer::<8, _, Fast>(&eight(), query, ray),
        Kernel::Quantised(Bits::Eight) => answer::<8, GridNode<8, u8>, Watertight>(&eight().of_nodes(), query, ray),
        Kernel::Quantised(Bits::Sixteen) => answer::<8, GridNode<8, u16>, Watertight>(&eight().of_nodes(), query, ray),
        other => panic!("{other:?} is not wide"),
    }
}

/// Trees of every arity that kernels take as they are, divide or collapse; some of them bad.
fn trees(seed: u64, triangles: &[Triangle]) -> Vec<Bvh> {
    let boxes = boxes(triangles);
    let sensible = [2, 3, 4, 8, 13].map(|arity| median_split(triangles, arity));
    let bad = [2, 4, 8, 16].map(|arity| random_tree(seed, &boxes, arity, 7));
    sensible.into_iter().chain(bad).collect()
}

/// Holds every exact kernel, at every level, to brute force; returns the hits.
fn check(seed: u64, triangles: &[Triangle], rays: &[Ray]) -> usize {
    let expected: Vec<_> = rays.iter().map(|ray| brute_force::<WatertightRay>(triangles, ray)).collect();
    let mut scratch = Scratch::default();
    for bvh in trees(seed, triangles) {
        for kernel in exact_kernels() {
            let tracer = Tracer::new(kernel, &bvh, triangles);
            for level in Simd::available() {
                let tracer = tracer.clone().at_level(level);
                for (ray, expected) in rays.iter().zip(&expected) {
                    let found = tracer.trace(Query::Closest, ray, &mut scratch, &mut ());
                    assert_eq!(bits(found), bits(*expected), "{kernel:?} {level:?} arity {} {ray:?}", bvh.arity);
                    let any = tracer.trace(Query::Any, ray, &mut scratch, &mut ());
                    assert_eq!(any.is_some(), expected.is_some(), "{kernel:?} {level:?} {ray:?}");
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
        for (kernel, query) in kernels().flat_map(|k| [Query::Closest, Query::Any].map(|q| (k, q))) {
            let tracer = Tracer::new(kernel, &bvh, &triangles);
            for ray in rays(!seed, 12, any_ray) {
                let Some(expected) = by_twin(kernel, query, &bvh, &triangles, &ray) else { continue };
                for level in Simd::available() {
                    let mut work = TraceCounters::default();
                    let hit = tracer.clone().at_level(level).trace(query, &ray, &mut Scratch::default(), &mut work);
                    prop_assert_eq!((bits(hit), work), (bits(expected.0), expected.1), "{:?} {:?} {:?}", kernel, level, ray);
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

/// Tests every block alone, and holds what is found to the test of one triangle in its own box.
fn check_blocks(wide: &WideBvh<8>, ray: &Ray, counts: &mut Counts) {
    let slabs = Slabs::within(ray, wide.reach, Slabs::LIMIT).unwrap();
    let exact = WatertightRay::new(ray);
    for block in &wide.blocks {
        let found = four::<Closest>(&exact, ray, block);
        let enough = four::<Any>(&exact, ray, block);
        // Where any hit is enough more of them are sure, and nothing else is different.
        assert_eq!(enough.surely | enough.held, found.surely | found.held);
        assert_eq!((enough.surely & found.surely, enough.perhaps), (found.surely, found.perhaps));
        counts.enough += (enough.surely & found.held).count_ones() as usize;
        assert_eq!((found.surely | found.held | found.perhaps) >> block.count, 0);
        assert_eq!(found.surely & (found.held | found.perhaps) | found.held & found.perhaps, 0);
        for lane in 0..block.count as usize {
            let alone = accepted(&exact, slabs, ray, &block.triangle(lane));
            counts.hits += usize::from(alone.is_some());
            if found.perhaps >> lane & 1 == 1 {
                counts.perhaps += 1;
                continue;
            }
            assert!(enough.surely >> lane & 1 == 0 || alone.is_some(), "{ray:?} {:?}", block.triangle(lane));
            let t = if found.held >> lane & 1 == 1 {
                counts.held += 1;
                held(found.t[lane], slabs, ray, &block.triangle(lane))
            } else {
                (found.surely >> lane & 1 == 1).then_some(found.t[lane])
            };
            assert_eq!(t.map(f32::to_bits), alone.map(f32::to_bits), "{ray:?} {:?}", block.triangle(lane));
        }
    }
}

#[derive(Debug, Default)]
struct Counts {
    hits: usize,
    held: usize,
    /// Of those held, the sure ones where any hit is enough.
    enough: usize,
    perhaps: usize,
}

/// The test of four triangles, by plain Rust.
fn four<G: Goal>(exact: &WatertightRay, ray: &Ray, block: &Block) -> Found {
    super::watertight::test::<Portable<4>, Portable64, G>(exact, ray, block)
}

#[test]
fn four_at_once_are_right_where_they_are_sure_and_mostly_sure() {
    for (scale, offset) in
        [(1.0, Vec3::ZERO), (1e-20, Vec3::ZERO), (1e15, Vec3::ZERO), (1.0, Vec3::new(4e4, -7e3, 2e5))]
    {
        let triangles = sphere(offset, scale, 32);
        let wide = WideBvh::<8>::new(&median_split(&triangles, 8), &triangles);
        let mut random = Random(3);
        let (mut far, mut left) = (Counts::default(), Counts::default());
        for _ in 0..300 {
            let direction = (random.point(2.0) - 1.0).normalize();
            let from = direction * 3.0 * scale + offset;
            let ray = Ray::new(from, random.point(1.2 * scale) - 0.6 * scale + offset - from);
            check_blocks(&wide, &ray, &mut far);
            // From a triangle just hit, back to where the ray came from.
            if let Some(hit) = brute_force::<WatertightRay>(&triangles, &ray) {
                let start = leave_surface(&ray, &hit, &triangles[hit.triangle as usize]);
                check_blocks(&wide, &Ray::new(start, from - start), &mut left);
            }
        }
        assert!(far.hits > 300 && far.perhaps < far.hits / 20, "{} of {}", far.perhaps, far.hits);
        assert!(left.perhaps < 15, "{}", left.perhaps);
    }
}

#[test]
fn rays_into_the_surface_that_they_start_on_are_not_tested_alone() {
    let triangles = sphere(Vec3::ZERO, 1.0, 3);
    let wide = WideBvh::<8>::new(&median_split(&triangles, 8), &triangles);
    let mut random = Random(4);
    let mut counts = Counts::default();
    for _ in 0..300 {
        let from = random.point(6.0) - 3.0;
        let ray = Ray::new(from, random.point(1.0) - 0.5 - from);
        if let Some(hit) = brute_force::<WatertightRay>(&triangles, &ray) {
            let start = leave_surface(&ray, &hit, &triangles[hit.triangle as usize]);
            check_blocks(&wide, &Ray::new(start, ray.direction), &mut counts);
        }
    }
    assert!(counts.enough > 100 && counts.perhaps < 5, "{counts:?}");
}

proptest! {
    #[test]
    fn four_at_once_are_right_about_needles_and_planes(seed: u64) {
        let mut random = Random(seed);
        let triangles = grid_soup(seed, 40);
        let wide = WideBvh::<8>::new(&median_split(&triangles, 8), &triangles);
        for _ in 0..20 {
            let ray = grid_ray(&mut random);
            if ray.is_traceable() && Slabs::within(&ray, wide.reach, Slabs::LIMIT).is_some() {
                check_blocks(&wide, &ray, &mut Counts::default());
            }
        }
    }

    #[test]
    fn four_at_once_are_right_about_needles_along_the_ray(seed: u64) {
        let mut random = Random(seed);
        let direction = random.point(2.0) - 1.0;
        let along = |random: &mut Random| direction * random.point(4.0).x;
        let triangles: Vec<_> = (0..40)
            .map(|_| {
                let thin = f32::from_bits((127 - 40 + random.below(40) as u32) << 23);
                Triangle { v: [(); 3].map(|()| along(&mut random) + random.point(thin) - thin * 0.5) }
            })
            .collect();
        let wide = WideBvh::<8>::new(&median_split(&triangles, 8), &triangles);
        for _ in 0..20 {
            let ray = Ray::new(along(&mut random) - direction, direction);
            if ray.is_traceable() && Slabs::within(&ray, wide.reach, Slabs::LIMIT).is_some() {
                check_blocks(&wide, &ray, &mut Counts::default());
            }
        }
    }

    #[test]
    fn many_at_once_are_answered_as_one_by_one(seed: u64, few in 0usize..5) {
        let mut random = Random(seed);
        let triangles = soup(seed, 60, 0.4);
        let bvh = median_split(&triangles, 2);
        let far = Ray::new(Vec3::splat(1e38), Vec3::NEG_ONE);
        let none = Ray::new(Vec3::ZERO, Vec3::ZERO);
        let mut rays: Vec<Ray> = (0..few * 7).map(|_| any_ray(&mut random)).collect();
        rays.extend([far, none, any_ray(&mut random), far]);
        for info in KERNELS {
            let tracer = Tracer::new(info.kernel, &bvh, &triangles);
            for (level, query) in Simd::available().flat_map(|l| [(l, Query::Closest), (l, Query::Any)]) {
                let tracer = tracer.clone().at_level(level);
                let (mut one, mut all) = (TraceCounters::default(), TraceCounters::default());
                let mut answers = vec![HitRecord::MISS; rays.len()];
                let scratch = &mut Scratch::default();
                let expected: Vec<HitRecord> =
                    rays.iter().map(|ray| tracer.trace(query, ray, scratch, &mut one).into()).collect();
                tracer.trace_all(query, &rays, &mut answers, scratch, &mut all);
                prop_assert_eq!((&answers, all), (&expected, one), "{} {:?}", info.id, level);
            }
        }
    }
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
