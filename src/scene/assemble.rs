//! Where generators put their triangles: f64 in, rounded to f32 once, grouped into named objects.

use super::{Camera, Dropped, Material, Object, Scene};
use crate::geom::Triangle;
use glam::DVec3;

/// A triangle before it is rounded.
pub(super) type Triangle64 = [DVec3; 3];

/// Triangles and objects of a scene that is being generated.
#[derive(Default)]
pub(super) struct Assembly {
    pub(super) triangles: Vec<Triangle>,
    pub(super) objects: Vec<Object>,
}

impl Assembly {
    /// Opens an object; the triangles pushed from now on are its own.
    pub(super) fn begin(&mut self, name: impl Into<String>) {
        let start = self.triangles.len();
        self.objects.push(Object {
            name: name.into(),
            triangles: start..start,
        });
    }

    /// Adds a triangle to the object opened last.
    pub(super) fn push(&mut self, triangle: Triangle64) {
        let [a, b, c] = triangle.map(|p| p.as_vec3());
        self.triangles.push(Triangle::new(a, b, c));
        if let Some(object) = self.objects.last_mut() {
            object.triangles.end = self.triangles.len();
        }
    }

    /// The scene of one default material.
    pub(super) fn finish(self, name: &str, camera: Camera) -> Scene {
        Scene {
            name: name.to_owned(),
            material_ids: vec![0; self.triangles.len()],
            triangles: self.triangles,
            objects: self.objects,
            materials: vec![Material::default()],
            dropped: Dropped::default(),
            warnings: Vec::new(),
            camera,
        }
    }
}
