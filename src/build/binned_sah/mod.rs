//! `binned-sah`: top-down by the surface area heuristic, with the planes between equal bins of centres as candidates.
//!
//! Source: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".
//!
//! A node's references fall into equal bins by their centres; bins give boxes and counts, and these the cost of each
//! plane between two of them. The node is divided at the cheapest, or becomes a leaf where that is cheaper.
//!
//! **One pass a level.** While the references of a node part, each one goes into the bins of its child at once. So the
//! bins have to be laid before the child's centres are known: over the part of its parent's span on its side of the
//! plane, as far as its box, which follows from the parent's bins, can have centres in it.
//!
//! **Parallel.** Large nodes are divided level by level: where one of them would keep the others waiting, by all threads,
//! each with a run of references; else by one thread each. What is left are subtrees that fit into a core's cache, one thread
//! each. Parting is stable, and minima, maxima and counts know no order, so the tree does not depend on the threads.
//!
//! **Numbers.** Costs are f32, of half areas. Scenes so large or so small that this could overflow or vanish are built
//! at another scale, a power of two, and get their own boxes back.
//!
//! Deviations:
//! - Wald looks at the axis on which the centres spread most, and so do large nodes. Small ones have bins on all axes:
//!   that is where most of the cost is decided.
//! - Spans are not tight around the centres, unless all of them fall into the same bin. Then they are made tight; and
//!   where all centres are the same, halves of the references in their order are the children.
//! - Few references have few bins; of subtrees over at most four references, the cheapest of all is taken.

mod bins;
mod grow;
mod lanes;
mod parting;
mod small;
mod team;
#[cfg(test)]
mod tests;

use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use crate::simd::Simd;
use grow::Part;
use lanes::{Lanes, Survey};
use rayon::prelude::*;
use std::mem::MaybeUninit;
use team::{Task, Team};

/// The most bins on an axis.
pub const MOST_BINS: usize = 256;

/// Subtrees of at most so many references are grown by one thread each: in both arrays they fill a core's own cache.
const SUBTREE: usize = 1 << 14;

/// Subtrees between two looks at the budget.
const BATCH: usize = 64;

/// From so many references on, only the axis on which they spread most has bins.
const WIDEST: usize = 1 << 10;

/// The bins worth laying for so many references.
#[inline(always)]
const fn few(references: usize) -> usize {
    4 + references / 8
}

/// What `binned-sah` can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BinnedSah {
    /// The most triangles a leaf holds.
    pub max_leaf: usize,
    /// The most bins on an axis, from 2 to [`MOST_BINS`].
    pub bins: usize,
}

impl Default for BinnedSah {
    fn default() -> Self {
        Self { max_leaf: MAX_LEAF, bins: 32 }
    }
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, a number of bins out of range, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &BinnedSah, probe: &mut P) -> Result<Bvh, BuildError> {
    build_at(Simd::detect(), boxes, params, probe)
}

/// [`build`] with vector instructions of the caller's choice.
pub(super) fn build_at<P: Probe>(
    simd: Simd,
    boxes: &[Aabb],
    params: &BinnedSah,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    if !(2..=MOST_BINS).contains(&params.bins) {
        return Err(BuildError::Parameter(format!("binned-sah takes 2 to {MOST_BINS} bins")));
    }
    let mut references = Vec::with_capacity(boxes.len());
    let references = &mut references.spare_capacity_mut()[..boxes.len()];
    let survey = survey(boxes, references)?;
    let scale = scale_for(&survey.aabb.aabb());
    if scale == 1.0 {
        // SAFETY: `survey` wrote them.
        return unsafe { grow_all(simd, references, &survey, params, probe) };
    }
    let scaled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
    let survey = self::survey(&scaled, references)?;
    // SAFETY: as above.
    let bvh = unsafe { grow_all(simd, references, &survey, params, probe)? };
    Ok(with_boxes_of(bvh, boxes))
}

