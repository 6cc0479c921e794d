//! What every tree of a scene must answer: ray sets, and their hits as brute force has them.

use crate::build::{BuildOptions, Input, find};
use crate::bvh::{Bvh, validate};
use crate::geom::{Aabb, Ray, Triangle, WatertightRay};
use crate::lab::{RAY_SEED, leaf_count_rays};
use crate::scene::Scene;
use crate::trace::{
    Batch, HitRecord, Kernel, Query, TraceCounters, Tracer, brute_force, count_batch, diffuse_rays, primary_rays,
    trace_batch,
};
use rayon::prelude::*;

/// The builder of the tree that rays and their answers come from: any exact kernel finds the same through every tree.
const BUILDER: &str = "binned-sah";

/// Triangle tests that brute force may spend on a ray set: a fraction of a second.
const TESTS: usize = 50_000_000;

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
    /// For the leaf count variability.
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
        let primary = primary_rays(&scene.camera, size.0, size.1);
        let diffuse = diffuse_rays(&bvh, triangles, &primary, RAY_SEED);
        for rays in [&primary, &diffuse] {
            agrees_with_brute_force(&bvh, triangles, rays)?;
        }
        let answered = |rays: Vec<Ray>| {
            let mut expected = Vec::new();
            let tracer = Tracer::new(kernel, &bvh, triangles);
            trace_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &rays }, &mut expected);
            RaySet { rays, expected }
        };
        let leaf_rays = leaf_count_rays(scene, &bvh);
        Ok(Self { primary: answered(primary), diffuse: answered(diffuse), leaf_rays })
    }
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
