//! `top-down`, preset `published`, engine `literal`: every combination of split positions on each axis.
//!
//! Source: Beick 2014, "Construction Algorithms", as its program did it. A node of more than four triangles sorts them
//! by the lower coordinate of their boxes on one axis after another, offers evenly spaced ranks as split positions, and
//! evaluates every choice of arity − 1 of them. The cost of a choice is Σ SA(child)/SA(node)·(triangles − 1); the first of
//! the cheapest wins, in the order x, y, z and then lexicographically.
//!
//! Deviations: areas are f64 and sums exact integers (see [`ChildCost`]) where the original has f32 for both, and its
//! constant 0.125, the same for every choice, is left out; equal keys are ordered by
//! triangle id where the original's sort was unstable; the box of a run of triangles is computed once per node, where the
//! original united all boxes again for each combination (counted as [`Work::OriginalUnions`]).

use super::Published;
use crate::build::{BuildError, ChildCost, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use ordered_float::OrderedFloat;

/// Builds the tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, an arity below 2 or above 8, fewer candidates than children, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Published, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    params.check()?;
    let mut builder = Builder {
        boxes,
        params,
        order: (0..boxes.len() as u32).collect(),
        nodes: vec![Node::leaf(Aabb::EMPTY, 0, 0)],
        pending: vec![Pending { node: 0, start: 0, n: boxes.len() }],
        probe,
    };
    while let Some(next) = builder.pending.pop() {
        builder.node(next)?;
    }
    Ok(Bvh { nodes: builder.nodes, triangle_ids: builder.order, arity: params.arity })
}

/// A node that waits for its box and its children.
#[derive(Clone, Copy)]
struct Pending {
    node: usize,
    start: usize,
    n: usize,
}

struct Builder<'a, P> {
    boxes: &'a [Aabb],
    params: &'a Published,
    /// Triangle ids by slot, permuted in place; leaves read their slots when the whole build is over.
    order: Vec<u32>,
    nodes: Vec<Node>,
    pending: Vec<Pending>,
    probe: &'a mut P,
}

/// The best choice so far: its axis, and the ranks at which the second and later children begin.
struct Best {
    axis: usize,
    splits: Vec<usize>,
}

impl<P: Probe> Builder<'_, P> {
    fn node(&mut self, p: Pending) -> Result<(), BuildError> {
        let Pending { node, start, n } = p;
        let slots = start..start + n;
        let aabb = Aabb::union_of(self.order[slots].iter().map(|&t| &self.boxes[t as usize]));
        self.probe.add(Work::BoxUnions, n as u64);
        if n <= MAX_LEAF {
            self.nodes[node] = Node::leaf(aabb, start, n);
            return Ok(());
        }
        match self.best_splits(&aabb, start, n) {
            Search::Stopped => Err(self.stopped(n)),
            Search::Best(best) => {
                self.sort(start, n, best.axis);
                let ends = best.splits.iter().copied().chain([n]);
                let mut from = 0;
                let children: Vec<_> = ends.map(|to| (std::mem::replace(&mut from, to), to)).collect();
                self.split(node, aabb, children.len(), |k, first| {
                    let (from, to) = children[k];
                    Pending { node: first + k, start: start + from, n: to - from }
                });
                Ok(())
            }
            Search::None => {
                self.without_combination(node, aabb, start, n);
                Ok(())
            }
        }
    }

    /// Makes `count` children of `node` and lines them up, the leftmost next.
    fn split(&mut self, node: usize, aabb: Aabb, count: usize, child: impl Fn(usize, usize) -> Pending) {
        let first = self.nodes.len();
        self.nodes[node] = Node::inner(aabb, first, count);
        self.nodes.resize(first + count, Node::leaf(Aabb::EMPTY, 0, 0));
        self.pending.extend((0..count).rev().map(|k| child(k, first)));
    }

    /// Nodes of 5 to 7 triangles at arity 8: rule Q8 of the specification, or one child per triangle.
    fn without_combination(&mut self, node: usize, aabb: Aabb, start: usize, n: usize) {
        if self.params.q8 {
            self.probe.add(if start == 0 { Work::Q8AtStart } else { Work::Q8Nodes }, 1);
        }
        if !self.params.q8 || start == 0 {
            self.split(node, aabb, n, |k, first| Pending { node: first + k, start: start + k, n: 1 });
            return;
        }
        // The original left split positions of −1 in place: seven children without triangles, whose boxes are those of
        // the triangles at their first slots, and an eighth that reaches one slot back into its left neighbour.
        let first = self.nodes.len();
        self.nodes[node] = Node::inner(aabb, first, 8);
        for k in 0..7 {
            let slot = if k == 0 { start } else { start - 1 };
            let aabb = self.boxes[self.order[slot] as usize];
            self.nodes.push(Node::leaf(aabb, start, 0));
        }
        self.nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
        self.pending.push(Pending { node: first + 7, start: start - 1, n: n + 1 });
    }

    fn sort(&mut self, start: usize, n: usize, axis: usize) {
        let boxes = self.boxes;
        self.order[start..start + n].sort_unstable_by_key(|&t| (OrderedFloat(boxes[t as usize].min[axis]), t));
    }

    fn best_splits(&mut self, aabb: &Aabb, start: usize, n: usize) -> Search {
        let stride = self.params.stride(n);
        let positions = self.params.positions(n);
        let cost = ChildCost::new(aabb, n);
        let mut best_cost = i64::MAX;
        let mut best = None;
        for axis in 0..3 {
            self.sort(start, n, axis);
            let sorted = &self.order[start..start + n];
            let runs = Runs::new(sorted, self.boxes, stride, positions, &cost, self.probe);
            let mut combinations = Combinations {
                runs: &runs,
                n: n as u64,
                best_cost,
                best: [0; MAX_SPLITS],
                chosen: [0; MAX_SPLITS],
                steps: 0,
                probe: self.probe,
            };
            if combinations.choose(0, self.params.arity - 1, 0, 0).is_none() {
                return Search::Stopped;
            }
            if combinations.best_cost < best_cost {
                best_cost = combinations.best_cost;
                let splits = combinations.best[..self.params.arity - 1].iter().map(|s| s * stride).collect();
                best = Some(Best { axis, splits });
            }
        }
        best.map_or(Search::None, Search::Best)
    }

    fn stopped(&self, current: usize) -> BuildError {
        let pending = self.pending.iter().map(|p| p.n).chain([current]).collect();
        BuildError::Stopped(Unfinished { pending })
    }
}

