//! `kway-sah`: top-down, each node divided into k parts at once by the cheapest cuts of a grid.
//!
//! Beick 2014 divides a node into k children by k − 1 planes, parallel ones as published: 8 slabs of a cube have 20/12 of the
//! area of 2 × 2 × 2 blocks. Here the planes may cut parts of parts, from side to side (*guillotine* cuts, as of Gilmore and
//! Gomory 1965, "Multistage Cutting Stock Problems of Two and More Dimensions"), and the cheapest such division under the
//! surface area heuristic is found exactly by a dynamic program over the boxes of a small grid (`guillotine.rs`). Nothing of
//! that is published for hierarchies as far as we know.
//!
//! - *Grid.* A node's triangles fall into [`KwaySah::runs`] equal bins of each axis by their centres, or into one run for each
//!   centre where there are not more triangles than that. The planes of the grid are those of the best
//!   [`KwaySah::bins`] slabs on each axis, by the thesis' interval program (`slabs.rs`): they follow the geometry.
//! - *Estimate.* A part of n triangles counts as area · n^¾. The customary area · n takes every subtree for a leaf, and looking
//!   several cuts ahead believes that too often; a true subtree costs about as a power of n below 1. (`estimate`)
//! - *Few triangles.* Of at most eight, the cheapest of all subtrees that such cuts can make (`few.rs`), leaves
//!   included.
//!
//! What becomes of the cuts is up to [`Nodes`]: a wide node (arity 4, 8, 16), binary nodes, or only the first cut becomes
//! a node and both sides are looked at anew. The last, with the best *binary tree over the whole grid* as its
//! estimate, is the builder at arity 2.
//!
//! `kway-slab` is the cheap relative: the best k slabs of one axis, exact between its bins.
//!
//! **Parallel.** Large nodes next to each other, then subtrees, each by one thread. Work on a node is of one thread alone, so
//! nothing depends on the threads.
//!
//! **Ties.** The lowest axis, the lowest plane, the fewest parts below it. Where all centres are the same, parts of equal size
//! in the order of the triangles.

mod bounds;
mod divide;
mod few;
mod guillotine;
mod runs;
mod slabs;
#[cfg(test)]
mod tests;

use super::subtrees::grow_behind;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use bounds::Reference;
use divide::Divider;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Subtrees of at most so many triangles are grown by one thread each.
const SUBTREE: usize = 1 << 14;

/// Subtrees between two looks at the budget.
const BATCH: usize = 64;

/// Nodes of fewer triangles have at most four slabs an axis: there are many of them, and little to choose between.
const COARSE: usize = 64;

/// By which planes a node is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cuts {
    /// Each from side to side of what the cuts before it have left.
    Guillotine,
    /// All parallel.
    Slabs,
}

/// What the cuts of a node become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nodes {
    /// One node, with the parts as its children.
    Parts,
    /// A binary node each.
    Cuts,
    /// The first of them a binary node; what is on both sides of it is looked at anew. The cuts are those of the best binary
    /// tree over all cells of the grid. For two parts.
    FirstCut,
}

/// What `kway-sah` can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KwaySah {
    /// Parts that a node is divided into: 2, 4, 8 or 16.
    pub parts: usize,
    /// What the cuts become.
    pub nodes: Nodes,
    /// By which planes.
    pub cuts: Cuts,
    /// The most triangles a leaf holds.
    pub max_leaf: usize,
    /// The most slabs of the grid on an axis, from 2 to [`KwaySah::MOST_BINS`].
    pub bins: usize,
    /// Runs of centres on an axis that slabs are made of, from 2 to [`KwaySah::MOST_RUNS`].
    pub runs: usize,
}

impl KwaySah {
    /// The most slabs on an axis.
    pub const MOST_BINS: usize = guillotine::MOST_SLABS;
    /// The most runs on an axis.
    pub const MOST_RUNS: usize = slabs::MOST_RUNS;

    /// The tree of this arity: wide nodes by their parts, binary ones by the first cut.
    pub fn at_arity(arity: usize) -> Self {
        let wide = Self { parts: arity, ..Self::default() };
        if arity == 2 { Self { nodes: Nodes::FirstCut, bins: 4, ..wide } } else { wide }
    }

