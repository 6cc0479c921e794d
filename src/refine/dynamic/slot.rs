//! One node of a tree that can be changed, and its box in registers.

use crate::geom::area_of_extent;
use glam::{BVec4A, Vec4};

/// No slot.
pub const NONE: u32 = u32::MAX;

/// Marks the link of a slot that holds a leaf; the rest is the leaf's index in the input.
pub const LEAF: u32 = 1 << 31;

/// The root's slot. Slot 1 stays empty, so that pairs start at even slots.
pub const ROOT: u32 = 0;

/// A node. Both vectors load whole; the last lanes are no coordinates.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub struct Slot {
    /// Lower corner.
    pub min: [f32; 3],
    /// The parent's slot.
    pub parent: u32,
    /// Upper corner.
    pub max: [f32; 3],
    /// First of the two slots of the children, or a leaf.
    pub link: u32,
}

/// A box in two registers, the last lanes 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wide {
    min: Vec4,
    max: Vec4,
}

/// The lanes that are coordinates.
const XYZ: BVec4A = BVec4A::from_array([true, true, true, false]);

impl Wide {
    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Half the surface area, in f32.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = self.max - self.min;
        e.x * (e.y + e.z) + e.y * e.z
    }

    /// Half the surface area in f64.
    #[inline(always)]
    pub fn exact_half_area(&self) -> f64 {
        0.5 * area_of_extent(self.max.truncate().as_dvec3() - self.min.truncate().as_dvec3())
    }

    /// Whether `other` lies inside.
    #[inline(always)]
    pub fn contains(&self, other: &Self) -> bool {
        self.union(other) == *self
    }
}

impl Slot {
    /// Nothing.
    pub const EMPTY: Self = Self { min: [0.0; 3], parent: NONE, max: [0.0; 3], link: NONE };

    /// The box.
    #[inline(always)]
    pub fn wide(&self) -> Wide {
        let [min, max]: &[Vec4; 2] = bytemuck::cast_ref(self);
        Wide { min: Vec4::select(XYZ, *min, Vec4::ZERO), max: Vec4::select(XYZ, *max, Vec4::ZERO) }
    }

    /// Gives it another box.
    pub fn set_box(&mut self, wide: &Wide) {
        (self.min, self.max) = (wide.min.truncate().to_array(), wide.max.truncate().to_array());
    }

    /// First of the two slots of the children; none for a leaf.
    #[inline(always)]
    pub fn pair(&self) -> Option<u32> {
        (self.link & LEAF == 0).then_some(self.link)
    }
}
