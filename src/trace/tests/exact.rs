//! `scalar` and `scalar-fast` against brute force, bit for bit; brute force against an f64 oracle.

use crate::bvh::Bvh;
use crate::bvh::testing::{Random, boxes, random_tree, soup};
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::trace::testing::{any_ray, grid_ray, grid_soup, median_split, sphere};
use crate::trace::{
    Arithmetic, FastTest, Oracle, Scratch, TriangleTest, Verdict, any_hit, brute_force, closest_hit, diffuse_rays,
};
use glam::Vec3;
use proptest::prelude::*;

fn bits(hit: Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|h| (h.triangle, h.t.to_bits()))
}

/// Asserts that a kernel answers as brute force does; returns whether there was a hit.
fn agrees<T: TriangleTest>(bvh: &Bvh, triangles: &[Triangle], ray: &Ray, scratch: &mut Scratch) -> bool {
    let expected = brute_force::<T>(triangles, ray);
    let found = closest_hit::<T, ()>(bvh, triangles, ray, scratch, &mut ());
    assert_eq!(bits(found), bits(expected), "{ray:?}, arity {}", bvh.arity);
    let any = any_hit::<T, ()>(bvh, triangles, ray, scratch, &mut ());
    assert_eq!(any, expected.is_some(), "{ray:?}");
    any
}

fn trees(seed: u64, triangles: &[Triangle]) -> Vec<Bvh> {
    let boxes = boxes(triangles);
    let sensible = [2, 3, 4, 8, 13].map(|arity| median_split(triangles, arity));
    let bad = [2, 4, 8].map(|arity| random_tree(seed, &boxes, arity, 4));
    sensible.into_iter().chain(bad).collect()
}

fn check_all(seed: u64, triangles: &[Triangle], rays: &[Ray]) -> usize {
    let mut scratch = Scratch::default();
    let mut hits = 0;
    for bvh in trees(seed, triangles) {
        for ray in rays {
            hits += usize::from(agrees::<WatertightRay>(&bvh, triangles, ray, &mut scratch));
            agrees::<FastTest>(&bvh, triangles, ray, &mut scratch);
        }
    }
    hits
}