    fn check(&self) -> Result<(), BuildError> {
        let message = if !(2..=Self::MOST_BINS).contains(&self.bins) {
            format!("kway-sah takes 2 to {} bins", Self::MOST_BINS)
        } else if !(2..=Self::MOST_RUNS).contains(&self.runs) {
            format!("slabs are made of 2 to {} bins", Self::MOST_RUNS)
        } else if self.nodes == Nodes::FirstCut && self.parts != 2 {
            "a first cut makes two parts".into()
        } else {
            return Ok(());
        };
        Err(BuildError::Parameter(message))
    }
}

impl Default for KwaySah {
    fn default() -> Self {
        Self { parts: 8, nodes: Nodes::Parts, cuts: Cuts::Guillotine, max_leaf: MAX_LEAF, bins: 6, runs: 32 }
    }
}

/// Builds the tree over `boxes`, one per triangle: of arity [`KwaySah::parts`] with [`Nodes::Parts`], else 2.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, parameters out of range, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &KwaySah, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    params.check()?;
    match params.parts {
        2 => Builder::<2>::new(params).build(boxes, probe),
        4 => Builder::<4>::new(params).build(boxes, probe),
        8 => Builder::<8>::new(params).build(boxes, probe),
        16 => Builder::<16>::new(params).build(boxes, probe),
        other => Err(BuildError::Parameter(format!("a node has 2, 4, 8 or 16 parts, not {other}"))),
    }
}

/// What a subtree over so many triangles is taken to cost, in areas of its box: n^¾.
///
/// Square roots are correctly rounded everywhere, powers are not.
#[inline(always)]
fn estimate(triangles: u32) -> f64 {
    let n = f64::from(triangles);
    (n * n.sqrt()).sqrt()
}

/// A node that is not yet divided: now a leaf over all its slots.
#[derive(Clone, Copy, Debug)]
struct Open {
    node: usize,
    start: usize,
    count: usize,
}

struct Builder<const K: usize> {
    params: KwaySah,
    /// Dividers that no thread uses at the moment: tables are large.
    dividers: Mutex<Vec<Divider<K>>>,
}

impl<const K: usize> Builder<K> {
    fn new(params: &KwaySah) -> Self {
        Self { params: *params, dividers: Mutex::new(Vec::new()) }
    }

    fn build<P: Probe>(self, boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
        let referring = |(id, &aabb): (usize, &Aabb)| Reference { aabb, id: id as u32, cell: 0 };
        let mut references: Vec<_> = boxes.par_iter().enumerate().with_min_len(SUBTREE).map(referring).collect();
        let mut nodes = vec![Node::leaf(Aabb::union_of(boxes), 0, boxes.len())];
        let mut level = vec![Open { node: 0, start: 0, count: boxes.len() }];
        let mut subtrees = Vec::new();
        while !level.is_empty() {
            let large = level.extract_if(.., |open| open.count > SUBTREE).collect::<Vec<_>>();
            subtrees.append(&mut level);
            if !probe.go_on(large.iter().map(|open| open.count as u64).sum()) {
                return Err(stopped(&[&large, &subtrees]));
            }
            self.all(&mut references, &large, &mut nodes, |_| 2 * K - 2, Divider::one, &mut level);
        }
        subtrees.sort_unstable_by_key(|open| open.start);
        for (i, batch) in subtrees.chunks(BATCH).enumerate() {
            if !probe.go_on(batch.iter().map(|open| open.count as u64).sum()) {
                return Err(stopped(&[&subtrees[i * BATCH..]]));
            }
            self.all(&mut references, batch, &mut nodes, |open| 2 * open.count - 2, Divider::subtree, &mut level);
        }
        let dividers = self.dividers.into_inner().unwrap_or_else(PoisonError::into_inner);
        probe.add(Work::DpSteps, dividers.iter().map(Divider::steps).sum());
        probe.add(Work::Binned, dividers.iter().map(|divider| divider.binned).sum());
        let triangle_ids = references.iter().map(|reference| reference.id).collect();
        let arity = if self.params.nodes == Nodes::Parts { K } else { 2 };
        Ok(Bvh { nodes, triangle_ids, arity })
    }

