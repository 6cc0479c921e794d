//! The conservative box test of the exact kernels: the interval of t in which a ray is inside a box.
//!
//! Three properties carry the kernels:
//! 1. **Conservative.** The interval contains the true one, as far as it lies at t ≥ 0: the exit is padded by 2⁻²¹ of itself,
//!    above the 1 + 2γ₃ that Ize ("Robust BVH Ray Traversal", JCGT 2(2), 2013) derives for two distances of three roundings
//!    each. In f32 the padding is in the inverse direction that exits are computed with, whose rounding is a seventh.
//! 2. **Monotone.** Subtraction, multiplication by a constant, minimum and maximum are monotone in floating point, so a
//!    box that contains another has the earlier entry and the later exit, rounding included.
//! 3. **No NaN.** A direction component of 0 (either sign) gives ±∞ for a slab beside or around the origin, and 0·∞ = NaN
//!    for an origin exactly on a plane. All comparisons are written so that NaN changes nothing: the boundary belongs to
//!    the box, and +0 and −0 give the same answer.

use crate::geom::{Aabb, Ray};
use glam::{BVec3A, DVec3, Vec3, Vec3A};

/// Relative padding: 8 roundings of f32.
pub(super) const RELATIVE: f32 = 1.0 / (1 << 21) as f32;
/// Absolute padding (2⁻¹⁴⁰), for distances so small that rounding is no longer relative.
pub(super) const ABSOLUTE: f32 = f32::from_bits(1 << 9);

/// A bound that `t` stays below whatever the rounding of the distances it is compared with; monotone in `t`.
#[inline(always)]
pub(super) fn pad_up(t: f32) -> f32 {
    let factor = if t < 0.0 { 1.0 - RELATIVE } else { 1.0 + RELATIVE };
    t * factor + ABSOLUTE
}

/// A ray prepared for box tests.
pub(super) trait SlabTest: Copy {
    /// Entry and padded exit of `aabb`; the ray's line misses the box where the entry exceeds the exit.
    fn interval(&self, aabb: &Aabb) -> (f32, f32);
}

/// The greater, the second where the first is NaN.
#[inline(always)]
fn later<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The lesser, the second where the first is NaN.
#[inline(always)]
fn sooner<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// In f32: for every ray whose inverse direction and differences stay in range.
#[derive(Clone, Copy)]
pub(super) struct Slabs {
    pub(super) origin: Vec3A,
    pub(super) inverse: Vec3A,
    /// `inverse`, padded: what exits are computed with.
    pub(super) padded: Vec3A,
    pub(super) negative: BVec3A,
}

/// The greatest |coordinate| of a box.
pub(super) fn reach(aabb: &Aabb) -> f32 {
    aabb.min.abs().max(aabb.max.abs()).max_element()
}

impl Slabs {
    /// Up to which coordinates of the scene and of a ray f32 serves: 2¹²⁵, so that sums of two and their inverses are normal
    /// numbers.
    pub(super) const LIMIT: f32 = f32::from_bits((127 + 125) << 23);

    /// Up to which coordinates products of three overflow nowhere: 2⁴⁰.
    pub(super) const PRODUCT_LIMIT: f32 = (1u64 << 40) as f32;

    /// Of no ray.
    pub(super) const IDLE: Self =
        Self { origin: Vec3A::ZERO, inverse: Vec3A::ZERO, padded: Vec3A::ZERO, negative: BVec3A::FALSE };

    /// Prepares a traceable `ray` for a tree whose root box is `root`; `None` where only [`WideSlabs`] is safe.
    #[inline(always)]
    pub(super) fn new(ray: &Ray, root: &Aabb) -> Option<Self> {
        Self::within(ray, reach(root), Self::LIMIT)
    }

    /// Prepares `ray` for a tree with no coordinate beyond `reach`. `None` where f32 would overflow or lose relative precision,
    /// with `limit` at most [`Self::LIMIT`]; where hits behind the origin count; and where the ray is not traceable.
    #[inline(always)]
    pub(super) fn within(ray: &Ray, reach: f32, limit: f32) -> Option<Self> {
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
        let size = direction.abs();
        let zero = size.cmpeq(Vec3A::ZERO);
        // All false for NaN.
        let large = size.cmpge(Vec3A::splat(1.0 / Self::LIMIT)) & size.cmple(Vec3A::splat(limit));
        let fits = (large | zero) & origin.abs().cmple(Vec3A::splat(limit));
        let sound = fits.all() && !zero.all() && reach <= limit && ray.t_min >= 0.0 && ray.t_min <= ray.t_max;
        sound.then(|| Self::of(ray))
    }

