//! `sweep-sah`: top-down by the surface area heuristic, with every split of the sorted centres of each axis as candidate.
//!
//! Source: MacDonald and Booth 1990, "Heuristics for Ray Tracing using Space Subdivision"; Wald, Boulos and Shirley 2007,
//! "Ray Tracing Deformable Scenes using Dynamic Bounding Volume Hierarchies", for object splits and their sweep.
//!
//! The triangles are sorted by centre once an axis, equal centres by id. A sweep from above and one from below give the
//! areas on both sides of every split of a node; the cheapest divides it, or it becomes a leaf where that is cheaper.
//! The other two orders are parted stably, so they stay sorted: O(n) a level, O(n log n) in all for all but adversaries.
//! Costs are f64.
//!
//! **Ties.** Of equal costs the most even split, then the lowest axis, then the lowest split: areas of nothing, as along
//! a line, would otherwise part one triangle at a time. An axis on which all centres of a node are the same does not
//! count; where none does, the first half of the ids is the left child.
//!
//! Deviations: none known. This is what other builders are measured by.

#[cfg(test)]
mod tests;

use super::subtrees::grow_behind;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Subtrees of at most so many triangles are grown by one thread each.
const SUBTREE: usize = 1 << 14;

/// Subtrees between two looks at the budget.
const BATCH: usize = 16;

/// What `sweep-sah` can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepSah {
    /// The most triangles a leaf holds.
    pub max_leaf: usize,
}

impl Default for SweepSah {
    fn default() -> Self {
        Self { max_leaf: MAX_LEAF }
    }
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &SweepSah, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let left: Vec<_> = boxes.iter().map(|_| AtomicBool::new(false)).collect();
    let sweep = Sweep { boxes, max_leaf: params.max_leaf, left: &left };
    let mut orders = [0, 1, 2].map(|axis| sorted(boxes, axis));
    let mut nodes = Vec::with_capacity(2 * boxes.len() - 1);
    nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));

    let [x, y, z] = &mut orders;
    let part = Part { start: 0, orders: [x, y, z] };
    let root = Open { node: 0, start: 0, count: boxes.len(), aabb: Aabb::union_of(boxes) };
    let mut top = Stage { stack: vec![root], later: Vec::new(), least: SUBTREE, costs: 0 };
    let part = top.grow(&sweep, part, &mut Scratch::default(), &mut nodes, |steps| probe.go_on(steps));
    if !top.stack.is_empty() {
        let pending = top.stack.iter().chain(&top.later).map(|open| open.count).collect();
        return Err(BuildError::Stopped(Unfinished { pending }));
    }
    let mut costs = top.costs;
    let mut jobs = parts_of(part, top.later);
    while !jobs.is_empty() {
        if !probe.go_on(jobs.iter().take(BATCH).map(|(open, _)| open.count as u64).sum()) {
            return Err(BuildError::Stopped(Unfinished { pending: jobs.iter().map(|(open, _)| open.count).collect() }));
        }
        let later = jobs.split_off(jobs.len().min(BATCH));
        let room = |(open, _): &(Open, Part)| 2 * open.count - 2;
        let grow = |scratch: &mut Scratch, (open, part): (Open, Part), subtree: &mut Vec<Node>| {
            (open.node, sweep.subtree(open, part, scratch, subtree))
        };
        costs += grow_behind(&mut nodes, jobs, room, Scratch::default, grow).iter().map(|(_, done)| done).sum::<u64>();
        jobs = later;
    }
    probe.add(Work::SplitCosts, costs);
    let [triangle_ids, ..] = orders;
    Ok(Bvh { nodes, triangle_ids, arity: 2 })
}

/// Ids by centre, then by id.
fn sorted(boxes: &[Aabb], axis: usize) -> Vec<u32> {
    // Adding 0 makes one zero of two.
    let key = |(id, aabb): (usize, &Aabb)| (aabb.centre()[axis] + 0.0, id as u32);
    let mut keys: Vec<_> = boxes.par_iter().enumerate().map(key).collect();
    keys.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    keys.into_par_iter().map(|(_, id)| id).collect()
}

