//! Whether boxes that hold parts of a triangle together hold all of it.
//!
//! The triangle is cut up until each piece lies in one of the boxes, or in none. Boxes are drawn larger by
//! [`TOLERANCE`], so that the rounding of cuts (2⁻⁵³) loses nothing; a gap that is wider is found, be it between boxes
//! that touch the triangle in one point only.

use crate::geom::{Aabb, Polygon, Triangle, cut};
use glam::DVec3;

/// How much larger boxes are drawn, in parts of the triangle's longest extent.
const TOLERANCE: f64 = 1.0 / (1 << 26) as f64;

/// Boxes up to this many are taken from a piece one after the other; more are parted first.
const FEW: usize = 8;

/// A box in f64.
#[derive(Clone, Copy)]
struct Wide {
    min: DVec3,
    max: DVec3,
}

/// Whether every point of `triangle` lies in one of `boxes`, within the tolerance.
///
/// Time is near r log r for r boxes that part the triangle among themselves, as spatial splits make them.
pub(super) fn is_covered(triangle: &Triangle, boxes: &[Aabb]) -> bool {
    let whole = triangle.aabb();
    let margin = whole.extent().max_element() * TOLERANCE;
    let wide = |b: &Aabb| Wide { min: b.min.as_dvec3() - margin, max: b.max.as_dvec3() + margin };
    let corners: Polygon = triangle.v.iter().map(|p| p.as_dvec3()).collect();
    let mut pending = vec![(corners, boxes.iter().map(wide).collect::<Vec<_>>())];
    while let Some((piece, mut boxes)) = pending.pop() {
        let (low, high) = bounds(&piece);
        boxes.retain(|b| b.min.cmple(high).all() && b.max.cmpge(low).all());
        if boxes.iter().any(|b| b.min.cmple(low).all() && b.max.cmpge(high).all()) {
            continue;
        }
        if let Some((axis, at)) = middle_face(&boxes, low, high) {
            let sides = [-1.0, 1.0].map(|side| cut(&piece, axis, at, side));
            pending.extend(sides.into_iter().filter(|side| !side.is_empty()).map(|side| (side, boxes.clone())));
            continue;
        }
        let Some(taken) = boxes.pop() else { return false };
        pending.extend(beyond(piece, &taken).map(|rest| (rest, boxes.clone())));
    }
    true
}

/// Corners of the box around a polygon.
fn bounds(polygon: &Polygon) -> (DVec3, DVec3) {
    polygon.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)))
}

/// Where there are many boxes, the middle one of their faces between `low` and `high` on the axis on which these are
/// farthest apart.
fn middle_face(boxes: &[Wide], low: DVec3, high: DVec3) -> Option<(usize, f64)> {
    if boxes.len() <= FEW {
        return None;
    }
    let axis = (high - low).max_position();
    let faces = boxes.iter().flat_map(|b| [b.min[axis], b.max[axis]]);
    let mut faces: Vec<f64> = faces.filter(|&at| low[axis] < at && at < high[axis]).collect();
    let middle = faces.len() / 2;
    (!faces.is_empty()).then(|| (axis, *faces.select_nth_unstable_by(middle, f64::total_cmp).1))
}

