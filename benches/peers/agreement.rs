//! Whether a library's hits are those of the laboratory's exact kernel, ray by ray.

use bvh_lab::geom::{Ray, Triangle};
use bvh_lab::trace::HitRecord;

/// How far two answers for t may lie apart, relative to t and to the size of the scene.
const T_TOLERANCE: f32 = 1e-4;
/// How near to an edge, in barycentric coordinates, a hit counts as one at the edge.
const EDGE: f64 = 1e-3;

/// How answers differ from the reference's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Where the nearer of the two hits is at an edge, or on a triangle without an area.
    pub at_edges: usize,
    /// Elsewhere.
    pub elsewhere: usize,
}

/// Holds answers against the reference's. Which of several triangles at the same t is named does not matter.
pub fn compare(
    triangles: &[Triangle],
    rays: &[Ray],
    expected: &[HitRecord],
    hits: &[HitRecord],
    size: f32,
) -> Difference {
    let mut found = Difference::default();
    for ((ray, expected), hit) in rays.iter().zip(expected).zip(hits) {
        let same = match (expected.is_hit(), hit.is_hit()) {
            (false, false) => true,
            (true, true) => (expected.t - hit.t).abs() <= T_TOLERANCE * expected.t.max(1e-2 * size),
            _ => false,
        };
        if same {
            continue;
        }
        // The nearer of the two was seen by one side alone: is it at an edge?
        let nearer = if hit.t < expected.t { hit } else { expected };
        let edge = triangles.get(nearer.triangle as usize).is_some_and(|t| at_edge(t, ray, nearer.t));
        if edge { found.at_edges += 1 } else { found.elsewhere += 1 }
    }
    found
}

/// Holds answers that are yes or no against the reference's; where rays pass is not told.
pub fn compare_occlusion(expected: &[HitRecord], hits: &[HitRecord]) -> Difference {
    let elsewhere = expected.iter().zip(hits).filter(|(expected, hit)| expected.is_hit() != hit.is_hit()).count();
    Difference { at_edges: 0, elsewhere }
}

/// Whether the ray at `t` is near an edge of the triangle, or beyond it.
fn at_edge(triangle: &Triangle, ray: &Ray, t: f32) -> bool {
    let [a, b, c] = triangle.v.map(|p| p.as_dvec3());
    let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(t);
    let normal = triangle.cross();
    let twice = normal.length_squared();
    let weight = |p: glam::DVec3, q: glam::DVec3| (q - p).cross(point - p).dot(normal) / twice;
    let inmost = weight(a, b).min(weight(b, c)).min(weight(c, a));
    // A triangle without an area has no weights: all of it is edge.
    inmost.is_nan() || inmost <= EDGE
}
