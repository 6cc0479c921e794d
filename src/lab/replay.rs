//! What the thesis' own kd-tree would have cost: the published chain, watched.

use crate::build::bottom_up::chain_literal::{self, Observer};
use crate::build::{Brake, BuildError, OriginalKdTree, OriginalWork};
use crate::geom::Aabb;
use glam::Vec3;
use std::time::Instant;

/// Follows the chain's searches and merges in the original's kd-tree.
#[derive(Debug, Default)]
struct Replay {
    tree: OriginalKdTree,
    /// Whether the tree lacked a cluster that the chain has.
    diverged: bool,
}

impl Observer for Replay {
    fn search(&mut self, id: u32, centre: Vec3) {
        self.diverged |= self.tree.nearest(id, centre).is_none();
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
    let mut replay = Replay::default();
    for (id, aabb) in (0..).zip(boxes) {
        replay.tree.insert(id, aabb.centre().as_vec3());
    }
    match chain_literal::build(boxes, &mut Brake::new(deadline), &mut replay) {
        Ok(_) if replay.diverged => Err("the replayed kd-tree lost a cluster of the chain".into()),
        Ok(_) => Ok(Some(replay.tree.work())),
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
    fn a_replay_without_time_ends_without_a_count() {
        let boxes = Scene::load("thesis:med").unwrap().boxes();
        assert_eq!(original_work(&boxes, Some(Instant::now())).unwrap(), None);
    }
}
