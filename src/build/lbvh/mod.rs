//! `lbvh`: the binary tree that codes along the Morton curve have in themselves, with leaves where the cost wants them.
//!
//! Sources: Lauterbach et al. 2009, "Fast BVH Construction on GPUs": triangles are sorted by Morton codes of their centres, and
//! a node is split where the highest bit that differs in it changes. Karras 2012, "Maximizing Parallelism in the Construction
//! of BVHs, Octrees, and k-d Trees", and Apetrei 2014, "Fast and Simple Agglomerative LBVH Construction": the tree follows
//! from levels between neighbours alone, and can be put together from below with its boxes.
//!
//! **Leaves.** A first pass over the sorted triangles finds every subtree of at most `max_leaf` triangles and makes leaves of
//! it as [`crate::refine::open_leaves`] does, so that their number is known. A second one joins the leaves.
//!
//! **Layout.** A pair of siblings is written when its parent is known, from the back of the array to the front, and the pass
//! goes from right to left: parents stand before children, and nodes in depth-first order, left before right.
//!
//! **Parallel.** The sorted triangles are cut into parts, at places where no subtree as small as a leaf is cut. Each part joins
//! what is complete in it; what is not, a few nodes a part, is joined at last. Parts do not depend on threads.
//!
//! Deviations: Apetrei's threads climb from every leaf and meet at atomic flags; here a part is one sweep with a stack. Equal
//! codes are in the order of ids and are halved, not split by the bits of their places. Codes have 63 bits.

mod join;
mod leaves;
#[cfg(test)]
mod tests;

pub(super) use join::{Edges, join};
#[cfg(test)]
pub(super) use leaves::MOST_GROWTH;
pub(super) use leaves::{Clusters, leaves_of};

use super::morton::Order;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use crate::simd::Simd;
use join::complete;
use rayon::prelude::*;
use std::ops::Range;

/// Triangles of a part.
pub(super) const PART: usize = 1 << 14;

/// The most triangles that a leaf may be asked to hold.
pub(super) const MOST_IN_LEAF: usize = 64;

/// Parameters of [`build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lbvh {
    /// The most triangles a leaf holds, from 1 to 64.
    pub max_leaf: usize,
}

impl Default for Lbvh {
    fn default() -> Self {
        Self { max_leaf: MAX_LEAF }
    }
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`super::check_boxes`] refuses, a leaf size out of range, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Lbvh, probe: &mut P) -> Result<Bvh, BuildError> {
    build_with(boxes, params, Simd::detect(), PART, probe)
}

/// [`build`] with vector instructions and a size of parts of the caller's choice.
fn build_with<P: Probe>(
    boxes: &[Aabb],
    params: &Lbvh,
    simd: Simd,
    part: usize,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    if !(1..=MOST_IN_LEAF).contains(&params.max_leaf) {
        return Err(BuildError::Parameter(format!("a leaf holds 1 to {MOST_IN_LEAF} triangles")));
    }
    let order = Order::new(boxes, simd)?;
    let n = boxes.len() as u64;
    probe.add(Work::KeysSorted, order.moved);
    if !probe.go_on(n) {
        return Err(BuildError::Stopped(Unfinished { pending: vec![boxes.len()] }));
    }
    let nodes = nodes_over(boxes, &order, params.max_leaf, part);
    probe.add(Work::Merges, n - 1);
    probe.add(Work::BoxUnions, n - 1);
    probe.go_on(n);
    Ok(Bvh { nodes, triangle_ids: order.ids, arity: 2 })
}

/// The tree's nodes.
fn nodes_over(boxes: &[Aabb], order: &Order, max_leaf: usize, part: usize) -> Vec<Node> {
    let levels = &order.levels;
    let parts = cut(levels, part, max_leaf);
    let prepared: Vec<_> = parts
        .par_iter()
        .map(|part| {
            let edges = Edges::of(levels, part);
            let leaves = leaves_of(boxes, order, part.clone(), &edges, max_leaf, &mut ());
            let joined = complete(&leaves, levels, &edges);
            (leaves, edges, joined)
        })
        .collect();
    let total: usize = prepared.iter().map(|(leaves, ..)| 2 * leaves.len()).sum::<usize>() - 1;
    let mut nodes: Vec<Node> = Vec::with_capacity(total);
    // The root, the pairs joined last, the pairs of each part.
    let (root, mut rest) = nodes.spare_capacity_mut()[..total].split_at_mut(1);
    let of_parts: usize = prepared.iter().map(|(.., joined)| 2 * joined).sum();
    let mut first = total - of_parts;
    let last = rest.split_off_mut(..first - 1).expect("pairs of parts are not all");
    let mut tasks = Vec::with_capacity(prepared.len());
    for (leaves, edges, joined) in prepared {
        let region = rest.split_off_mut(..2 * joined).expect("as many as were counted");
        tasks.push((leaves, edges, region, first));
        first += 2 * joined;
    }
    let roots: Vec<Vec<(Node, i16)>> = tasks
        .into_par_iter()
        .map(|(leaves, edges, region, first)| {
            let levelled = leaves.iter().rev().map(|leaf| (*leaf, edges.before(levels, leaf)));
            join(levelled, edges.right, region, first)
        })
        .collect();
    let mut top = join(roots.into_iter().rev().flatten(), Edges::NONE, last, 1);
    let (tree, _) = top.pop().expect("there is a leaf");
    debug_assert!(top.is_empty());
    root[0].write(tree);
    // SAFETY: `join` fills the whole of its region or panics; the regions and the root are all nodes.
    unsafe { nodes.set_len(total) };
    nodes
}

/// Parts of about `part` triangles, cut where no subtree of at most `most` is.
pub(super) fn cut(levels: &[u8], part: usize, most: usize) -> Vec<Range<usize>> {
    let mut parts = Vec::with_capacity(levels.len() / part + 1);
    let mut start = 0;
    // A subtree that is parted at the place of least level among so many reaches beyond them.
    let window = most + 1;
    while start + part + window < levels.len() {
        let window = start + part..start + part + window;
        let place = window.min_by_key(|&place| levels[place]).expect("a window is not empty");
        parts.push(start..place + 1);
        start = place + 1;
    }
    parts.push(start..levels.len() + 1);
    parts
}
