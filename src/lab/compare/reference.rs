//! What every tree of a scene must answer: ray sets, and their hits as brute force has them.

use crate::build::{BuildOptions, Input, find};
use crate::bvh::{Bvh, validate};
use crate::geom::{Aabb, Ray, Triangle, WatertightRay};
use crate::lab::RAY_SEED;
use crate::lab::leaf_counts::end_at_hits;
use crate::scene::Scene;
use crate::trace::{
    Batch, HitRecord, Kernel, Query, TraceCounters, Tracer, brute_force, count_batch, diffuse_rays, primary_rays,
    trace_batch,
};
use rayon::prelude::*;

/// The builder of the tree that rays and their answers come from: any exact kernel finds the same through every tree.
const BUILDER: &str = "binned-sah";

/// Triangle tests that brute force may spend on a ray set: a fraction of a second.
const TESTS: usize = 10_000_000;

/// Boxes and triangles that one pass over a ray set may test: a second or two. A usual scene of a million triangles takes a third.
const PASS: f64 = 2.5e7;

/// Rays with their answers.
#[derive(Debug)]
pub(super) struct RaySet {
    pub rays: Vec<Ray>,
    pub expected: Vec<HitRecord>,
}

/// The rays of a scene.
#[derive(Debug)]
pub(super) struct Reference {
    /// From the camera.
    pub primary: RaySet,
    /// From what the camera sees; none where it sees nothing.
    pub diffuse: RaySet,
    /// For the leaf count variability: the diffuse ones, each ending at its hit. At 512 × 512 pixels those of
    /// [`crate::lab::leaf_count_rays`], unless thinned out.
    pub leaf_rays: Vec<Ray>,
}

impl Reference {
    /// Makes the ray sets, answers them, and checks a part of the answers against brute force.
    ///
    /// # Errors
    /// One line, where the answers are not those of brute force.
    pub fn new(scene: &Scene, kernel: Kernel, size: (u32, u32)) -> Result<Self, String> {
        let triangles = &scene.triangles;
        let boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
        let builder = find(BUILDER).ok_or_else(|| format!("there is no builder {BUILDER}"))?;
        let options = BuildOptions::default();
        let bvh = (builder.timed)(Input::of_triangles(triangles, &boxes), &options, &mut Default::default())
            .map_err(|e| e.to_string())?;
        validate(&bvh, &boxes, &builder.limits(&options)).map_err(|e| e.to_string())?;
        let primary = thinned(primary_rays(&scene.camera, size.0, size.1), &bvh, triangles, PASS);
        let diffuse = thinned(diffuse_rays(&bvh, triangles, &primary, RAY_SEED), &bvh, triangles, PASS);
        for rays in [&primary, &diffuse] {
            agrees_with_brute_force(&bvh, triangles, rays)?;
        }
        let answered = |rays: Vec<Ray>| {
            let mut expected = Vec::new();
            let tracer = Tracer::new(kernel, &bvh, triangles);
            trace_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &rays }, &mut expected);
            RaySet { rays, expected }
        };
        let (primary, diffuse) = (answered(primary), answered(diffuse));
        let mut leaf_rays = diffuse.rays.clone();
        end_at_hits(&mut leaf_rays, &diffuse.expected);
        Ok(Self { primary, diffuse, leaf_rays })
    }
}

/// Every so many-th ray where all of them would make a pass take minutes, as where thousands of triangles lie on each other. What
/// is left depends on counted work, not on the clock: it is the same in every run.
fn thinned(rays: Vec<Ray>, bvh: &Bvh, triangles: &[Triangle], pass: f64) -> Vec<Ray> {
    const SAMPLE: usize = 256;
    let some: Vec<Ray> = rays.iter().copied().step_by(rays.len().div_ceil(SAMPLE).max(1)).collect();
    let tracer = Tracer::new(Kernel::Scalar, bvh, triangles);
    let (_, work) = count_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &some });
    let a_ray = (work.box_tests + work.triangle_tests) as f64 / some.len().max(1) as f64;
    let step = (a_ray * rays.len() as f64 / pass).ceil().max(1.0) as usize;
    rays.into_iter().step_by(step).collect()
}

/// Looks at rays evenly over the set, as many as time allows.
fn agrees_with_brute_force(bvh: &Bvh, triangles: &[Triangle], rays: &[Ray]) -> Result<(), String> {
    let looked_at = (TESTS / triangles.len().max(1)).clamp(16, 512);
    let some: Vec<Ray> = rays.iter().copied().step_by(rays.len().div_ceil(looked_at).max(1)).collect();
    let mut found = Vec::new();
    let tracer = Tracer::new(Kernel::Scalar, bvh, triangles);
    trace_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &some }, &mut found);
    let by_force = |ray: &Ray| HitRecord::from(brute_force::<WatertightRay>(triangles, ray));
    let wrong = some.par_iter().zip(&found).filter(|(ray, hit)| by_force(ray) != **hit).count();
    match wrong {
        0 => Ok(()),
        _ => Err(format!("{wrong} of {} rays hit something else than by brute force", some.len())),
    }
}

impl RaySet {
    /// Traces and counts. The second is the number of rays whose answer is not the expected one.
    pub fn count(&self, tracer: &Tracer) -> (TraceCounters, usize) {
        let (hits, work) = count_batch(&self.batch(tracer));
        let wrong = hits.iter().zip(&self.expected).filter(|(found, expected)| found != expected).count();
        (work, wrong)
    }

    /// What is to be timed.
    pub fn batch<'a>(&'a self, tracer: &'a Tracer<'a>) -> Batch<'a> {
        Batch { tracer, query: Query::Closest, rays: &self.rays }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_thinned_evenly_where_each_takes_much() {
        let scene = Scene::load("gen:coincident:300").unwrap();
        let reference = Reference::new(&scene, Kernel::Scalar, (64, 64)).unwrap();
        let rays = reference.primary.rays;
        assert!(rays.len() == 64 * 64 && reference.leaf_rays.len() == reference.diffuse.rays.len());
        let options = BuildOptions::default();
        let boxes = scene.boxes();
        let bvh = (find(BUILDER).unwrap().timed)(Input::of_boxes(&boxes), &options, &mut Default::default()).unwrap();
        let tracer = Tracer::new(Kernel::Scalar, &bvh, &scene.triangles);
        let work = |rays: &[Ray]| {
            let (_, work) = count_batch(&Batch { tracer: &tracer, query: Query::Closest, rays });
            (work.box_tests + work.triangle_tests) as f64
        };
        let all = work(&rays);
        assert!(thinned(rays.clone(), &bvh, &scene.triangles, 2.0 * all) == rays);
        let fewer = thinned(rays.clone(), &bvh, &scene.triangles, all / 10.0);
        assert!((200..600).contains(&fewer.len()), "{}", fewer.len());
        assert!((0.05..0.2).contains(&(work(&fewer) / all)), "{} of {all}", work(&fewer));
    }
}