fn rays(seed: u64, n: usize, make: fn(&mut Random) -> Ray) -> Vec<Ray> {
    let mut random = Random(seed);
    (0..n).map(|_| make(&mut random)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn scattered_triangles(seed in any::<u64>(), n in 1_usize..300, size in 0.001_f32..0.5) {
        check_all(seed, &soup(seed, n, size), &rays(!seed, 60, any_ray));
    }

    #[test]
    fn ties_shared_planes_and_zeros_of_either_sign(seed in any::<u64>(), n in 1_usize..120) {
        check_all(seed, &grid_soup(seed, n), &rays(!seed, 120, grid_ray));
    }

    #[test]
    fn intervals(seed in any::<u64>(), low in -2.0_f32..2.0, length in 0.0_f32..2.0) {
        let mut rays = rays(!seed, 60, any_ray);
        rays.extend(self::rays(seed, 60, grid_ray));
        for ray in &mut rays {
            (ray.t_min, ray.t_max) = (low.round(), (low + length).round());
        }
        check_all(seed, &soup(seed, 80, 0.4), &rays);
        check_all(seed, &grid_soup(seed, 80), &rays);
    }

    #[test]
    fn slivers_and_far_away(seed in any::<u64>(), n in 1_usize..100, offset in 0_i32..7) {
        let away = Vec3::new(1.0, -0.3, 0.7) * 10f32.powi(offset);
        let mut triangles = soup(seed, n, 0.5);
        for t in &mut triangles {
            t.v[2] = t.v[0] + (t.v[1] - t.v[0]) * 0.37 + t.v[2] * 1e-6;
            t.v = t.v.map(|p| p + away);
        }
        let mut random = Random(!seed);
        let rays: Vec<_> = (0..60)
            .map(|_| {
                let origin = random.point(3.0) - 1.0 + away;
                let target = &triangles[random.below(n)];
                Ray::new(origin, target.v[0] * 0.4 + target.v[1] * 0.6 - origin)
            })
            .collect();
        check_all(seed, &triangles, &rays);
    }

    #[test]
    fn extreme_scales(seed in any::<u64>(), exponent in -140_i32..100, along in -126_i32..100) {
        let scale = |p: Vec3, e: i32| (p.as_dvec3() * 2f64.powi(e)).as_vec3();
        let triangles: Vec<_> = soup(seed, 60, 0.4)
            .into_iter()
            .map(|t| Triangle { v: t.v.map(|p| scale(p, exponent)) })
            .collect();
        let rays: Vec<_> = rays(!seed, 40, any_ray)
            .into_iter()
            .map(|r| Ray::new(scale(r.origin, exponent), scale(r.direction, along)))
            .collect();
        check_all(seed, &triangles, &rays);
    }
}

/// From far away the f32 triangle test reports hits of rays that pass beside the triangle, and even beside its box.
#[test]
fn far_rays_past_edges_agree_with_brute_force_in_trees_of_single_triangles() {
    let mut random = Random(31);
    let mut scratch = Scratch::default();
    let mut hits = 0;
    for seed in 0..40 {
        let triangles = soup(seed, 40, 0.3);
        let bvh = random_tree(seed, &boxes(&triangles), 4, 1);
        for _ in 0..500 {
            let [a, b, _] = triangles[random.below(40)].v;
            let origin = (random.point(2.0) - 1.0) * 10f32.powi(2 + random.below(5) as i32);
            let target = a + (b - a) * random.unit();
            let ray = Ray::new(origin, target - origin);
            hits += usize::from(agrees::<FastTest>(&bvh, &triangles, &ray, &mut scratch));
            agrees::<WatertightRay>(&bvh, &triangles, &ray, &mut scratch);
        }
    }
    assert!(hits > 1000);
}

#[test]
fn scaling_by_a_power_of_two_scales_t_and_nothing_else() {
    let triangles = soup(4, 200, 0.2);
    let bvh = median_split(&triangles, 4);
    let mut scratch = Scratch::default();
    for exponent in [-60, -3, 20, 62] {
        let factor = 2f32.powi(exponent);
        let scaled: Vec<_> = triangles.iter().map(|t| Triangle { v: t.v.map(|p| p * factor) }).collect();
        let scaled_bvh = median_split(&scaled, 4);
        for ray in rays(5, 300, any_ray) {
            let hit = closest_hit::<WatertightRay, ()>(&bvh, &triangles, &ray, &mut scratch, &mut ());
            let far = Ray::new(ray.origin * factor, ray.direction);
            let scaled_hit = closest_hit::<WatertightRay, ()>(&scaled_bvh, &scaled, &far, &mut scratch, &mut ());
            assert_eq!(hit.map(|h| Hit { t: h.t * factor, ..h }), scaled_hit);
        }
    }
}

#[test]
fn watertight_hits_are_those_of_an_f64_oracle() {
    let triangles = soup(11, 400, 0.3);
    let (mut hits, mut borders) = (0, 0);
    for ray in rays(12, 3000, any_ray) {
        let oracle = Oracle::new(&triangles, &ray, Arithmetic::Watertight);
        let found = brute_force::<WatertightRay>(&triangles, &ray);
        let verdict = oracle.judge(found);
        assert!(verdict.is_right(), "{verdict:?} {found:?} {ray:?}");
        hits += usize::from(found.is_some());
        borders += usize::from(verdict == Verdict::Border);
    }
    assert!(hits > 1000 && borders < 3, "{hits} {borders}");
}

#[test]
fn no_ray_leaves_a_closed_sphere() {
    let mut fast_misses = 0;
    for (centre, radius) in [(Vec3::ZERO, 1.0), (Vec3::new(148376.0, 1234.0, -223423.0), 1.0)] {
        let triangles = sphere(centre, radius, 24);
        let bvh = median_split(&triangles, 4);
        let mut scratch = Scratch::default();
        let mut random = Random(17);
        let mut origins = vec![centre];
        origins.extend((0..3).map(|_| centre + random.point(0.6) - 0.3));
        for origin in origins {
            let at_features = triangles.iter().flat_map(|t| {
                let [a, b, c] = t.v;
                [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5]
            });
            let directions = at_features.map(|p| p - origin).chain((0..20_000).map(|_| random.point(2.0) - 1.0));
            for direction in directions.collect::<Vec<_>>() {
                let ray = Ray::new(origin, direction);
                let hit = closest_hit::<WatertightRay, ()>(&bvh, &triangles, &ray, &mut scratch, &mut ());
                assert!(hit.is_some(), "{ray:?}");
                let fast = closest_hit::<FastTest, ()>(&bvh, &triangles, &ray, &mut scratch, &mut ());
                fast_misses += usize::from(fast.is_none());
            }
        }
    }
    eprintln!("scalar-fast misses {fast_misses} rays");
}

#[test]
fn coincident_triangles_give_the_lowest_id() {
    let mut triangles = vec![Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y); 300];
    triangles.extend(sphere(Vec3::new(0.0, 0.0, 9.0), 1.0, 4));
    triangles.swap(0, 310);
    let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z);
    for bvh in trees(1, &triangles) {
        let hit = closest_hit::<WatertightRay, ()>(&bvh, &triangles, &ray, &mut Scratch::default(), &mut ());
        assert_eq!(hit, Some(Hit { triangle: 1, t: 1.0 }), "arity {}", bvh.arity);
    }
}

