//! `bottom-up`, preset `walter`, engine `exact`.

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


/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut live: Vec<Live> = (0u32..).zip(boxes).map(|(id, &aabb)| Live { aabb, id, handle: id }).collect();
    let mut merges = Merges::new(boxes.len());
    let mut tree = Tree::default();
    let mut level: usize = std::env::var("LV").map_or(6, |s| s.parse().unwrap());
    let dbg = std::env::var("DBG").is_ok();
    while live.len() > 1 {
        let t0 = std::time::Instant::now();
        order::sort(&mut live);
        let t1 = t0.elapsed();
        tree.fill(&live, |c| Entry { inner: c.aabb, id: c.id });
        let t2 = t0.elapsed();
        let level_now = level.min(tree.height());
        let parts = live.len().div_ceil(1 << (2 * level_now));
        let next = merges.next();
        let work = |part: &mut Part, i: usize| part.merge_all(&tree, &live, level_now, i, next, |_| true);
        let outcomes: Vec<_> = (0..parts).into_par_iter().map_init(Part::default, work).collect();
        let before = live.len();
        live.clear();
        let (mut s, mut q, mut e) = (0, 0, 0);
        for outcome in outcomes {
            let base = merges.append(next, &outcome.merges);
            let shift = base - next;
            live.extend(outcome.live.iter().map(|c| Live {
                handle: if c.handle >= next { c.handle + shift } else { c.handle },
                ..*c
            }));
            let effort = outcome.effort;
            s += effort.searches;
            q += effort.quads;
            e += effort.exact;
            probe.add(Work::NearestSearches, effort.searches);
            probe.add(Work::SearchVisits, effort.quads * LANES as u64);
            probe.add(Work::PairDistances, effort.pairs);
            probe.add(Work::BoxUnions, effort.quads * LANES as u64 + effort.exact + outcome.merges.len() as u64);
            probe.add(Work::Merges, outcome.merges.len() as u64);
            if !probe.go_on(effort.quads * LANES as u64) {
                return Err(BuildError::Stopped(Unfinished { pending: vec![before] }));
            }
        }
        if dbg {
            println!("  phase {before} -> {} parts {parts} sort {t1:?} fill {:?} all {:?} searches {s} quads/search {:.1} exact/search {:.1}", live.len(), t2 - t1, t0.elapsed(), q as f64 / s as f64, e as f64 / s as f64);
        }
        if live.len() > before / 2 {
            level += 1;
        }
    }
    let t0 = std::time::Instant::now();
    let r = merges.into_tree(boxes);
    if dbg { println!("  tree {:?}", t0.elapsed()); }
    Ok(r)
}
