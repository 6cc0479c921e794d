//! The best division of a row of runs into slabs: an interval program.
//!
//! *Recurrence.* F₁(e) = t(0, e); Fⱼ(e) = min over p < e of Fⱼ₋₁(p) + t(p, e), with t = area · triangles of the runs from p
//! up to e: the least cost of the first e runs in j slabs. O(slabs · runs²).

use super::bounds::Group;

/// The most runs of a row.
pub(super) const MOST_RUNS: usize = 64;

/// The program's tables; only their memory outlives a call.
#[derive(Default)]
pub(super) struct Slabs {
    /// t by end, then by start: what a step looks at is next to each other.
    terms: Vec<f64>,
    /// F, a row for each number of slabs.
    least: Vec<f64>,
    /// The p of each F: the lowest of equals.
    from: Vec<u8>,
    /// Transitions so far.
    pub steps: u64,
}

impl Slabs {
    /// Divides `runs`, at most [`MOST_RUNS`] and none of them empty, into as many slabs as asked for, or one a run. Puts the
    /// first run of each slab into `starts` and returns the cost.
    pub fn divide(&mut self, runs: &[Group], slabs: usize, starts: &mut Vec<usize>) -> f64 {
        let (n, slabs) = (runs.len(), slabs.min(runs.len()));
        let width = n + 1;
        self.terms.resize((width * width).max(self.terms.len()), 0.0);
        self.least.resize((width * slabs).max(self.least.len()), 0.0);
        self.from.resize((width * slabs).max(self.from.len()), 0);
        for p in 0..n {
            let mut slab = Group::EMPTY;
            for (e, run) in (p + 1..).zip(&runs[p..]) {
                slab = slab.and(run);
                self.terms[e * width + p] = slab.bounds.area() * f64::from(slab.count);
            }
        }
        for e in 1..=n {
            self.least[e] = self.terms[e * width];
        }
        for j in 1..slabs {
            let (before, row) = self.least.split_at_mut(j * width);
            let before = &before[(j - 1) * width..];
            // Every slab before has a run at least, and so has every one behind.
            for e in j + 1..=n - (slabs - 1 - j) {
                let (mut best, mut from) = (f64::INFINITY, j);
                for (p, (before, term)) in (j..e).zip(before[j..e].iter().zip(&self.terms[e * width + j..])) {
                    let cost = before + term;
                    if cost < best {
                        (best, from) = (cost, p);
                    }
                }
                self.steps += (e - j) as u64;
                (row[e], self.from[j * width + e]) = (best, from as u8);
            }
        }
        starts.clear();
        let mut end = n;
        for j in (1..slabs).rev() {
            end = usize::from(self.from[j * width + end]);
            starts.push(end);
        }
        starts.push(0);
        starts.reverse();
        self.least[(slabs - 1) * width + n]
    }
}
