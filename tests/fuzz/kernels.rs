//! Triangles and rays from bytes, through every kernel over some tree: the watertight ones answer as brute force, bit for bit, and
//! brute force as the oracle in f64; of the others, hits are within the ray's interval.

use crate::builders::RECIPES;
use crate::bytes::Bytes;
use bvh_lab::build::{Brake, Engine, Input};
use bvh_lab::geom::{Hit, Triangle, WatertightRay};
use bvh_lab::simd::Simd;
use bvh_lab::trace::{Arithmetic, KERNELS, Oracle, Query, Scratch, Tracer, brute_force, brute_force_all};

/// Triangles of an execution, at most.
const TRIANGLES: usize = 24;
/// Rays of an execution, at most.
const RAYS: usize = 6;

/// One execution.
///
/// # Panics
/// On what must not be.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes(data);
    let recipe = usize::from(bytes.byte()) | usize::from(bytes.byte()) << 8;
    let (style, n) = (bytes.style(), 1 + bytes.below(TRIANGLES));
    let triangles: Vec<_> = (0..n).map(|_| bytes.triangle(style)).filter(Triangle::is_finite).collect();
    if triangles.is_empty() {
        return;
    }
    let (builder, mut options) = RECIPES[recipe % RECIPES.len()];
    // Literal engines build the same trees, more slowly; rule Q8 hides triangles.
    options.engine = Engine::Exact;
    options.q8 = options.q8 && !builder.limits(&options).q8;
    let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
    let bvh = (builder.timed)(Input::of_triangles(&triangles, &boxes), &options, &mut Brake::default());
    let bvh = bvh.unwrap_or_else(|e| panic!("{} {options:?}: {e}", builder.id));
    let tracers = KERNELS.iter().map(|info| Tracer::new(info.kernel, &bvh, &triangles));
    let tracers: Vec<_> = tracers.flat_map(|t| [t.clone().at_level(Simd::Baseline), t]).collect();
    let (mut scratch, mut all) = (Scratch::default(), Vec::new());
    for _ in 0..1 + bytes.below(RAYS) {
        let ray_style = if bytes.byte() & 3 == 0 { bytes.style() } else { style };
        let ray = bytes.ray(ray_style, &triangles);
        let closest = brute_force::<WatertightRay>(&triangles, &ray);
        let every = brute_force_all::<WatertightRay>(&triangles, &ray);
        assert_eq!(bits(every.first()), bits(closest.as_ref()), "{ray:?}");
        let oracle = Oracle::new(&triangles, &ray, Arithmetic::Watertight);
        let verdicts = (oracle.judge(closest), oracle.judge_all(&every));
        assert!(verdicts.0.is_right() && verdicts.1.is_right(), "{ray:?} {closest:?} {verdicts:?}");
        for tracer in &tracers {
            let found = tracer.trace(Query::Closest, &ray, &mut scratch, &mut ());
            let any = tracer.trace(Query::Any, &ray, &mut scratch, &mut ());
            tracer.all_hits(&ray, &mut scratch, &mut (), &mut all);
            let place = || format!("{:?} on {} {options:?}, {ray:?}", tracer.kernel(), builder.id);
            if tracer.kernel().is_exact() {
                assert_eq!(bits(found.as_ref()), bits(closest.as_ref()), "{}", place());
                assert_eq!(any.is_some(), closest.is_some(), "{}", place());
                assert_eq!(all, every, "{}", place());
            }
            let inside =
                |hit: &Hit| (ray.t_min..=ray.t_max).contains(&hit.t) && (hit.triangle as usize) < triangles.len();
            assert!(found.iter().chain(&all).all(inside), "{}", place());
        }
    }
}

fn bits(hit: Option<&Hit>) -> Option<(u32, u32)> {
    hit.map(|h| (h.triangle, h.t.to_bits()))
}
