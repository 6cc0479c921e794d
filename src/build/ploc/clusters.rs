//! The row of clusters.

use crate::geom::Aabb;
use glam::Vec3;
use rayon::prelude::*;

/// Clusters that one task works on.
pub(super) const CHUNK: usize = 1 << 12;

/// A cluster: half a cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Cluster {
    min: Vec3,
    /// The id of a triangle, or a merge ([`super::merges`]).
    pub name: u32,
    max: Vec3,
    /// The place in Morton order of its first triangle: rises along the row.
    pub place: u32,
}

impl Cluster {
    /// The cluster over `self` and one behind it.
    #[inline(always)]
    pub fn with(&self, right: &Self, name: u32) -> Self {
        let Aabb { min, max } = self.aabb().union(&right.aabb());
        Self { min, name, max, place: self.place }
    }

    #[inline(always)]
    pub fn aabb(&self) -> Aabb {
        Aabb::new(self.min, self.max)
    }

    /// Lower x, y, z, upper x, y, z.
    #[inline(always)]
    pub fn bounds(&self) -> [f32; 6] {
        [self.min.x, self.min.y, self.min.z, self.max.x, self.max.y, self.max.z]
    }
}

/// Triangles in the order of `ids`.
pub(super) fn of_triangles(boxes: &[Aabb], ids: &[u32]) -> Vec<Cluster> {
    let mut clusters = Vec::with_capacity(ids.len());
    let places = clusters.spare_capacity_mut()[..ids.len()].chunks_mut(CHUNK);
    let tasks: Vec<_> = places.zip(ids.chunks(CHUNK)).zip((0..).step_by(CHUNK)).collect();
    each(tasks, |((places, ids), first)| {
        for ((to, &name), place) in places.iter_mut().zip(ids).zip(first..) {
            let Aabb { min, max } = boxes[name as usize];
            to.write(Cluster { min, name, max, place });
        }
    });
    // SAFETY: there are as many places as ids, and all are written.
    unsafe { clusters.set_len(ids.len()) };
    clusters
}

/// Does all tasks, in parallel where there are several.
pub(super) fn each<T: Send>(tasks: Vec<T>, work: impl Fn(T) + Sync + Send) {
    if tasks.len() < 2 {
        tasks.into_iter().for_each(work);
    } else {
        tasks.into_par_iter().for_each(work);
    }
}
