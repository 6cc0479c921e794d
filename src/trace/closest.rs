//! Kernel `scalar`: the closest hit, front to back, one box at a time; and any hit for shadow-like rays.
//!
//! This is the traversal that the thesis describes in words (`text`): children farther than the current hit are skipped.
//! The answer is that of brute force over all triangles with the same triangle test, bit for bit, in any tree whose boxes
//! contain their triangles. It holds by construction, not by the size of an epsilon: a triangle's t is accepted only
//! where the ray meets the triangle's *own* box, and is moved into that box's interval should rounding have put it
//! outside. Boxes above contain this box and the box test is monotone (see `slab.rs`), so none of them can be missed or
//! lie behind a hit that is not better. A true hit loses nothing by it, as the box test is conservative.
//!
//! Where spatial splits have put parts of a triangle into several leaves, the leaf's box has only its part. There the
//! margin that parts are drawn with (`build::sbvh::reference`) is what holds the watertight test's hits. The f32 test of
//! `scalar-fast` has errors beyond it at grazing angles: it may miss hits there that brute force by that test has.

use super::probe::TraceProbe;
use super::scratch::{OpenNode, Scratch};
use super::slab::{SlabTest, Slabs, WideSlabs, pad_up};
use crate::bvh::{Bvh, NodeKind};
use crate::geom::{Aabb, Hit, Ray, Triangle, WatertightRay};

/// A triangle test that a ray can be prepared for.
pub trait TriangleTest {
    /// Prepares for `ray`.
    fn new(ray: &Ray) -> Self;

    /// The t at which the ray meets `triangle`; the kernel checks the ray's interval.
    fn meets(&self, triangle: &Triangle) -> Option<f32>;
}

impl TriangleTest for WatertightRay {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self::new(ray)
    }

    #[inline(always)]
    fn meets(&self, triangle: &Triangle) -> Option<f32> {
        self.meets(triangle)
    }
}

/// Möller–Trumbore in f32 ([`Triangle::intersect`]): quicker, but rays can slip between two triangles.
#[derive(Clone, Copy, Debug)]
pub struct FastTest(Ray);

impl TriangleTest for FastTest {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        Self(*ray)
    }

    #[inline(always)]
    fn meets(&self, triangle: &Triangle) -> Option<f32> {
        triangle.intersect(&self.0)
    }
}

/// The closest hit with t in `[t_min, t_max]`; equal t: the lowest triangle id, wherever in the tree it stands.
///
/// The root is entered without a box test, as in the thesis' program: a ray that misses everything costs one node. A ray
/// with NaN, infinities or no direction ([`Ray::is_traceable`]) misses without entering a node.
#[inline]
pub fn closest_hit<T: TriangleTest, P: TraceProbe>(
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut P,
) -> Option<Hit> {
    if !ray.is_traceable() {
        return None;
    }
    match Slabs::new(ray, &bvh.root().aabb) {
        Some(slabs) => search::<Closest, T, _, P>(bvh, triangles, ray, slabs, scratch, probe),
        None => search::<Closest, T, _, P>(bvh, triangles, ray, WideSlabs::new(ray), scratch, probe),
    }
}

/// Whether anything is hit with t in `[t_min, t_max]`: the same rays as [`closest_hit`], but the search ends at the first
/// hit found.
#[inline]
pub fn any_hit<T: TriangleTest, P: TraceProbe>(
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut P,
) -> bool {
    if !ray.is_traceable() {
        return false;
    }
    match Slabs::new(ray, &bvh.root().aabb) {
        Some(slabs) => search::<Any, T, _, P>(bvh, triangles, ray, slabs, scratch, probe),
        None => search::<Any, T, _, P>(bvh, triangles, ray, WideSlabs::new(ray), scratch, probe),
    }
    .is_some()
}

/// The closest hit without a tree: every triangle tested. What the kernels' answers are checked against.
pub fn brute_force<T: TriangleTest>(triangles: &[Triangle], ray: &Ray) -> Option<Hit> {
    if !ray.is_traceable() {
        return None;
    }
    let bounds = triangles.iter().fold(Aabb::EMPTY, |b, t| b.union(&t.aabb()));
    match Slabs::new(ray, &bounds) {
        Some(slabs) => scan::<T, _>(triangles, ray, slabs),
        None => scan::<T, _>(triangles, ray, WideSlabs::new(ray)),
    }
}

