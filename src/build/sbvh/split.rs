//! One node: its best object split, its best spatial split, and the references on either side of the better one.

use super::Sbvh;
use super::estimate::nodes;
use super::object::{ObjectSplit, Sweep};
use super::reference::{Reference, Source};
use super::spatial::Chop;
use crate::build::{Probe, Work};
use crate::geom::Aabb;

/// References from which on the axes of one node are searched in parallel.
const PARALLEL_AXES: usize = 1 << 14;

/// What all nodes of a build have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splitter<'a> {
    pub source: Source<'a>,
    pub params: &'a Sbvh,
    /// The area that both sides of an object split must share for planes to be tried.
    pub least_overlap: f64,
}

/// Room for splitting a node.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    sweeps: [Sweep; 3],
    chop: Chop,
    parts: Vec<[Aabb; 2]>,
    pub left: Vec<Reference>,
    pub right: Vec<Reference>,
    pub effort: Effort,
}

/// Work done.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    /// Object splits looked at.
    splits: u64,
    /// References put into bins between planes, on each axis.
    binned: u64,
    /// Planes looked at.
    planes: u64,
}

impl Effort {
    /// Tells the probe; returns whether to go on.
    pub fn tell<P: Probe>(self, probe: &mut P) -> bool {
        probe.add(Work::SplitCosts, self.splits + self.planes);
        probe.add(Work::Binned, self.binned);
        probe.go_on(self.splits + self.binned)
    }
}

impl Splitter<'_> {
    /// Splits at least two references; the sides are in the workspace then, each in the old order. At most `budget`
    /// references are added. Returns what is left of it for either side.
    pub fn split(&self, references: &[Reference], aabb: &Aabb, budget: usize, room: &mut Workspace) -> [usize; 2] {
        let n = references.len();
        room.left.clear();
        room.right.clear();
        let object = room.best_object(references);
        let sides = object.sides(references);
        if budget > 0 && common_area(&sides[0].0, &sides[1].0) > self.least_overlap {
            let Workspace { chop, parts, left, right, effort, .. } = room;
            let best = chop.best(&self.source, references, aabb, self.params.bins, budget);
            effort.binned += 3 * n as u64;
            effort.planes += chop.planes() as u64;
            if let Some(spatial) = best {
                let cost = spatial.part(&self.source, references, left, right, parts);
                if cost >= sides.iter().map(|(aabb, n)| nodes(aabb.surface_area(), *n)).sum() {
                    left.clear();
                }
            }
        }
        let Workspace { left, right, .. } = room;
        if left.is_empty() || right.is_empty() {
            left.clear();
            right.clear();
            for (index, reference) in references.iter().enumerate() {
                if object.is_left(reference, index) { &mut *left } else { &mut *right }.push(*reference);
            }
        }
        share(budget - (left.len() + right.len() - n), [left, right])
    }
}

impl Workspace {
    /// The best object split of all axes.
    fn best_object(&mut self, references: &[Reference]) -> ObjectSplit {
        let n = references.len();
        self.effort.splits += 3 * (n as u64 - 1);
        let [x, y, z] = on_each_axis(n, &mut self.sweeps, |(axis, sweep)| sweep.best(references, axis));
        let better = |best: ObjectSplit, next: ObjectSplit| if next.precedes(&best, n) { next } else { best };
        better(better(x, y), z)
    }
}

/// Does the same on each axis, in parallel where there are many references.
fn on_each_axis<T: Send, R: Send>(n: usize, rooms: &mut [T; 3], work: impl Fn((usize, &mut T)) -> R + Sync) -> [R; 3] {
    let [x, y, z] = rooms;
    if n < PARALLEL_AXES {
        return [work((0, x)), work((1, y)), work((2, z))];
    }
    let (x, (y, z)) = rayon::join(|| work((0, x)), || rayon::join(|| work((1, y)), || work((2, z))));
    [x, y, z]
}

/// The surface area of what both boxes have in common.
fn common_area(a: &Aabb, b: &Aabb) -> f64 {
    Aabb::new(a.min.max(b.min), a.max.min(b.max)).surface_area()
}

/// Shares out `budget` in proportion to the areas of the references of both sides; where they have none, to their
/// numbers.
fn share(budget: usize, sides: [&[Reference]; 2]) -> [usize; 2] {
    if budget == 0 {
        return [0, 0];
    }
    let areas = sides.map(|side| side.iter().map(|r| r.aabb.surface_area()).sum::<f64>());
    let [left, right] = if areas[0] + areas[1] > 0.0 { areas } else { sides.map(|side| side.len() as f64) };
    let share = ((budget as f64 * (left / (left + right))) as usize).min(budget);
    [share, budget - share]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_budget_goes_where_the_areas_are() {
        let cubes = |n: usize, size: f32| vec![Reference { aabb: Aabb::new(Vec3::ZERO, Vec3::splat(size)), id: 0 }; n];
        assert_eq!(share(10, [&cubes(1, 2.0), &cubes(1, 1.0)]), [8, 2]);
        assert_eq!(share(10, [&cubes(4, 1.0), &cubes(1, 2.0)]), [5, 5]);
        assert_eq!(share(7, [&cubes(4, 0.0), &cubes(3, 0.0)]), [4, 3]);
        assert_eq!(share(7, [&cubes(4, 1.0), &cubes(3, 0.0)]), [7, 0]);
        assert_eq!(share(usize::MAX >> 1, [&cubes(4, 1.0), &cubes(3, 0.0)]), [usize::MAX >> 1, 0]);
        assert_eq!(share(0, [&cubes(4, 1.0), &cubes(3, 1.0)]), [0, 0]);
    }
}