/// A node that is not yet settled.
#[derive(Clone, Copy, Debug)]
struct Open {
    node: usize,
    /// Its triangles: so many in each order, from there on.
    start: usize,
    count: usize,
    aabb: Aabb,
}

/// A run of all three orders: the same triangles in each. The order along x ends as that of the slots.
struct Part<'a> {
    start: usize,
    orders: [&'a mut [u32]; 3],
}

/// The runs of `nodes`, which are in rising order, each with its node.
fn parts_of(part: Part, nodes: Vec<Open>) -> Vec<(Open, Part)> {
    let Part { start: mut at, mut orders } = part;
    let mut parts = Vec::with_capacity(nodes.len());
    for open in nodes {
        let orders = orders.each_mut().map(|order| {
            let (run, more) = std::mem::take(order)[open.start - at..].split_at_mut(open.count);
            *order = more;
            run
        });
        at = open.start + open.count;
        parts.push((open, Part { start: open.start, orders }));
    }
    parts
}

/// What stays the same during a build.
struct Sweep<'a> {
    boxes: &'a [Aabb],
    max_leaf: usize,
    /// Of each triangle, whether it went to the left at the last split of one of its nodes.
    left: &'a [AtomicBool],
}

/// A split of an order.
#[derive(Clone, Copy, Debug)]
struct Split {
    /// Area times triangles, of both sides together.
    cost: f64,
    /// By how many triangles one side is larger.
    uneven: usize,
    axis: usize,
    /// Triangles on the left.
    left: usize,
}

/// Growth down to nodes of at most `least` triangles, which are left in `later`.
struct Stage {
    stack: Vec<Open>,
    later: Vec<Open>,
    least: usize,
    costs: u64,
}

impl Stage {
    /// Settles nodes from the stack until it is empty, or `go_on`, told of the triangles of each, says no.
    fn grow<'a>(
        &mut self,
        sweep: &Sweep,
        mut part: Part<'a>,
        scratch: &mut Scratch,
        nodes: &mut Vec<Node>,
        mut go_on: impl FnMut(u64) -> bool,
    ) -> Part<'a> {
        while let Some(open) = self.stack.pop() {
            if open.count <= self.least {
                self.later.push(open);
                continue;
            }
            if !go_on(open.count as u64) {
                self.stack.push(open);
                break;
            }
            let range = open.start - part.start..open.start - part.start + open.count;
            let mut orders = part.orders.each_mut().map(|order| &mut order[range.clone()]);
            let split = sweep.best(&orders.each_ref().map(|order| &**order), scratch, &mut self.costs);
            let area = open.aabb.surface_area();
            let closes =
                split.is_none_or(|s| open.count <= sweep.max_leaf && area * open.count as f64 <= area + s.cost);
            let Some(split) = split.filter(|_| !closes) else {
                nodes[open.node] = Node::leaf(open.aabb, open.start, open.count);
                continue;
            };
            sweep.part(&mut orders, &split, scratch);
            let first = nodes.len();
            nodes[open.node] = Node::inner(open.aabb, first, 2);
            nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
            let (left, right) = orders[0].split_at(split.left);
            let child = |node, start, ids: &[u32]| Open { node, start, count: ids.len(), aabb: sweep.around(ids) };
            self.stack.push(child(first + 1, open.start + split.left, right));
            self.stack.push(child(first, open.start, left));
        }
        part
    }
}

/// Memory that is used again and again, an axis each.
#[derive(Default)]
struct Scratch {
    areas: [Vec<f64>; 3],
    right: [Vec<u32>; 3],
}

