//! `top-down`, preset `published`, engine `literal`: every combination of split positions on each axis.
//!
//! Source: Beick 2014, "Construction Algorithms", as its program did it. A node of more than four triangles sorts them
//! by the lower coordinate of their boxes on one axis after another, offers evenly spaced ranks as split positions, and
//! evaluates every choice of arity − 1 of them. The cost of a choice is Σ SA(child)/SA(node)·(triangles − 1); the first of
//! the cheapest wins, in the order x, y, z and then lexicographically.
//!
//! Deviations: unless [`Costs::Single`] is asked for, areas are f64 and sums exact integers (see [`ChildCost`]) where the
//! original has f32 for both, and its constant 0.125, the same for every choice, is left out; equal keys are ordered by
//! triangle id where the original's sort was unstable; the box of a run of triangles is computed once per node, where the
//! original united all boxes again for each combination (counted as [`Work::OriginalUnions`]).

use super::Published;
use super::arithmetic::{Arithmetic, Costs, SingleCost};
use super::published_tree::{Choice, MAX_SPLITS, Search, Splitting, grow};
use crate::build::{BuildError, ChildCost, Probe, Work};
use crate::bvh::Bvh;
use crate::geom::Aabb;

/// Builds the tree over `boxes`, one per triangle, by exact costs.
///
/// # Errors
/// Boxes that [`check_boxes`](crate::build::check_boxes) refuses, an arity below 2 or above 8, fewer candidates than
/// children, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Published, probe: &mut P) -> Result<Bvh, BuildError> {
    grow(boxes, params, probe, best_choice::<P, ChildCost>)
}

/// Builds the tree over `boxes`, one per triangle, by costs added as `costs` says.
///
/// # Errors
/// As [`build`].
pub fn build_by<P: Probe>(boxes: &[Aabb], params: &Published, costs: Costs, probe: &mut P) -> Result<Bvh, BuildError> {
    match costs {
        Costs::Exact => build(boxes, params, probe),
        Costs::Single => grow(boxes, params, probe, best_choice::<P, SingleCost>),
    }
}

fn best_choice<P: Probe, C: Arithmetic>(mut node: Splitting, probe: &mut P) -> Search {
    let n = node.ids.len();
    let stride = node.params.stride(n);
    let positions = node.params.positions(n);
    let terms = C::of_node(&node.aabb, n);
    let mut best_cost = C::ABOVE;
    let mut best = Search::None;
    for axis in 0..3 {
        node.sort(axis);
        let runs = Runs::new(node.ids, node.boxes, stride, positions, &terms, probe);
        let mut combinations = Combinations {
            runs: &runs,
            n: n as u64,
            best_cost,
            best: [0; MAX_SPLITS],
            chosen: [0; MAX_SPLITS],
            steps: 0,
            probe,
        };
        if combinations.choose(0, node.params.arity - 1, 0, C::EMPTY).is_none() {
            return Search::Stopped;
        }
        if combinations.best_cost < best_cost {
            best_cost = combinations.best_cost;
            best = Search::Best(Choice { axis, positions: combinations.best });
        }
    }
    best
}

/// The cost of every run of segments between two split positions of one axis.
struct Runs<C: Arithmetic> {
    /// Number of split positions m; there are m + 1 segments.
    positions: usize,
    /// `cost[a·(m+2) + b]`: the child made of segments a … b − 1.
    cost: Vec<C::Cost>,
    /// `rest[a]`: the child made of segments a … m.
    rest: Vec<C::Cost>,
}

impl<C: Arithmetic> Runs<C> {
    fn new<P: Probe>(
        sorted: &[u32],
        boxes: &[Aabb],
        stride: usize,
        positions: usize,
        terms: &C,
        probe: &mut P,
    ) -> Self {
        let n = sorted.len();
        // Segment s holds the ranks s·stride … (s + 1)·stride, the last one all that is left.
        let begin = |s: usize| if s > positions { n } else { s * stride };
        let segments: Vec<Aabb> = (0..=positions)
            .map(|s| Aabb::union_of(sorted[begin(s)..begin(s + 1)].iter().map(|&t| &boxes[t as usize])))
            .collect();
        probe.add(Work::BoxUnions, n as u64);
        let width = positions + 2;
        let mut table = vec![C::Cost::default(); width * width];
        for a in 0..=positions {
            let mut aabb = Aabb::EMPTY;
            for b in a + 1..=positions + 1 {
                aabb = aabb.union(&segments[b - 1]);
                table[a * width + b] = terms.term(&aabb, begin(b) - begin(a) - 1);
                probe.add(Work::BoxUnions, 1);
                probe.add(Work::ChildCosts, 1);
            }
        }
        let rest = (0..width).map(|a| table[a * width + width - 1]).collect();
        Self { positions, cost: table, rest }
    }

    fn from(&self, a: usize) -> &[C::Cost] {
        let width = self.positions + 2;
        &self.cost[a * width..(a + 1) * width]
    }
}

/// Walks through every choice of split positions in lexicographic order.
struct Combinations<'a, P, C: Arithmetic> {
    runs: &'a Runs<C>,
    n: u64,
    best_cost: C::Cost,
    best: [usize; MAX_SPLITS],
    chosen: [usize; MAX_SPLITS],
    /// Combinations since the probe was last asked.
    steps: u64,
    probe: &'a mut P,
}

impl<P: Probe, C: Arithmetic> Combinations<'_, P, C> {
    /// Chooses `left` more positions beyond position `last` (0 is before the first), `sum` being the cost of the
    /// children before it. `None` when the probe asked to stop.
    fn choose(&mut self, depth: usize, left: usize, last: usize, sum: C::Cost) -> Option<()> {
        let runs = self.runs;
        let from = runs.from(last);
        if left == 1 {
            let below = &from[last + 1..=runs.positions.max(last)];
            let above = &runs.rest[last + 1..=runs.positions.max(last)];
            for (p, (below, above)) in (last + 1..).zip(below.iter().zip(above)) {
                // From left to right: f32 rounds after each child.
                let total = sum + *below + *above;
                self.probe.add(Work::Combinations, 1);
                self.probe.add(Work::OriginalUnions, self.n);
                if total < self.best_cost {
                    self.best_cost = total;
                    self.chosen[depth] = p;
                    self.best = self.chosen;
                }
            }
            self.steps += runs.positions.saturating_sub(last) as u64;
        } else {
            // The last of the remaining positions must still find room.
            let end = (runs.positions + 2).saturating_sub(left);
            for (p, child) in from.iter().enumerate().take(end).skip(last + 1) {
                self.chosen[depth] = p;
                self.choose(depth + 1, left - 1, p, sum + *child)?;
            }
        }
        // Asked at the root and above the two innermost loops.
        let ask = depth == 0 || left == 3;
        (!ask || self.probe.go_on(std::mem::take(&mut self.steps))).then_some(())
    }
}

#[cfg(test)]
mod tests;