/// The pieces of a polygon that are left when what lies in `taken` is taken away: up to six.
fn beyond(piece: Polygon, taken: &Wide) -> impl Iterator<Item = Polygon> {
    let mut inside = piece;
    let faces = (0..3).flat_map(|axis| [(axis, taken.min[axis], 1.0), (axis, taken.max[axis], -1.0)]);
    faces.filter_map(move |(axis, at, side)| {
        let outside = |p: &DVec3| side * (p[axis] - at) < 0.0;
        // What only touches the face is inside.
        let rest = inside.iter().any(outside).then(|| cut(&inside, axis, at, -side));
        if rest.is_some() {
            inside = cut(&inside, axis, at, side);
        }
        rest.filter(|rest| !rest.is_empty())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{Random, soup};
    use glam::Vec3;

    fn floor() -> Triangle {
        Triangle::new(Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 4.0)
    }

    fn slab(x: f32, to: f32) -> Aabb {
        Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(to, 4.0, 0.0))
    }

    #[test]
    fn by_hand() {
        assert!(is_covered(&floor(), &[floor().aabb()]));
        assert!(is_covered(&floor(), &[slab(0.0, 1.0), slab(1.0, 4.0)]));
        assert!(is_covered(&floor(), &[slab(2.0, 4.0), slab(0.0, 3.0)]));
        assert!(!is_covered(&floor(), &[]));
        assert!(!is_covered(&floor(), &[slab(0.0, 1.0), slab(1.001, 4.0)]));
        assert!(!is_covered(&floor(), &[slab(0.0, 3.999)]), "a corner is missing");
        // The part above x = 2 is no higher than 2.
        let low = Aabb::new(Vec3::new(2.0, 0.0, 0.0), Vec3::new(4.0, 2.0, 0.0));
        assert!(is_covered(&floor(), &[slab(0.0, 2.0), low]));
        assert!(!is_covered(&floor(), &[slab(0.0, 1.9), low]));
        // Beside the triangle's plane.
        let beside = Aabb::new(Vec3::Z, Vec3::splat(4.0));
        assert!(!is_covered(&floor(), &[beside]));
        // Points and needles.
        let point = Triangle::new(Vec3::ONE, Vec3::ONE, Vec3::ONE);
        assert!(is_covered(&point, &[point.aabb()]) && !is_covered(&point, &[slab(0.0, 4.0)]));
        let needle = Triangle::new(Vec3::ZERO, Vec3::X * 2.0, Vec3::X * 4.0);
        assert!(is_covered(&needle, &[slab(0.0, 2.0), slab(2.0, 4.0)]));
        assert!(!is_covered(&needle, &[slab(0.0, 2.0), slab(2.1, 4.0)]));
    }

    #[test]
    fn cells_of_a_grid_cover_and_each_of_them_is_needed() {
        let mut random = Random(3);
        for (round, t) in soup(8, 60, 1.0).into_iter().enumerate() {
            let aabb = t.aabb();
            let planes: Vec<Vec<f32>> = (0..3)
                .map(|axis| {
                    let mut p: Vec<f32> = (0..1 + round % 9)
                        .map(|_| aabb.min[axis] + random.unit() * (aabb.max[axis] - aabb.min[axis]))
                        .collect();
                    p.extend([aabb.min[axis], aabb.max[axis]]);
                    p.sort_by(f32::total_cmp);
                    p
                })
                .collect();
            let mut cells = Vec::new();
            for x in planes[0].windows(2) {
                for y in planes[1].windows(2) {
                    for z in planes[2].windows(2) {
                        cells.push(Aabb::new(Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1])));
                    }
                }
            }
            assert!(is_covered(&t, &cells), "{round}");
            // A cell around a point of the triangle, not at the edge of the cell.
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p = t.v[0] + (t.v[1] - t.v[0]) * u + (t.v[2] - t.v[0]) * v;
            let inside = |c: &Aabb| (p - c.min).min_element().min((c.max - p).min_element()) > 1e-4;
            if let Some(needed) = cells.iter().position(inside) {
                cells.swap_remove(needed);
                assert!(!is_covered(&t, &cells), "{round}");
            }
        }
    }

    #[test]
    fn many_boxes_end_soon() {
        let n = 20_000;
        let slabs: Vec<_> = (0..n).map(|i| slab(4.0 * i as f32 / n as f32, 4.0 * (i + 1) as f32 / n as f32)).collect();
        assert!(is_covered(&floor(), &slabs));
        let mut gap = slabs.clone();
        gap.remove(n / 3);
        assert!(!is_covered(&floor(), &gap));
    }
}
