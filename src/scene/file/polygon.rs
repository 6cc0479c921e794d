//! Polygons cut into triangles.
//!
//! A polygon of n corners becomes n − 2 triangles: the fan from its first corner where no triangle of the fan is turned
//! over (every convex polygon, and any that its first corner sees whole), ear clipping otherwise. Both keep the area
//! of a simple planar polygon. Where there is no ear left (the outline crosses itself, or has no area) the next corner
//! is cut off as it comes. Polygons of more than 2,048 corners are always cut as a fan: clipping takes quadratic time.

use glam::{DVec2, DVec3, Vec3};

/// The most corners an outline may have to be clipped ear by ear.
const MOST_CLIPPED: usize = 2048;

/// Hands the triangles of the polygon to `push`, as places in `corners`; each keeps the polygon's winding.
pub(super) fn triangulate(corners: &[Vec3], mut push: impl FnMut(usize, usize, usize)) {
    if corners.len() > 3 && corners.iter().all(|corner| corner.is_finite()) {
        let flat = Flat::of(corners);
        let at = |i: usize| flat.place(corners[i]);
        let first = at(0);
        let folded = (1..corners.len() - 1).any(|i| turn(first, at(i), at(i + 1)) < 0.0);
        if folded && corners.len() <= MOST_CLIPPED {
            let outline: Vec<DVec2> = corners.iter().map(|&corner| flat.place(corner)).collect();
            return clip(&outline, push);
        }
    }
    (1..corners.len().saturating_sub(1)).for_each(|i| push(0, i, i + 1));
}

/// The plane of the axes other than the one a polygon's normal leans to most, its outline counter-clockwise in it.
struct Flat {
    origin: DVec3,
    u: DVec3,
    v: DVec3,
}

impl Flat {
    fn of(corners: &[Vec3]) -> Self {
        let origin = corners[0].as_dvec3();
        let local = |corner: Vec3| corner.as_dvec3() - origin;
        let normal: DVec3 = corners.windows(2).map(|pair| local(pair[0]).cross(local(pair[1]))).sum();
        let size = normal.abs();
        let (u, v, along) = if size.x >= size.y && size.x >= size.z {
            (DVec3::Y, DVec3::Z, normal.x)
        } else if size.y >= size.z {
            (DVec3::Z, DVec3::X, normal.y)
        } else {
            (DVec3::X, DVec3::Y, normal.z)
        };
        let (u, v) = if along < 0.0 { (v, u) } else { (u, v) };
        Self { origin, u, v }
    }

    fn place(&self, corner: Vec3) -> DVec2 {
        let p = corner.as_dvec3() - self.origin;
        DVec2::new(p.dot(self.u), p.dot(self.v))
    }
}

/// Ear clipping (Meisters 1975): cuts off, again and again, the first convex corner whose triangle holds no other.
fn clip(outline: &[DVec2], mut push: impl FnMut(usize, usize, usize)) {
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut at = 1;
    while left.len() > 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i % n], left[(i + 1) % n]];
        let ear = (at..at + n).find(|&i| is_ear(outline, &left, corner(i))).unwrap_or(at);
        let [a, b, c] = corner(ear);
        push(a, b, c);
        left.remove(ear % n);
        // From the next corner but one, so that a strip is not whittled down to slivers around one corner.
        at = (ear % n) + 1;
    }
    push(left[0], left[1], left[2]);
}