    /// Does something to several nodes, which are in the order of their slots, and puts what comes of it into place: each
    /// with the nodes below it, for which there is `room`. Those that may be divided further are added to `level`, in the order of their slots.
    fn all(
        &self,
        references: &mut [Reference],
        opens: &[Open],
        nodes: &mut Vec<Node>,
        room: impl Fn(&Open) -> usize + Sync + Send,
        work: impl Fn(&mut Divider<K>, Open, &mut [Reference], &mut Vec<Node>) -> Vec<Open> + Sync + Send,
        level: &mut Vec<Open>,
    ) {
        let (mut rest, mut at) = (references, 0);
        let mut jobs = Vec::with_capacity(opens.len());
        for &open in opens {
            let (part, more) = std::mem::take(&mut rest)[open.start - at..].split_at_mut(open.count);
            (rest, at) = (more, open.start + open.count);
            jobs.push((open, nodes[open.node].aabb, part));
        }
        let run = |_: &mut (), (open, aabb, part): (Open, Aabb, &mut [Reference]), below: &mut Vec<Node>| {
            let idle = self.dividers.lock().unwrap_or_else(PoisonError::into_inner).pop();
            let mut divider = idle.unwrap_or_else(|| Divider::new(&self.params));
            below.push(Node::leaf(aabb, open.start, open.count));
            let left = work(&mut divider, Open { node: 0, ..open }, part, below);
            self.dividers.lock().unwrap_or_else(PoisonError::into_inner).push(divider);
            (open.node, left)
        };
        let room = |(open, ..): &(Open, Aabb, &mut [Reference])| room(open);
        for (shift, left) in grow_behind(nodes, jobs, room, || (), run) {
            level.extend(left.iter().map(|&open| Open { node: open.node + shift, ..open }));
        }
    }
}

fn stopped(pending: &[&[Open]]) -> BuildError {
    BuildError::Stopped(Unfinished { pending: pending.iter().copied().flatten().map(|open| open.count).collect() })
}

impl<const K: usize> Divider<K> {
    /// Divides one node, the first of `nodes`. Returns those that may be divided further.
    fn one(&mut self, root: Open, references: &mut [Reference], nodes: &mut Vec<Node>) -> Vec<Open> {
        let mut below = Vec::new();
        self.settle(root, references, nodes, &mut below);
        below.sort_unstable_by_key(|open| open.start);
        below
    }

    /// Grows everything below a node, the first of `nodes`. Nothing is left to divide.
    fn subtree(&mut self, root: Open, references: &mut [Reference], nodes: &mut Vec<Node>) -> Vec<Open> {
        let mut stack = vec![root];
        while let Some(open) = stack.pop() {
            let from = open.start - root.start;
            self.settle(open, &mut references[from..from + open.count], nodes, &mut stack);
        }
        stack
    }

    /// Divides a node, if it is not to stay a leaf, and adds what may be divided further to `open`.
    fn settle(&mut self, this: Open, references: &mut [Reference], nodes: &mut Vec<Node>, open: &mut Vec<Open>) {
        let aabb = nodes[this.node].aabb;
        if this.count == 1 || !self.divide(references, aabb.surface_area()) {
            return;
        }
        let mut start = this.start;
        let mut leaf = |node: usize, part: &bounds::Group| {
            let count = part.count as usize;
            open.push(Open { node, start, count });
            let leaf = Node::leaf(part.bounds.aabb(), start, count);
            start += count;
            leaf
        };
        let first = nodes.len();
        if self.is_wide() {
            nodes[this.node] = Node::inner(aabb, first, self.parts.len());
            nodes.extend(self.parts.iter().zip(first..).map(|(part, node)| leaf(node, part)));
            return;
        }
        let mut places = vec![this.node];
        let mut parts = self.parts.iter();
        for &is_cut in &self.is_cut {
            let Some(place) = places.pop() else { break };
            if is_cut {
                let children = nodes.len();
                nodes[place] = Node::inner(aabb, children, 2);
                nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
                places.extend([children + 1, children]);
            } else if let Some(part) = parts.next() {
                nodes[place] = leaf(place, part);
            }
        }
        // Boxes of the cuts in between, from below.
        for index in (first..nodes.len()).rev() {
            if !nodes[index].is_leaf() {
                nodes[index].aabb = Aabb::union_of(nodes[nodes[index].range()].iter().map(|child| &child.aabb));
            }
        }
    }
}
