//! Boxes as eight numbers, so that a union is a maximum.

use crate::geom::Aabb;
use glam::{BVec4A, Vec4};

/// A box as (−min.xyz, tag) and (max.xyz, 0): the union of two is the greater of each number. What a tag says survives
/// copies, not unions.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Lanes {
    negated_min: Vec4,
    max: Vec4,
}

/// What tags are mixed with: as numbers, small ones would be subnormal, and slow in sums that nobody reads.
const NORMAL: u32 = 1 << 30;

impl Lanes {
    /// Neutral in unions.
    pub const EMPTY: Self = Self { negated_min: Vec4::NEG_INFINITY, max: Vec4::NEG_INFINITY };

    /// The box with `tag`.
    #[inline(always)]
    pub fn tagged(aabb: &Aabb, tag: u32) -> Self {
        // Adding 0 leaves one zero, the positive one, so that no maximum depends on the order of its operands.
        let (negated_min, max) = (0.0 - aabb.min, aabb.max + 0.0);
        Self { negated_min: negated_min.extend(f32::from_bits(tag ^ NORMAL)), max: max.extend(0.0) }
    }

    /// The tag.
    #[inline(always)]
    pub fn tag(&self) -> u32 {
        self.negated_min.w.to_bits() ^ NORMAL
    }

    /// The box.
    #[inline(always)]
    pub fn aabb(&self) -> Aabb {
        Aabb::new((Vec4::ZERO - self.negated_min).truncate(), self.max.truncate())
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self { negated_min: self.negated_min.max(other.negated_min), max: self.max.max(other.max) }
    }

    /// Becomes the smallest box around both; in one instruction if `WIDE`.
    ///
    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    pub unsafe fn extend<const WIDE: bool>(&mut self, other: &Self) {
        #[cfg(target_arch = "x86_64")]
        if WIDE {
            use std::arch::x86_64::{_mm256_load_ps, _mm256_max_ps, _mm256_store_ps};
            let (to, other) = (std::ptr::from_mut(self).cast::<f32>(), std::ptr::from_ref(other).cast::<f32>());
            // SAFETY: both are eight numbers on a multiple of 32 bytes; the caller vouches for AVX.
            unsafe { _mm256_store_ps(to, _mm256_max_ps(_mm256_load_ps(to), _mm256_load_ps(other))) };
            return;
        }
        *self = self.union(other);
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn centre(&self) -> Vec4 {
        self.max - self.negated_min
    }

    /// Twice the centre on one axis, four times.
    #[inline(always)]
    pub fn centre_on(&self, axis: usize) -> Vec4 {
        Vec4::splat(self.max.as_ref()[axis]) - Vec4::splat(self.negated_min.as_ref()[axis])
    }

    /// Half the surface area, in f32: the builder sees to it that nothing overflows.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = self.max + self.negated_min;
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

impl Lanes {
    /// [`Lanes::half_area`] of three boxes, and 0.
    #[inline(always)]
    pub fn half_areas(boxes: &[Self; 3]) -> Vec4 {
        let e = boxes.map(|b| b.max + b.negated_min);
        let [x, y, z] = [0, 1, 2].map(|i| Vec4::new(e[0][i], e[1][i], e[2][i], 0.0));
        x * y + y * z + z * x
    }
}

/// An interval of centres on each axis, doubled: see [`Lanes::centre`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub low: Vec4,
    pub high: Vec4,
}

impl Span {
    /// Contains nothing.
    const EMPTY: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    /// Exactly around the centres of `references`.
    #[inline(always)]
    pub fn around(references: &[Lanes]) -> Self {
        references.iter().fold(Self::EMPTY, |span, reference| {
            let centre = reference.centre();
            Self { low: span.low.min(centre), high: span.high.max(centre) }
        })
    }

    /// The part in which boxes inside `aabb` can have their centres.
    #[inline(always)]
    pub fn within(&self, aabb: &Lanes) -> Self {
        Self { low: self.low.max(aabb.negated_min * -2.0), high: self.high.min(aabb.max * 2.0) }
    }
}

/// What references are like.
#[derive(Clone, Copy, Debug)]
pub(super) struct Survey {
    /// The box around them.
    pub aabb: Lanes,
    /// Around their centres.
    pub span: Span,
    /// On each axis, whether no box is empty there, or without end, or holds NaN.
    sound: BVec4A,
}

impl Survey {
    /// No references.
    pub const NOTHING: Self = Self { aabb: Lanes::EMPTY, span: Span::EMPTY, sound: BVec4A::TRUE };

    /// With one more.
    #[inline(always)]
    pub fn with(self, reference: &Lanes) -> Self {
        let (centre, extent) = (reference.centre(), reference.max + reference.negated_min);
        Self {
            aabb: self.aabb.union(reference),
            span: Span { low: self.span.low.min(centre), high: self.span.high.max(centre) },
            sound: self.sound & extent.cmpge(Vec4::ZERO) & extent.cmplt(Vec4::INFINITY),
        }
    }

    /// Of both.
    pub fn and(self, other: Self) -> Self {
        Self {
            aabb: self.aabb.union(&other.aabb),
            span: Span { low: self.span.low.min(other.span.low), high: self.span.high.max(other.span.high) },
            sound: self.sound & other.sound,
        }
    }

    /// Whether all boxes are certainly valid.
    pub fn is_sound(&self) -> bool {
        self.sound.bitmask() & 7 == 7
    }
}