#[test]
fn all_26_directions_with_either_sign_of_zero() {
    let triangles = sphere(Vec3::ZERO, 2.0, 6);
    let walls = grid_soup(8, 60);
    let mut rays = Vec::new();
    for i in 0..5_usize.pow(3) {
        let part = |k: u32| [-1.0, -0.0, 0.0, 1.0, 1.0][i / 5_usize.pow(k) % 5];
        let direction = Vec3::new(part(0), part(1), part(2));
        for origin in [Vec3::ZERO, Vec3::new(0.5, 0.25, 0.125), Vec3::new(1.0, 2.0, 0.0), Vec3::new(-3.0, 1.0, 1.0)] {
            rays.push(Ray::new(origin, direction));
        }
    }
    assert!(check_all(3, &triangles, &rays) > 1000);
    assert!(check_all(3, &walls, &rays) > 1000);
    let positive_zeros = |r: &Ray| Ray::new(r.origin + Vec3::ZERO, r.direction + Vec3::ZERO);
    for ray in &rays {
        let answers = [*ray, positive_zeros(ray)].map(|r| bits(brute_force::<WatertightRay>(&walls, &r)));
        assert_eq!(answers[0], answers[1], "{ray:?}");
    }
}

#[test]
fn planar_scenes_are_hit_across_and_missed_along() {
    let floor: Vec<_> = (0..50)
        .map(|i| {
            let at = Vec3::new((i % 7) as f32, 0.0, (i / 7) as f32);
            Triangle::new(at, at + Vec3::X, at + Vec3::Z)
        })
        .collect();
    let mut scratch = Scratch::default();
    for bvh in trees(2, &floor) {
        let mut hit = |o: Vec3, d: Vec3| {
            closest_hit::<WatertightRay, ()>(&bvh, &floor, &Ray::new(o, d), &mut scratch, &mut ()).map(|h| h.t)
        };
        assert_eq!(hit(Vec3::new(3.25, 5.0, 2.25), Vec3::new(-0.0, -1.0, 0.0)), Some(5.0));
        assert_eq!(hit(Vec3::new(3.25, -5.0, 2.25), Vec3::new(0.0, 2.0, -0.0)), Some(2.5));
        for zero in [0.0, -0.0] {
            assert_eq!(hit(Vec3::new(-1.0, zero, 0.25), Vec3::new(1.0, zero, zero)), None);
            assert_eq!(hit(Vec3::new(0.25, zero, 0.25), Vec3::new(0.3, -zero, 0.7)), None);
        }
    }
}

#[test]
fn rays_that_leave_a_convex_surface_do_not_come_back_and_walls_do_not_leak() {
    for (centre, radius) in [(Vec3::ZERO, 1.0), (Vec3::new(3e3, -2e3, 5e2), 7.0), (Vec3::ZERO, 1e-5)] {
        let triangles = sphere(centre, radius, 16);
        let bvh = median_split(&triangles, 4);
        let mut random = Random(5);
        let primary: Vec<_> = (0..3000)
            .map(|_| {
                let origin = centre + (random.point(2.0) - 1.0).normalize() * radius * 4.0;
                Ray::new(origin, centre + (random.point(1.6) - 0.8) * radius - origin)
            })
            .collect();
        let leaving = diffuse_rays(&bvh, &triangles, &primary, 3);
        assert!(leaving.len() > 2000, "{}", leaving.len());
        for ray in leaving {
            assert!(!any_hit::<WatertightRay, ()>(&bvh, &triangles, &ray, &mut Scratch::default(), &mut ()), "{ray:?}");
        }
    }
    // Two walls 10⁻⁴ of the scene apart, far from the origin: what starts between them stays between them.
    let wall = |x: f32| {
        let corner = Vec3::new(1000.0 + x, 1000.0, 1000.0);
        Triangle::new(corner, corner + Vec3::Y * 99.0, corner + Vec3::Z * 99.0)
    };
    let walls = [wall(0.0), wall(0.01)];
    let bvh = median_split(&walls, 2);
    let mut random = Random(6);
    let primary: Vec<_> = (0..1000)
        .map(|_| Ray::new(Vec3::new(1000.005, 1020.0, 1020.0), (random.point(2.0) - 1.0) * Vec3::new(1.0, 0.01, 0.01)))
        .collect();
    for ray in diffuse_rays(&bvh, &walls, &primary, 3) {
        let steep = ray.direction.x.abs() > 0.01;
        let found = closest_hit::<WatertightRay, ()>(&bvh, &walls, &ray, &mut Scratch::default(), &mut ());
        assert!(found.is_some() || !steep, "{ray:?}");
    }
}