impl Sweep<'_> {
    /// The subtree of a node, with itself in front, into `nodes`. Returns the splits costed.
    fn subtree(&self, open: Open, part: Part, scratch: &mut Scratch, nodes: &mut Vec<Node>) -> u64 {
        nodes.reserve(2 * open.count - 1);
        nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
        let mut stage = Stage { stack: vec![Open { node: 0, ..open }], later: Vec::new(), least: 0, costs: 0 };
        stage.grow(self, part, scratch, nodes, |_| true);
        stage.costs
    }

    fn around(&self, ids: &[u32]) -> Aabb {
        Aabb::union_of(ids.iter().map(|&id| &self.boxes[id as usize]))
    }

    /// The best split of a node; none of a single triangle.
    fn best(&self, orders: &[&[u32]; 3], scratch: &mut Scratch, costs: &mut u64) -> Option<Split> {
        let count = orders[0].len();
        if count < 2 {
            return None;
        }
        let [x, y, z] = &mut scratch.areas;
        let (a, b, c) = if count > SUBTREE {
            let on = |axis: usize, areas| self.best_on(axis, orders[axis], areas);
            let (a, (b, c)) = rayon::join(|| on(0, x), || rayon::join(|| on(1, y), || on(2, z)));
            (a, b, c)
        } else {
            (self.best_on(0, orders[0], x), self.best_on(1, orders[1], y), self.best_on(2, orders[2], z))
        };
        let found = [a, b, c];
        *costs += found.iter().flatten().count() as u64 * (count as u64 - 1);
        let best = found.into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost).then(a.uneven.cmp(&b.uneven)));
        best.or_else(|| {
            let left = count / 2;
            let cost = |ids: &[u32]| self.around(ids).surface_area() * ids.len() as f64;
            let cost = cost(&orders[0][..left]) + cost(&orders[0][left..]);
            *costs += 1;
            Some(Split { cost, uneven: count - 2 * left, axis: 0, left })
        })
    }

    /// The best split of one order; none where its centres are all the same.
    fn best_on(&self, axis: usize, order: &[u32], areas: &mut Vec<f64>) -> Option<Split> {
        let count = order.len();
        let centre = |id: u32| self.boxes[id as usize].centre()[axis];
        if centre(order[0]) == centre(order[count - 1]) {
            return None;
        }
        areas.resize(areas.len().max(count), 0.0);
        let mut aabb = Aabb::EMPTY;
        for i in (1..count).rev() {
            aabb = aabb.union(&self.boxes[order[i] as usize]);
            areas[i] = aabb.surface_area();
        }
        let mut aabb = Aabb::EMPTY;
        let mut best = Split { cost: f64::INFINITY, uneven: usize::MAX, axis, left: 0 };
        for left in 1..count {
            aabb = aabb.union(&self.boxes[order[left - 1] as usize]);
            let cost = aabb.surface_area() * left as f64 + areas[left] * (count - left) as f64;
            let uneven = left.abs_diff(count - left);
            if cost < best.cost || (cost == best.cost && uneven < best.uneven) {
                best = Split { cost, uneven, axis, left };
            }
        }
        Some(best)
    }

    /// Parts all orders, each staying sorted on both sides.
    fn part(&self, orders: &mut [&mut [u32]; 3], split: &Split, scratch: &mut Scratch) {
        let (left, right) = orders[split.axis].split_at(split.left);
        left.iter().for_each(|&id| self.left[id as usize].store(true, Ordering::Relaxed));
        right.iter().for_each(|&id| self.left[id as usize].store(false, Ordering::Relaxed));
        for (axis, (order, right)) in orders.iter_mut().zip(&mut scratch.right).enumerate() {
            if axis == split.axis {
                continue;
            }
            right.clear();
            let mut kept = 0;
            for i in 0..order.len() {
                let id = order[i];
                if self.left[id as usize].load(Ordering::Relaxed) {
                    order[kept] = id;
                    kept += 1;
                } else {
                    right.push(id);
                }
            }
            order[kept..].copy_from_slice(right);
        }
    }
}
