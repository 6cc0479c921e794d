//! Boxes as eight numbers, so that a union is one maximum.

use crate::geom::Aabb;
use glam::Vec3;

/// A box as (−min.xyz, tag, max.xyz, 0): the union of two is the greater of each number. What a tag says survives copies,
/// not unions.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Lanes([f32; 8]);

/// One number an axis, and one that means nothing.
pub(super) type Axes = [f32; 4];

impl Lanes {
    /// Neutral in unions.
    pub const EMPTY: Self = Self([f32::NEG_INFINITY; 8]);

    /// The box, times `scale`, with `tag`.
    #[inline(always)]
    pub fn tagged(aabb: &Aabb, scale: f32, tag: u32) -> Self {
        // Adding 0 leaves one zero, the positive one, so that no maximum depends on the order of its operands.
        let (a, b) = (aabb.min * -scale + 0.0, aabb.max * scale + 0.0);
        Self([a.x, a.y, a.z, f32::from_bits(tag), b.x, b.y, b.z, 0.0])
    }

    /// The tag.
    #[inline(always)]
    pub fn tag(&self) -> u32 {
        self.0[3].to_bits()
    }

    /// The box.
    #[inline(always)]
    pub fn aabb(&self) -> Aabb {
        let l = &self.0;
        Aabb::new(Vec3::new(0.0 - l[0], 0.0 - l[1], 0.0 - l[2]), Vec3::new(l[4], l[5], l[6]))
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| if other.0[i] > self.0[i] { other.0[i] } else { self.0[i] }))
    }

    /// Twice the lower corner.
    #[inline(always)]
    pub fn low(&self) -> Axes {
        std::array::from_fn(|i| -2.0 * self.0[i])
    }

    /// Twice the upper corner.
    #[inline(always)]
    pub fn high(&self) -> Axes {
        std::array::from_fn(|i| 2.0 * self.0[i + 4])
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn centre(&self) -> Axes {
        std::array::from_fn(|i| self.0[i + 4] - self.0[i])
    }

    /// Twice the centre on one axis.
    #[inline(always)]
    pub fn centre_on(&self, axis: usize) -> f32 {
        self.0[(axis & 3) + 4] - self.0[axis & 3]
    }

    /// Half the surface area, in f32: the builder sees to it that nothing overflows.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z, _]: Axes = std::array::from_fn(|i| self.0[i + 4] + self.0[i]);
        x * y + y * z + z * x
    }
}

/// An interval of centres on each axis, doubled: see [`Lanes::centre`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub low: Axes,
    pub high: Axes,
}

impl Span {
    /// Contains nothing.
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    /// Exactly around the centres of `references`.
    #[inline(always)]
    pub fn around(references: &[Lanes]) -> Self {
        references.iter().fold(Self::EMPTY, |span, r| {
            let centre = r.centre();
            Self {
                low: std::array::from_fn(|i| if centre[i] < span.low[i] { centre[i] } else { span.low[i] }),
                high: std::array::from_fn(|i| if centre[i] > span.high[i] { centre[i] } else { span.high[i] }),
            }
        })
    }

    /// The smallest span around both.
    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|i| if other.low[i] < self.low[i] { other.low[i] } else { self.low[i] }),
            high: std::array::from_fn(|i| if other.high[i] > self.high[i] { other.high[i] } else { self.high[i] }),
        }
    }

    /// The part in which boxes inside `aabb` can have their centres.
    #[inline(always)]
    pub fn within(&self, aabb: &Lanes) -> Self {
        let (low, high) = (aabb.low(), aabb.high());
        Self {
            low: std::array::from_fn(|i| if low[i] > self.low[i] { low[i] } else { self.low[i] }),
            high: std::array::from_fn(|i| if high[i] < self.high[i] { high[i] } else { self.high[i] }),
        }
    }
}
