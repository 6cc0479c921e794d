//! `hlbvh`: neighbours along the Morton curve below, binned SAH above.
//!
//! Sources: Pantaleoni and Luebke 2010, "HLBVH: Hierarchical LBVH Construction for Real-Time Ray Tracing" (its SAH-optimized variant);
//! Garanzha, Pantaleoni and McAllister 2011, "Simpler and Faster HLBVH with Work Queues".
//!
//! The tree of [`super::lbvh`] is cut into its largest subtrees of at most [`Hlbvh::cluster`] triangles that hang together.
//! These clusters stay as they are; what is above them is built anew by [`super::binned_sah`], with each cluster as one box.
//! Most of the decisions are made below, quickly; those that most rays meet are made above, by their cost.
//!
//! Deviations: Pantaleoni and Luebke, and Garanzha after them, take as clusters what shares the upper bits of its codes, which
//! in a dense part of an uneven scene is most of the scene; here they are cut by their number of triangles, so that what is
//! above them has about the same share of the work everywhere. A subtree that would cost as a leaf more than three times what its
//! halves would is none: a large triangle among small ones would hide them all. Clusters count alike in the cost, however many
//! triangles they have.

mod clusters;
#[cfg(test)]
mod tests;

use super::binned_sah::{self, BinnedSah};
use super::lbvh::{Edges, MOST_IN_LEAF, PART, cut, join, leaves_of};
use super::morton::Order;
use super::{BuildError, MAX_LEAF, Probe, Unfinished, Work};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use crate::simd::Simd;
use clusters::Starts;
use rayon::prelude::*;
use std::ops::Range;

/// The most triangles that a cluster may be asked to hold. Larger ones would save little: not much time is spent above them.
pub const MOST_IN_CLUSTER: usize = 256;

/// Parameters of [`build`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hlbvh {
    /// The most triangles a leaf holds, from 1 to 64.
    pub max_leaf: usize,
    /// The most triangles of a cluster, from 1 to [`MOST_IN_CLUSTER`]; where a leaf may hold more, as many as that. Few make
    /// a better tree, many a faster build.
    pub cluster: usize,
    /// The most bins on an axis above the clusters, from 2 to [`binned_sah::MOST_BINS`].
    pub bins: usize,
}

impl Default for Hlbvh {
    fn default() -> Self {
        Self { max_leaf: MAX_LEAF, cluster: 32, bins: BinnedSah::default().bins }
    }
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`super::check_boxes`] refuses, a parameter out of range, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Hlbvh, probe: &mut P) -> Result<Bvh, BuildError> {
    build_with(boxes, params, Simd::detect(), PART, probe)
}

/// [`build`] with vector instructions and a size of parts of the caller's choice.
fn build_with<P: Probe>(
    boxes: &[Aabb],
    params: &Hlbvh,
    simd: Simd,
    part: usize,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    for (what, asked, most) in
        [("a leaf", params.max_leaf, MOST_IN_LEAF), ("a cluster", params.cluster, MOST_IN_CLUSTER)]
    {
        if !(1..=most).contains(&asked) {
            return Err(BuildError::Parameter(format!("{what} holds 1 to {most} triangles")));
        }
    }
    let order = Order::new(boxes, simd)?;
    let n = boxes.len() as u64;
    probe.add(Work::KeysSorted, order.moved);
    if !probe.go_on(n) {
        return Err(BuildError::Stopped(Unfinished { pending: vec![boxes.len()] }));
    }
    let below = Below::new(boxes, &order, params, part);
    probe.add(Work::Merges, n - below.clusters() as u64);
    probe.add(Work::BoxUnions, n - below.clusters() as u64);
    let (roots, mut nodes) = below.join(&order.levels);
    let clusters: Vec<Aabb> = roots.iter().map(|root| root.aabb).collect();
    let above = BinnedSah { max_leaf: 1, bins: params.bins };
    let above = binned_sah::build_at(simd, &clusters, &above, probe).map_err(|e| match e {
        BuildError::Stopped(_) => BuildError::Stopped(Unfinished { pending: vec![boxes.len()] }),
        other => other,
    })?;
    for (to, node) in nodes.iter_mut().zip(&above.nodes) {
        *to = if node.is_leaf() { roots[above.triangle_ids[node.range().start] as usize] } else { *node };
    }
    Ok(Bvh { nodes, triangle_ids: order.ids, arity: 2 })
}

/// A part of the order: its leaves, and where clusters begin among them.
struct Part {
    leaves: Vec<Node>,
    clusters: Vec<usize>,
}

impl Part {
    /// Nodes below the roots of its clusters.
    fn below(&self) -> usize {
        2 * (self.leaves.len() - self.clusters.len())
    }
}

/// All that is below the roots of clusters, and these.
struct Below(Vec<(Part, Edges)>);

impl Below {
    fn new(boxes: &[Aabb], order: &Order, params: &Hlbvh, part: usize) -> Self {
        let most = params.cluster.max(params.max_leaf);
        let of = |part: Range<usize>| {
            let edges = Edges::of(&order.levels, &part);
            let mut clusters = Starts { most, leaves: Vec::with_capacity(part.len()) };
            let leaves = leaves_of(boxes, order, part, &edges, params.max_leaf, &mut clusters);
            (Part { leaves, clusters: clusters.leaves }, edges)
        };
        Self(cut(&order.levels, part, most).into_par_iter().map(of).collect())
    }

    /// How many clusters there are.
    fn clusters(&self) -> usize {
        self.0.iter().map(|(part, _)| part.clusters.len()).sum()
    }

    /// The roots of the clusters, and the nodes of the tree: empty leaves where those above and the roots belong, then what is
    /// below each cluster.
    fn join(self, levels: &[u8]) -> (Vec<Node>, Vec<Node>) {
        let clusters = self.clusters();
        let above = 2 * clusters - 1;
        let total = above + self.0.iter().map(|(part, _)| part.below()).sum::<usize>();
        let mut nodes = Vec::with_capacity(total);
        nodes.resize(above, Node::leaf(Aabb::EMPTY, 0, 0));
        let (mut rest, mut first) = (&mut nodes.spare_capacity_mut()[..total - above], above);
        let mut tasks = Vec::with_capacity(self.0.len());
        for (part, edges) in self.0 {
            let below = part.below();
            let region = rest.split_off_mut(..below).expect("as many as were counted");
            tasks.push((part, edges, region, first));
            first += below;
        }
        let join_part = |(part, edges, region, first): (Part, Edges, _, usize)| {
            // From right to left: nothing joins what is before a cluster.
            let mut starts = part.clusters.iter().rev().peekable();
            let levelled = part.leaves.iter().enumerate().rev().map(|(index, leaf)| {
                let begins = starts.next_if_eq(&&index).is_some();
                (*leaf, if begins { Edges::NONE } else { edges.before(levels, leaf) })
            });
            join(levelled, Edges::NONE, region, first)
        };
        let roots: Vec<Vec<(Node, i16)>> = tasks.into_par_iter().map(join_part).collect();
        // SAFETY: `join` fills the whole of its region or panics; the regions are all nodes behind those above.
        unsafe { nodes.set_len(total) };
        let roots = roots.iter().flat_map(|roots| roots.iter().rev()).map(|(root, _)| *root).collect();
        (roots, nodes)
    }
}
