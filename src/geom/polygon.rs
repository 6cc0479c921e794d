//! Convex polygons cut by planes across the axes: Sutherland and Hodgman 1974, in f64.

use arrayvec::ArrayVec;
use glam::DVec3;

/// A triangle cut by six planes has at most nine corners.
pub(crate) type Polygon = ArrayVec<DVec3, 9>;

/// The part of the polygon with `side · (coordinate − at) ≥ 0`.
///
/// Corners on the plane are kept and new corners get the plane's own coordinate, so a polygon that lies in the plane is
/// kept whole.
pub(crate) fn cut(polygon: &Polygon, axis: usize, at: f64, side: f64) -> Polygon {
    let mut kept = Polygon::new();
    let Some(&last) = polygon.last() else {
        return kept;
    };
    let mut from = last;
    let mut from_distance = side * (from[axis] - at);
    for &to in polygon {
        let to_distance = side * (to[axis] - at);
        if (from_distance < 0.0) != (to_distance < 0.0) {
            let mut crossing = from + (to - from) * (from_distance / (from_distance - to_distance));
            crossing[axis] = at;
            push(&mut kept, crossing);
        }
        if to_distance >= 0.0 {
            push(&mut kept, to);
        }
        (from, from_distance) = (to, to_distance);
    }
    kept
}

/// Adds a corner. Rounding may make a polygon that is not quite convex and so has corners to spare; those that would
/// not fit lie on an edge as far as f64 can tell, and carry no area.
fn push(polygon: &mut Polygon, corner: DVec3) {
    if polygon.last() != Some(&corner) && !polygon.is_full() {
        polygon.push(corner);
    }
}

/// Area of a polygon.
pub(crate) fn polygon_area(polygon: &Polygon) -> f64 {
    let Some((&first, rest)) = polygon.split_first() else {
        return 0.0;
    };
    let twice = rest.windows(2).map(|edge| (edge[0] - first).cross(edge[1] - first)).sum::<DVec3>();
    0.5 * twice.length()
}
