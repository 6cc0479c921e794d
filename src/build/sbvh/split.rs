//! One node: its best object split, its best spatial split, and the references on either side of the better one.

use super::Sbvh;
use super::object::Sweep;
use super::reference::{Reference, Source};
use super::spatial::Chop;
use crate::build::{Probe, Work};
use crate::geom::Aabb;
use rayon::prelude::*;

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
    chops: [Chop; 3],
    parts: Vec<[Aabb; 2]>,
    pub left: Vec<Reference>,
    pub right: Vec<Reference>,
    pub effort: Effort,
}

/// Work done.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    /// Splits looked at.
    pub splits: u64,
    /// Unions of boxes.
    pub unions: u64,
}

impl Effort {
    /// Tells the probe; returns whether to go on.
    pub fn tell<P: Probe>(self, probe: &mut P) -> bool {
        probe.add(Work::Combinations, self.splits);
        probe.add(Work::ChildCosts, 2 * self.splits);
        probe.add(Work::BoxUnions, self.unions);
        probe.go_on(self.splits)
    }
}

impl Splitter<'_> {
    /// Splits at least two references; the sides are in the workspace then, each in the old order. At most `budget`
    /// references are added. Returns what is left of it for either side.
    pub fn split(&self, references: &[Reference], aabb: &Aabb, budget: usize, room: &mut Workspace) -> [usize; 2] {
        let n = references.len();
        let Workspace { sweeps, chops, parts, left, right, effort } = room;
        let object = |(axis, sweep): (usize, &mut Sweep)| sweep.best(references, axis);
        let objects = if n < PARALLEL_AXES {
            let mut all = sweeps.iter_mut().enumerate().map(object);
            [all.next(), all.next(), all.next()]
        } else {
            let mut all = [None; 3];
            sweeps.par_iter_mut().enumerate().zip(&mut all).for_each(|(s, out)| *out = Some(object(s)));
            all
        };
        let object = objects.into_iter().flatten().reduce(|best, next| if next.precedes(&best, n) { next } else { best });
        let Some(object) = object else { return [0, 0] };
        effort.splits += 3 * (n as u64 - 1);
        effort.unions += 6 * (n as u64 - 1);
        left.clear();
        right.clear();
        if budget > 0 && object.overlap(references) > self.least_overlap {
            let chop = |(axis, chop): (usize, &mut Chop)| {
                chop.best(&self.source, references, aabb, axis, self.params.bins, budget)
            };
            let planes = if n < PARALLEL_AXES {
                let mut all = chops.iter_mut().enumerate().map(chop);
                [all.next().flatten(), all.next().flatten(), all.next().flatten()]
            } else {
                let mut all = [None; 3];
                chops.par_iter_mut().enumerate().zip(&mut all).for_each(|(c, out)| *out = chop(c));
                all
            };
            let spatial = planes.into_iter().flatten().reduce(|best, next| if next.cost < best.cost { next } else { best });
            if let Some(spatial) = spatial.filter(|s| self.params.q > 5.0 || s.cost * self.params.q < object.cost) {
                let cost = spatial.part(&self.source, references, left, right, parts);
                if cost >= object.real(references) { left.clear(); }
            }
        }
        if left.is_empty() || right.is_empty() {
            left.clear();
            right.clear();
            for (index, reference) in references.iter().enumerate() {
                if object.is_left(reference, index) { &mut *left } else { &mut *right }.push(*reference);
            }
        }
        let rest = budget - (left.len() + right.len() - n);
        let share = (rest as u128 * left.len() as u128 / (left.len() + right.len()) as u128) as usize;
        [share, rest - share]
    }
}