    /// Prepares a ray that [`Self::within`] takes.
    #[inline(always)]
    pub(super) fn of(ray: &Ray) -> Self {
        let inverse = Vec3A::from(ray.direction).recip();
        Self {
            origin: Vec3A::from(ray.origin),
            inverse,
            padded: inverse * (1.0 + RELATIVE),
            // −0 is negative here, as its inverse −∞ is.
            negative: inverse.cmplt(Vec3A::ZERO),
        }
    }
}

impl SlabTest for Slabs {
    #[inline(always)]
    fn interval(&self, aabb: &Aabb) -> (f32, f32) {
        let (min, max) = (Vec3A::from(aabb.min), Vec3A::from(aabb.max));
        let near = (Vec3A::select(self.negative, max, min) - self.origin) * self.inverse;
        let far = (Vec3A::select(self.negative, min, max) - self.origin) * self.padded;
        let entry = later(near.z, later(near.y, later(near.x, f32::NEG_INFINITY)));
        let exit = sooner(far.z, sooner(far.y, sooner(far.x, f32::INFINITY)));
        (entry, exit + ABSOLUTE)
    }
}

/// In f64: no finite f32 over- or underflows.
#[derive(Clone, Copy)]
pub(super) struct WideSlabs {
    origin: DVec3,
    inverse: DVec3,
    negative: glam::BVec3,
}

impl WideSlabs {
    /// Prepares `ray`.
    pub(super) fn new(ray: &Ray) -> Self {
        let inverse = ray.direction.as_dvec3().recip();
        Self { origin: ray.origin.as_dvec3(), inverse, negative: inverse.cmplt(DVec3::ZERO) }
    }
}

impl SlabTest for WideSlabs {
    #[inline]
    fn interval(&self, aabb: &Aabb) -> (f32, f32) {
        let near = (Vec3::select(self.negative, aabb.max, aabb.min).as_dvec3() - self.origin) * self.inverse;
        let far = (Vec3::select(self.negative, aabb.min, aabb.max).as_dvec3() - self.origin) * self.inverse;
        let entry = later(near.z, later(near.y, later(near.x, f64::NEG_INFINITY)));
        let exit = sooner(far.z, sooner(far.y, sooner(far.x, f64::INFINITY)));
        // Rounding to f32 is monotone and far inside the padding.
        (entry as f32, pad_up(exit as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb::new(Vec3::ZERO, Vec3::ONE);

    fn hits(origin: Vec3, direction: Vec3, aabb: &Aabb) -> bool {
        let ray = Ray::new(origin, direction);
        let answer = |(entry, exit): (f32, f32)| entry <= exit && exit >= ray.t_min;
        let wide = answer(WideSlabs::new(&ray).interval(aabb));
        if let Some(slabs) = Slabs::new(&ray, aabb) {
            assert_eq!(answer(slabs.interval(aabb)), wide, "{ray:?}");
        }
        wide
    }

    #[test]
    fn the_boundary_belongs_to_the_box_for_either_sign_of_zero() {
        let flat = Aabb::new(Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0));
        for zero in [0.0, -0.0] {
            for y in [0.0, -0.0, 0.5, 1.0] {
                assert!(hits(Vec3::new(-1.0, y, 0.5), Vec3::new(1.0, zero, zero), &UNIT), "{y} {zero}");
            }
            for y in [-1e-30, 1.0000001] {
                assert!(!hits(Vec3::new(-1.0, y, 0.5), Vec3::new(1.0, zero, zero), &UNIT), "{y} {zero}");
            }
            assert!(hits(Vec3::new(-1.0, 0.0, 0.5), Vec3::new(1.0, zero, zero), &flat));
            assert!(hits(Vec3::ZERO, Vec3::new(zero, zero, 1.0), &UNIT));
        }
        assert!(!hits(Vec3::splat(0.5), Vec3::X, &Aabb::EMPTY));
    }

    #[test]
    fn extreme_rays_take_the_wide_path_and_hit() {
        for d in [1e-40_f32, 1e-45, 3e38] {
            let ray = Ray::new(Vec3::splat(0.5), Vec3::new(d, d, d));
            assert!(Slabs::new(&ray, &UNIT).is_none());
            assert!(hits(ray.origin, ray.direction, &UNIT));
        }
        let tiny = Aabb::new(Vec3::ZERO, Vec3::splat(1e-44));
        assert!(hits(Vec3::new(-1e-44, 0.0, 0.0), Vec3::new(3.0, 1.0, 0.0), &tiny));
    }

    #[test]
    fn padding_is_monotone_and_outward() {
        let mut last = f32::NEG_INFINITY;
        for t in [f32::NEG_INFINITY, -1e38, -1.0, -1e-40, 0.0, 1e-45, 1e-20, 1.0, 1.0000001, 1e38, f32::INFINITY] {
            assert!(pad_up(t) >= t && pad_up(t) >= last);
            last = pad_up(t);
        }
    }
}
