//! One axis of the recurrence: a row of slabs, none of them empty, cut by planes into runs.

use crate::build::{ChildCost, Probe, Work};
use crate::geom::Aabb;

/// More than any admissible sum; eight of them still fit an i64.
pub const INADMISSIBLE: i64 = 1 << 59;

/// Least costs by the number of planes used, or left to use: 0 … K − 1.
pub type ByPlanes<const K: usize> = [i64; K];

/// No number of planes reaches anything.
pub const fn no_way<const K: usize>() -> ByPlanes<K> {
    [INADMISSIBLE; K]
}

/// Takes the least of `costs` and of `term` + `beyond` with one plane fewer.
#[inline(always)]
pub fn relax<const K: usize>(costs: &mut ByPlanes<K>, term: i64, beyond: &ByPlanes<K>) {
    for planes in 1..K {
        costs[planes] = costs[planes].min(term + beyond[planes - 1]);
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

/// The last axis: a row of slabs that only its own planes cut.
#[derive(Default)]
pub struct LastAxis<const K: usize> {
    /// `rest[a]`: the child made of slabs a …
    rest: Vec<i64>,
    /// `ways[a]`: least costs of cutting off the slabs before a, or of cutting slabs a ….
    ways: Vec<ByPlanes<K>>,
    terms: Vec<i64>,
}

impl<const K: usize> LastAxis<K> {
    /// Least costs of `slabs` (two or more) cut by 1, 2 … `most` planes, where they are at most `budget`; where not, some
    /// more than `budget`.
    ///
    /// From the front, so that a row ends where it and what leads to it are too much. The first child has at least the
    /// first slab, the last child at least the last one.
    pub fn cut<P: Probe>(
        &mut self,
        slabs: &[Aabb],
        most: usize,
        budget: i64,
        cost: &ChildCost,
        probe: &mut P,
    ) -> ByPlanes<K> {
        let mut costs = no_way();
        let lowest = self.fill_rest(slabs, budget - cost.term(&slabs[0], 1), cost, probe);
        let Some(&last) = self.rest.last().filter(|_| lowest < slabs.len()) else { return costs };
        self.terms.clear();
        let found = heads(slabs, budget - last, cost, &mut self.terms, probe);
        probe.add(Work::DpSteps, found as u64);
        for (term, rest) in self.terms.iter().zip(&self.rest[1..]) {
            costs[1] = costs[1].min(term + rest);
        }
        if most == 1 {
            return costs;
        }
        self.ways.clear();
        self.ways.resize(slabs.len(), no_way());
        for (way, term) in self.ways[1..].iter_mut().zip(&self.terms) {
            way[1] = *term;
        }
        for first in 1..slabs.len() {
            let (here, beyond) = self.ways[first..].split_first_mut().expect("a slab");
            for planes in 2..=most {
                costs[planes] = costs[planes].min(here[planes] + self.rest[first]);
            }
            let least = here[1..most].iter().min().expect("one or more");
            if least + last > budget || beyond.is_empty() {
                continue;
            }
            self.terms.clear();
            let found = heads(&slabs[first..], budget - last - least, cost, &mut self.terms, probe);
            for (term, beyond) in self.terms.iter().zip(beyond) {
                relax(beyond, *term, here);
            }
            probe.add(Work::DpSteps, (found * (K - 1)) as u64);
        }
        costs
    }

    /// Fills `rest` as far as it stays within `budget`, and returns from which slab on.
    fn fill_rest<P: Probe>(&mut self, slabs: &[Aabb], budget: i64, cost: &ChildCost, probe: &mut P) -> usize {
        self.rest.clear();
        self.rest.resize(slabs.len(), INADMISSIBLE);
        let mut aabb = Aabb::EMPTY;
        let mut lowest = slabs.len();
        // The first slab is the first child's.
        while lowest > 1 {
            aabb = aabb.union(&slabs[lowest - 1]);
            let term = cost.term(&aabb, 1);
            if term > budget {
                break;
            }
            lowest -= 1;
            self.rest[lowest] = term;
        }
        let found = (slabs.len() - lowest) as u64;
        probe.add(Work::BoxUnions, found);
        probe.add(Work::ChildCosts, found + 1);
        lowest
    }

    /// The lexicographically first choice of `planes` planes that costs `target`, the least: the slabs below them.
    pub fn walk<P: Probe>(
        &mut self,
        slabs: &[Aabb],
        planes: usize,
        mut target: i64,
        cost: &ChildCost,
        mut choose: impl FnMut(usize),
        probe: &mut P,
    ) {
        self.fill_rest(slabs, target, cost, probe);
        self.ways.clear();
        self.ways.resize(slabs.len(), no_way());
        for (way, rest) in self.ways.iter_mut().zip(&self.rest) {
            way[0] = *rest;
        }
        // Row 0 is only walked.
        for first in (1..slabs.len()).rev() {
            self.terms.clear();
            let found = heads(&slabs[first..], target, cost, &mut self.terms, probe);
            let (here, beyond) = self.ways[first..].split_first_mut().expect("a slab");
            for (term, beyond) in self.terms.iter().zip(beyond) {
                relax(here, *term, beyond);
            }
            probe.add(Work::DpSteps, (found * (K - 1)) as u64);
        }
        let mut first = 0;
        for left in (0..planes).rev() {
            self.terms.clear();
            heads(&slabs[first..], target, cost, &mut self.terms, probe);
            let reaches = |k: &usize| self.terms[*k] + self.ways[first + k + 1][left] == target;
            let plane = (0..self.terms.len()).find(reaches).expect("the least cost is reached");
            target -= self.terms[plane];
            choose(first + plane);
            first += plane + 1;
        }
    }
}
