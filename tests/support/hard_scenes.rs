//! Scenes that builders and kernels have stumbled over.

use bvh_lab::geom::Triangle;
use bvh_lab::scene::Scene;
use glam::Vec3;

/// Points, needles and collinear corners; then some of each among triangles that have an area, points on a line, and one point
/// again and again. Sixty each.
pub fn without_area() -> Vec<Vec<Triangle>> {
    let some = Scene::load("gen:soup:60").unwrap().triangles;
    let point = |t: &Triangle| Triangle::new(t.v[0], t.v[0], t.v[0]);
    let needle = |t: &Triangle| Triangle::new(t.v[0], t.v[1], t.v[0]);
    let along_x = |t: &Triangle| Triangle::new(t.v[0], t.v[0] + Vec3::X, t.v[0] - Vec3::X);
    let kinds: [&dyn Fn(&Triangle) -> Triangle; 3] = [&point, &needle, &along_x];
    let each = kinds.map(|kind| some.iter().map(kind).collect::<Vec<_>>());
    let mixed = some.iter().enumerate().map(|(i, t)| if i % 4 == 3 { *t } else { kinds[i % 4](t) }).collect();
    let on_a_line = (0..60).map(|i| point(&Triangle { v: [Vec3::X * i as f32; 3] })).collect();
    each.into_iter().chain([mixed, on_a_line, vec![point(&some[0]); 60]]).collect()
}

/// As many sizes as there are numbers, from the least to the greatest whose areas f64 can tell: depth grows with them. Every
/// triangle's box is a cube around the origin.
pub fn nested() -> Vec<Triangle> {
    let halves = (-140..120).map(|e| 2f64.powi(e) as f32);
    let corner = |h: f32, x: f32, y: f32, z: f32| Vec3::new(x, y, z) * h;
    let halves = halves.flat_map(|h| [h, 1.5 * h]);
    halves
        .map(|h| Triangle::new(corner(h, -1.0, -1.0, -1.0), corner(h, 1.0, 1.0, -1.0), corner(h, 1.0, -1.0, 1.0)))
        .collect()
}

/// Where [`far`] stands.
pub const FAR: Vec3 = Vec3::new(1e6, -1e6, 1e6);

/// A scene of size 1 at [`FAR`], rounded to what f32 has there: sixteenths.
pub fn far() -> Vec<Triangle> {
    let near = Scene::load("gen:soup:120").unwrap().triangles;
    near.iter().map(|t| Triangle { v: t.v.map(|p| p * 0.01 + FAR) }).collect()
}
