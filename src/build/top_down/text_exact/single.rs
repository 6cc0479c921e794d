//! One plane only: a sweep along each axis, as at arity 2 or where nothing else separates.

use super::cells::Cells;
use super::cuts::{INADMISSIBLE, heads};
use super::{Plane, Triangle};
use crate::build::{ChildCost, Probe, Work};
use crate::geom::Aabb;

/// The tables of the sweeps; only their memory outlives a node.
#[derive(Default)]
pub struct Single {
    /// Boxes of the slabs of x, y and z, one after the other.
    slabs: Vec<Aabb>,
    terms: Vec<i64>,
}

impl Single {
    /// The first of the cheapest planes, if any separates the node.
    pub fn run<P: Probe>(
        &mut self,
        triangles: &[Triangle],
        cells: &Cells,
        cost: &ChildCost,
        probe: &mut P,
    ) -> Option<Plane> {
        let [sx, sy, sz] = cells.slabs;
        self.slabs.clear();
        self.slabs.resize(sx + sy + sz, Aabb::EMPTY);
        for (triangle, cell) in triangles.iter().zip(cells.of_triangles()) {
            let [i, j, k, _] = cell.map(usize::from);
            for slab in [i, sx + j, sx + sy + k] {
                self.slabs[slab] = self.slabs[slab].union(&triangle.aabb);
            }
        }
        probe.add(Work::BoxUnions, 3 * triangles.len() as u64);
        let mut best = INADMISSIBLE;
        let mut plane = None;
        let mut slabs = self.slabs.as_slice();
        for (axis, len) in cells.slabs.into_iter().enumerate() {
            let (here, others) = slabs.split_at(len);
            slabs = others;
            let Some(last) = here.last().filter(|_| len > 1) else { continue };
            // An axis must do better than those before it; on it, the sweep goes down, so the later find is the first.
            let mut limit = best - 1;
            self.terms.clear();
            let found = heads(here, limit - cost.term(last, 1), cost, &mut self.terms, probe);
            let Some(least) = self.terms.first() else { continue };
            let (mut rest, mut swept) = (Aabb::EMPTY, 0);
            for slab in (0..len - 1).rev() {
                rest = rest.union(&here[slab + 1]);
                let above = cost.term(&rest, 1);
                swept += 1;
                if least + above > limit {
                    break;
                }
                let Some(below) = self.terms.get(slab) else { continue };
                if below + above <= limit {
                    limit = below + above;
                    best = limit;
                    plane = Some(Plane { axis, slab });
                }
            }
            probe.add(Work::BoxUnions, swept);
            probe.add(Work::ChildCosts, swept + 1);
            probe.add(Work::DpSteps, found as u64);
        }
        plane
    }
}
