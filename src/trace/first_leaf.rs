//! Kernel `first-leaf`: the traversal of the thesis' program (Beick 2014), which stops at the first leaf that reports a hit.
//!
//! All boxes of an inner node's children are tested, and the hit ones entered by entry distance, among equal entries the
//! smaller exit first, then the lower index. The first child that reports a hit ends the search, so where boxes overlap
//! the answer is not always the closest hit (`scalar` is the kernel that finds it). The root is entered without a box
//! test: a ray that misses everything costs one node. Everything is f32; an entry of exactly 0 counts as a miss.

use super::probe::TraceProbe;
use super::scratch::{Frame, HitChild, Scratch};
use crate::bvh::{Bvh, NodeKind};
use crate::geom::{Aabb, Hit, Ray, Triangle};
use glam::{BVec3, Vec3};
use std::hint::black_box;

/// What the study can switch in `first-leaf`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FirstLeafOptions {
    /// Whether to reproduce the program's slip with tied entries (default: yes, as the program did).
    ///
    /// In trees of arity 4 or 8, when the least entry is shared by at least two but fewer than `arity` pending children,
    /// child 0 joins them if its box was hit, even if it is not tied or was visited before; if its exit is strictly smaller
    /// it is entered (again) and counted (again). Ties are handled only while a counter exceeds 1 that starts at the
    /// number of boxes hit and is lowered after every failed visit; from then on the lowest index of the tied goes first.
    ///
    /// Where ties go on from level to level, as over triangles in one plane, the slip enters nodes exponentially often. No ray
    /// slips more than 4,096 times here: what is entered again has failed before, so answers stay what they are, and counts of
    /// such rays alone are lower than the program's.
    pub tie_slip: bool,
    /// Whether every triangle test first finds its triangle by a linear scan over all triangles, as the program did
    /// (default: no). Changes times only, never results: it is why the printed times per pixel grow with the scene.
    pub linear_lookup: bool,
}

impl Default for FirstLeafOptions {
    fn default() -> Self {
        Self { tie_slip: true, linear_lookup: false }
    }
}

/// See [`FirstLeafOptions::tie_slip`].
const MOST_SLIPS: usize = 1 << 12;

/// Traces one ray. A hit is the closest triangle *of the first leaf that reports one*; equal t: the lowest id.
///
/// Triangle test: [`Triangle::intersect_published`]. A ray with NaN, infinities or no direction
/// ([`Ray::is_traceable`]) misses without entering a node.
pub fn first_leaf<P: TraceProbe>(
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
    options: FirstLeafOptions,
    scratch: &mut Scratch,
    probe: &mut P,
) -> Option<Hit> {
    if !ray.is_traceable() {
        return None;
    }
    let mut slip_arity = match bvh.arity {
        4 | 8 if options.tie_slip => bvh.arity,
        _ => 0,
    };
    let mut slips_left = MOST_SLIPS;
    let slabs = PublishedSlabs::new(ray);
    scratch.frames.clear();
    scratch.children.clear();
    let mut entered = 0;
    loop {
        probe.node();
        match bvh.nodes[entered].kind() {
            NodeKind::Leaf(slots) => {
                let hit = closest_of_leaf(triangles, &bvh.triangle_ids[slots], ray, options.linear_lookup, probe);
                if hit.is_some() {
                    return hit;
                }
            }
            NodeKind::Inner(children) => {
                let start = scratch.children.len();
                let first_child = children.start as u32;
                for node in children {
                    probe.box_test();
                    if let Some((entry, exit)) = slabs.enter(&bvh.nodes[node].aabb) {
                        scratch.children.push(HitChild { entry, exit, node: node as u32, pending: true });
                    }
                }
                // One more than the boxes hit: the loop below lowers it on arrival as after a failed visit.
                scratch.frames.push(Frame { start, first_child, counter: scratch.children.len() - start + 1 });
            }
        }
        // The visit failed, or has only just begun: go on with the innermost node that has a pending child.
        loop {
            let frame = scratch.frames.last_mut()?;
            frame.counter = frame.counter.saturating_sub(1);
            let children = &mut scratch.children[frame.start..];
            match next_child(children, frame, slip_arity) {
                Some(chosen) => {
                    if !std::mem::replace(&mut children[chosen].pending, false) {
                        slips_left -= 1;
                        slip_arity = if slips_left == 0 { 0 } else { slip_arity };
                    }
                    entered = children[chosen].node as usize;
                    break;
                }
                None => {
                    scratch.children.truncate(frame.start);
                    scratch.frames.pop();
                }
            }
        }
    }
}

