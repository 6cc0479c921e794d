//! One axis of the recurrence: a row of slabs, none of them empty, cut by planes into runs.

use crate::build::{ChildCost, Probe, Work};
use crate::geom::Aabb;

/// More than any admissible sum; eight of them still fit an i64.
pub const INADMISSIBLE: i64 = 1 << 59;

/// Least costs by the number of planes used, or left to use.
pub type ByPlanes = [i64; 8];

/// No number of planes reaches anything.
pub const NO_WAY: ByPlanes = [INADMISSIBLE; 8];

/// Takes the least of `costs` and of `term` + `beyond` with one plane fewer left.
#[inline(always)]
pub fn relax(costs: &mut ByPlanes, term: i64, beyond: &ByPlanes, most: usize) {
    for left in 1..=most {
        costs[left] = costs[left].min(term + beyond[left - 1]);
    }
}

/// Appends to `terms` those of the children made of slabs 0 … b for rising b, but the last slab, while they stay within `budget`
/// (they rise with b). Returns how many there are.
pub fn heads<P: Probe>(slabs: &[Aabb], budget: i64, cost: &ChildCost, terms: &mut Vec<i64>, probe: &mut P) -> usize {
    let (mut aabb, before) = (Aabb::EMPTY, terms.len());
    for slab in &slabs[..slabs.len() - 1] {
        aabb = aabb.union(slab);
        let term = cost.term(&aabb, 1);
        if term > budget {
            break;
        }
        terms.push(term);
    }
    let found = terms.len() - before;
    probe.add(Work::BoxUnions, found as u64);
    probe.add(Work::ChildCosts, found as u64);
    found
}

/// The last axis: `beyond[a][left]` is the least cost of slabs a … cut by `left` planes.
#[derive(Default)]
pub struct LastAxis {
    beyond: Vec<ByPlanes>,
    terms: Vec<i64>,
}

impl LastAxis {
    /// Least costs of `slabs` cut by 1, 2 … `most` planes, where they are at most `budget`; `INADMISSIBLE` where not.
    pub fn cut<P: Probe>(
        &mut self,
        slabs: &[Aabb],
        most: usize,
        budget: i64,
        cost: &ChildCost,
        probe: &mut P,
    ) -> ByPlanes {
        self.fill(slabs, most, budget, cost, probe);
        self.beyond[0]
    }

    fn fill<P: Probe>(&mut self, slabs: &[Aabb], most: usize, budget: i64, cost: &ChildCost, probe: &mut P) {
        self.beyond.clear();
        self.beyond.resize(slabs.len(), NO_WAY);
        let mut rest = Aabb::EMPTY;
        for first in (0..slabs.len()).rev() {
            rest = rest.union(&slabs[first]);
            let term = cost.term(&rest, 1);
            probe.add(Work::BoxUnions, 1);
            probe.add(Work::ChildCosts, 1);
            if term > budget {
                break;
            }
            self.beyond[first][0] = term;
        }
        for first in (0..slabs.len() - 1).rev() {
            // Between two planes of this axis there is one fewer left; with one in all, only the first row counts.
            let most = if first == 0 { most } else { most - 1 };
            if most == 0 {
                continue;
            }
            self.terms.clear();
            let found = heads(&slabs[first..], budget, cost, &mut self.terms, probe);
            let (here, beyond) = self.beyond[first..].split_first_mut().expect("not the last slab");
            for (term, beyond) in self.terms.iter().zip(beyond) {
                relax(here, *term, beyond, most);
            }
            probe.add(Work::DpSteps, (found * most) as u64);
        }
    }

    /// The lexicographically first choice of `planes` planes that costs `target`, as the slabs below them.
    pub fn walk<P: Probe>(
        &mut self,
        slabs: &[Aabb],
        planes: usize,
        mut target: i64,
        cost: &ChildCost,
        mut choose: impl FnMut(usize),
        probe: &mut P,
    ) {
        self.fill(slabs, planes, target, cost, probe);
        let mut first = 0;
        for left in (0..planes).rev() {
            self.terms.clear();
            heads(&slabs[first..], target, cost, &mut self.terms, probe);
            let reaches = |k: &usize| self.terms[*k] + self.beyond[first + k + 1][left] == target;
            let plane = (0..self.terms.len()).find(reaches).expect("the least cost is reached");
            target -= self.terms[plane];
            choose(first + plane);
            first += plane + 1;
        }
    }
}
