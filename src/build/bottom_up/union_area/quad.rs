//! Four entries of the search tree side by side: clusters, or nodes that stand for all clusters below them.

use crate::geom::Aabb;
use glam::{Vec3, Vec4};

/// Entries of a quad.
pub(super) const LANES: usize = 4;

/// An id above every triangle's: that of an entry without clusters.
pub(super) const NOBODY: u32 = u32::MAX;

/// Four entries of the search tree. For each: per axis the greatest `lo` and the least `hi` of its clusters, and the
/// smallest of their ids. For a single cluster these are its box and its id.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    lo: [Vec4; 3],
    hi: [Vec4; 3],
    ids: [u32; LANES],
}

/// One entry of a [`Quad`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    /// `min` is the greatest lower corner of the clusters, `max` the least upper corner: "empty" in general.
    pub inner: Aabb,
    /// Smallest id of the clusters.
    pub id: u32,
}

impl Entry {
    /// The entry without clusters: neutral in [`Quad::summary`], and at an infinite distance from everything.
    pub const VACANT: Self = Self { inner: Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY }, id: NOBODY };
}

impl Quad {
    /// Four vacant entries.
    pub const VACANT: Self = Self { lo: [Vec4::NEG_INFINITY; 3], hi: [Vec4::INFINITY; 3], ids: [NOBODY; LANES] };

    /// Entry `lane`.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Entry {
        let at = |rows: &[Vec4; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
        Entry { inner: Aabb::new(at(&self.lo), at(&self.hi)), id: self.ids[lane] }
    }

    /// Smallest id of entry `lane`.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> u32 {
        self.ids[lane]
    }

    /// Puts `entry` at `lane`.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, entry: &Entry) {
        for axis in 0..3 {
            self.lo[axis][lane] = entry.inner.min[axis];
            self.hi[axis][lane] = entry.inner.max[axis];
        }
        self.ids[lane] = entry.id;
    }

    /// The entry that stands for all four.
    #[inline(always)]
    pub fn summary(&self) -> Entry {
        let [a, b, c, d] = self.ids;
        let min = Vec3::new(self.lo[0].max_element(), self.lo[1].max_element(), self.lo[2].max_element());
        let max = Vec3::new(self.hi[0].min_element(), self.hi[1].min_element(), self.hi[2].min_element());
        Entry { inner: Aabb::new(min, max), id: a.min(b).min(c.min(d)) }
    }

    /// Half the area of the union of `query` with each entry, in f32.
    #[inline(always)]
    pub fn half_areas(&self, query: &Query) -> Vec4 {
        let extent = |axis: usize| self.hi[axis].max(query.hi[axis]) - self.lo[axis].min(query.lo[axis]);
        let (x, y, z) = (extent(0), extent(1), extent(2));
        x * (y + z) + y * z
    }
}

/// A box to search for, once for each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    lo: [Vec4; 3],
    hi: [Vec4; 3],
}

impl Query {
    /// The query for `aabb`.
    #[inline(always)]
    pub fn new(aabb: &Aabb) -> Self {
        Self { lo: aabb.min.to_array().map(Vec4::splat), hi: aabb.max.to_array().map(Vec4::splat) }
    }
}
