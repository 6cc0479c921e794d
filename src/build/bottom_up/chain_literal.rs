//! `bottom-up`, preset `published`, engine `literal`: a chain of nearest neighbours, all live clusters scanned for each.
//!
//! Source: what the program of Beick 2014 does. A is the cluster whose centre is nearest the origin, B the nearest to A,
//! d their distance. Then, again and again: C is the nearest to B; if C is A, or d ≤ d(B, C), A and B merge into the new A,
//! whose nearest becomes B and d their distance; otherwise A ← B and B ← C, and d *stays* what it was. Distances are
//! those of box centres; ties go to the lowest id.
//!
//! Deviation: the original found nearest clusters in a kd-tree, whose walk decided ties.

use super::clusters::{Centres, Cluster, Dead, LANES, Precision, clusters, least};
use crate::build::{BuildError, Probe, Unfinished, Work, check_boxes};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use glam::{DVec3, Vec3};

/// Sees the searches and merges of the chain as they happen, so that another structure can be run beside it.
pub trait Observer {
    /// The nearest cluster to `centre` other than `id` itself was asked for.
    fn search(&mut self, id: u32, centre: Vec3) {
        let _ = (id, centre);
    }

    /// The clusters `a` and `b` gave way to one with the smaller id and this centre.
    fn merge(&mut self, a: (u32, Vec3), b: (u32, Vec3), merged: (u32, Vec3)) {
        let _ = (a, b, merged);
    }
}

impl Observer for () {}

/// Builds the binary tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, [`BuildError::Circling`], or the probe's stop.
pub fn build<P: Probe, O: Observer>(boxes: &[Aabb], probe: &mut P, observer: &mut O) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    let mut live = Live::new(clusters(boxes));
    let mut dead = Dead::default();
    if live.clusters.len() == 1 {
        return Ok(live.clusters.remove(0).into_tree(&dead));
    }
    let mut a = live.nearest_to_origin();
    let (mut b, mut d) = live.nearest(a, probe, observer);
    // Without a merge the chain's next step depends on A alone, so it cannot be longer than the clusters are many
    // unless it goes round in a circle.
    let mut steps = 0;
    loop {
        let (c, d_bc) = live.nearest(b, probe, observer);
        let mut looked_at = live.clusters.len();
        if c == a || d <= d_bc {
            let merged = live.merge(a, b, &mut dead, observer);
            probe.add(Work::Merges, 1);
            probe.add(Work::BoxUnions, 1);
            if live.clusters.len() == 1 {
                return Ok(live.clusters.remove(0).into_tree(&dead));
            }
            a = merged;
            (b, d) = live.nearest(a, probe, observer);
            looked_at += live.clusters.len();
            steps = 0;
        } else {
            (a, b) = (b, c);
            steps += 1;
            if steps > live.clusters.len() as u64 {
                return Err(BuildError::Circling(steps));
            }
        }
        if !probe.go_on(looked_at as u64) {
            return Err(BuildError::Stopped(Unfinished { pending: vec![live.clusters.len()] }));
        }
    }
}

/// The clusters not yet merged, in no particular order, and their centres for the scan.
struct Live {
    clusters: Vec<Cluster>,
    centres: Centres,
}

impl Live {
    fn new(clusters: Vec<Cluster>) -> Self {
        let centres = Centres::of(&clusters, Precision::Single);
        Self { clusters, centres }
    }

    fn nearest_to_origin(&self) -> usize {
        self.scan(DVec3::ZERO, None, &mut ()).0
    }

    /// The live cluster nearest to cluster `of`, among equals the one with the lowest id, and its squared distance.
    fn nearest<P: Probe, O: Observer>(&self, of: usize, probe: &mut P, observer: &mut O) -> (usize, f64) {
        observer.search(self.clusters[of].id, self.centres.get(of).as_vec3());
        probe.add(Work::NearestSearches, 1);
        self.scan(self.centres.get(of), Some(of), probe)
    }

    /// Looks at every live cluster but `except`.
    fn scan<P: Probe>(&self, point: DVec3, except: Option<usize>, probe: &mut P) -> (usize, f64) {
        let mut best = (usize::MAX, f64::INFINITY);
        let mut distances = [0.0; LANES];
        let mut from = 0;
        while from < self.clusters.len() {
            let n = self.centres.distances(point, from, &mut distances);
            let own = except.is_some_and(|of| (from..from + n).contains(&of));
            probe.add(Work::PairDistances, n as u64 - u64::from(own));
            if least(&distances) <= best.1 {
                for (i, &d) in (from..).zip(&distances[..n]) {
                    let tied = d == best.1 && best.0 != usize::MAX;
                    let nearer = d < best.1 || !tied || self.clusters[i].id < self.clusters[best.0].id;
                    if d <= best.1 && nearer && Some(i) != except {
                        best = (i, d);
                    }
                }
            }
            from += n;
        }
        best
    }

    /// Merges the clusters at `a` and `b` and returns where the new one stands.
    fn merge<O: Observer>(&mut self, a: usize, b: usize, dead: &mut Dead, observer: &mut O) -> usize {
        // The one farther back leaves first, so that the other's place stays what it is.
        let (front, back) = (a.min(b), a.max(b));
        self.centres.swap_remove(back);
        let second = self.clusters.swap_remove(back);
        let first = self.clusters[front].clone();
        let seen = |c: &Cluster| (c.id, c.centre(Precision::Single).as_vec3());
        let parts = (seen(&first), seen(&second));
        let merged = first.merge(second, dead);
        observer.merge(parts.0, parts.1, seen(&merged));
        self.centres.set(front, &merged);
        self.clusters[front] = merged;
        front
    }
}

#[cfg(test)]
mod tests;
