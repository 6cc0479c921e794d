//! prototype

mod bounds;
mod divide;
mod few;
mod guillotine;
mod slabs;

use super::subtrees::append;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use bounds::Reference;
use divide::Divider;
use rayon::prelude::*;

/// How a node is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cuts {
    /// Any.
    Guillotine,
    /// Parallel.
    Slabs,
}

/// What can be asked.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct KwaySah {
    /// Parts of a node.
    pub parts: usize,
    /// Leaf limit.
    pub max_leaf: usize,
    /// Bins.
    pub bins: usize,
    pub cuts: Cuts,
    pub binary: bool,
    pub deep: bool,
    pub power: f64,
    pub fitted: bool,
    pub small: usize,
    pub small_bins: usize,
}

impl Default for KwaySah {
    fn default() -> Self {
        Self {
            parts: 8, max_leaf: MAX_LEAF, bins: 6, cuts: Cuts::Guillotine, binary: false,
            deep: false, power: 1.0, fitted: true, small: 64, small_bins: 4,
        }
    }
}

/// Builds.
///
/// # Errors
/// Bad boxes.
pub fn build<P: Probe>(boxes: &[Aabb], params: &KwaySah, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    match params.parts {
        2 => grow_all::<2, P>(boxes, params, probe),
        4 => grow_all::<4, P>(boxes, params, probe),
        8 => grow_all::<8, P>(boxes, params, probe),
        16 => grow_all::<16, P>(boxes, params, probe),
        k => Err(BuildError::Arity(k)),
    }
}

/// Subtrees of at most so many triangles are grown by one thread each.
const SUBTREE: usize = 1 << 14;

#[derive(Clone, Copy, Debug)]
struct Open {
    node: usize,
    start: usize,
    count: usize,
}

fn grow_all<const K: usize, P: Probe>(boxes: &[Aabb], params: &KwaySah, probe: &mut P) -> Result<Bvh, BuildError> {
    let mut references: Vec<_> =
        boxes.iter().enumerate().map(|(id, &aabb)| Reference { aabb, id: id as u32, cell: 0 }).collect();
    let mut divider = Divider::<K>::new(params);
    let mut nodes = vec![Node::leaf(Aabb::union_of(boxes), 0, boxes.len())];
    let mut stack = vec![Open { node: 0, start: 0, count: boxes.len() }];
    let _ = SUBTREE;
    while let Some(open) = stack.pop() {
        if !probe.go_on(open.count as u64) {
            return Err(BuildError::Stopped(Unfinished::default()));
        }
        settle(&mut divider, open, &mut references[open.start..open.start + open.count], &mut nodes, &mut stack, params.binary);
    }
    probe.add(Work::DpSteps, divider.steps());
    probe.add(Work::Binned, divider.binned);
    let triangle_ids = references.iter().map(|r| r.id).collect();
    let _ = (append, boxes.par_iter());
    Ok(Bvh { nodes, triangle_ids, arity: if params.binary { 2 } else { K } })
}

fn settle<const K: usize>(
    divider: &mut Divider<K>,
    open: Open,
    references: &mut [Reference],
    nodes: &mut Vec<Node>,
    stack: &mut Vec<Open>,
    binary: bool,
) {
    let aabb = nodes[open.node].aabb;
    if !divider.divide(references, aabb.surface_area()) {
        return;
    }
    let mut start = open.start;
    if !binary {
        let first = nodes.len();
        nodes[open.node] = Node::inner(aabb, first, divider.parts.len());
        for &(bounds, count) in &divider.parts {
            stack.push(Open { node: nodes.len(), start, count });
            nodes.push(Node::leaf(bounds.aabb(), start, count));
            start += count;
        }
        return;
    }
    let from = nodes.len();
    let mut places = vec![open.node];
    let mut parts = divider.parts.iter();
    for &is_cut in &divider.is_cut {
        let place = places.pop().unwrap();
        if is_cut {
            let first = nodes.len();
            nodes[place] = Node::inner(aabb, first, 2);
            nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
            places.extend([first + 1, first]);
        } else {
            let &(bounds, count) = parts.next().unwrap();
            nodes[place] = Node::leaf(bounds.aabb(), start, count);
            stack.push(Open { node: place, start, count });
            start += count;
        }
    }
    for i in (from..nodes.len()).rev() {
        if !nodes[i].is_leaf() {
            let children = nodes[i].range();
            nodes[i].aabb = Aabb::union_of(nodes[children].iter().map(|n| &n.aabb));
        }
    }
}
