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
//! **Parallel.** Large nodes are divided by all threads, each with a run of references; what is left are subtrees that
//! fit into a core's cache, one thread each. Parting is stable, and minima, maxima and counts know no order, so the
//! tree does not depend on the threads.
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
mod small;
#[cfg(test)]
mod tests;

use super::subtrees::append;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use crate::simd::Simd;
use grow::{Grower, Open, Part, Tally};
use lanes::{Lanes, Survey};
use rayon::prelude::*;

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

fn build_at<P: Probe>(simd: Simd, boxes: &[Aabb], params: &BinnedSah, probe: &mut P) -> Result<Bvh, BuildError> {
    if !(2..=MOST_BINS).contains(&params.bins) {
        return Err(BuildError::Parameter(format!("binned-sah takes 2 to {MOST_BINS} bins")));
    }
    let (references, survey) = references(boxes)?;
    let scale = scale_for(&survey.aabb.aabb());
    if scale == 1.0 {
        return grow_all(simd, references, &survey, params, probe);
    }
    let scaled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
    let (references, survey) = self::references(&scaled)?;
    Ok(with_boxes_of(grow_all(simd, references, &survey, params, probe)?, boxes))
}

/// The references to all boxes, and what they are like.
fn references(boxes: &[Aabb]) -> Result<(Vec<Lanes>, Survey), BuildError> {
    if boxes.is_empty() || boxes.len() >= 1 << 31 {
        check_boxes(boxes)?;
    }
    let mut survey = Survey::NOTHING;
    let mut references = Vec::new();
    let tagged = |(id, aabb): (usize, &Aabb)| Lanes::tagged(aabb, id as u32);
    if rayon::current_num_threads() > 1 {
        boxes.par_iter().enumerate().with_min_len(SUBTREE).map(tagged).collect_into_vec(&mut references);
        let runs = references.par_chunks(SUBTREE);
        survey = runs.map(|run| run.iter().fold(Survey::NOTHING, Survey::with)).reduce(|| Survey::NOTHING, Survey::and);
    } else {
        references.extend(boxes.iter().enumerate().map(tagged).inspect(|one| survey = survey.with(one)));
    }
    if !survey.is_sound() {
        // Or it is only larger than can be told from these sums.
        check_boxes(boxes)?;
    }
    Ok((references, survey))
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

fn grow_all<P: Probe>(
    simd: Simd,
    references: Vec<Lanes>,
    survey: &Survey,
    params: &BinnedSah,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    let &BinnedSah { max_leaf, bins } = params;
    let threads = rayon::current_num_threads();
    let count = references.len();
    let (mut first, mut second) = (references, Vec::new());
    if threads > 1 {
        first.par_iter().with_min_len(SUBTREE).map(|_| Lanes::EMPTY).collect_into_vec(&mut second);
    } else {
        second.resize(count, Lanes::EMPTY);
    }
    let mut ids = vec![0; count];
    let mut nodes = Vec::with_capacity(2 * count - 1);

    let mut grower = Grower::new(simd, max_leaf, bins, threads);
    let mut part = Part { start: 0, arrays: [&mut first, &mut second], ids: &mut ids };
    let mut subtrees = Vec::new();
    let root = grower.root(&mut part, survey, &mut nodes);
    if let Some(root) = root
        && !grower.grow(root, &mut part, &mut nodes, SUBTREE, &mut subtrees, |steps| probe.go_on(steps))
    {
        let pending = grower.pending().chain(subtrees.iter().map(|open| open.place.count)).collect();
        return Err(BuildError::Stopped(Unfinished { pending }));
    }
    let mut tally = grower.tally;
    let parts = parts_of(part, &subtrees);
    let mut jobs = subtrees.into_iter().zip(parts).collect::<Vec<(Open, Part)>>().into_iter();
    while jobs.len() > 0 {
        let batch: Vec<_> = jobs.by_ref().take(BATCH).collect();
        let steps = batch.iter().map(|(open, _)| open.place.count as u64).sum();
        if !probe.go_on(steps) {
            let pending = batch.iter().chain(jobs.as_slice()).map(|(open, _)| open.place.count).collect();
            return Err(BuildError::Stopped(Unfinished { pending }));
        }
        if threads == 1 {
            for (open, mut part) in batch {
                grower.grow(open, &mut part, &mut nodes, 0, &mut Vec::new(), |_| true);
            }
            continue;
        }
        let grown: Vec<_> = batch
            .into_par_iter()
            .with_max_len(1)
            .map_init(
                || Grower::new(simd, max_leaf, bins, 1),
                |grower, (mut open, mut part)| {
                    let place = std::mem::replace(&mut open.place.node, 0);
                    let mut block = Vec::with_capacity(2 * open.place.count - 1);
                    block.push(Node::leaf(Aabb::EMPTY, 0, 0));
                    grower.tally = Tally::default();
                    grower.grow(open, &mut part, &mut block, 0, &mut Vec::new(), |_| true);
                    (place, block, grower.tally)
                },
            )
            .collect();
        append(&mut nodes, &grown.iter().map(|(place, block, _)| (*place, &block[..])).collect::<Vec<_>>());
        for (_, _, done) in grown {
            tally.binned += done.binned;
            tally.costs += done.costs;
        }
    }
    drop(jobs);
    if threads == 1 {
        tally = grower.tally;
    }
    probe.add(Work::Binned, tally.binned);
    probe.add(Work::SplitCosts, tally.costs);
    Ok(Bvh { nodes, triangle_ids: ids, arity: 2 })
}

/// The parts of the arrays that belong to each of `subtrees`, which are in rising order.
fn parts_of<'a>(part: Part<'a>, subtrees: &[Open]) -> Vec<Part<'a>> {
    let Part { start: mut at, arrays: [mut first, mut second], mut ids } = part;
    let mut parts = Vec::with_capacity(subtrees.len());
    for open in subtrees {
        let (start, count) = (open.place.start, open.place.count);
        let (one, more_first) = std::mem::take(&mut first)[start - at..].split_at_mut(count);
        let (two, more_second) = std::mem::take(&mut second)[start - at..].split_at_mut(count);
        let (slots, more_ids) = std::mem::take(&mut ids)[start - at..].split_at_mut(count);
        (first, second, ids, at) = (more_first, more_second, more_ids, start + count);
        parts.push(Part { start, arrays: [one, two], ids: slots });
    }
    parts
}
