//! `bottom-up`, presets `text` and `walter`, engine `literal`: the globally closest pair, all pairs scanned at every step.
//!
//! Source: Beick 2014, "Construction Algorithms", by its words (`text`: distance of box centres), and Walter et al. 2008,
//! which it cites (`walter`: surface area of the union of both boxes, in f64). Among equally close pairs the one with
//! the smaller first id merges, then the one with the smaller second id.

use super::clusters::{Dead, clusters, distance_squared};
use crate::build::{BuildError, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use glam::DVec3;

/// What makes two clusters close.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// Squared Euclidean distance of the box centres.
    Centres,
    /// Surface area of the union of the boxes.
    UnionArea,
}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, or the probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], distance: Distance, probe: &mut P) -> Result<Bvh, BuildError> {
    match distance {
        Distance::Centres => merge_all(boxes, |_, centre| centre, |a, b| distance_squared(*a, *b), probe),
        Distance::UnionArea => merge_all(boxes, |aabb, _| aabb, |a, b| a.union(b).surface_area(), probe),
    }
}

/// Merges until one cluster is left; `key` is what `distance` looks at, from a cluster's box and centre.
fn merge_all<K: Copy, P: Probe>(
    boxes: &[Aabb],
    key: impl Fn(Aabb, DVec3) -> K,
    distance: impl Fn(&K, &K) -> f64,
    probe: &mut P,
) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    // Kept in id order: a merged cluster has the smaller id of its parts and takes that part's place.
    let mut live = clusters(boxes);
    let mut keys: Vec<K> = live.iter().map(|c| key(c.aabb, c.centre.as_dvec3())).collect();
    let mut dead = Dead::default();
    while live.len() > 1 {
        let mut best = (f64::INFINITY, 0, 1);
        for (i, a) in keys.iter().enumerate() {
            for (j, b) in keys.iter().enumerate().skip(i + 1) {
                let d = distance(a, b);
                probe.add(Work::PairDistances, 1);
                if d < best.0 {
                    best = (d, i, j);
                }
            }
            if !probe.go_on((keys.len() - 1 - i) as u64) {
                return Err(BuildError::Stopped(Unfinished { pending: vec![live.len()] }));
            }
        }
        let (_, i, j) = best;
        let second = live.remove(j);
        keys.remove(j);
        let merged = live[i].clone().merge(second, &mut dead);
        probe.add(Work::Merges, 1);
        keys[i] = key(merged.aabb, merged.centre.as_dvec3());
        live[i] = merged;
    }
    Ok(live.remove(0).into_tree(&dead))
}

#[cfg(test)]
mod tests;
