//! The best choice of split positions on one axis.
//!
//! With m positions there are m + 1 segments, and a choice cuts them into k runs. `suffix[a][j]`, the least cost of the
//! segments from a on as j + 1 runs, is the least `term(a, b) + suffix[b][j − 1]` over all b; rows are filled from the
//! last to the first. The boxes of the runs a … b grow with the rows: each is united with one segment a row, for all b
//! at once. Walking forward from segment 0 and taking the smallest b that still reaches the optimum gives the
//! lexicographically first of the cheapest choices.
//!
//! Runs that cost as much as some choice already known are left out: no sum with such a term can be cheaper. Boxes,
//! areas and weights grow with a run, rounding included, so that what is left out of one row is left out of all rows
//! after it: the reach of the rows only shrinks.

use crate::build::{ChildCost, Probe, Work};
use crate::geom::{Aabb, area_of_extent, lower, upper};
use glam::{DVec3, Vec3};

/// The most children of a node.
pub const MAX_ARITY: usize = 8;

/// More than any sum of terms, and small enough to add some of those to.
const IMPOSSIBLE: i64 = 1 << 60;

/// A box as two vectors of four lanes, the last of which means nothing.
#[derive(Clone, Copy)]
struct Bounds {
    lo: [f32; 4],
    hi: [f32; 4],
}

impl Bounds {
    const EMPTY: Self = Self { lo: [f32::INFINITY; 4], hi: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn new(b: &Aabb) -> Self {
        Self { lo: [b.min.x, b.min.y, b.min.z, 0.0], hi: [b.max.x, b.max.y, b.max.z, 0.0] }
    }

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        let mut both = *self;
        for d in 0..4 {
            both.lo[d] = lower(both.lo[d], other.lo[d]);
            both.hi[d] = upper(both.hi[d], other.hi[d]);
        }
        both
    }

    #[inline(always)]
    fn aabb(&self) -> Aabb {
        Aabb::new(Vec3::new(self.lo[0], self.lo[1], self.lo[2]), Vec3::new(self.hi[0], self.hi[1], self.hi[2]))
    }

    /// Surface area; the box must not be empty.
    #[inline(always)]
    fn area(&self) -> f64 {
        area_of_extent(self.aabb().extent())
    }
}

/// A choice that beats all before it.
#[derive(Clone, Copy)]
pub struct Choice {
    /// The axis.
    pub axis: usize,
    /// Its cost: the sum of its children's terms.
    pub cost: i64,
    /// Segments before which its children end; as many as there are children.
    ends: [usize; MAX_ARITY],
}

/// Working memory, and what a node's search needs to know.
pub struct Search {
    arity: usize,
    stride: usize,
    n: usize,
    cost: ChildCost,
    /// Boxes of the segments between neighbouring split positions, by axis.
    segments: [Vec<Bounds>; 3],
    /// Corners of the runs from the current segment to before segment b, by b.
    lo: [Vec<f32>; 3],
    hi: [Vec<f32>; 3],
    /// Surface areas of those runs.
    area: Vec<f64>,
    /// Ranks at which segments begin, and n.
    rank: Vec<f64>,
    /// Terms of those runs.
    row: Vec<i64>,
    /// `suffix[a][j]`: least cost of the segments from a on as j + 1 children.
    suffix: Vec<[i64; MAX_ARITY]>,
    /// Transitions looked at in this node.
    pub steps: u64,
}

impl Search {
    /// For nodes of `arity` children.
    pub fn new(arity: usize) -> Self {
        Self {
            arity,
            stride: 1,
            n: 0,
            cost: ChildCost::new(&Aabb::EMPTY, 1),
            segments: Default::default(),
            lo: Default::default(),
            hi: Default::default(),
            area: vec![],
            rank: vec![],
            row: vec![],
            suffix: vec![],
            steps: 0,
        }
    }

    /// Begins with a node of `n` triangles and box `aabb`, whose split positions are `stride` apart.
    pub fn begin(&mut self, aabb: &Aabb, n: usize, stride: usize) {
        self.n = n;
        self.stride = stride;
        self.cost = ChildCost::new(aabb, n);
        self.steps = 0;
    }

    /// Takes the boxes of `axis` from the triangles in its order.
    pub fn gather<P: Probe>(&mut self, axis: usize, boxes: &[Aabb], sorted: &[u32], probe: &mut P) {
        let segments = &mut self.segments[axis];
        segments.clear();
        let of = |&t: &u32| Bounds::new(&boxes[t as usize]);
        if self.stride == 1 {
            segments.extend(sorted.iter().map(of));
        } else {
            let united = |ids: &[u32]| ids.iter().map(of).fold(Bounds::EMPTY, |a, b| a.union(&b));
            let (body, rest) = sorted.split_at((self.n - 1) / self.stride * self.stride);
            segments.extend(body.chunks_exact(self.stride).map(united));
            segments.push(united(rest));
            probe.add(Work::BoxUnions, self.n as u64);
        }
    }

