//! The choice that an enumeration of all split positions in order would keep, without the enumeration, in any arithmetic
//! that is monotone: exact or rounded after every addition.
//!
//! A choice of k − 1 of m positions makes k runs of segments; its cost is the sum of the runs' terms, added from left to
//! right. Kept is the first of the least, in the order of axes and then lexicographically.
//!
//! *State and recurrence.* F₁(e) = c + t(0, e); Fⱼ(e) = min over p < e of Fⱼ₋₁(p) + t(p, e): the least cost of the first e
//! segments as j runs. *Proof*: adding the last term to a prefix is monotone, so no prefix yields less than the least
//! prefix does; this needs no associativity, and holds for f32 summed from left to right. F_k(m + 1) is the least cost.
//!
//! *Ties.* Rounding makes prefixes above the least reach the same total, so walking along least prefixes would miss earlier
//! choices. R_k(m + 1) = F_k(m + 1); Rⱼ(p) = max over e > p of the greatest v with v + t(p, e) ≤ Rⱼ₊₁(e). Again because
//! addition is monotone, a prefix of j runs that ends at p can be completed to the least cost exactly when its own sum is
//! at most Rⱼ(p). The walk takes the smallest next position that stays within: the lexicographically first choice.

use super::arithmetic::Arithmetic;
use super::published_tree::{Choice, MAX_SPLITS, Splitting};
use crate::build::{Probe, Work};
use crate::geom::Aabb;

/// The terms of all runs of one node in one arithmetic, and the buffers to choose among them.
pub(super) struct LeastSum<C: Arithmetic> {
    arity: usize,
    /// Number of split positions m; there are m + 1 segments on each axis.
    positions: usize,
    /// `terms[axis][a·(m + 2) + b]`: the run of segments a … b − 1.
    terms: [Vec<C::Cost>; 3],
    /// F of the runs so far, by end.
    least: Vec<C::Cost>,
    /// R by number of runs, then by end.
    rooms: Vec<C::Cost>,
}

/// A choice and its cost.
#[derive(Clone, Copy)]
pub(super) struct Chosen<C: Arithmetic> {
    pub choice: Choice,
    pub cost: C::Cost,
}

impl<C: Arithmetic> LeastSum<C> {
    /// Without a node yet.
    pub fn new() -> Self {
        Self { arity: 0, positions: 0, terms: Default::default(), least: Vec::new(), rooms: Vec::new() }
    }

    /// Makes room for the terms of `node`; each run's is to be put in.
    pub fn begin(&mut self, node: &Splitting) {
        self.arity = node.params.arity;
        self.positions = node.params.positions(node.ids.len());
        let size = self.width() * self.width();
        self.terms.iter_mut().for_each(|terms| terms.resize(size, C::EMPTY));
    }

    /// The term of the run of segments a … b − 1 on one axis.
    pub fn put(&mut self, axis: usize, (a, b): (usize, usize), term: C::Cost) {
        let at = a * self.width() + b;
        self.terms[axis][at] = term;
    }

    /// What the enumeration of every axis would keep; `None` where there are too few positions.
    pub fn first_of_least<P: Probe>(&mut self, probe: &mut P) -> Option<Chosen<C>> {
        if self.positions + 1 < self.arity {
            return None;
        }
        let (mut axis, mut cost) = (0, C::ABOVE);
        for candidate in 0..3 {
            let least = self.least(candidate, probe);
            if least < cost {
                (axis, cost) = (candidate, least);
            }
        }
        let positions = self.first(axis, cost, probe);
        Some(Chosen { choice: Choice { axis, positions }, cost })
    }

    /// The cost of a choice, added from left to right.
    pub fn cost_of(&self, choice: &Choice) -> C::Cost {
        let ends = choice.positions[..self.arity - 1].iter().copied().chain([self.positions + 1]);
        let mut from = 0;
        ends.fold(C::EMPTY, |sum, to| sum + self.row(choice.axis, std::mem::replace(&mut from, to))[to])
    }

    fn width(&self) -> usize {
        self.positions + 2
    }