/// Which of a node's hit children (in index order) goes next.
fn next_child(children: &[HitChild], frame: &Frame, slip_arity: usize) -> Option<usize> {
    let mut pending = (0..children.len()).filter(|&i| children[i].pending);
    let mut least = pending.next()?;
    let mut tied = 1;
    let mut chosen = least;
    for i in pending {
        let child = &children[i];
        if child.entry < children[least].entry {
            (least, chosen, tied) = (i, i, 1);
        } else if child.entry == children[least].entry {
            tied += 1;
            if child.exit < children[chosen].exit {
                chosen = i;
            }
        }
    }
    if tied == 1 || frame.counter <= 1 {
        return Some(least);
    }
    // Hit children stand in index order: child 0 can only be the first.
    let slips = tied < slip_arity && children[0].node == frame.first_child && children[0].exit < children[chosen].exit;
    Some(if slips { 0 } else { chosen })
}

/// The program's box test.
struct PublishedSlabs {
    origin: Vec3,
    direction: Vec3,
    negative: BVec3,
}

impl PublishedSlabs {
    fn new(ray: &Ray) -> Self {
        // Adding 0 turns −0 into 0: both signs give the same answer.
        let direction = ray.direction + Vec3::ZERO;
        Self { origin: ray.origin, direction, negative: direction.cmplt(Vec3::ZERO) }
    }

    /// Entry and exit where the program takes the box as hit: slabs overlap, entry below the greatest f32 and not exactly
    /// 0, exit above the least normal f32. Negative entries (the origin is inside) count.
    #[inline(always)]
    fn enter(&self, aabb: &Aabb) -> Option<(f32, f32)> {
        let near = (Vec3::select(self.negative, aabb.max, aabb.min) - self.origin) / self.direction;
        let far = (Vec3::select(self.negative, aabb.min, aabb.max) - self.origin) / self.direction;
        let (mut entry, mut exit) = (f32::NEG_INFINITY, f32::INFINITY);
        for axis in 0..3 {
            // 0/0 = NaN, an origin on a slab's plane and no motion across it, fails both: the boundary belongs to the box.
            if near[axis] > entry {
                entry = near[axis];
            }
            if far[axis] < exit {
                exit = far[axis];
            }
        }
        (entry <= exit && entry < f32::MAX && entry != 0.0 && exit > f32::MIN_POSITIVE).then_some((entry, exit))
    }
}

#[inline]
fn closest_of_leaf<P: TraceProbe>(
    triangles: &[Triangle],
    ids: &[u32],
    ray: &Ray,
    linear_lookup: bool,
    probe: &mut P,
) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    for &id in ids {
        probe.triangle_test();
        let index = if linear_lookup { look_up(triangles, id) } else { id as usize };
        if let Some(t) = triangles[index].intersect_published(ray)
            && best.is_none_or(|b| t < b.t || (t == b.t && id < b.triangle))
        {
            best = Some(Hit { triangle: id, t });
        }
    }
    best
}

/// Finds triangle `id` the slow way; the compiler may not see through it.
fn look_up(triangles: &[Triangle], id: u32) -> usize {
    (0..triangles.len()).find(|&i| black_box(i) == id as usize).unwrap_or(id as usize)
}
