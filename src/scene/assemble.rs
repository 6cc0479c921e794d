//! Where generators put their triangles: f64 in, rounded to f32 once, grouped into named objects.

use super::{Camera, Dropped, Material, Object, Scene};
use crate::geom::{Aabb, Triangle};
use glam::DVec3;

/// A triangle before it is rounded.
pub(super) type Triangle64 = [DVec3; 3];

/// Triangles and objects of a scene that is being generated.
pub(super) struct Assembly {
    triangles: Vec<Triangle>,
    objects: Vec<Object>,
    limit: usize,
}

impl Assembly {
    /// An assembly that is full at `limit` triangles and takes no more: generators of whole shapes fill it until then,
    /// and the last shape is cut short.
    pub(super) fn with_limit(limit: usize) -> Self {
        Self { triangles: Vec::with_capacity(limit), objects: Vec::new(), limit }
    }

    /// How many triangles still fit.
    pub(super) fn room(&self) -> usize {
        self.limit - self.triangles.len()
    }

    /// How many triangles it takes in all.
    pub(super) fn limit(&self) -> usize {
        self.limit
    }

    /// The box around everything so far.
    pub(super) fn bounds(&self) -> Aabb {
        Aabb::around(self.triangles.iter().flat_map(|t| t.v))
    }

    /// Opens an object; the triangles pushed from now on are its own.
    pub(super) fn begin(&mut self, name: impl Into<String>) {
        let start = self.triangles.len();
        self.objects.push(Object { name: name.into(), triangles: start..start });
    }

    /// Adds a triangle to the object opened last, if there is room.
    pub(super) fn push(&mut self, triangle: Triangle64) {
        if self.room() == 0 {
            return;
        }
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
            texture_coordinates: Vec::new(),
            dropped: Dropped::default(),
            warnings: Vec::new(),
            camera,
            cameras: Vec::new(),
        }
    }
}
