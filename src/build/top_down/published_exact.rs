//! `top-down`, preset `published`, engine `exact`: the tree of the literal engine without its combinations.
//!
//! Source: Beick 2014, "Construction Algorithms"; what is built, and how it deviates from the original, is said in
//! [`super::published_literal`].
//!
//! Why it is the same tree. On one axis a choice cuts the m + 1 segments between the candidates into k runs, and its cost
//! is the sum of the runs' terms: integers, so the order of adding is free. With `best(a, j)` the least cost of the
//! segments from a on as j runs,
//!
//! ```text
//! best(a, 1) = term(a, m + 1)        best(a, j) = min over b > a of term(a, b) + best(b, j − 1)
//! ```
//!
//! and best(0, k) is the least cost of all C(m, k − 1) choices after O(k·m²) steps (a sweep from both sides at k = 2).
//! Ties: walking forward from (0, k), the smallest b that reaches the optimum is the smallest first split of any cheapest
//! choice, and so on: the lexicographically first. Axes come in the order x, y, z, and only a smaller cost replaces.
//!
//! A node's triangles are a set that only its ancestors' choices decide, and every order is total (lower coordinate, id),
//! so three orders sorted once and split stably equal the original's sorting at every node. Rule Q8 alone looks at what is
//! left in the one array of the original: there, finished leaves hold the order of their parent's axis, and nodes with
//! fewer triangles than children their own by z. Those slots are written as the original would leave them, in its order,
//! depth first from left to right; it reads no others.
//!
//! Where all boxes of a node are equal, so are its three orders and costs: only x is searched, and no order is split.

use super::Published;
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use arrayvec::ArrayVec;
use ordered_float::OrderedFloat;
use orders::Orders;
use splits::{Choice, MAX_ARITY, Search};

mod orders;
mod splits;

/// Builds the tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, an arity below 2 or above 8, fewer candidates than children, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Published, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    params.check()?;
    let n = boxes.len();
    let root = Aabb::union_of(boxes);
    probe.add(Work::BoxUnions, n as u64);
    let mut builder = Builder {
        boxes,
        params,
        orders: Orders::new(boxes),
        slots: (0..n as u32).collect(),
        nodes: vec![Node::leaf(root, 0, n)],
        pending: vec![],
        search: Search::new(params.arity),
        probe,
    };
    if n > MAX_LEAF {
        let uniform = boxes.iter().all(|b| *b == root);
        builder.pending.push(Pending { node: 0, start: 0, n, uniform });
    }
    while let Some(next) = builder.pending.pop() {
        builder.node(next)?;
    }
    Ok(Bvh { nodes: builder.nodes, triangle_ids: builder.slots, arity: params.arity })
}

/// An inner node that waits for its children; its box is known.
#[derive(Clone, Copy)]
struct Pending {
    node: usize,
    start: usize,
    n: usize,
    /// Whether all its boxes are equal.
    uniform: bool,
}

struct Builder<'a, P> {
    boxes: &'a [Aabb],
    params: &'a Published,
    orders: Orders,
    /// Triangle ids by slot, as the original's one array has them wherever a finished leaf or rule Q8 looks.
    slots: Vec<u32>,
    nodes: Vec<Node>,
    pending: Vec<Pending>,
    search: Search,
    probe: &'a mut P,
}

