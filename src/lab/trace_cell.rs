//! One picture of the thesis' study: its work counted, its time taken apart, both held against each other.

use super::measure::{Repeats, repeat};
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::rows::{Lighting, Spread};
use crate::scene::{Camera, Scene};
use crate::trace::{
    ImageCounts, PublishedCamera, Reading, Scratch, StudyView, THESIS_SIZE, brute_force, closest_hit, primary_rays,
    run_image, trace_image,
};
use glam::Vec3;
use rayon::prelude::*;

/// What all pictures of one scene share.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Triangles by id.
    pub triangles: Vec<Triangle>,
    /// Unit smooth normals of their vertices.
    pub normals: Vec<[Vec3; 3]>,
    /// The scene's camera.
    pub camera: Camera,
    /// Hash of the triangles.
    pub hash: String,
    /// Rays over the whole picture, and what brute force says that they hit.
    reference: Vec<(Ray, Option<Hit>)>,
}

/// Rays of the reference: enough to meet every object, few enough for brute force.
const REFERENCE: (u32, u32) = (24, 24);

/// What a picture took.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Work, from a pass that counts.
    pub counts: ImageCounts,
    /// Seconds for the whole picture on one thread, from passes that do not count.
    pub seconds: Spread,
}

impl Stage {
    /// Takes what tracing needs out of `scene`.
    pub fn new(scene: &Scene) -> Self {
        let rays = primary_rays(&scene.camera.upright(), REFERENCE.0, REFERENCE.1);
        let by_force = |ray| (ray, brute_force::<WatertightRay>(&scene.triangles, &ray));
        Self {
            triangles: scene.triangles.clone(),
            normals: crate::scene::smooth_normals(scene),
            camera: scene.camera,
            hash: blake3::hash(bytemuck::cast_slice(&scene.triangles)).to_hex()[..16].to_owned(),
            reference: rays.into_par_iter().map(by_force).collect(),
        }
    }

    /// Checks that a closest-hit search through `bvh` finds what brute force finds.
    ///
    /// # Errors
    /// One line, where it does not.
    pub fn verify(&self, bvh: &Bvh) -> Result<(), String> {
        let mut scratch = Scratch::default();
        let mut wrong = 0;
        for (ray, expected) in &self.reference {
            let found = closest_hit::<WatertightRay, ()>(bvh, &self.triangles, ray, &mut scratch, &mut ());
            wrong += usize::from(found != *expected);
        }
        match wrong {
            0 => Ok(()),
            _ => Err(format!("{wrong} of {} rays hit something else than by brute force", self.reference.len())),
        }
    }

    /// The thesis' picture of the scene through `bvh`.
    pub fn view<'a>(&'a self, bvh: &'a Bvh) -> StudyView<'a> {
        StudyView {
            bvh,
            triangles: &self.triangles,
            normals: &self.normals,
            camera: PublishedCamera::new(&self.camera, THESIS_SIZE.0, THESIS_SIZE.1),
        }
    }

    /// Counts, then times one picture of the study.
    ///
    /// # Errors
    /// One line, where a timed pass saw something else than the counted one.
    pub fn trace(&self, bvh: &Bvh, lighting: Lighting, reading: Reading, repeats: &Repeats) -> Result<Traced, String> {
        let view = self.view(bvh);
        let counts = trace_image(&view, lighting, reading);
        let seconds = repeat(repeats, || {
            if run_image(&view, lighting, reading) == counts.digest() {
                Ok(())
            } else {
                Err("the timed picture differs from the counted one".to_owned())
            }
        })?;
        Ok(Traced { counts, seconds })
    }
}