/// What the boxes are like. Fills `references` with references to all of them.
fn survey(boxes: &[Aabb], references: &mut [MaybeUninit<Lanes>]) -> Result<Survey, BuildError> {
    if boxes.is_empty() || boxes.len() >= 1 << 31 {
        check_boxes(boxes)?;
    }
    let write = |(run, (boxes, references)): (usize, (&[Aabb], &mut [MaybeUninit<Lanes>]))| {
        let ids = (run * SUBTREE) as u32..;
        let written = ids.zip(boxes).zip(references).map(|((id, aabb), to)| &*to.write(Lanes::tagged(aabb, id)));
        written.fold(Survey::NOTHING, Survey::with)
    };
    let runs = boxes.par_chunks(SUBTREE).zip(references.par_chunks_mut(SUBTREE)).enumerate();
    let survey = runs.map(write).reduce(|| Survey::NOTHING, Survey::and);
    if !survey.is_sound() {
        // Or it is only larger than can be told from these sums.
        check_boxes(boxes)?;
    }
    Ok(survey)
}

/// A power of two that takes coordinates to where neither areas overflow f32 nor those of small boxes vanish; 1 for
/// all but extreme scenes.
fn scale_for(bounds: &Aabb) -> f32 {
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    if largest == 0.0 || (2f32.powi(-20)..2f32.powi(40)).contains(&largest) {
        return 1.0;
    }
    // To between 1 and 2; where that takes a factor beyond f32, as near as it gets.
    2f32.powi((-f64::from(largest).log2().floor() as i32).clamp(-126, 127))
}

/// The tree with the boxes that its triangles have: numbers far below the largest do not survive scaling.
fn with_boxes_of(mut bvh: Bvh, boxes: &[Aabb]) -> Bvh {
    for index in (0..bvh.nodes.len()).rev() {
        bvh.nodes[index].aabb = if bvh.nodes[index].is_leaf() {
            Aabb::union_of(bvh.leaf_triangles(index).iter().map(|&id| &boxes[id as usize]))
        } else {
            Aabb::union_of(bvh.nodes[bvh.children(index)].iter().map(|n| &n.aabb))
        };
    }
    bvh
}

/// # Safety
/// All `references` have been written.
unsafe fn grow_all<P: Probe>(
    simd: Simd,
    references: &mut [MaybeUninit<Lanes>],
    survey: &Survey,
    params: &BinnedSah,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    let count = references.len();
    let mut second = Vec::with_capacity(count);
    let mut ids = vec![0; count];
    let mut nodes = Vec::with_capacity(2 * count - 1);

    let mut team = Team::new(simd, params.max_leaf, params.bins, rayon::current_num_threads());
    let part = Part { start: 0, arrays: [references, &mut second.spare_capacity_mut()[..count]], ids: &mut ids };
    // SAFETY: the caller's.
    let mut large: Vec<Task> = unsafe { team.root(part, survey, &mut nodes) }.into_iter().collect();
    // Level by level, down to subtrees.
    let mut subtrees = Vec::new();
    while !large.is_empty() {
        if !probe.go_on(steps(&large)) {
            return Err(stopped(large.iter().chain(&subtrees)));
        }
        let (still_large, small) = team.divide(large, &mut nodes).into_iter().partition(|task| task.count() > SUBTREE);
        large = still_large;
        subtrees.extend::<Vec<_>>(small);
    }
    let mut subtrees = subtrees.into_iter();
    while subtrees.len() > 0 {
        let batch: Vec<Task> = subtrees.by_ref().take(BATCH).collect();
        if !probe.go_on(steps(&batch)) {
            return Err(stopped(batch.iter().chain(subtrees.as_slice())));
        }
        team.finish(batch, &mut nodes);
    }
    let tally = team.tally();
    probe.add(Work::Binned, tally.binned);
    probe.add(Work::SplitCosts, tally.costs);
    Ok(Bvh { nodes, triangle_ids: ids, arity: 2 })
}

/// The references of all tasks.
fn steps(tasks: &[Task]) -> u64 {
    tasks.iter().map(|task| task.count() as u64).sum()
}

fn stopped<'a, 'b: 'a>(tasks: impl Iterator<Item = &'a Task<'b>>) -> BuildError {
    BuildError::Stopped(Unfinished { pending: tasks.map(Task::count).collect() })
}