impl<P: Probe> Builder<'_, P> {
    fn node(&mut self, p: Pending) -> Result<(), BuildError> {
        let Pending { node, start, n, .. } = p;
        if n < self.params.arity {
            self.without_combination(p);
            return Ok(());
        }
        self.search.begin(&self.nodes[node].aabb, n, self.params.stride(n));
        let mut best: Option<Choice> = None;
        if p.uniform {
            // The same on all axes, and only a smaller sum replaces the first.
            self.search.repeat(0, &self.nodes[node].aabb);
            best = self.search.best(0, i64::MAX, self.probe);
        } else {
            for axis in 0..3 {
                let sorted = self.orders.sorted(axis, start..start + n);
                self.search.gather(axis, self.boxes, sorted, self.probe);
                let bound = best.map_or(i64::MAX, |choice| choice.cost);
                best = self.search.best(axis, bound, self.probe).or(best);
            }
        }
        if !self.probe.go_on(self.search.steps) {
            let pending = self.pending.iter().map(|p| p.n).chain([n]).collect();
            return Err(BuildError::Stopped(Unfinished { pending }));
        }
        self.split(&p, &best.expect("as many candidates as a choice takes"));
        Ok(())
    }

    fn split(&mut self, p: &Pending, choice: &Choice) {
        let arity = self.params.arity;
        let first = self.nodes.len();
        self.nodes[p.node] = Node::inner(self.nodes[p.node].aabb, first, arity);
        let waiting = self.pending.len();
        let mut ends = ArrayVec::<usize, MAX_ARITY>::new();
        let mut search = false;
        let mut start = p.start;
        for (end, aabb) in self.search.children(choice) {
            ends.push(end);
            let n = p.start + end - start;
            let sorted = self.orders.sorted(choice.axis, start..start + n);
            if n > MAX_LEAF {
                let uniform = p.uniform || sorted.iter().all(|&t| self.boxes[t as usize] == aabb);
                self.pending.push(Pending { node: self.nodes.len(), start, n, uniform });
                search |= n >= arity;
            }
            if n <= MAX_LEAF || n < arity {
                self.slots[start..start + n].copy_from_slice(sorted);
            }
            self.nodes.push(Node::leaf(aabb, start, n));
            start += n;
        }
        self.probe.add(Work::BoxUnions, self.search.segments(choice.axis) as u64);
        // Children that search on need their orders; those of a uniform node are the same on all axes.
        if search && !p.uniform {
            self.orders.split(choice.axis, p.start, &ends);
        }
        self.pending[waiting..].reverse();
    }

    /// Nodes of fewer triangles than children: rule Q8 of the specification, or one child per triangle.
    fn without_combination(&mut self, p: Pending) {
        let Pending { mut node, mut start, mut n, .. } = p;
        loop {
            if self.params.q8 {
                self.probe.add(if start == 0 { Work::Q8AtStart } else { Work::Q8Nodes }, 1);
            }
            self.sort_slots(start, n, 2);
            if !self.params.q8 || start == 0 {
                break;
            }
            // Seven children without triangles, whose boxes are those of the triangles at their first slots, and an
            // eighth that reaches one slot back into its left neighbour.
            let first = self.nodes.len();
            self.nodes[node] = Node::inner(self.nodes[node].aabb, first, 8);
            for k in 0..7 {
                let slot = if k == 0 { start } else { start - 1 };
                self.nodes.push(Node::leaf(self.boxes[self.slots[slot] as usize], start, 0));
            }
            (node, start, n) = (first + 7, start - 1, n + 1);
            let aabb = Aabb::union_of(self.slots[start..start + n].iter().map(|&t| &self.boxes[t as usize]));
            self.probe.add(Work::BoxUnions, n as u64);
            self.nodes.push(Node::leaf(aabb, start, n));
            if n == self.params.arity {
                // The one combination there is costs nothing on any axis: the first.
                self.sort_slots(start, n, 0);
                break;
            }
        }
        let first = self.nodes.len();
        self.nodes[node] = Node::inner(self.nodes[node].aabb, first, n);
        for slot in start..start + n {
            self.nodes.push(Node::leaf(self.boxes[self.slots[slot] as usize], slot, 1));
        }
    }

    fn sort_slots(&mut self, start: usize, n: usize, axis: usize) {
        let boxes = self.boxes;
        self.slots[start..start + n].sort_unstable_by_key(|&t| (OrderedFloat(boxes[t as usize].min[axis]), t));
    }
}

#[cfg(test)]
mod tests;
