//! Rays at scenes of any size: through them, and at what is hard about them.

use bvh_lab::geom::{Aabb, Ray, Triangle};
use glam::{DVec3, Vec3};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng;

/// Seeded, the same everywhere.
pub struct Random(Pcg32);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0xb5))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / (1u64 << 32) as f64
    }

    /// Uniform in `0 .. n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// In the cube from −1 to 1.
    pub fn in_cube(&mut self) -> DVec3 {
        let mut side = || 2.0 * self.unit() - 1.0;
        DVec3::new(side(), side(), side())
    }
}

/// From one point towards another. In f64, so that it is right for numbers of any size.
pub fn towards(from: DVec3, to: DVec3) -> Ray {
    let origin = from.as_vec3();
    Ray::new(origin, (to - origin.as_dvec3()).as_vec3())
}

pub fn bounds(triangles: &[Triangle]) -> Aabb {
    triangles.iter().fold(Aabb::EMPTY, |b, t| b.union(&t.aabb()))
}

/// `n` rays of every kind: across the scene, from inside it, at the inside, a corner and the middle of an edge of some triangle,
/// along an axis, and with an interval that may end before a hit or begin behind it.
pub fn mixed(triangles: &[Triangle], seed: u64, n: usize) -> Vec<Ray> {
    let bounds = bounds(triangles);
    let (centre, half) =
        (bounds.centre(), (bounds.extent() * 0.5).max(DVec3::splat(bounds.extent().max_element() * 1e-3)));
    let random = &mut Random::new(seed);
    let ray = |i: usize| {
        let outside = centre + half * random.in_cube().normalize_or(DVec3::X) * (2.0 + random.unit());
        let inside = centre + half * random.in_cube();
        let [a, b, c] = triangles[random.below(triangles.len())].v.map(|p| p.as_dvec3());
        let (u, v) = (random.unit(), random.unit());
        let within = a + ((b - a) * u + (c - a) * (1.0 - u) * v) * 0.98;
        match i % 7 {
            0 => towards(outside, inside),
            1 => towards(inside, inside + half * random.in_cube()),
            2 => towards(outside, within),
            3 => towards(outside, [a, b, c][random.below(3)]),
            4 => towards(inside, [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5][random.below(3)]),
            5 => {
                let axis = random.below(3);
                let mut from = within;
                from[axis] = outside[axis];
                let mut direction = Vec3::ZERO;
                direction[axis] = (within[axis] - from[axis]) as f32;
                Ray::new(from.as_vec3(), direction)
            }
            _ => {
                let [near, far] = [0.9 + 0.2 * random.unit(), 1.0 + 0.5 * random.unit()].map(|t| t as f32);
                Ray { t_min: near, t_max: near.max(far), ..towards(outside, within) }
            }
        }
    };
    (0..n).map(ray).collect()
}

/// From inside a closed mesh: at every corner and every middle of an edge, then `n` times anywhere.
pub fn from_inside(triangles: &[Triangle], seed: u64, n: usize) -> Vec<Ray> {
    let bounds = bounds(triangles);
    let (centre, half) = (bounds.centre(), bounds.extent() * 0.25);
    let random = &mut Random::new(seed);
    let features = triangles.iter().flat_map(|t| {
        let [a, b, c] = t.v.map(|p| p.as_dvec3());
        [a, b, c, (a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5]
    });
    let mut rays: Vec<_> = features.map(|p| towards(centre, p)).collect();
    rays.extend((0..n).map(|_| {
        let from = centre + half * random.in_cube();
        towards(from, from + half * random.in_cube())
    }));
    rays
}

/// From every one of `origins` in all 26 directions along axes and diagonals; each ray followed by itself with the other sign of
/// every zero.
pub fn both_zeros(origins: &[Vec3]) -> Vec<Ray> {
    let directions = (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(|k| k as f32 - 1.0)).filter(|d| *d != [0.0; 3]);
    let directions: Vec<_> = directions.collect();
    let pair = |origin: Vec3, d: [f32; 3]| {
        let other = d.map(|x| if x == 0.0 { -x } else { x });
        [d, other].map(|d| Ray::new(origin, Vec3::from(d)))
    };
    origins.iter().flat_map(|&o| directions.iter().flat_map(move |&d| pair(o, d)).collect::<Vec<_>>()).collect()
}

/// Rays that are none, made from one that is.
pub fn broken(fine: Ray) -> Vec<Ray> {
    let mut rays = vec![
        Ray { direction: Vec3::ZERO, ..fine },
        Ray { direction: Vec3::new(-0.0, 0.0, -0.0), ..fine },
        Ray { t_min: f32::NAN, ..fine },
        Ray { t_max: f32::NAN, ..fine },
        Ray { t_min: 2.0, t_max: 1.0, ..fine },
    ];
    for value in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let (mut a, mut b) = (fine, fine);
            a.origin[axis] = value;
            b.direction[axis] = value;
            rays.extend([a, b]);
        }
    }
    rays
}
