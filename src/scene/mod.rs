//! Scenes: triangles with their objects and materials, a camera, and an account of what the loader dropped.

mod assemble;
mod camera;
mod effects;
mod error;
mod export;
pub mod families;
pub mod file;
mod normals;
mod spec;
mod texture;
pub mod thesis;
mod twist;

pub use camera::{CameraError, CameraSpec, View};
pub use effects::{Effect, EffectSet, EffectUse, UnknownEffect, effects, used_materials};
pub use error::SceneError;
pub use export::export_obj;
pub use normals::smooth_normals;
pub use texture::{Bitmap, Texture, TextureError, TextureSource};
pub use twist::twist;

use crate::geom::{Aabb, Triangle};
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Everything a builder, a tracer or a renderer needs to know of a scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The name it was asked for by (`thesis:tiny`, `gen:soup:1000:1`, a path).
    pub name: String,
    /// Triangles; a triangle's index is its id everywhere.
    pub triangles: Vec<Triangle>,
    /// Objects in file order, each a contiguous range of triangle ids.
    pub objects: Vec<Object>,
    /// Materials; never empty, index 0 is the default one.
    pub materials: Vec<Material>,
    /// Index into [`Scene::materials`], one per triangle.
    pub material_ids: Vec<u16>,
    /// Texture coordinates of the three vertices, one entry per triangle; empty where no material has a texture.
    pub texture_coordinates: Vec<[Vec2; 3]>,
    /// What the loader left out, and why.
    pub dropped: Dropped,
    /// Lines worth telling the user: what was repaired, ignored or not found.
    pub warnings: Vec<String>,
    /// Where the scene is looked at from.
    pub camera: Camera,
    /// Cameras that the file names; the first is the scene's own.
    pub cameras: Vec<NamedCamera>,
}

/// A camera of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// Its name in the file.
    pub name: String,
    /// The camera.
    pub camera: Camera,
}

/// A named range of triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Its name in the file or generator.
    pub name: String,
    /// Its triangle ids.
    pub triangles: Range<usize>,
}

/// A surface description in the terms of the MTL format.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name in the file.
    pub name: String,
    /// Diffuse reflectance `Kd`, linear RGB.
    pub diffuse: Vec3,
    /// Specular reflectance `Ks`, linear RGB.
    pub specular: Vec3,
    /// Emitted radiance `Ke`, linear RGB.
    pub emission: Vec3,
    /// Specular exponent `Ns`.
    pub shininess: f32,
    /// Index of refraction `Ni`.
    pub refraction_index: f32,
    /// Opacity `d` (1 − `Tr`).
    pub opacity: f32,
    /// Transmission filter `Tf`, linear RGB: what passes through a body of it, of the light that its opacity lets in.
    pub transmission_filter: Vec3,
    /// Illumination model `illum`.
    pub illumination_model: u8,
    /// Picture whose colours the diffuse reflectance is multiplied by, `map_Kd`.
    pub diffuse_map: Option<Texture>,
    /// Picture of the surface's shape, `map_d`: what is clear in it is cut out.
    pub opacity_map: Option<Texture>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: "default".into(),
            diffuse: Vec3::splat(0.8),
            specular: Vec3::ZERO,
            emission: Vec3::ZERO,
            shininess: 1.0,
            refraction_index: 1.0,
            opacity: 1.0,
            transmission_filter: Vec3::ONE,
            illumination_model: 1,
            diffuse_map: None,
            opacity_map: None,
        }
    }
}

/// What a loader left out, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Dropped {
    /// Triangles with a NaN or infinite vertex.
    pub not_finite: usize,
    /// Point and line elements.
    pub points_and_lines: usize,
}

impl Dropped {
    /// How many in all.
    pub fn total(&self) -> usize {
        self.not_finite + self.points_and_lines
    }
}

impl std::fmt::Display for Dropped {
    /// `3 triangles with a NaN or infinite vertex and 2 points and lines`, or nothing where nothing was left out.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counted = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
        let parts = [
            counted(self.not_finite, "triangles with a NaN or infinite vertex"),
            counted(self.points_and_lines, "points and lines"),
        ];
        f.write_str(&parts.into_iter().flatten().collect::<Vec<_>>().join(" and "))
    }
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: Vec3,
    /// The point in the middle of the picture.
    pub look_at: Vec3,
    /// Roughly upwards in the picture.
    pub up: Vec3,
    /// Vertical field of view in degrees, over the whole picture.
    pub fov_degrees: f32,
}

impl Scene {
    /// Bounding boxes of all triangles, in id order: what a builder starts from.
    pub fn boxes(&self) -> Vec<Aabb> {
        self.triangles.iter().map(Triangle::aabb).collect()
    }

    /// The box around the whole scene.
    pub fn bounds(&self) -> Aabb {
        self.triangles.iter().fold(Aabb::EMPTY, |b, t| b.union(&t.aabb()))
    }

    /// Sum of all triangle areas.
    pub fn surface_area(&self) -> f64 {
        self.triangles.iter().map(Triangle::area).sum()
    }
}
