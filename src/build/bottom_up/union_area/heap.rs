//! The same clustering in the order of its merges: a heap of nearest neighbours. One thread, no parts, no chains: the
//! cross-check of [`build`](super::build).
//!
//! Source: Walter et al. 2008. Every cluster keeps the nearest it found when it was searched; a heap has the least key on
//! top. A key whose owner is gone is dropped, one whose other cluster is gone is searched again, any other is the
//! globally closest pair: the younger cluster of any pair has seen the older one, so the least key of all pairs is in the
//! heap or a lower bound of it is. This holds for any distance, reducible or not.

use super::order::{self, Live};
use super::quad::{Entry, NOBODY};
use super::tree::{Effort, Nearest, Stack, Tree};
use super::{Merges, count, count_merges, stopped};
use crate::build::{BuildError, MAX_LEAF, Probe, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A pair as it was found. Clusters go by position and handle: an id passes on to what a cluster merges into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Found {
    /// Bits of the distance: not negative, so their order is its order.
    distance: u64,
    ids: [u32; 2],
    owner: [u32; 2],
    other: [u32; 2],
}

struct Clusters {
    tree: Tree,
    /// By position; [`NOBODY`] where the cluster has merged into another.
    handles: Vec<u32>,
    heap: BinaryHeap<Reverse<Found>>,
    stack: Stack,
    effort: Effort,
}

impl Clusters {
    fn new(boxes: &[Aabb], live: &[Live]) -> Self {
        let mut tree = Tree::new(boxes);
        tree.fill(live);
        Self {
            tree,
            handles: live.iter().map(|c| c.handle).collect(),
            heap: BinaryHeap::with_capacity(live.len()),
            stack: Stack::default(),
            effort: Effort::default(),
        }
    }

    /// Searches the nearest of the cluster at position `at`; none if it is the last one.
    fn search(&mut self, at: u32) {
        let own = self.tree.get(at as usize);
        let mut best = Nearest::NONE;
        self.effort.searches += 1;
        self.tree.nearest::<false>(&own.inner, 0, at as usize, &mut best, &mut self.stack, &mut self.effort);
        if best.id != NOBODY {
            let named = |at: u32| [at, self.handles[at as usize]];
            self.heap.push(Reverse(Found {
                distance: best.distance.to_bits(),
                ids: [own.id.min(best.id), own.id.max(best.id)],
                owner: named(at),
                other: named(best.at),
            }));
        }
    }

    fn is_live(&self, [at, handle]: [u32; 2]) -> bool {
        self.handles[at as usize] == handle
    }
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut merges = Merges::new(boxes.len());
    let mut live = order::triangles(boxes);
    order::sort(&mut live);
    let mut clusters = Clusters::new(boxes, &live);
    let mut steps = 0;
    let mut go_on = |effort: &Effort| probe.go_on(effort.steps() - std::mem::replace(&mut steps, effort.steps()));
    for at in 0..live.len() as u32 {
        clusters.search(at);
        if !go_on(&clusters.effort) {
            return Err(stopped(boxes, &merges));
        }
    }
    while let Some(Reverse(found)) = clusters.heap.pop() {
        if !clusters.is_live(found.owner) {
            continue;
        }
        let at = found.owner[0];
        if clusters.is_live(found.other) {
            let (own, other) = (clusters.tree.get(at as usize), clusters.tree.get(found.other[0] as usize));
            let [a, b] = [found.owner[1], found.other[1]];
            let made = if own.id < other.id { merges.push(a, b) } else { merges.push(b, a) };
            let merged = Entry { inner: own.inner.union(&other.inner), id: own.id.min(other.id) };
            clusters.tree.set(found.other[0] as usize, &Entry::VACANT);
            clusters.tree.set(at as usize, &merged);
            clusters.handles[found.other[0] as usize] = NOBODY;
            clusters.handles[at as usize] = made;
        }
        clusters.search(at);
        if !go_on(&clusters.effort) {
            return Err(stopped(boxes, &merges));
        }
    }
    count(&clusters.effort, probe);
    count_merges(boxes, probe);
    Ok(merges.into_tree(boxes, MAX_LEAF))
}
