//! Scenes of the matrix that no generator of the library has.

use crate::rays::Random;
use bvh_lab::geom::Triangle;
use glam::{DVec3, Vec3};

/// A closed sphere of 8 n² triangles: an octahedron, each face cut n times. Neighbours share their corners bit for bit.
pub fn sphere(centre: Vec3, radius: f64, n: i32) -> Vec<Triangle> {
    let corner = |[i, j]: [i32; 2], sign: DVec3| {
        let on_face = DVec3::new(f64::from(i), f64::from(j), f64::from(n - i - j)) * sign;
        (centre.as_dvec3() + on_face.normalize() * radius).as_vec3()
    };
    let mut triangles = Vec::new();
    for face in 0..8 {
        let sign = DVec3::from([0, 1, 2].map(|axis| if face >> axis & 1 == 0 { 1.0 } else { -1.0 }));
        let mut push = |a, b, c| triangles.push(Triangle { v: [a, b, c].map(|p| corner(p, sign)) });
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            push([i, j], [i + 1, j], [i, j + 1]);
            if i + j + 1 < n {
                push([i + 1, j], [i + 1, j + 1], [i, j + 1]);
            }
        }
    }
    triangles
}

/// Triangles on a grid of small integers: full of ties, shared planes and triangles without area.
pub fn grid(seed: u64, n: usize) -> Vec<Triangle> {
    let random = &mut Random::new(seed);
    let mut corner = || Vec3::from([(); 3].map(|()| random.below(4) as f32));
    (0..n).map(|_| Triangle { v: [(); 3].map(|()| corner()) }).collect()
}

/// Large triangles in the unit cube, whose boxes overlap nearly everywhere.
pub fn overlapping(seed: u64, n: usize) -> Vec<Triangle> {
    let random = &mut Random::new(seed);
    (0..n).map(|_| Triangle { v: [(); 3].map(|()| random.in_cube().as_vec3()) }).collect()
}

/// A floor of separate triangles in the plane y = 0, whose boxes have no thickness.
pub fn floor(n: usize) -> Vec<Triangle> {
    let at = |i: usize| Vec3::new((i % 7) as f32, 0.0, (i / 7) as f32);
    (0..n).map(|i| Triangle::new(at(i), at(i) + Vec3::X, at(i) + Vec3::Z)).collect()
}

/// Walls across the x axis at x = 0, 1, …, n − 1.
pub fn walls(n: usize) -> Vec<Triangle> {
    let wall = |x: f32| Triangle::new(Vec3::new(x, 0.0, 0.0), Vec3::new(x, 4.0, 0.0), Vec3::new(x, 0.0, 4.0));
    (0..n).map(|i| wall(i as f32)).collect()
}

/// Two walls, each of 2 n² triangles, a hundredth apart in a scene of size 100 that is far from the origin.
pub fn thin_gap(n: usize) -> Vec<Triangle> {
    let corner = |x: f32, i: usize, j: usize| {
        let step = 100.0 / n as f32;
        Vec3::new(1000.0 + x, 1000.0 + step * i as f32, 1000.0 + step * j as f32)
    };
    let quad = |x: f32, i: usize, j: usize| {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(x, i, j));
        [Triangle::new(a, b, c), Triangle::new(a, c, d)]
    };
    let cells = (0..n * n).map(|i| (i / n, i % n));
    cells.flat_map(|(i, j)| [0.0, 0.01].map(|x| quad(x, i, j)).into_iter().flatten()).collect()
}

/// The same scene, every coordinate times 2^`exponent`, rounded once where it becomes subnormal.
pub fn scaled(triangles: &[Triangle], exponent: i32) -> Vec<Triangle> {
    let scale = |p: Vec3| (p.as_dvec3() * 2f64.powi(exponent)).as_vec3();
    triangles.iter().map(|t| Triangle { v: t.v.map(scale) }).collect()
}
