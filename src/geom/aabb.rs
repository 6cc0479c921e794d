//! Axis-aligned bounding boxes and the only surface area of the crate.

use glam::{DVec3, Vec3};

/// An axis-aligned bounding box; empty when any `min` component exceeds its `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner, in scene units.
    pub min: Vec3,
    /// Upper corner, in scene units.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing: the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// A box from two corners.
    pub const fn new(min: Vec3, max: Vec3) -> Self {
        Self { min, max }
    }

    /// The smallest box around all `points`.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| b.union(&Self::new(p, p)))
    }

    /// The smallest box around all `boxes`.
    pub fn union_of<'a>(boxes: impl IntoIterator<Item = &'a Self>) -> Self {
        boxes.into_iter().fold(Self::EMPTY, |a, b| a.union(b))
    }

    /// The smallest box around both.
    ///
    /// Written as comparisons, not `f32::min`: one instruction each, and the same result in every vectorisation.
    /// The boxes a builder sees hold no NaN (loaders drop such triangles, builders refuse such boxes).
    #[inline(always)]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: Vec3::new(
                lower(self.min.x, other.min.x),
                lower(self.min.y, other.min.y),
                lower(self.min.z, other.min.z),
            ),
            max: Vec3::new(
                upper(self.max.x, other.max.x),
                upper(self.max.y, other.max.y),
                upper(self.max.z, other.max.z),
            ),
        }
    }

    /// Surface area 2(xy + yz + zx) in f64, so that no finite f32 box overflows; 0 for an empty box.
    ///
    /// Corners are widened before they are subtracted. Minima, maxima, differences and products are monotone, so a
    /// box inside another never has the larger area, rounding included.
    #[inline(always)]
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        area_of_extent(self.extent())
    }

    /// Edge lengths in f64 (negative where the box is empty).
    #[inline(always)]
    pub fn extent(&self) -> DVec3 {
        self.max.as_dvec3() - self.min.as_dvec3()
    }

    /// Centre (min + max)/2 in f64: exact to one rounding, and free of overflow.
    #[inline(always)]
    pub fn centre(&self) -> DVec3 {
        (self.min.as_dvec3() + self.max.as_dvec3()) * 0.5
    }

    /// Whether the box holds no point.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Whether `other` lies inside (shared boundaries count); the empty box lies inside every box.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || (self.min.cmple(other.min).all() && self.max.cmpge(other.max).all())
    }

    /// Whether every corner is a finite number and `min` does not exceed `max`.
    pub fn is_valid(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && !self.is_empty()
    }
}

/// The smaller of two numbers, as boxes are united: one instruction, the same result in every vectorisation.
#[inline(always)]
pub(crate) fn lower(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// The larger of two numbers: see [`lower`].
#[inline(always)]
pub(crate) fn upper(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Surface area of a box that is not empty, from its edge lengths: see [`Aabb::surface_area`].
#[inline(always)]
pub fn area_of_extent(e: DVec3) -> f64 {
    2.0 * (e.x * e.y + e.y * e.z + e.z * e.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn area_of_a_brick_and_of_nothing() {
        let b = Aabb::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(b.surface_area(), 22.0);
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
        assert_eq!(Aabb::new(Vec3::ONE, Vec3::ONE).surface_area(), 0.0);
    }

    #[test]
    fn area_does_not_overflow_where_f32_would() {
        let b = Aabb::new(Vec3::splat(-1e19), Vec3::splat(1e19));
        let side = 2.0 * f64::from(1e19_f32);
        assert_eq!(b.surface_area(), 6.0 * side * side);
        let whole = Aabb::new(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX));
        assert!(whole.surface_area().is_finite() && whole.centre() == DVec3::ZERO);
    }

    #[test]
    fn empty_is_neutral_and_inside_everything() {
        let b = Aabb::new(Vec3::NEG_ONE, Vec3::ONE);
        assert_eq!(Aabb::EMPTY.union(&b), b);
        assert_eq!(b.union(&Aabb::EMPTY), b);
        assert!(b.contains(&Aabb::EMPTY) && Aabb::EMPTY.is_empty() && !Aabb::EMPTY.is_valid());
        assert!(!b.contains(&Aabb::new(Vec3::ZERO, Vec3::splat(1.5))));
    }
}
