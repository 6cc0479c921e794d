//! Rays with an interval.

use glam::Vec3;

/// A ray `origin + t · direction` for t in `[t_min, t_max]`, both ends included; the direction need not be of unit length.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ray {
    /// Start, in scene units.
    pub origin: Vec3,
    /// Least t that counts as a hit.
    pub t_min: f32,
    /// Direction; t is measured in its length.
    pub direction: Vec3,
    /// Greatest t that counts as a hit.
    pub t_max: f32,
}

impl Ray {
    /// A ray without an end, from t = 0.
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, t_min: 0.0, direction, t_max: f32::INFINITY }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }

    /// Whether the ray can hit anything: finite origin, finite direction that is not zero, and an interval that is not
    /// empty (infinite ends are fine, NaN is not).
    #[inline]
    pub fn is_traceable(&self) -> bool {
        self.origin.is_finite()
            && self.direction.is_finite()
            && self.direction != Vec3::ZERO
            && self.t_min <= self.t_max
    }
}
