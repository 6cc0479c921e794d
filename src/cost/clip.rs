//! The area of the part of a triangle that lies in a box.

use crate::geom::{Aabb, Polygon, Triangle, cut, polygon_area};
use glam::DVec3;

/// A triangle prepared for being clipped to many boxes.
pub(super) struct Clipped {
    corners: [DVec3; 3],
    /// Its bounding box.
    pub(super) aabb: Aabb,
    /// The area of the whole.
    pub(super) area: f64,
}

impl Clipped {
    pub(super) fn new(triangle: &Triangle) -> Self {
        Self { corners: triangle.v.map(|p| p.as_dvec3()), aabb: triangle.aabb(), area: triangle.area() }
    }

    /// Area of the part within `to`, whose faces belong to it.
    ///
    /// A triangle that lies in a face, or in a box without thickness, is cut as one in the inside: see [`cut`].
    pub(super) fn area_within(&self, to: &Aabb) -> f64 {
        let (low, high) = (self.aabb.min, self.aabb.max);
        if to.contains(&self.aabb) {
            return self.area;
        }
        let mut polygon: Polygon = self.corners.into_iter().collect();
        for axis in 0..3 {
            // Planes that the whole triangle is on the right side of cut nothing off.
            if low[axis] < to.min[axis] {
                polygon = cut(&polygon, axis, f64::from(to.min[axis]), 1.0);
            }
            if high[axis] > to.max[axis] {
                polygon = cut(&polygon, axis, f64::from(to.max[axis]), -1.0);
            }
        }
        polygon_area(&polygon)
    }
}

/// Whether the boxes have a point in common.
pub(super) fn overlap(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::Random;
    use glam::Vec3;

    fn within(triangle: [Vec3; 3], min: Vec3, max: Vec3) -> f64 {
        Clipped::new(&Triangle { v: triangle }).area_within(&Aabb::new(min, max))
    }

    #[test]
    fn by_hand() {
        let t = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 2.0];
        let everything = Vec3::splat(9.0);
        assert_eq!(within(t, -everything, everything), 2.0);
        assert_eq!(within(t, Vec3::NEG_ONE, Vec3::ONE), 1.0);
        assert_eq!(within(t, Vec3::new(1.0, -1.0, -1.0), everything), 0.5);
        assert_eq!(within(t, Vec3::new(3.0, 0.0, 0.0), everything), 0.0);
        // In a face, and in a box without thickness.
        assert_eq!(within(t, Vec3::ZERO, Vec3::ONE), 1.0);
        assert_eq!(within(t, Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)), 1.0);
        // A box that touches in an edge or a corner only, or lies in the triangle's box but beside it.
        assert_eq!(within(t, Vec3::new(-1.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 1.0)), 0.0);
        assert_eq!(within(t, Vec3::splat(-1.0), Vec3::ZERO), 0.0);
        assert_eq!(within(t, Vec3::new(1.5, 1.5, -1.0), Vec3::new(2.0, 2.0, 1.0)), 0.0);
        assert_eq!(within([Vec3::ONE; 3], Vec3::ZERO, everything), 0.0);
        assert_eq!(within(t, everything, -everything), 0.0);
        // All six planes cut: the hexagon of x + y + z = 0 in the cube of half edge 1.
        let t = [Vec3::new(20.0, -10.0, -10.0), Vec3::new(-10.0, 20.0, -10.0), Vec3::new(-10.0, -10.0, 20.0)];
        let hexagon = 3.0 * 3.0f64.sqrt();
        assert!((within(t, Vec3::NEG_ONE, Vec3::ONE) - hexagon).abs() < 1e-12);
    }

    #[test]
    fn the_cells_of_a_grid_share_out_the_triangle() {
        let mut random = Random(5);
        for round in 0..300 {
            let size = [1.0, 1e-3, 1e15][round % 3];
            let corner = |random: &mut Random| (random.point(1.2) - 0.1) * size;
            let t = Triangle::new(corner(&mut random), corner(&mut random), corner(&mut random));
            let clipped = Clipped::new(&t);
            // Cells of an uneven grid with inner planes at random, the outer ones beyond everything.
            let planes: Vec<Vec<f32>> = (0..3)
                .map(|_| {
                    let mut p: Vec<f32> = (0..4).map(|_| random.unit() * size).collect();
                    p.extend([-size, 2.0 * size]);
                    p.sort_by(f32::total_cmp);
                    p
                })
                .collect();
            let mut sum = 0.0;
            for x in planes[0].windows(2) {
                for y in planes[1].windows(2) {
                    for z in planes[2].windows(2) {
                        sum +=
                            clipped.area_within(&Aabb::new(Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1])));
                    }
                }
            }
            assert!((sum / t.area() - 1.0).abs() < 1e-11, "{sum} {}", t.area());
        }
    }

    #[test]
    fn boxes_overlap_where_they_touch() {
        let a = Aabb::new(Vec3::ZERO, Vec3::ONE);
        assert!(overlap(&a, &Aabb::new(Vec3::ONE, Vec3::splat(2.0))));
        assert!(!overlap(&a, &Aabb::new(Vec3::new(0.0, 0.0, 1.5), Vec3::splat(2.0))));
        assert!(!overlap(&a, &Aabb::EMPTY));
    }
}
