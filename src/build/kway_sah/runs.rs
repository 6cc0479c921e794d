//! A node's triangles by the centres of their boxes, axis by axis: runs, and slabs of runs.

use super::bounds::{Bounds, Group, Reference};
use super::slabs::{MOST_RUNS, Slabs};
use glam::DVec3;

/// The runs of each axis; only their memory outlives a node.
#[derive(Default)]
pub(super) struct Runs {
    /// What is in each run; none is empty.
    groups: [Vec<Group>; 3],
    /// The run of each triangle on each axis, and nothing.
    of: Vec<[u8; 4]>,
    order: Vec<(f64, u32)>,
    starts: Vec<usize>,
}

/// The slab of each run of an axis.
pub(super) type SlabOf = [u8; MOST_RUNS];

impl Runs {
    /// Lays the runs of a node: one for each centre of few triangles; else those between `runs` equal bins.
    pub fn lay(&mut self, references: &[Reference], runs: usize) {
        self.of.clear();
        self.of.resize(references.len(), [0; 4]);
        self.groups.iter_mut().for_each(Vec::clear);
        if references.len() <= runs {
            (0..3).for_each(|axis| self.sort(references, axis));
        } else {
            self.bin(references, runs);
        }
    }

    fn sort(&mut self, references: &[Reference], axis: usize) {
        self.order.clear();
        self.order.extend(references.iter().zip(0..).map(|(reference, i)| (reference.centre()[axis], i)));
        self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let groups = &mut self.groups[axis];
        let mut last = f64::NAN;
        for &(centre, i) in &self.order {
            if centre != last {
                groups.push(Group::EMPTY);
                last = centre;
            }
            let run = groups.len() - 1;
            self.of[i as usize][axis] = run as u8;
            groups[run].add(&Bounds::of(&references[i as usize].aabb));
        }
    }

    fn bin(&mut self, references: &[Reference], bins: usize) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for reference in references {
            let centre = reference.centre();
            (low, high) = (low.min(centre), high.max(centre));
        }
        let extent = high - low;
        let scale = [0, 1, 2].map(|axis| if extent[axis] > 0.0 { bins as f64 / extent[axis] } else { 0.0 });
        self.groups.iter_mut().for_each(|groups| groups.resize(bins, Group::EMPTY));
        for (reference, of) in references.iter().zip(&mut self.of) {
            let (offset, bounds) = (reference.centre() - low, Bounds::of(&reference.aabb));
            for axis in 0..3 {
                let bin = ((offset[axis] * scale[axis]) as usize).min(bins - 1);
                of[axis] = bin as u8;
                self.groups[axis][bin].add(&bounds);
            }
        }
        // Empty bins are no runs.
        let mut run_of = [[0; MOST_RUNS]; 3];
        for (groups, run_of) in self.groups.iter_mut().zip(&mut run_of) {
            let mut used = 0;
            for (run, group) in run_of.iter_mut().zip(groups.iter()) {
                *run = used;
                used += u8::from(group.count > 0);
            }
            groups.retain(|group| group.count > 0);
        }
        for of in &mut self.of {
            (0..3).for_each(|axis| of[axis] = run_of[axis][usize::from(of[axis])]);
        }
    }

    /// Puts the runs of an axis into the cheapest `most` slabs, or one each where there are not so many. Returns the slab of
    /// each, the number of slabs, and their cost.
    pub fn slabs(&mut self, axis: usize, most: usize, slabs: &mut Slabs) -> (SlabOf, usize, f64) {
        let groups = &self.groups[axis];
        let cost = slabs.divide(groups, most, &mut self.starts);
        let mut slab_of = [0; MOST_RUNS];
        for (slab, &start) in self.starts.iter().enumerate() {
            slab_of[start..groups.len()].fill(slab as u8);
        }
        (slab_of, self.starts.len(), cost)
    }

    /// The run of each triangle on each axis, in their order.
    pub fn of_references(&self) -> &[[u8; 4]] {
        &self.of
    }
}
