//! `top-down`, preset `published`, engine `exact`: the tree of the literal engine without its combinations.

use super::Published;
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use ordered_float::OrderedFloat;
use orders::Orders;
use splits::{Choice, Search};

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
        builder.pending.push(Pending { node: 0, start: 0, n });
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
        let Pending { node, start, n } = p;
        if n < self.params.arity {
            self.without_combination(p);
            return Ok(());
        }
        let stride = self.params.stride(n);
        let aabb = self.nodes[node].aabb;
        self.search.begin(&aabb, n, stride);
        let mut steps = 0;
        let mut best: Option<(usize, Choice)> = None;
        for axis in 0..3 {
            let bound = best.as_ref().map_or(i64::MAX, |(_, choice)| choice.cost);
            let sorted = self.orders.sorted(axis, start..start + n);
            if let Some(choice) = self.search.best(self.boxes, sorted, bound, &mut steps, self.probe) {
                best = Some((axis, choice));
            }
        }
        if !self.probe.go_on(steps) {
            let pending = self.pending.iter().map(|p| p.n).chain([n]).collect();
            return Err(BuildError::Stopped(Unfinished { pending }));
        }
        let (axis, choice) = best.expect("as many candidates as a choice takes");
        self.split(node, start, axis, &choice);
        Ok(())
    }

    fn split(&mut self, node: usize, start: usize, axis: usize, choice: &Choice) {
        let arity = self.params.arity;
        let ends = &choice.ends[..arity];
        let n = ends[arity - 1];
        self.slots[start..start + n].copy_from_slice(self.orders.sorted(axis, start..start + n));
        let first = self.nodes.len();
        self.nodes[node] = Node::inner(self.nodes[node].aabb, first, arity);
        let waiting = self.pending.len();
        let mut begin = 0;
        for (k, &end) in ends.iter().enumerate() {
            let (start, n) = (start + begin, end - begin);
            self.nodes.push(Node::leaf(choice.boxes[k], start, n));
            if n > MAX_LEAF {
                self.pending.push(Pending { node: first + k, start, n });
            }
            begin = end;
        }
        // Children that search on need their orders.
        if self.pending[waiting..].iter().any(|p| p.n >= arity) {
            self.orders.split(axis, start, ends);
        }
        self.pending[waiting..].reverse();
    }

    /// Nodes of fewer triangles than children: rule Q8 of the specification, or one child per triangle.
    fn without_combination(&mut self, p: Pending) {
        let Pending { mut node, mut start, mut n } = p;
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
