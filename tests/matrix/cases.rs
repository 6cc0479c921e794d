//! The rows that are judged ray by ray: a scene, rays, and what is asked beyond agreement with the oracle.

use crate::hard_scenes::{FAR, far, nested, without_area};
use crate::rays::{Random, both_zeros, broken, from_inside, mixed, towards};
use crate::scenes::{floor, grid, overlapping, scaled, sphere, thin_gap, walls};
use bvh_lab::build::{Brake, BuildOptions, Input, find};
use bvh_lab::geom::{Hit, Ray, Triangle};
use bvh_lab::scene::Scene;
use bvh_lab::trace::diffuse_rays;
use glam::{DVec3, Vec3};

/// The seed of all rays and scenes; printed with the table.
pub const SEED: u64 = 20_261_127;

/// What is asked beyond agreement with the oracle.
pub enum Demand {
    /// Nothing more.
    Oracle,
    /// The kernels that are watertight miss no ray: the mesh is closed, or no ray can pass.
    NoMiss,
    /// Those kernels hit nothing.
    NoHit,
    /// Rays stand in pairs that every kernel answers alike.
    Pairs,
    /// Every kernel but the thesis' answers just this.
    Exactly(Vec<Option<Hit>>),
}

pub struct Case {
    pub row: u8,
    pub what: String,
    pub triangles: Vec<Triangle>,
    pub rays: Vec<Ray>,
    pub demand: Demand,
}

fn case(row: u8, what: impl Into<String>, triangles: Vec<Triangle>, rays: Vec<Ray>, demand: Demand) -> Case {
    Case { row, what: what.into(), triangles, rays, demand }
}

fn by_oracle(row: u8, what: impl Into<String>, triangles: Vec<Triangle>) -> Case {
    let rays = mixed(&triangles, SEED + u64::from(row), 210);
    case(row, what, triangles, rays, Demand::Oracle)
}

fn generated(spec: &str) -> Vec<Triangle> {
    Scene::load(spec).unwrap().triangles
}

pub fn all() -> Vec<Case> {
    let parts = [closed(), zeros(), flat(), small(), numbers(), intervals(), secondary(), shapes()];
    let mut cases: Vec<_> = parts.into_iter().flatten().collect();
    cases.sort_by_key(|c| c.row);
    cases
}

/// Rows 1 and 2; with 10⁷ rays in `watertight.rs`.
fn closed() -> Vec<Case> {
    let here = sphere(Vec3::ZERO, 1.0, 4);
    let there = sphere(Vec3::new(148_376.0, 1234.0, -223_423.0), 2.0, 4);
    let inside = |triangles: &[Triangle]| from_inside(triangles, SEED, 400);
    vec![
        case(1, "closed sphere from inside", here.clone(), inside(&here), Demand::NoMiss),
        case(2, "the same far away", there.clone(), inside(&there), Demand::NoMiss),
    ]
}

/// Rows 3 and 4.
fn zeros() -> Vec<Case> {
    let grid = grid(SEED, 100);
    let corners: Vec<_> = (0..27).map(|i| Vec3::new((i % 3) as f32, (i / 3 % 3) as f32, (i / 9) as f32)).collect();
    let inside = [Vec3::ZERO, Vec3::new(0.1, 0.2, 0.3), Vec3::new(-3.0, 0.5, 0.25), Vec3::new(0.5, 5.0, 0.5)];
    let soup = overlapping(SEED, 100);
    vec![
        case(3, "origins on slab planes", grid.clone(), both_zeros(&corners), Demand::Pairs),
        case(4, "26 directions, sphere", sphere(Vec3::ZERO, 1.0, 3), both_zeros(&inside), Demand::Pairs),
        case(4, "26 directions, soup", soup, both_zeros(&inside), Demand::Pairs),
        case(4, "26 directions, grid", grid, both_zeros(&inside), Demand::Pairs),
    ]
}

