//! Four entries of the search tree side by side: clusters, or nodes that stand for all clusters below them.

use crate::geom::Aabb;
use glam::{Vec3, Vec4};

/// Entries of a quad.
pub(super) const LANES: usize = 4;

/// An id, or handle, above every cluster's: there is no cluster.
pub(super) const NOBODY: u32 = u32::MAX;

/// Four entries of the search tree. For each: per axis the greatest `lo` and the least `hi` of its clusters, and the
/// smallest of their ids. For a single cluster these are its box and its id.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Quad {
    lo: [[f32; LANES]; 3],
    hi: [[f32; LANES]; 3],
    ids: [u32; LANES],
}

/// One entry of a [`Quad`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    /// `min` is the greatest lower corner of the clusters, `max` the least upper one: no box in general.
    pub inner: Aabb,
    /// Smallest id of the clusters.
    pub id: u32,
}

impl Entry {
    /// The entry without clusters: neutral in [`Quad::summary`], and at an infinite distance from everything.
    pub const VACANT: Self = Self { inner: Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY }, id: NOBODY };
}

impl Quad {
    const VACANT: Self =
        Self { lo: [[f32::NEG_INFINITY; LANES]; 3], hi: [[f32::INFINITY; LANES]; 3], ids: [NOBODY; LANES] };

    /// At most four entries; the others are vacant.
    pub fn of(entries: impl Iterator<Item = Entry>) -> Self {
        let mut quad = Self::VACANT;
        entries.enumerate().for_each(|(lane, entry)| quad.set(lane, &entry));
        quad
    }

    /// Entry `lane`.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Entry {
        let at = |rows: &[[f32; LANES]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
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
        let (min, max) = (entry.inner.min.to_array(), entry.inner.max.to_array());
        for axis in 0..3 {
            self.lo[axis][lane] = min[axis];
            self.hi[axis][lane] = max[axis];
        }
        self.ids[lane] = entry.id;
    }

    /// The entry that stands for all four.
    #[inline(always)]
    pub fn summary(&self) -> Entry {
        let greatest = |axis: usize| Vec4::from_array(self.lo[axis]).max_element();
        let least = |axis: usize| Vec4::from_array(self.hi[axis]).min_element();
        let min = Vec3::new(greatest(0), greatest(1), greatest(2));
        let max = Vec3::new(least(0), least(1), least(2));
        let [a, b, c, d] = self.ids;
        Entry { inner: Aabb::new(min, max), id: a.min(b).min(c.min(d)) }
    }

    /// Half the areas of the unions of `query` with each entry, in f32, and a bit for each that is not above `most`.
    #[inline(always)]
    pub fn within(&self, query: &Query, most: f32) -> ([f32; LANES], u32) {
        let extent = |axis: usize| {
            let hi = Vec4::from_array(self.hi[axis]).max(query.hi[axis]);
            hi - Vec4::from_array(self.lo[axis]).min(query.lo[axis])
        };
        let (x, y, z) = (extent(0), extent(1), extent(2));
        let halves = x * (y + z) + y * z;
        // Not above, rather than below or equal: what overflowed to no number must not be left out.
        (halves.to_array(), !halves.cmpgt(Vec4::splat(most)).bitmask() & ((1 << LANES) - 1))
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