fn is_ear(outline: &[DVec2], left: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let (pa, pb, pc) = (outline[a], outline[b], outline[c]);
    if turn(pa, pb, pc) <= 0.0 {
        return false;
    }
    left.iter().all(|&i| {
        let p = outline[i];
        // A corner at the same place as one of the triangle's own is no obstacle: bridges to holes touch so.
        let own = p == pa || p == pb || p == pc;
        own || turn(pa, pb, p) < 0.0 || turn(pb, pc, p) < 0.0 || turn(pc, pa, p) < 0.0
    })
}

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Triangle;

    fn cut(corners: &[Vec3]) -> Vec<Triangle> {
        let mut triangles = Vec::new();
        triangulate(corners, |a, b, c| triangles.push(Triangle::new(corners[a], corners[b], corners[c])));
        triangles
    }

    fn flat(outline: &[(f32, f32)]) -> Vec<Vec3> {
        outline.iter().map(|&(x, y)| Vec3::new(x, y, 1.0)).collect()
    }

    /// The area by the shoelace formula, which needs no triangles.
    fn shoelace(corners: &[Vec3]) -> f64 {
        let next = corners.iter().cycle().skip(1);
        let sum: DVec3 = corners.iter().zip(next).map(|(a, b)| a.as_dvec3().cross(b.as_dvec3())).sum();
        let normal = sum.normalize();
        let moved = |p: &Vec3| (*p - corners[0]).as_dvec3();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(a, b)| moved(a).cross(moved(b)).dot(normal)).sum::<f64>().abs() / 2.0
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        let square = flat(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let expected = [[0, 1, 2], [0, 2, 3]].map(|t| Triangle { v: t.map(|i| square[i]) });
        assert_eq!(cut(&square), expected);
    }

    #[test]
    fn concave_polygons_keep_their_area_and_winding() {
        let arrow = flat(&[(0.0, 0.0), (2.0, 2.0), (0.0, 1.0), (-2.0, 2.0)]);
        let arrow_from_side: Vec<_> = (0..4).map(|i| arrow[(i + 1) % 4]).collect();
        let comb = flat(&[
            (0., 0.),
            (7., 0.),
            (7., 3.),
            (6., 3.),
            (6., 1.),
            (4., 1.),
            (4., 3.),
            (3., 3.),
            (3., 1.),
            (1., 1.),
            (1., 3.),
            (0., 3.),
        ]);
        let spiral = flat(&[
            (0., 0.),
            (5., 0.),
            (5., 5.),
            (1., 5.),
            (1., 2.),
            (3., 2.),
            (3., 3.),
            (2., 3.),
            (2., 4.),
            (4., 4.),
            (4., 1.),
            (0., 1.),
        ]);
        let with_hole =
            flat(&[(0., 0.), (4., 0.), (4., 4.), (0., 4.), (0., 0.), (1., 1.), (1., 3.), (3., 3.), (3., 1.), (1., 1.)]);
        for outline in [arrow, arrow_from_side, comb, spiral, with_hole] {
            for turned in [false, true] {
                for start in 0..outline.len() {
                    let mut corners: Vec<_> =
                        (0..outline.len()).map(|i| outline[(start + i) % outline.len()]).collect();
                    if turned {
                        corners.reverse();
                    }
                    for axes in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
                        let corners: Vec<_> = corners.iter().map(|p| Vec3::from(axes.map(|i| p[i]))).collect();
                        let triangles = cut(&corners);
                        assert_eq!(triangles.len(), corners.len() - 2);
                        let area: f64 = triangles.iter().map(Triangle::area).sum();
                        assert!((area - shoelace(&corners)).abs() < 1e-9, "{corners:?}: {area}");
                        let sum: DVec3 = triangles.iter().map(Triangle::cross).sum();
                        assert!(triangles.iter().all(|t| t.cross().dot(sum) >= 0.0));
                    }
                }
            }
        }
    }

    #[test]
    fn what_has_no_ears_still_gives_all_its_triangles() {
        let bow = flat(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0), (0.5, 3.0)]);
        assert_eq!(cut(&bow).len(), 3);
        assert_eq!(cut(&[Vec3::ONE; 6]).len(), 4);
        assert_eq!(cut(&flat(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.5, 0.0)])).len(), 2);
        let mut broken = bow;
        broken[1].x = f32::NAN;
        assert_eq!(cut(&broken).len(), 3);
        let zigzag: Vec<_> = (0..5000).map(|i| Vec3::new(i as f32, (i % 2) as f32, 0.0)).collect();
        assert_eq!(cut(&zigzag).len(), 4998);
        assert!(cut(&[Vec3::ZERO; 2]).is_empty() && cut(&[]).is_empty());
    }
}
