//! What the thesis' own kd-tree would have cost: the published chain, watched.

use crate::build::bottom_up::chain_literal::{self, Observer};
use crate::build::{Brake, BuildError, OriginalKdTree, OriginalWork};
use crate::geom::Aabb;
use glam::Vec3;
use std::time::Instant;

/// Follows the chain's searches and merges in the original's kd-tree.
#[derive(Debug)]
struct Replay {
    tree: OriginalKdTree,
    /// One search in so many is made.
    every: u64,
    /// Searches of the chain so far.
    searches: u64,
    /// Whether the tree lacked a cluster that the chain has.
    diverged: bool,
}

impl Replay {
    /// The work with all searches in it.
    fn scaled(&self) -> OriginalWork {
        let made = self.tree.work();
        // In 128 bits the products cannot overflow.
        let all = |n: u64| (u128::from(n) * u128::from(self.searches) / u128::from(made.queries.max(1))) as u64;
        OriginalWork {
            queries: self.searches,
            range_queries: all(made.range_queries),
            visited: all(made.visited),
            listed: all(made.listed),
            list_steps: all(made.list_steps),
            ..made
        }
    }
}

impl Observer for Replay {
    fn search(&mut self, id: u32, centre: Vec3) {
        if self.searches.is_multiple_of(self.every) {
            self.diverged |= self.tree.nearest(id, centre).is_none();
        }
        self.searches += 1;
    }

    fn merge(&mut self, a: (u32, Vec3), b: (u32, Vec3), merged: (u32, Vec3)) {
        self.diverged |= !(self.tree.remove(a.0, a.1) & self.tree.remove(b.0, b.1));
        self.tree.insert(merged.0, merged.1);
    }
}

/// Counts the work of the original's kd-tree over a whole build of `bottom-up published`; `None` when that is not done
/// by `deadline`.
///
/// # Errors
/// One line: the chain's errors, other than being stopped, or that the kd-tree lost a cluster.
pub fn original_work(boxes: &[Aabb], deadline: Option<Instant>) -> Result<Option<OriginalWork>, String> {
    sampled_work(boxes, 1, deadline)
}

/// As [`original_work`], but only one search in `every` is made; what all of them would have visited and sorted follows by
/// proportion. A search's cost changes slowly over a build, as clusters become fewer, so evenly spaced ones stand for the
/// rest. Insertions and removals are all made and counted.
///
/// # Errors
/// As [`original_work`].
pub fn sampled_work(boxes: &[Aabb], every: u64, deadline: Option<Instant>) -> Result<Option<OriginalWork>, String> {
    let mut replay = Replay { tree: OriginalKdTree::new(), every: every.max(1), searches: 0, diverged: false };
    for (id, aabb) in (0..).zip(boxes) {
        replay.tree.insert(id, aabb.centre().as_vec3());
    }
    match chain_literal::build(boxes, &mut Brake::new(deadline), &mut replay) {
        Ok(_) if replay.diverged => Err("the replayed kd-tree lost a cluster of the chain".into()),
        Ok(_) => Ok(Some(replay.scaled())),
        Err(BuildError::Stopped(_)) => Ok(None),
        Err(e) => Err(e.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{Counters, Work};
    use crate::scene::Scene;

    #[test]
    fn every_search_and_merge_of_the_chain_reaches_the_kd_tree() {
        let boxes = Scene::load("thesis:tiny").unwrap().boxes();
        let mut counters = Counters::default();
        chain_literal::build(&boxes, &mut counters, &mut ()).unwrap();
        let work = original_work(&boxes, None).unwrap().unwrap();
        assert_eq!(work.queries, counters.get(Work::NearestSearches));
        assert_eq!(work.inserts, boxes.len() as u64 + counters.get(Work::Merges));
        assert!(work.visited > work.queries && work.list_steps > work.listed);
    }

    #[test]
    fn a_sample_of_the_searches_stands_for_all() {
        let boxes = Scene::load("thesis:small").unwrap().boxes();
        let all = original_work(&boxes, None).unwrap().unwrap();
        assert_eq!(sampled_work(&boxes, 1, None).unwrap().unwrap(), all);
        let some = sampled_work(&boxes, 8, None).unwrap().unwrap();
        assert_eq!((some.queries, some.inserts, some.insert_steps), (all.queries, all.inserts, all.insert_steps));
        for (a, b) in [(some.visited, all.visited), (some.list_steps, all.list_steps)] {
            let ratio = a as f64 / b as f64;
            assert!((0.95..1.05).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn a_replay_without_time_ends_without_a_count() {
        let boxes = Scene::load("thesis:med").unwrap().boxes();
        assert_eq!(original_work(&boxes, Some(Instant::now())).unwrap(), None);
    }
}
