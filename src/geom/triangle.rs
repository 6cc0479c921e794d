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
        match self.moller_trumbore(ray, EPSILON..=f32::INFINITY) {
            Outcome::Hit(t) if t > EPSILON => Some(t),
            _ => None,
        }
    }

    /// Möller–Trumbore (1997) without thresholds: two-sided, t in the ray's interval, both ends included. Returns t; a NaN
    /// anywhere is a miss.
    ///
    /// In f32, but for what f32 over- or underflows in: that is done again in f64.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<f32> {
        match self.moller_trumbore(ray, Self::F32_DETERMINANTS) {
            Outcome::Hit(t) => Some(t),
            Outcome::Miss => None,
            Outcome::OutOfRange => self.intersect_f64(ray),
        }
    }

    /// Determinants e₁·(d×e₂) that f32 is precise enough for: below 2⁻⁸⁰ what underflows in them may matter.
    pub(crate) const F32_DETERMINANTS: std::ops::RangeInclusive<f32> = f32::from_bits((127 - 80) << 23)..=f32::MAX;

    #[inline(always)]
    fn moller_trumbore(&self, ray: &Ray, determinants: std::ops::RangeInclusive<f32>) -> Outcome {
        let (e1, e2) = (self.v[1] - self.v[0], self.v[2] - self.v[0]);
        let p = ray.direction.cross(e2);
        let det = e1.dot(p);
        // Written so that NaN fails each test.
        if !determinants.contains(&det.abs()) {
            return Outcome::OutOfRange;
        }
        let inv = 1.0 / det;
        let s = ray.origin - self.v[0];
        let u = s.dot(p) * inv;
        if !(0.0..=1.0).contains(&u) {
            return if u.is_finite() { Outcome::Miss } else { Outcome::OutOfRange };
        }
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * inv;
        if !(v >= 0.0 && u + v <= 1.0) {
            return if v.is_finite() { Outcome::Miss } else { Outcome::OutOfRange };
        }
        let t = e2.dot(q) * inv;
        if t >= ray.t_min && t <= ray.t_max {
            Outcome::Hit(t)
        } else if t.is_finite() {
            Outcome::Miss
        } else {
            Outcome::OutOfRange
        }
    }

    /// The same in f64, in which nothing over- or underflows for any f32.
    #[cold]
    fn intersect_f64(&self, ray: &Ray) -> Option<f32> {
        let [a, b, c] = self.v.map(|p| p.as_dvec3());
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (e1, e2, s) = (b - a, c - a, o - a);
        let (p, q) = (d.cross(e2), s.cross(e1));
        let det = e1.dot(p);
        let (u, v, t) = (s.dot(p) / det, d.dot(q) / det, (e2.dot(q) / det) as f32);
        // A determinant of 0 makes them infinite or NaN.
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        (inside && t >= ray.t_min && t <= ray.t_max).then_some(t)
    }
}

/// What the test in f32 comes to.
enum Outcome {
    Hit(f32),
    Miss,
    /// Something was too large or too small.
    OutOfRange,
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
    fn no_scale_is_too_small_or_too_large_for_the_f32_test() {
        for exponent in [-140, -100, -60, 0, 41, 80, 120] {
            let scale = |p: Vec3| (p.as_dvec3() * 2f64.powi(exponent)).as_vec3();
            let triangle = Triangle { v: T.v.map(|p| scale(p * 4.0)) };
            for direction in [Vec3::NEG_Z, scale(Vec3::NEG_Z)] {
                let t = scale(Vec3::ONE).x / direction.z.abs();
                assert_eq!(triangle.intersect(&Ray::new(scale(Vec3::ONE), direction)), Some(t), "2^{exponent}");
                let beside = Ray::new(scale(Vec3::new(-1.0, 1.0, 1.0)), direction);
                assert_eq!(triangle.intersect(&beside), None, "2^{exponent}");
            }
        }
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