/// Rows 5 and 6.
fn flat() -> Vec<Case> {
    let floor = floor(49);
    let random = &mut Random::new(SEED);
    let across: Vec<Ray> = (0..200)
        .map(|i| {
            let on = floor[random.below(49)].v[0] + Vec3::new(0.25, 0.0, 0.5);
            let height = if i % 2 == 0 { 5.0 } else { -5.0 };
            Ray::new(on + Vec3::Y * height, Vec3::Y * -height)
        })
        .collect();
    let along = (0..200).map(|i| {
        let zero = if i % 2 == 0 { 0.0 } else { -0.0 };
        let d = [Vec3::new(1.0, zero, zero), Vec3::new(zero, -zero, -1.0), Vec3::new(0.3, zero, 0.7)][i % 3];
        Ray::new(Vec3::new(random.below(15) as f32 * 0.5 - 1.0, zero, random.below(15) as f32 * 0.5 - 1.0), d)
    });
    let along = along.collect();
    let mut cases = vec![
        case(5, "across a plane", floor.clone(), across, Demand::NoMiss),
        case(5, "along a plane", floor.clone(), along, Demand::NoHit),
        by_oracle(5, "any rays at a plane", floor),
    ];
    for (i, triangles) in without_area().into_iter().enumerate() {
        let demand = if i == 3 { Demand::Oracle } else { Demand::NoHit };
        let rays = mixed(&triangles, SEED, 140);
        cases.push(case(6, format!("no area, kind {}", i + 1), triangles, rays, demand));
    }
    cases
}

/// Rows 7 to 9.
fn small() -> Vec<Case> {
    let front = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);
    let mut coincident = vec![front; 120];
    coincident[0] = Triangle { v: front.v.map(|p| p + Vec3::Z) };
    let at = |i: usize| Ray::new(Vec3::new(0.125, 0.25, -1.0), Vec3::new(0.0, 0.0, 1.0 + (i % 4) as f32));
    let rays: Vec<_> = (0..40).map(at).collect();
    let lowest = rays.iter().map(|ray| Some(Hit { triangle: 1, t: 1.0 / ray.direction.z })).collect();
    let concentric = (0..120).map(|i| Triangle {
        v: [Vec3::new(-1.0, -1.0, 0.0), Vec3::new(3.0, -1.0, 0.0), Vec3::new(-2.0, 2.0, 0.0)]
            .map(|p| p * (1.0 + (i % 30) as f32)),
    });
    let mut cases = vec![
        case(7, "coincident: lowest id", coincident.clone(), rays, Demand::Exactly(lowest)),
        by_oracle(7, "coincident", coincident),
        by_oracle(7, "coincident centres", concentric.collect()),
    ];
    cases.extend((1..=9).map(|n| by_oracle(8, format!("{n} triangles"), generated(&format!("gen:soup:{n}")))));
    cases.push(by_oracle(9, "nested, family", generated("gen:nested:120")));
    cases.push(by_oracle(9, "nested, deepest", nested()));
    cases
}

/// Rows 11, 13 and 14.
fn numbers() -> Vec<Case> {
    let soup = generated("gen:soup:100");
    let bad = broken(Ray::new(Vec3::new(0.5, 0.25, -200.0), Vec3::new(0.1, 0.1, 1.0)));
    let nothing = vec![None; bad.len()];
    let tiny = scaled(&soup, -146);
    let unit_directions = mixed(&tiny, SEED, 140).into_iter().map(|ray| {
        let direction = ray.direction.as_dvec3().normalize_or(DVec3::X).as_vec3();
        Ray { t_min: 0.0, t_max: f32::INFINITY, direction, ..ray }
    });
    // As long as they may be without being normal numbers, in a scene so small that f32 holds t.
    let small = scaled(&soup, -9);
    let tiny_directions = mixed(&small, SEED, 140).into_iter().map(|ray| Ray {
        direction: (ray.direction.as_dvec3() * 2f64.powi(-127)).as_vec3(),
        t_min: 0.0,
        t_max: f32::INFINITY,
        ..ray
    });
    vec![
        case(11, "rays that are none", soup.clone(), bad, Demand::Exactly(nothing)),
        case(13, "denormal scene", tiny.clone(), unit_directions.collect(), Demand::Oracle),
        by_oracle(13, "denormal scene and directions", tiny),
        case(13, "denormal directions", small, tiny_directions.collect(), Demand::Oracle),
        by_oracle(14, "about 1e19", soup.iter().map(|t| Triangle { v: t.v.map(|p| p * 1e17) }).collect()),
        by_oracle(14, "about 1e37", scaled(&soup, 117)),
    ]
}

