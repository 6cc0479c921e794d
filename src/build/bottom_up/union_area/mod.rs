//! `bottom-up`, preset `walter`, engine `exact`: agglomeration by least union area in near-linear work, on all cores.
//!
//! Source: Walter et al. 2008, "Fast Agglomerative Clustering for Rendering", for the problem, reducibility and locally
//! ordered merging; Benzécri 1982 for chains of nearest neighbours. The tree is that of
//! [`all_pairs_literal`](super::all_pairs_literal), ties included.
//!
//! **Order.** A cluster has a box and an id, its smallest triangle. The key of a pair is (area of the union, smaller id,
//! larger id): no two pairs share one. Seen from one of the two, keys are in the order of (area, the other's id).
//!
//! **Reducible.** For any C beside A and B, key(A∪B, C) ≥ key(A, C) or ≥ key(B, C). Say A∪B has A's id. Its box contains
//! A's and areas are monotone, rounding included ([`Aabb::surface_area`]), so the area is no smaller, and the ids are
//! those of A and C. Merging brings nothing nearer to anybody.
//!
//! **Any order will do.** Let A and B be nearest to each other. Whatever others merge, both stay nearest to each other,
//! so the only pair of either that the literal engine can ever choose is (A, B): A∪B is a node of its tree. Merged now
//! instead of then, A∪B disturbs nothing in between: key(A∪B, C) > key(A, B) for every C, and until it comes to (A, B)
//! the literal engine chooses smaller keys only.
//!
//! **Phases.** Clusters are sorted into a search tree (`order`, `tree`) and cut into parts of neighbours. Each part
//! merges on its own what is mutually nearest (`chain`), with all others standing still as they were. What they turn
//! into meanwhile is no nearer than they were, so what is mutually nearest in this picture is so indeed; and parts
//! know nothing of each other, so neither tree nor counts depend on threads. What is left, clusters with their nearest
//! in another part, begins the next phase. A part that is everything leaves one cluster.
//!
//! **Work.** A phase makes at most 3 searches per merge and 2 per cluster it leaves. One that leaves more than half,
//! as where all are nearest to one of smallest id, is followed by one with larger parts.
//!
//! Deviations: none in the tree. Walter et al. keep clusters in a kd-tree, and merge in parallel by other means.

mod chain;
pub mod heap;
mod order;
mod quad;
#[cfg(test)]
mod tests;
mod tree;

use super::merges::Merges;
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use chain::{Part, Place};
use quad::LANES;
use rayon::prelude::*;
use tree::{Effort, Tree};

/// Levels of the search tree that a part of the first phase spans: 4⁶ clusters, which a core's own cache holds.
const FIRST_SPAN: usize = 6;

/// Levels that parts gain where a phase leaves more than half of its clusters.
const MORE_SPAN: usize = 2;

/// Parts between two looks at the budget; each has its own memory, used again and again.
const BATCH: usize = 16;

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    build_with_leaves(boxes, MAX_LEAF, probe)
}

/// [`build`], with leaves of at most `max_leaf` triangles: clusters that are no larger.
///
/// # Errors
/// As [`build`].
pub fn build_with_leaves<P: Probe>(boxes: &[Aabb], max_leaf: usize, probe: &mut P) -> Result<Bvh, BuildError> {
    Ok(merges_spanning(boxes, FIRST_SPAN, probe)?.into_tree(boxes, max_leaf))
}

/// The merges, with parts of 4^span clusters in the first phase.
fn merges_spanning<P: Probe>(boxes: &[Aabb], span: usize, probe: &mut P) -> Result<Merges, BuildError> {
    check_boxes(boxes)?;
    let mut live = order::triangles(boxes);
    let mut left = Vec::new();
    let mut merges = Merges::new(boxes.len());
    let mut tree = Tree::new(boxes);
    let mut batch: Vec<Part> = Vec::new();
    let mut span = span;
    while live.len() > 1 {
        order::sort(&mut live);
        tree.fill(&live);
        let place = Place { tree: &tree, clusters: &live, span: span.min(tree.height()), next: merges.next() };
        let parts = place.parts();
        batch.resize_with(batch.len().max(parts.min(BATCH)), Part::default);
        left.clear();
        for first in (0..parts).step_by(BATCH) {
            let batch = &mut batch[..BATCH.min(parts - first)];
            if parts == 1 {
                batch[0].merge_all(&place, 0, |steps| probe.go_on(steps));
            } else {
                let numbered = batch.par_iter_mut().with_max_len(1).enumerate();
                numbered.for_each(|(i, part)| part.merge_all(&place, first + i, |_| true));
            }
            let mut go_on = true;
            for part in batch {
                part.move_into(&mut merges, place.next, &mut left);
                count(&part.effort, probe);
                go_on &= !part.stopped && (parts == 1 || probe.go_on(part.effort.steps()));
            }
            if !go_on {
                return Err(stopped(boxes, &merges));
            }
        }
        if left.len() > live.len() / 2 {
            span += MORE_SPAN;
        }
        std::mem::swap(&mut live, &mut left);
    }
    count_merges(boxes, probe);
    Ok(merges)
}

/// Tells what searches did.
fn count<P: Probe>(effort: &Effort, probe: &mut P) {
    probe.add(Work::NearestSearches, effort.searches);
    probe.add(Work::SearchVisits, effort.quads * LANES as u64);
    probe.add(Work::PairDistances, effort.pairs);
    probe.add(Work::BoxUnions, effort.quads * LANES as u64 + effort.bounds + effort.pairs);
}

/// Tells of all merges of a finished build.
fn count_merges<P: Probe>(boxes: &[Aabb], probe: &mut P) {
    probe.add(Work::Merges, boxes.len() as u64 - 1);
    probe.add(Work::BoxUnions, boxes.len() as u64 - 1);
}

fn stopped(boxes: &[Aabb], merges: &Merges) -> BuildError {
    BuildError::Stopped(Unfinished { pending: vec![boxes.len() - merges.len()] })
}
