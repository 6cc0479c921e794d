//! Triangles and the ray–triangle test of the thesis' program.

use super::{Aabb, Ray};
use glam::{DVec3, Vec3};

/// A triangle as its three vertices, in scene units.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Triangle {
    /// The vertices; counter-clockwise seen from outside.
    pub v: [Vec3; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle in its scene.
    pub triangle: u32,
    /// Ray parameter.
    pub t: f32,
}

impl Triangle {
    /// A triangle from three vertices.
    pub const fn new(a: Vec3, b: Vec3, c: Vec3) -> Self {
        Self { v: [a, b, c] }
    }

    /// Whether every coordinate is a finite number.
    pub fn is_finite(&self) -> bool {
        self.v.iter().all(|p| p.is_finite())
    }

    /// Its bounding box.
    pub fn aabb(&self) -> Aabb {
        Aabb::around(self.v)
    }

    /// Twice the area times the unit normal, in f64 from the f32 vertices.
    pub fn cross(&self) -> DVec3 {
        let [a, b, c] = self.v.map(|p| p.as_dvec3());
        (b - a).cross(c - a)
    }

    /// Area, in f64.
    pub fn area(&self) -> f64 {
        0.5 * self.cross().length()
    }

    /// Möller–Trumbore (1997) as the thesis' program has it: two-sided, |det| < 10⁻⁶ is a miss, t must exceed 10⁻⁶
    /// and lie in the ray's interval. Returns t.
    ///
    /// Both thresholds are absolute, so the test is not invariant under scaling the scene; that is the original's.
    #[inline]
    pub fn intersect_published(&self, ray: &Ray) -> Option<f32> {
        const EPSILON: f32 = 1e-6;
        let t = self.moller_trumbore(ray, EPSILON)?;
        (t > EPSILON).then_some(t)
    }

    /// Möller–Trumbore (1997) with no threshold but division by zero: two-sided, t in the ray's interval, both ends
    /// included. Returns t; a NaN anywhere is a miss.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<f32> {
        self.moller_trumbore(ray, f32::MIN_POSITIVE)
    }

    #[inline(always)]
    fn moller_trumbore(&self, ray: &Ray, least_det: f32) -> Option<f32> {
        let (e1, e2) = (self.v[1] - self.v[0], self.v[2] - self.v[0]);
        let p = ray.direction.cross(e2);
        let det = e1.dot(p);
        if det.abs() < least_det || det.is_nan() {
            return None;
        }
        let inv = 1.0 / det;
        // Written so that NaN fails each test.
        let s = ray.origin - self.v[0];
        let u = s.dot(p) * inv;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * inv;
        if !(v >= 0.0 && u + v <= 1.0) {
            return None;
        }
        let t = e2.dot(q) * inv;
        (t >= ray.t_min && t <= ray.t_max).then_some(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: Triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);

    #[test]
    fn hits_from_both_sides_and_misses_beside() {
        for z in [-1.0, 1.0] {
            let at = |x, y| Ray::new(Vec3::new(x, y, z), Vec3::new(0.0, 0.0, -z));
            assert_eq!(T.intersect(&at(0.25, 0.25)), Some(1.0));
            assert_eq!(T.intersect_published(&at(0.25, 0.25)), Some(1.0));
            assert_eq!(T.intersect(&at(0.75, 0.75)), None);
            assert_eq!(T.intersect(&at(-0.1, 0.5)), None);
        }
    }

    #[test]
    fn interval_is_closed_and_nan_misses() {
        let mut ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        (ray.t_min, ray.t_max) = (1.0, 1.0);
        assert_eq!(T.intersect(&ray), Some(1.0));
        ray.t_min = 1.0000001;
        assert_eq!(T.intersect(&ray), None);
        let nan = Ray::new(Vec3::splat(f32::NAN), Vec3::NEG_Z);
        assert_eq!(T.intersect(&nan), None);
        let nan = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::splat(f32::NAN));
        assert_eq!(T.intersect(&nan), None);
    }

    #[test]
    fn published_thresholds_are_absolute() {
        let small = Triangle::new(Vec3::ZERO, Vec3::X * 1e-4, Vec3::Y * 1e-4);
        let ray = Ray::new(Vec3::new(1e-5, 1e-5, 1.0), Vec3::NEG_Z);
        assert_eq!(small.intersect_published(&ray), None);
        assert!(small.intersect(&ray).is_some());
        let near = Ray::new(Vec3::new(0.25, 0.25, 5e-7), Vec3::NEG_Z);
        assert_eq!(T.intersect_published(&near), None);
        assert!(T.intersect(&near).is_some());
    }
}
