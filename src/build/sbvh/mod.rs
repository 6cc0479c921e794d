//! `sbvh`: top-down by the surface area heuristic with object and spatial splits.
//!
//! Stich, Friedrich and Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies". At every node the best object
//! split is found; where its two sides overlap by more than α of the root's area, planes are tried, too, at which
//! references on both sides are cut in two, each with the box of its own part. The better of both splits is taken.
//!
//! Deviations:
//! - Object splits are not binned: every position of each axis is evaluated.
//! - Small nodes are cut into fewer slabs than large ones, and so are nodes whose references reach through many of them.
//!   Where a node has few references, the planes tried are the faces of their boxes.
//! - A reference is the part of a triangle within the box left by *all* cuts so far, clipped in f64, and drawn with a
//!   margin, so that no hit is lost (`reference`). The paper intersects boxes. Where triangles are not known, boxes are
//!   cut.
//! - The best object split and the best plane are found by the paper's cost, area times number. Which of both it is,
//!   and which references are not cut after all ("reference unsplitting"), is decided by an estimate of what the subtrees
//!   will cost (`estimate`): as if each side became one leaf, planes that pay off much further down would look too dear.
//! - At most [`Sbvh::budget`] references are added. A node hands what it does not use to its children, in proportion to
//!   the areas of their references, for that is what cuts make less of; so it is never exceeded, and nothing depends
//!   on the order in which nodes are split. What a node does not use is not used elsewhere.
//! - Nodes are split down to single references; leaves are made last, by cost ([`crate::refine::open_leaves`]). A triangle that stands
//!   several times below such a leaf stands in it once.
//!
//! **Parallel.** Nodes with many references are split in rounds, all of a round at once. Each of the others makes a
//! subtree on one thread. A node's split depends on its own references and budget alone.

mod estimate;
mod object;
mod reference;
mod spatial;
mod split;
mod subtree;
#[cfg(test)]
mod tests;

use super::{BuildError, Input, MAX_LEAF, Probe, Unfinished, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use rayon::prelude::*;
use reference::{Reference, Source};
use split::{Effort, Splitter, Workspace};
use subtree::{Subtree, assemble};

/// How the tree is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sbvh {
    /// Slabs that planes cut a large node into, per axis: 2 to 4096. Small nodes have fewer, and so have nodes that most references reach through.
    pub bins: usize,
    /// References that may be added, in percent of the triangles. With none the tree is that of object splits alone.
    pub budget: usize,
    /// α: the part of the root's surface area that both sides of an object split must share for planes to be tried.
    pub overlap: f64,
    /// The most triangles a leaf holds.
    pub max_leaf: usize,
}

impl Default for Sbvh {
    /// The paper's α. Few scenes use up the budget; hair does. With 32 bins a teapot in a stadium and a staircase come out 1 to 3 % dearer
    /// once they are refined (before, the staircase is cheaper by 2 %); with 128 in small nodes, too, the build takes up to half as long
    /// again, for 2 % at most.
    fn default() -> Self {
        Self { bins: 128, budget: 100, overlap: 1e-5, max_leaf: MAX_LEAF }
    }
}

/// The most slabs that a node is cut into.
const MOST_BINS: usize = 1 << 12;

/// References of a node that makes a subtree on one thread; as many as a leaf may hold, if that is more, so that leaves are
/// decided in subtrees.
const ALONE: usize = 4096;

/// Subtrees between two looks at the clock.
const BATCH: usize = 64;

/// A node not yet split.
struct Open {
    references: Vec<Reference>,
    budget: usize,
    /// Its place in the upper tree.
    place: usize,
}

/// A node of the upper tree.
#[derive(Clone, Copy, Debug)]
enum Upper {
    /// A subtree of its own, by number.
    Subtree(usize),
    /// A node with two children, by place.
    Inner(Aabb, [usize; 2]),
}

/// Builds the binary tree over the triangles of `input`, or over its boxes where triangles are not known.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, parameters out of their range, or the probe's stop.
pub fn build<P: Probe>(input: Input, params: &Sbvh, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(input.boxes)?;
    if !(2..=MOST_BINS).contains(&params.bins) {
        return Err(BuildError::Parameter(format!("planes cut a node into 2 to {MOST_BINS} bins")));
    }
    let n = input.boxes.len();
    // Slots and nodes have 31 bits.
    let budget = (n as u128 * params.budget as u128 / 100).min((1 << 31) - n as u128) as usize;
    let references: Vec<_> = (0u32..).zip(input.boxes).map(|(id, &aabb)| Reference { aabb, id }).collect();
    let root = union(&references);
    let splitter = Splitter { source: Source(input), params, least_overlap: params.overlap * root.surface_area() };
    let mut upper = vec![Upper::Subtree(0)];
    let mut small: Vec<Open> = Vec::new();
    let mut large = Vec::new();
    let sort = |open: Open, large: &mut Vec<Open>, small: &mut Vec<Open>, upper: &mut Vec<Upper>| {
        if open.references.len() > ALONE.max(params.max_leaf) {
            large.push(open);
        } else {
            upper[open.place] = Upper::Subtree(small.len());
            small.push(open);
        }
    };
    sort(Open { references, budget, place: 0 }, &mut large, &mut small, &mut upper);
    while !large.is_empty() {
        let split: Vec<_> = large.par_drain(..).map(|open| open.split(&splitter)).collect();
        let mut go_on = true;
        for (place, aabb, children, effort) in split {
            upper[place] = Upper::Inner(aabb, [upper.len(), upper.len() + 1]);
            for mut child in children {
                child.place = upper.len();
                upper.push(Upper::Subtree(0));
                sort(child, &mut large, &mut small, &mut upper);
            }
            go_on &= effort.tell(probe);
        }
        if !go_on {
            return Err(unfinished(large.iter().chain(&small)));
        }
    }
    let mut subtrees: Vec<Subtree> = Vec::with_capacity(small.len());
    while subtrees.len() < small.len() {
        let last = small.len().min(subtrees.len() + BATCH);
        let batch = &mut small[subtrees.len()..last];
        let grow = |room: &mut Workspace, open: &mut Open| {
            Subtree::grow(&splitter, std::mem::take(&mut open.references), open.budget, params.max_leaf, room)
        };
        let grown: Vec<Subtree> = batch.par_iter_mut().with_max_len(1).map_init(Workspace::default, grow).collect();
        let mut go_on = true;
        for subtree in &grown {
            go_on &= subtree.effort.tell(probe);
        }
        subtrees.extend(grown);
        if !go_on {
            return Err(unfinished(&small[subtrees.len()..]));
        }
    }
    Ok(assemble(&upper, subtrees))
}

/// What is left to do.
fn unfinished<'a>(open: impl IntoIterator<Item = &'a Open>) -> BuildError {
    BuildError::Stopped(Unfinished { pending: open.into_iter().map(|open| open.references.len()).collect() })
}

fn union(references: &[Reference]) -> Aabb {
    Aabb::union_of(references.iter().map(|r| &r.aabb))
}

impl Open {
    /// Its place, its box and its children.
    fn split(self, splitter: &Splitter) -> (usize, Aabb, [Self; 2], Effort) {
        let mut room = Workspace::default();
        let aabb = union(&self.references);
        let budgets = splitter.split(&self.references, &aabb, self.budget, &mut room);
        let child = |references, budget| Self { references, budget, place: 0 };
        let children = [child(room.left, budgets[0]), child(room.right, budgets[1])];
        (self.place, aabb, children, room.effort)
    }
}