    fn row(&self, axis: usize, from: usize) -> &[C::Cost] {
        &self.terms[axis][from * self.width()..][..self.width()]
    }

    /// Greatest end of the `j`-th run that leaves each later run a segment.
    fn last_end(&self, j: usize) -> usize {
        self.positions + 1 - (self.arity - j)
    }

    /// F_k(m + 1) of one axis.
    fn least<P: Probe>(&mut self, axis: usize, probe: &mut P) -> C::Cost {
        let mut least = std::mem::take(&mut self.least);
        least.clear();
        least.extend(self.row(axis, 0).iter().map(|&term| C::EMPTY + term));
        for j in 2..=self.arity {
            // From the back, so that a sum is overwritten only when no end needs it any more.
            let first = if j == self.arity { self.positions + 1 } else { j };
            for e in (first..=self.last_end(j)).rev() {
                let mut best = C::ABOVE;
                for (p, &prefix) in (j - 1..e).zip(&least[j - 1..e]) {
                    let sum = prefix + self.row(axis, p)[e];
                    if sum < best {
                        best = sum;
                    }
                }
                probe.add(Work::DpSteps, (e + 1 - j) as u64);
                least[e] = best;
            }
        }
        self.least = least;
        self.least[self.positions + 1]
    }

    /// The first choice on `axis` that costs `cost`, its least.
    fn first<P: Probe>(&mut self, axis: usize, cost: C::Cost, probe: &mut P) -> [usize; MAX_SPLITS] {
        let width = self.width();
        let mut rooms = std::mem::take(&mut self.rooms);
        rooms.clear();
        rooms.resize((self.arity + 1) * width, C::BELOW);
        rooms[self.arity * width + self.positions + 1] = cost;
        for j in (1..self.arity).rev() {
            for p in j..=self.last_end(j) {
                let row = self.row(axis, p);
                let mut room = C::BELOW;
                for e in p + 1..=self.last_end(j + 1) {
                    let limit = rooms[(j + 1) * width + e];
                    // Where even the room found so far does not fit, there is less.
                    if room + row[e] <= limit {
                        room = C::room(limit, row[e]);
                    }
                }
                probe.add(Work::DpSteps, (self.last_end(j + 1) - p) as u64);
                rooms[j * width + p] = room;
            }
        }
        let mut positions = [0; MAX_SPLITS];
        let (mut from, mut sum) = (0, C::EMPTY);
        for (j, position) in (1..self.arity).zip(&mut positions) {
            let row = self.row(axis, from);
            let fits = |&e: &usize| sum + row[e] <= rooms[j * width + e];
            let next = (from + 1..=self.last_end(j)).find(fits).expect("the least cost is reached");
            sum = sum + row[next];
            (*position, from) = (next, next);
        }
        self.rooms = rooms;
        positions
    }
}

/// Sorts the node on every axis in turn and tells the box of each run of segments, its axis, its ends and the number of its
/// triangles.
pub(super) fn each_run<P: Probe>(
    node: &mut Splitting,
    probe: &mut P,
    mut tell: impl FnMut(usize, (usize, usize), &Aabb, usize),
) {
    let n = node.ids.len();
    let (stride, positions) = (node.params.stride(n), node.params.positions(n));
    let begin = |s: usize| if s > positions { n } else { s * stride };
    let mut segments = Vec::with_capacity(positions + 1);
    for axis in 0..3 {
        node.sort(axis);
        segments.clear();
        segments.extend((0..=positions).map(|s| {
            let ids = &node.ids[begin(s)..begin(s + 1)];
            Aabb::union_of(ids.iter().map(|&t| &node.boxes[t as usize]))
        }));
        for a in 0..=positions {
            let mut aabb = Aabb::EMPTY;
            for (b, segment) in (a + 1..).zip(&segments[a..]) {
                aabb = aabb.union(segment);
                tell(axis, (a, b), &aabb, begin(b) - begin(a));
            }
        }
        probe.add(Work::BoxUnions, (n + (positions + 1) * (positions + 2) / 2) as u64);
    }
}