fn scan<T: TriangleTest, S: SlabTest>(triangles: &[Triangle], ray: &Ray, slabs: S) -> Option<Hit> {
    let test = T::new(ray);
    let mut best = None;
    for (id, triangle) in triangles.iter().enumerate() {
        let t = accepted(&test, slabs, ray, triangle);
        improve(&mut best, id as u32, t);
    }
    best
}

/// When a search may end.
pub(super) trait Goal {
    /// Whether the first hit found is enough.
    const FIRST_IS_ENOUGH: bool;
}

/// At the closest hit.
pub(super) struct Closest;
impl Goal for Closest {
    const FIRST_IS_ENOUGH: bool = false;
}

/// At the first hit found.
pub(super) struct Any;
impl Goal for Any {
    const FIRST_IS_ENOUGH: bool = true;
}

#[inline]
fn search<G: Goal, T: TriangleTest, S: SlabTest, P: TraceProbe>(
    bvh: &Bvh,
    triangles: &[Triangle],
    ray: &Ray,
    slabs: S,
    scratch: &mut Scratch,
    probe: &mut P,
) -> Option<Hit> {
    let test = T::new(ray);
    let open = &mut scratch.open;
    open.clear();
    open.push(OpenNode { entry: f32::NEG_INFINITY, node: 0 });
    let mut best: Option<Hit> = None;
    // Nodes entered at exactly the best t stay open: they may hold a lower id.
    let mut limit = pad_up(ray.t_max);
    while let Some(OpenNode { entry, node }) = open.pop() {
        if entry > limit {
            continue;
        }
        probe.node();
        match bvh.nodes[node as usize].kind() {
            NodeKind::Leaf(slots) => {
                for &id in &bvh.triangle_ids[slots] {
                    probe.triangle_test();
                    let t = accepted(&test, slabs, ray, &triangles[id as usize]);
                    if improve(&mut best, id, t) {
                        if G::FIRST_IS_ENOUGH {
                            return best;
                        }
                        limit = best.map_or(limit, |b| pad_up(b.t));
                    }
                }
            }
            NodeKind::Inner(children) => {
                let start = open.len();
                for child in children {
                    probe.box_test();
                    let (entry, exit) = slabs.interval(&bvh.nodes[child].aabb);
                    if entry <= exit && exit >= ray.t_min && entry <= limit {
                        open.push(OpenNode { entry, node: child as u32 });
                        // Nearest on top; among equals the lower index.
                        let mut i = open.len() - 1;
                        while i > start && open[i - 1].entry <= entry {
                            open.swap(i, i - 1);
                            i -= 1;
                        }
                    }
                }
            }
        }
    }
    best
}

/// The t of a hit that stands: the triangle test's, held to the interval of the triangle's own box and to the ray's.
#[inline(always)]
pub(super) fn accepted<T: TriangleTest, S: SlabTest>(
    test: &T,
    slabs: S,
    ray: &Ray,
    triangle: &Triangle,
) -> Option<f32> {
    held(test.meets(triangle)?, slabs, ray, triangle)
}

/// [`accepted`], of a triangle that is met at `t`.
#[inline(always)]
pub(super) fn held<S: SlabTest>(t: f32, slabs: S, ray: &Ray, triangle: &Triangle) -> Option<f32> {
    let (entry, exit) = slabs.interval(&triangle.aabb());
    if entry > exit {
        return None;
    }
    let t = if entry > pad_up(t) {
        entry
    } else if t > exit {
        exit
    } else {
        t
    };
    (t >= ray.t_min && t <= ray.t_max && t.is_finite()).then_some(t)
}

/// Keeps the better hit: the nearer one, of two as near that of the lower id.
#[inline(always)]
pub(super) fn improve(best: &mut Option<Hit>, triangle: u32, t: Option<f32>) -> bool {
    let Some(t) = t else { return false };
    let better = best.is_none_or(|b| t < b.t || (t == b.t && triangle < b.triangle));
    if better {
        *best = Some(Hit { triangle, t });
    }
    better
}
