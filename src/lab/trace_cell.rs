//! One picture of the thesis' study: its work counted, its time taken apart, both held against each other.

use super::measure::{Repeats, repeat};
use crate::bvh::Bvh;
use crate::geom::Triangle;
use crate::rows::{Lighting, Spread};
use crate::scene::{Camera, Scene};
use crate::trace::{ImageCounts, PublishedCamera, Reading, StudyView, THESIS_SIZE, run_image, trace_image};
use glam::Vec3;

/// What all pictures of one scene share.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Triangles by id.
    pub triangles: Vec<Triangle>,
    /// Unit smooth normals of their vertices.
    pub normals: Vec<[Vec3; 3]>,
    /// The scene's camera.
    pub camera: Camera,
}

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
        Self { triangles: scene.triangles.clone(), normals: crate::scene::smooth_normals(scene), camera: scene.camera }
    }

    /// Counts, then times one picture of the study.
    ///
    /// # Errors
    /// One line, where a timed pass saw something else than the counted one.
    pub fn trace(&self, bvh: &Bvh, lighting: Lighting, reading: Reading, repeats: &Repeats) -> Result<Traced, String> {
        let view = StudyView {
            bvh,
            triangles: &self.triangles,
            normals: &self.normals,
            camera: PublishedCamera::new(&self.camera, THESIS_SIZE.0, THESIS_SIZE.1),
        };
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
