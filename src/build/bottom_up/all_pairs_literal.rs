//! `bottom-up`, presets `text` and `walter`, engine `literal`: the globally closest pair, all pairs scanned at every step.
//!
//! Source: Beick 2014, "Construction Algorithms", by its words (`text`: distance of box centres, in f64), and Walter et al. 2008,
//! which it cites (`walter`: surface area of the union of both boxes, in f64). Among equally close pairs the one with
//! the smaller first id merges, then the one with the smaller second id.

use super::clusters::{Centres, Cluster, Dead, LANES, Precision, clusters, least};
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
    check_boxes(boxes)?;
    let clusters = clusters(boxes);
    match distance {
        Distance::Centres => merge_all(Centres::of(&clusters, Precision::Double), clusters, probe),
        Distance::UnionArea => merge_all(Boxes(boxes.to_vec()), clusters, probe),
    }
}

/// What distances are measured by, one entry per live cluster.
trait Keys {
    /// One entry.
    type Key;

    /// Whether a distance is the area of a union.
    const UNITES: bool;

    /// Entry `i`.
    fn key(&self, i: usize) -> Self::Key;
    /// Distances from `key` to the entries `from`, from + 1, …, at most [`LANES`] of them; returns how many.
    /// Those beyond them are infinite.
    fn distances(&self, key: &Self::Key, from: usize, out: &mut [f64; LANES]) -> usize;
    /// Takes entry `j` out and puts `merged` at `i`, before it.
    fn merge(&mut self, i: usize, j: usize, merged: &Cluster);
}

impl Keys for Centres {
    type Key = DVec3;

    const UNITES: bool = false;

    #[inline(always)]
    fn key(&self, i: usize) -> DVec3 {
        self.get(i)
    }

    #[inline(always)]
    fn distances(&self, key: &Self::Key, from: usize, out: &mut [f64; LANES]) -> usize {
        Centres::distances(self, *key, from, out)
    }

    fn merge(&mut self, i: usize, j: usize, merged: &Cluster) {
        self.remove(j);
        self.set(i, merged);
    }
}

struct Boxes(Vec<Aabb>);

impl Keys for Boxes {
    type Key = Aabb;

    const UNITES: bool = true;

    #[inline(always)]
    fn key(&self, i: usize) -> Aabb {
        self.0[i]
    }

    #[inline(always)]
    fn distances(&self, key: &Self::Key, from: usize, out: &mut [f64; LANES]) -> usize {
        let others = self.0[from..].iter().take(LANES);
        let n = others.len();
        out[n..].fill(f64::INFINITY);
        others.zip(out).for_each(|(other, out)| *out = key.union(other).surface_area());
        n
    }

    fn merge(&mut self, i: usize, j: usize, merged: &Cluster) {
        self.0.remove(j);
        self.0[i] = merged.aabb;
    }
}

/// Merges until one cluster is left. The clusters stay in id order: a merged one has the smaller id of its parts and
/// takes that part's place, so the first of the closest pairs met is the one the tie order wants.
fn merge_all<K: Keys, P: Probe>(mut keys: K, mut live: Vec<Cluster>, probe: &mut P) -> Result<Bvh, BuildError> {
    let mut dead = Dead::default();
    let mut distances = [0.0; LANES];
    while live.len() > 1 {
        let mut best = (f64::INFINITY, 0, 1);
        for i in 0..live.len() {
            let key = keys.key(i);
            let mut from = i + 1;
            while from < live.len() {
                let n = keys.distances(&key, from, &mut distances);
                probe.add(Work::PairDistances, n as u64);
                probe.add(Work::BoxUnions, if K::UNITES { n as u64 } else { 0 });
                if least(&distances) < best.0 {
                    for (j, &d) in (from..).zip(&distances[..n]) {
                        if d < best.0 {
                            best = (d, i, j);
                        }
                    }
                }
                from += n;
            }
            if !probe.go_on((live.len() - 1 - i) as u64) {
                return Err(BuildError::Stopped(Unfinished { pending: vec![live.len()] }));
            }
        }
        let (_, i, j) = best;
        let second = live.remove(j);
        let merged = live[i].clone().merge(second, &mut dead);
        probe.add(Work::Merges, 1);
        probe.add(Work::BoxUnions, 1);
        keys.merge(i, j, &merged);
        live[i] = merged;
    }
    Ok(live.remove(0).into_tree(&dead))
}

#[cfg(test)]
mod tests;