    /// Takes boxes that are all equal for those of `axis`.
    pub fn repeat(&mut self, axis: usize, aabb: &Aabb) {
        let segments = &mut self.segments[axis];
        segments.clear();
        segments.resize((self.n - 1) / self.stride + 1, Bounds::new(aabb));
    }

    /// The first of the cheapest choices on `axis`, if it costs less than `bound`.
    pub fn best<P: Probe>(&mut self, axis: usize, bound: i64, probe: &mut P) -> Option<Choice> {
        match self.arity {
            2 => self.sweep(axis, bound, probe),
            3 => self.dynamic::<P, 3>(axis, bound, probe),
            4 => self.dynamic::<P, 4>(axis, bound, probe),
            5 => self.dynamic::<P, 5>(axis, bound, probe),
            6 => self.dynamic::<P, 6>(axis, bound, probe),
            7 => self.dynamic::<P, 7>(axis, bound, probe),
            _ => self.dynamic::<P, 8>(axis, bound, probe),
        }
    }

    /// Number of segments on `axis`.
    pub fn segments(&self, axis: usize) -> usize {
        self.segments[axis].len()
    }

    /// The children of a choice: where each ends, counted in triangles of the node, and its box.
    pub fn children(&self, choice: &Choice) -> impl Iterator<Item = (usize, Aabb)> {
        let mut begin = 0;
        choice.ends[..self.arity].iter().map(move |&end| {
            let run = &self.segments[choice.axis][std::mem::replace(&mut begin, end)..end];
            let aabb = run.iter().fold(Bounds::EMPTY, |a, b| a.union(b)).aabb();
            (if end < self.segments[choice.axis].len() { end * self.stride } else { self.n }, aabb)
        })
    }

    /// Two children: their terms, from the right and from the left.
    fn sweep<P: Probe>(&mut self, axis: usize, bound: i64, probe: &mut P) -> Option<Choice> {
        let Self { n, stride, cost, ref mut row, .. } = *self;
        let segments = &self.segments[axis][..];
        let end = segments.len();
        row.resize(end, 0);
        let mut costs = 0;
        // Positions before `from` leave too much on their right.
        let mut from = end;
        let mut right = Bounds::EMPTY;
        while from > 1 {
            right = right.union(&segments[from - 1]);
            let term = cost.term_of_area(right.area(), (n - (from - 1) * stride - 1) as f64);
            costs += 1;
            if term >= bound {
                break;
            }
            from -= 1;
            row[from] = term;
        }
        let (mut best, mut split) = (bound, 0);
        let mut left = segments[..from - 1].iter().fold(Bounds::EMPTY, |a, b| a.union(b));
        let mut p = from;
        while p < end {
            left = left.union(&segments[p - 1]);
            let term = cost.term_of_area(left.area(), (p * stride - 1) as f64);
            costs += 1;
            if term >= best {
                break;
            }
            let total = term + row[p];
            if total < best {
                (best, split) = (total, p);
            }
            p += 1;
        }
        let done = (p - from) as u64;
        self.steps += done;
        probe.add(Work::ChildCosts, costs);
        probe.add(Work::BoxUnions, costs + from as u64 - 1);
        probe.add(Work::DpSteps, done);
        let mut ends = [end; MAX_ARITY];
        ends[0] = split;
        (best < bound).then_some(Choice { axis, cost: best, ends })
    }

    fn dynamic<P: Probe, const K: usize>(&mut self, axis: usize, bound: i64, probe: &mut P) -> Option<Choice> {
        let end = self.segments[axis].len();
        self.reset(end);
        let bound = bound.min(self.evenly(axis, probe) + 1);
        let mut reach = end;
        let (mut runs, mut steps) = (0, 0);
        // What stays where a segment alone costs too much and the loop ends early.
        self.suffix[0] = [IMPOSSIBLE; MAX_ARITY];
        for a in (0..end).rev() {
            self.fill_row(axis, a, reach);
            runs += (reach - a) as u64;
            while reach > a && self.row[reach] >= bound {
                reach -= 1;
            }
            if reach == a {
                // Segment a alone costs too much.
                break;
            }
            let mut best = [IMPOSSIBLE; MAX_ARITY];
            if reach == end {
                best[0] = self.row[end];
            }
            let last = reach.min(end - 1);
            let terms = self.row[a + 1..=last].iter().zip(&self.suffix[a + 1..=last]);
            if a > 0 {
                for (term, rest) in terms {
                    for j in 1..K - 1 {
                        best[j] = best[j].min(term + rest[j - 1]);
                    }
                }
                steps += (last - a) as u64 * (K as u64 - 2);
            } else {
                for (term, rest) in terms {
                    best[K - 1] = best[K - 1].min(term + rest[K - 2]);
                }
                steps += last as u64;
            }
            self.suffix[a] = best;
        }
        self.steps += steps;
        probe.add(Work::ChildCosts, runs);
        probe.add(Work::BoxUnions, runs);
        probe.add(Work::DpSteps, steps);
        let cost = self.suffix[0][K - 1];
        if cost >= bound {
            return None;
        }
        Some(Choice { axis, cost, ends: self.walk::<P, K>(axis, cost, probe) })
    }

