//! A mesh under construction: what every reader of polygons fills.

use super::{Parts, polygon};
use crate::geom::Triangle;
use crate::scene::{Dropped, Material, Object};
use glam::{Vec2, Vec3};

/// The triangles of a strip, all wound as its first one: every other one comes the other way round.
pub(super) fn strip<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> {
    corners.windows(3).enumerate().map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
}

/// Triangles with their objects and materials, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) triangles: Vec<Triangle>,
    /// Empty, or one entry a triangle.
    pub(super) texture_coordinates: Vec<[Vec2; 3]>,
    pub(super) material_ids: Vec<u16>,
    pub(super) objects: Vec<Object>,
}

impl Mesh {
    /// Opens an object; the triangles pushed from now on are its own.
    pub(super) fn begin(&mut self, name: String) {
        let start = self.triangles.len();
        self.objects.push(Object { name, triangles: start..start });
    }

    /// Adds a polygon to the object opened last: one triangle fewer than two per corner. `texture` is empty, or one entry
    /// a corner.
    pub(super) fn polygon(&mut self, corners: &[Vec3], texture: &[Vec2], material: u16) {
        let start = self.triangles.len();
        polygon::triangulate(corners, |a, b, c| {
            self.triangles.push(Triangle::new(corners[a], corners[b], corners[c]));
            if !texture.is_empty() {
                self.texture_coordinates.push([texture[a], texture[b], texture[c]]);
            }
        });
        self.material_ids.resize(self.triangles.len(), material);
        self.close(start);
    }

    /// Adds a triangle to the object opened last.
    #[inline]
    pub(super) fn triangle(&mut self, triangle: Triangle, material: u16) {
        self.triangles.push(triangle);
        self.material_ids.push(material);
        self.close(self.triangles.len() - 1);
    }

    #[inline]
    fn close(&mut self, start: usize) {
        let end = self.triangles.len();
        match self.objects.last_mut() {
            Some(object) => object.triangles.end = end,
            None => self.objects.push(Object { name: "unnamed".into(), triangles: start..end }),
        }
    }

    /// The finished parts: triangles with a NaN or infinite vertex dropped and counted, objects without triangles gone.
    pub(super) fn finish(mut self, materials: Vec<Material>, mut dropped: Dropped, warnings: Vec<String>) -> Parts {
        if self.triangles.iter().any(|t| !t.is_finite()) {
            dropped.not_finite += self.drop_not_finite();
        }
        self.objects.retain(|object| !object.triangles.is_empty());
        Parts {
            triangles: self.triangles,
            objects: self.objects,
            materials,
            material_ids: self.material_ids,
            texture_coordinates: self.texture_coordinates,
            cameras: Vec::new(),
            dropped,
            warnings,
        }
    }

    fn drop_not_finite(&mut self) -> usize {
        let keep: Vec<bool> = self.triangles.iter().map(Triangle::is_finite).collect();
        fn retain<T>(items: &mut Vec<T>, keep: &[bool]) {
            let mut kept = keep.iter();
            items.retain(|_| kept.next().copied().unwrap_or(false));
        }
        retain(&mut self.triangles, &keep);
        retain(&mut self.material_ids, &keep);
        retain(&mut self.texture_coordinates, &keep);
        let mut end = 0;
        for object in &mut self.objects {
            let start = end;
            end += keep[object.triangles.clone()].iter().filter(|&&kept| kept).count();
            object.triangles = start..end;
        }
        keep.len() - end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_goes_with_all_that_belongs_to_it() {
        let mut mesh = Mesh::default();
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN];
        let texture = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
        mesh.begin("all gone".into());
        mesh.polygon(&corners[1..], &texture[1..], 1);
        mesh.begin("two".into());
        mesh.polygon(&corners, &texture, 2);
        mesh.polygon(&corners[..3], &texture[..3], 3);
        let parts = mesh.finish(Vec::new(), Dropped::default(), Vec::new());
        assert_eq!((parts.triangles.len(), parts.dropped.not_finite), (2, 2));
        assert_eq!(parts.material_ids, [2, 3]);
        assert_eq!(parts.texture_coordinates, [[Vec2::ZERO, Vec2::X, Vec2::Y]; 2]);
        assert_eq!(parts.objects, [Object { name: "two".into(), triangles: 0..2 }]);
    }
}