/// Row 16: walls at t = 1, 2, … along the x axis, so that every t is a number of f32.
fn intervals() -> Vec<Case> {
    const WALLS: usize = 40;
    let random = &mut Random::new(SEED);
    let (mut rays, mut hits) = (Vec::new(), Vec::new());
    for _ in 0..200 {
        let (low, length) = ((1 + random.below(WALLS + 2)) as f32, random.below(4) as f32);
        let at = |t: f32| (t as usize <= WALLS).then(|| Hit { triangle: t as u32 - 1, t });
        let straight = Ray::new(Vec3::new(-1.0, 0.5, 1.0), Vec3::X);
        let none = (low.next_up(), (low + 1.0).next_down());
        for (t_min, t_max, hit) in [
            (low, low + length, at(low)),
            (low, low, at(low)),
            (low.next_up(), low + 1.0, at(low + 1.0)),
            (none.0, none.1, None),
        ] {
            rays.push(Ray { t_min, t_max, ..straight });
            hits.push(hit);
        }
    }
    vec![case(16, "hits at the ends of the interval", walls(WALLS), rays, Demand::Exactly(hits))]
}

/// Row 17.
fn secondary() -> Vec<Case> {
    let mut cases = Vec::new();
    let places = [
        (Vec3::ZERO, 1.0, "here"),
        (Vec3::new(3e3, -2e3, 5e2), 7.0, "far"),
        (Vec3::new(148_376.0, 1234.0, -223_423.0), 900.0, "farther"),
        (Vec3::ZERO, 1e-5, "tiny"),
        (Vec3::ZERO, 1e15, "huge"),
    ];
    let random = &mut Random::new(SEED);
    for (centre, radius, name) in places {
        let triangles = sphere(centre, radius, 3);
        let c = centre.as_dvec3();
        let mut outside = || c + random.in_cube().normalize_or(DVec3::X) * radius * 4.0;
        let from: Vec<_> = (0..200).map(|_| outside()).collect();
        let primary: Vec<_> = from.iter().map(|&o| towards(o, c + random.in_cube() * radius * 0.7)).collect();
        let leaving = diffuse(&triangles, &primary);
        assert!(leaving.len() > 150, "{}", leaving.len());
        cases.push(case(17, format!("leaving a sphere, {name}"), triangles, leaving, Demand::NoHit));
    }
    let gap = thin_gap(5);
    let middle = DVec3::new(1000.005, 1050.0, 1050.0);
    let primary: Vec<_> = (0..400)
        .map(|_| {
            let from = middle + random.in_cube() * DVec3::new(0.004, 40.0, 40.0);
            towards(from, from + random.in_cube() * DVec3::new(1.0, 0.1, 0.1))
        })
        .collect();
    let kept: Vec<_> = diffuse(&gap, &primary).into_iter().filter(|ray| ray.direction.x.abs() > 0.01).collect();
    assert!(kept.len() > 300, "{}", kept.len());
    cases.push(case(17, "between walls 1e-4 apart", gap, kept, Demand::NoMiss));
    cases
}

fn diffuse(triangles: &[Triangle], primary: &[Ray]) -> Vec<Ray> {
    let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
    let builder = find("binned-sah").unwrap();
    let bvh = (builder.timed)(Input::of_boxes(&boxes), &BuildOptions::default(), &mut Brake::default()).unwrap();
    diffuse_rays(&bvh, triangles, primary, SEED)
}

/// Rows 18 and 22 to 24.
fn shapes() -> Vec<Case> {
    let close = mixed(&far(), SEED, 140);
    let from_origin =
        far().iter().map(|t| towards(DVec3::ZERO, t.v[0].as_dvec3() * 0.5 + t.v[1].as_dvec3() * 0.5)).collect();
    let span = far().iter().flat_map(|t| t.v).fold(0.0, |far: f32, p| far.max((p - FAR).abs().max_element()));
    assert!(span <= 2.0, "a scene of size 1: {span}");
    vec![
        by_oracle(18, "overlapping boxes", overlapping(SEED, 120)),
        by_oracle(22, "teapot in a stadium", generated("gen:stadium:130")),
        by_oracle(23, "slivers", generated("gen:slivers:120")),
        by_oracle(23, "hairball", generated("gen:hairball:120")),
        case(24, "far from the origin", far(), close, Demand::Oracle),
        case(24, "far away, seen from the origin", far(), from_origin, Demand::Oracle),
    ]
}
