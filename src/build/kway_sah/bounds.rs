//! Boxes of which the union is a maximum, and the references that a build moves about.

use crate::geom::{Aabb, area_of_extent};
use glam::{DVec3, Vec4};

/// A box as (−min, 0) and (max, 0): the union of two is the greater of each number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    negated_min: Vec4,
    max: Vec4,
}

impl Bounds {
    /// Neutral in unions.
    pub const EMPTY: Self = Self { negated_min: Vec4::NEG_INFINITY, max: Vec4::NEG_INFINITY };

    /// The same box.
    #[inline(always)]
    pub fn of(aabb: &Aabb) -> Self {
        // Adding 0 leaves one zero, the positive one, so that no maximum depends on the order of its operands.
        Self { negated_min: (0.0 - aabb.min).extend(0.0), max: (aabb.max + 0.0).extend(0.0) }
    }

    /// The same box.
    #[inline(always)]
    pub fn aabb(&self) -> Aabb {
        Aabb::new((Vec4::ZERO - self.negated_min).truncate(), self.max.truncate())
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        Self { negated_min: self.negated_min.max(other.negated_min), max: self.max.max(other.max) }
    }

    /// Its surface area; it is not empty.
    #[inline(always)]
    pub fn area(&self) -> f64 {
        area_of_extent(self.max.truncate().as_dvec3() + self.negated_min.truncate().as_dvec3())
    }
}

/// Triangles taken together: those of a run of centres, of a cell, of a box of cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// The box around them.
    pub bounds: Bounds,
    /// How many there are.
    pub count: u32,
}

impl Group {
    /// Of no triangles.
    pub const EMPTY: Self = Self { bounds: Bounds::EMPTY, count: 0 };

    /// Takes in one triangle.
    #[inline(always)]
    pub fn add(&mut self, bounds: &Bounds) {
        *self = Self { bounds: self.bounds.union(bounds), count: self.count + 1 };
    }

    /// Both.
    #[inline(always)]
    pub fn and(&self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(&other.bounds), count: self.count + other.count }
    }
}

/// A triangle of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// Its box.
    pub aabb: Aabb,
    /// Its id.
    pub id: u32,
    /// Its cell of the node's grid, then its part of the node.
    pub cell: u32,
}

impl Reference {
    /// To no triangle.
    pub const NONE: Self = Self { aabb: Aabb::EMPTY, id: 0, cell: 0 };

    /// The centre of its box; one zero of two.
    #[inline(always)]
    pub fn centre(&self) -> DVec3 {
        self.aabb.centre() + 0.0
    }
}
