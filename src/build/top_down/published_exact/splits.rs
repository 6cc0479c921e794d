//! The best choice of split positions on one axis.

use crate::build::{ChildCost, Probe, Work};
use crate::geom::Aabb;

/// The most children of a node.
pub const MAX_ARITY: usize = 8;

/// More than any sum of terms, and small enough to add some of those to.
const IMPOSSIBLE: i64 = 1 << 60;

/// A choice that beats all before it.
pub struct Choice {
    /// Its cost: the sum of its children's terms.
    pub cost: i64,
    /// Where its children end, counted in triangles of the node; as many as there are children.
    pub ends: [usize; MAX_ARITY],
    /// The boxes of its children.
    pub boxes: [Aabb; MAX_ARITY],
}

/// Working memory, and what a node's search needs to know.
pub struct Search {
    arity: usize,
    stride: usize,
    n: usize,
    cost: ChildCost,
    /// Boxes of the segments between neighbouring split positions.
    segments: Vec<Aabb>,
    /// Box of the run from the current segment to before segment b, by b.
    runs: Vec<Aabb>,
    /// Term of that run.
    row: Vec<i64>,
    /// `suffix[a][j]`: least cost of the segments from a on as j + 1 children.
    suffix: Vec<[i64; MAX_ARITY]>,
}

impl Search {
    /// For nodes of `arity` children.
    pub fn new(arity: usize) -> Self {
        let cost = ChildCost::new(&Aabb::EMPTY, 1);
        Self { arity, stride: 1, n: 0, cost, segments: vec![], runs: vec![], row: vec![], suffix: vec![] }
    }

    /// Begins with a node of `n` triangles and box `aabb`, whose split positions are `stride` apart.
    pub fn begin(&mut self, aabb: &Aabb, n: usize, stride: usize) {
        self.n = n;
        self.stride = stride;
        self.cost = ChildCost::new(aabb, n);
    }

    /// The first of the cheapest choices in the order `sorted`, if it costs less than `bound`; and the number of
    /// transitions looked at.
    pub fn best<P: Probe>(
        &mut self,
        boxes: &[Aabb],
        sorted: &[u32],
        bound: i64,
        steps: &mut u64,
        probe: &mut P,
    ) -> Option<Choice> {
        self.segments.clear();
        let united = |ids: &[u32]| Aabb::union_of(ids.iter().map(|&t| &boxes[t as usize]));
        let m = (self.n - 1) / self.stride;
        let (body, rest) = sorted.split_at(m * self.stride);
        self.segments.extend(body.chunks_exact(self.stride).map(united));
        self.segments.push(united(rest));
        probe.add(Work::BoxUnions, self.n as u64);
        match self.arity {
            2 => self.sweep(bound, steps, probe),
            3 => self.dynamic::<P, 3>(bound, steps, probe),
            4 => self.dynamic::<P, 4>(bound, steps, probe),
            5 => self.dynamic::<P, 5>(bound, steps, probe),
            6 => self.dynamic::<P, 6>(bound, steps, probe),
            7 => self.dynamic::<P, 7>(bound, steps, probe),
            _ => self.dynamic::<P, 8>(bound, steps, probe),
        }
    }

    /// Rank at which segment `s` begins, or where the last one ends.
    fn rank(&self, s: usize) -> usize {
        if s < self.segments.len() { s * self.stride } else { self.n }
    }

    /// The term of the run of the segments `a … b − 1`, whose box is `aabb`.
    #[inline(always)]
    fn term(&self, aabb: &Aabb, a: usize, b: usize) -> i64 {
        self.cost.term(aabb, self.rank(b) - self.rank(a) - 1)
    }

    /// Two children: their terms, from the left and from the right.
    fn sweep<P: Probe>(&mut self, bound: i64, steps: &mut u64, probe: &mut P) -> Option<Choice> {
        let end = self.segments.len();
        self.row.resize(end, 0);
        let mut right = Aabb::EMPTY;
        for p in (1..end).rev() {
            right = right.union(&self.segments[p]);
            self.row[p] = self.term(&right, p, end);
        }
        let (mut cost, mut split) = (bound, 0);
        let mut left = Aabb::EMPTY;
        for p in 1..end {
            left = left.union(&self.segments[p - 1]);
            let total = self.term(&left, 0, p) + self.row[p];
            if total < cost {
                (cost, split) = (total, p);
            }
        }
        *steps += end as u64 - 1;
        probe.add(Work::ChildCosts, 2 * (end as u64 - 1));
        probe.add(Work::BoxUnions, 2 * (end as u64 - 1));
        probe.add(Work::DpSteps, end as u64 - 1);
        (cost < bound).then(|| self.choice(cost, &[split, end]))
    }

    fn dynamic<P: Probe, const K: usize>(&mut self, bound: i64, steps: &mut u64, probe: &mut P) -> Option<Choice> {
        let end = self.segments.len();
        self.row.resize(end + 1, 0);
        self.runs.clear();
        self.runs.resize(end + 1, Aabb::EMPTY);
        self.suffix.resize(end + 1, [0; MAX_ARITY]);
        self.suffix[end] = [IMPOSSIBLE; MAX_ARITY];
        for a in (1..end).rev() {
            self.fill_row(a, end);
            let mut best = [IMPOSSIBLE; MAX_ARITY];
            best[0] = self.row[end];
            for (term, rest) in self.row[a + 1..end].iter().zip(&self.suffix[a + 1..end]) {
                for j in 1..K - 1 {
                    best[j] = best[j].min(term + rest[j - 1]);
                }
            }
            self.suffix[a] = best;
        }
        self.fill_row(0, end);
        let cost = (1..end).map(|b| self.row[b] + self.suffix[b][K - 2]).min()?;
        let pairs = (end * (end + 1) / 2) as u64;
        let done = (K as u64 - 2) * ((end - 1) * (end - 2) / 2) as u64 + end as u64 - 1;
        *steps += done;
        probe.add(Work::ChildCosts, pairs);
        probe.add(Work::BoxUnions, pairs);
        probe.add(Work::DpSteps, done);
        if cost >= bound {
            return None;
        }
        // Forward again: the first position from which the optimum is still reached.
        let mut ends = [end; K];
        let mut a = 0;
        let mut left = cost;
        for j in (1..K).rev() {
            let mut run = Aabb::EMPTY;
            for b in a + 1..end {
                run = run.union(&self.segments[b - 1]);
                let term = self.term(&run, a, b);
                if term + self.suffix[b][j - 1] == left {
                    ends[K - 1 - j] = b;
                    left -= term;
                    a = b;
                    break;
                }
            }
        }
        Some(self.choice(cost, &ends))
    }

    /// Extends the runs to begin at segment `a`, and computes their terms.
    #[inline(always)]
    fn fill_row(&mut self, a: usize, end: usize) {
        let segment = self.segments[a];
        for b in a + 1..=end {
            self.runs[b] = self.runs[b].union(&segment);
            self.row[b] = self.term(&self.runs[b], a, b);
        }
    }

    /// The choice whose children end before the segments `ends`.
    fn choice(&self, cost: i64, ends: &[usize]) -> Choice {
        let mut choice = Choice { cost, ends: [0; MAX_ARITY], boxes: [Aabb::EMPTY; MAX_ARITY] };
        let mut begin = 0;
        for (k, &end) in ends.iter().enumerate() {
            choice.ends[k] = self.rank(end);
            choice.boxes[k] = Aabb::union_of(&self.segments[begin..end]);
            begin = end;
        }
        choice
    }
}