    /// Forward through the table: the first positions from which the optimum `cost` is still reached.
    fn walk<P: Probe, const K: usize>(&self, axis: usize, cost: i64, probe: &mut P) -> [usize; MAX_ARITY] {
        let end = self.segments[axis].len();
        let mut ends = [end; MAX_ARITY];
        let (mut a, mut left) = (0, cost);
        for j in (1..K).rev() {
            let mut run = Bounds::EMPTY;
            for b in a + 1..end {
                run = run.union(&self.segments[axis][b - 1]);
                let term = self.cost.term_of_area(run.area(), self.rank[b] - self.rank[a] - 1.0);
                probe.add(Work::ChildCosts, 1);
                probe.add(Work::BoxUnions, 1);
                if term + self.suffix[b][j - 1] == left {
                    ends[K - 1 - j] = b;
                    left -= term;
                    a = b;
                    break;
                }
            }
        }
        ends
    }

    /// Makes ready for rows over `end` segments.
    fn reset(&mut self, end: usize) {
        for (lo, hi) in self.lo.iter_mut().zip(&mut self.hi) {
            lo.clear();
            lo.resize(end + 1, f32::INFINITY);
            hi.clear();
            hi.resize(end + 1, f32::NEG_INFINITY);
        }
        self.area.resize(end + 1, 0.0);
        self.row.resize(end + 1, 0);
        self.suffix.resize(end + 1, [0; MAX_ARITY]);
        let (n, stride) = (self.n, self.stride);
        self.rank.clear();
        self.rank.extend((0..end).map(|s| (s * stride) as f64).chain([n as f64]));
    }

    /// Cost of the choice whose children have equally many segments, or nearly so.
    fn evenly<P: Probe>(&self, axis: usize, probe: &mut P) -> i64 {
        let segments = &self.segments[axis][..];
        let end = segments.len();
        let mut total = 0;
        for k in 0..self.arity {
            let (a, b) = (k * end / self.arity, (k + 1) * end / self.arity);
            let run = segments[a..b].iter().fold(Bounds::EMPTY, |a, b| a.union(b));
            total += self.cost.term_of_area(run.area(), self.rank[b] - self.rank[a] - 1.0);
        }
        probe.add(Work::ChildCosts, self.arity as u64);
        probe.add(Work::BoxUnions, end as u64);
        total
    }

    /// Extends the runs up to `reach` to begin at segment `a`, and computes their terms.
    #[inline(always)]
    fn fill_row(&mut self, axis: usize, a: usize, reach: usize) {
        let segment = self.segments[axis][a];
        let runs = a + 1..reach + 1;
        let [lo_x, lo_y, lo_z] = &mut self.lo;
        let [hi_x, hi_y, hi_z] = &mut self.hi;
        let (lo_x, lo_y, lo_z) = (&mut lo_x[runs.clone()], &mut lo_y[runs.clone()], &mut lo_z[runs.clone()]);
        let (hi_x, hi_y, hi_z) = (&mut hi_x[runs.clone()], &mut hi_y[runs.clone()], &mut hi_z[runs.clone()]);
        let area = &mut self.area[runs.clone()];
        let extent = |lo: &mut f32, hi: &mut f32, d: usize| {
            *lo = lower(*lo, segment.lo[d]);
            *hi = upper(*hi, segment.hi[d]);
            f64::from(*hi) - f64::from(*lo)
        };
        for i in 0..area.len() {
            let x = extent(&mut lo_x[i], &mut hi_x[i], 0);
            let y = extent(&mut lo_y[i], &mut hi_y[i], 1);
            let z = extent(&mut lo_z[i], &mut hi_z[i], 2);
            area[i] = area_of_extent(DVec3::new(x, y, z));
        }
        let before = self.rank[a] + 1.0;
        let row = &mut self.row[runs.clone()];
        for ((row, area), rank) in row.iter_mut().zip(area).zip(&self.rank[runs]) {
            *row = self.cost.term_of_area(*area, rank - before);
        }
    }
}