enum Search {
    Best(Best),
    None,
    Stopped,
}

/// Splits of the widest node.
const MAX_SPLITS: usize = 7;

/// The cost of every run of segments between two split positions of one axis.
struct Runs {
    /// Number of split positions m; there are m + 1 segments.
    positions: usize,
    /// `cost[a·(m+2) + b]`: the child made of segments a … b − 1.
    cost: Vec<i64>,
    /// `rest[a]`: the child made of segments a … m.
    rest: Vec<i64>,
}

impl Runs {
    fn new<P: Probe>(
        sorted: &[u32],
        boxes: &[Aabb],
        stride: usize,
        positions: usize,
        cost: &ChildCost,
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
        let mut table = vec![0; width * width];
        for a in 0..=positions {
            let mut aabb = Aabb::EMPTY;
            for b in a + 1..=positions + 1 {
                aabb = aabb.union(&segments[b - 1]);
                table[a * width + b] = cost.term(&aabb, begin(b) - begin(a) - 1);
                probe.add(Work::BoxUnions, 1);
                probe.add(Work::ChildCosts, 1);
            }
        }
        let rest = (0..width).map(|a| table[a * width + width - 1]).collect();
        Self { positions, cost: table, rest }
    }

    fn from(&self, a: usize) -> &[i64] {
        let width = self.positions + 2;
        &self.cost[a * width..(a + 1) * width]
    }
}

/// Walks through every choice of split positions in lexicographic order.
struct Combinations<'a, P> {
    runs: &'a Runs,
    n: u64,
    best_cost: i64,
    best: [usize; MAX_SPLITS],
    chosen: [usize; MAX_SPLITS],
    /// Combinations since the probe was last asked.
    steps: u64,
    probe: &'a mut P,
}

impl<P: Probe> Combinations<'_, P> {
    /// Chooses `left` more positions beyond position `last` (0 is before the first), `sum` being the cost of the
    /// children before it. `None` when the probe asked to stop.
    fn choose(&mut self, depth: usize, left: usize, last: usize, sum: i64) -> Option<()> {
        let runs = self.runs;
        let from = runs.from(last);
        if left == 1 {
            let below = &from[last + 1..=runs.positions.max(last)];
            let above = &runs.rest[last + 1..=runs.positions.max(last)];
            for (p, (below, above)) in (last + 1..).zip(below.iter().zip(above)) {
                let total = sum + below + above;
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
                self.choose(depth + 1, left - 1, p, sum + child)?;
            }
        }
        // Asked at the root and above the two innermost loops.
        let ask = depth == 0 || left == 3;
        (!ask || self.probe.go_on(std::mem::take(&mut self.steps))).then_some(())
    }
}

#[cfg(test)]
mod tests;
