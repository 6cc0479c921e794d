//! All hits of a ray, not only the closest: what shadows through glass and cut-out leaves ask for.
//!
//! One walk gathers them, in whatever order the tree has them, and sorts at the end. The other way would be to step from hit to
//! hit, a search for each, from (t, id) to the next greater pair: that is as many walks as hits, most of them over the same
//! nodes, and pays only where few of many hits are wanted. A hit is what it is for the closest hit, by the same box test and the same
//! `accepted`, so the answer is that of brute force, bit for bit, with the least of it the closest hit.

use super::closest::{TriangleTest, accepted};
use super::probe::TraceProbe;
use super::scratch::{OpenNode, Scratch};
use super::slab::{SlabTest, Slabs, WideSlabs, pad_up};
use crate::bvh::{Bvh, NodeKind};
use crate::geom::{Aabb, Hit, Ray, Triangle};

/// Every hit with t in `[t_min, t_max]`, into `hits` (emptied first) by t, equal t by triangle id; each triangle once, in
/// however many leaves it stands.
///
/// Nodes are entered as by [`super::closest_hit`], with a limit that stays at `t_max`.
pub fn all_hits<T: TriangleTest, P: TraceProbe>(
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut P,
    hits: &mut Vec<Hit>,
) {
    hits.clear();
    if !ray.is_traceable() {
        return;
    }
    match Slabs::new(ray, &bvh.root().aabb) {
        Some(slabs) => gather::<T, _, P>(bvh, triangles, ray, slabs, scratch, probe, hits),
        None => gather::<T, _, P>(bvh, triangles, ray, WideSlabs::new(ray), scratch, probe, hits),
    }
    in_order(hits);
}

/// The same without a tree: what the kernels' answers are checked against.
pub fn brute_force_all<T: TriangleTest>(triangles: &[Triangle], ray: &Ray) -> Vec<Hit> {
    if !ray.is_traceable() {
        return Vec::new();
    }
    let bounds = triangles.iter().fold(Aabb::EMPTY, |b, t| b.union(&t.aabb()));
    let mut hits = match Slabs::new(ray, &bounds) {
        Some(slabs) => scan::<T, _>(triangles, ray, slabs),
        None => scan::<T, _>(triangles, ray, WideSlabs::new(ray)),
    };
    in_order(&mut hits);
    hits
}

fn scan<T: TriangleTest, S: SlabTest>(triangles: &[Triangle], ray: &Ray, slabs: S) -> Vec<Hit> {
    let test = T::new(ray);
    let hit = |(id, triangle)| accepted(&test, slabs, ray, triangle).map(|t| Hit { triangle: id as u32, t });
    triangles.iter().enumerate().filter_map(hit).collect()
}

/// By t, then id; a triangle that was met in several leaves stays once: its t is the same in all of them.
pub(super) fn in_order(hits: &mut Vec<Hit>) {
    // −0 is no sooner than 0, as for the closest hit: adding 0 makes one of both.
    hits.sort_unstable_by(|a, b| (a.t + 0.0).total_cmp(&(b.t + 0.0)).then(a.triangle.cmp(&b.triangle)));
    hits.dedup_by_key(|hit| hit.triangle);
}

fn gather<T: TriangleTest, S: SlabTest, P: TraceProbe>(
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
    slabs: S,
    scratch: &mut Scratch,
    probe: &mut P,
    hits: &mut Vec<Hit>,
) {
    let test = T::new(ray);
    let limit = pad_up(ray.t_max);
    let open = &mut scratch.open;
    open.clear();
    open.push(OpenNode { entry: f32::NEG_INFINITY, node: 0 });
    while let Some(OpenNode { node, .. }) = open.pop() {
        probe.node();
        match bvh.nodes[node as usize].kind() {
            NodeKind::Leaf(slots) => {
                for &id in &bvh.triangle_ids[slots] {
                    probe.triangle_test();
                    let t = accepted(&test, slabs, ray, &triangles[id as usize]);
                    hits.extend(t.map(|t| Hit { triangle: id, t }));
                }
            }
            NodeKind::Inner(children) => {
                for child in children {
                    probe.box_test();
                    let (entry, exit) = slabs.interval(&bvh.nodes[child].aabb);
                    if entry <= exit && exit >= ray.t_min && entry <= limit {
                        open.push(OpenNode { entry, node: child as u32 });
                    }
                }
            }
        }
    }
}
