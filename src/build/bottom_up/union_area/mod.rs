//! `bottom-up`, preset `walter`, engine `exact`: the globally closest pair by the area of the union, in near-linear work.
//!
//! Union area is reducible, so mutually nearest clusters may merge in any order; they are found by chains of nearest
//! neighbours within parts of the clusters, side by side.

mod chain;
mod order;
mod quad;
mod tree;

use super::merges::Merges;
use crate::build::{BuildError, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use chain::Part;
use order::Live;
use quad::{Entry, LANES};
use rayon::prelude::*;
use tree::Tree;

/// Parts of 4^PART_LEVEL clusters.
const PART_LEVEL: usize = 6;

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut live: Vec<Live> = (0u32..).zip(boxes).map(|(id, &aabb)| Live { aabb, id, handle: id }).collect();
    let mut merges = Merges::new(boxes.len());
    let mut tree = Tree::default();
    let mut level = PART_LEVEL;
    while live.len() > 1 {
        order::sort(&mut live);
        tree.fill(live.iter().map(|c| Entry { inner: c.aabb, id: c.id }));
        let level_now = level.min(tree.height());
        let parts = live.len().div_ceil(1 << (2 * level_now));
        let next = merges.next();
        let work = |part: &mut Part, i: usize| part.merge_all(&tree, &live, level_now, i, next, |_| true);
        let outcomes: Vec<_> = (0..parts).into_par_iter().map_init(Part::default, work).collect();
        let before = live.len();
        live.clear();
        for outcome in outcomes {
            let base = merges.append(next, &outcome.merges);
            let shift = base - next;
            live.extend(
                outcome
                    .live
                    .iter()
                    .map(|c| Live { handle: if c.handle >= next { c.handle + shift } else { c.handle }, ..*c }),
            );
            let effort = outcome.effort;
            probe.add(Work::NearestSearches, effort.searches);
            probe.add(Work::SearchVisits, effort.quads * LANES as u64);
            probe.add(Work::PairDistances, effort.pairs);
            probe.add(Work::BoxUnions, effort.quads * LANES as u64 + effort.exact + outcome.merges.len() as u64);
            probe.add(Work::Merges, outcome.merges.len() as u64);
            if !probe.go_on(effort.quads * LANES as u64) {
                return Err(BuildError::Stopped(Unfinished { pending: vec![before] }));
            }
        }
        if live.len() > before / 2 {
            level += 1;
        }
    }
    Ok(merges.into_tree(boxes))
}
