//! What a ray meets: normals, texture coordinates, colour.

use crate::geom::{Hit, Ray, Triangle};
use glam::{DVec3, Vec2, Vec3};

/// A point of a surface, seen along a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// The triangle's own unit normal, on the ray's side.
    pub(super) flat: DVec3,
    /// The unit normal to shade with, on the ray's side.
    pub(super) normal: DVec3,
    /// Whether the ray comes from the side from which the corners are counter-clockwise.
    pub(super) is_front: bool,
    /// Unit direction of the ray.
    pub(super) direction: DVec3,
}

impl Surface {
    /// Of `corners`, the unit normals of the triangle's vertices; without them every triangle is flat.
    pub(super) fn at(triangle: &Triangle, corners: Option<&[Vec3; 3]>, ray: &Ray, hit: &Hit) -> Self {
        let direction = ray.direction.as_dvec3().normalize();
        let flat = triangle.cross().normalize();
        let smooth = corners.and_then(|corners| {
            let [a, b, c] = corners.map(|n| at_crease(n.as_dvec3(), flat));
            let [u, v, w] = weights(triangle, ray, hit);
            (a * u + b * v + c * w).try_normalize()
        });
        let normal = smooth.unwrap_or(flat);
        let is_front = flat.dot(direction) <= 0.0;
        let side = if is_front { 1.0 } else { -1.0 };
        Self { flat: flat * side, normal: normal * side, is_front, direction }
    }

    /// Cosine of the angle between the ray and the normal, at least 0.
    pub(super) fn cosine(&self) -> f64 {
        (-self.direction.dot(self.normal)).max(0.0)
    }

    /// The mirrored ray's direction. A smooth normal can send it into the surface; the flat one then takes its place.
    pub(super) fn mirrored(&self) -> DVec3 {
        let about = |normal: DVec3| self.direction - 2.0 * self.direction.dot(normal) * normal;
        let smooth = about(self.normal);
        if smooth.dot(self.flat) > 0.0 { smooth } else { about(self.flat) }
    }
}

/// A corner's normal, or the triangle's own where the two differ by more than 30°: an edge that is meant to be seen.
/// (Half of the angle between two faces of a box is 45°, between neighbours of a coarse cylinder less than 20°.)
fn at_crease(smooth: DVec3, flat: DVec3) -> DVec3 {
    const COS_30_DEGREES: f64 = 0.866_025_403_784_438_6;
    if smooth.dot(flat) < COS_30_DEGREES { flat } else { smooth }
}

/// Barycentric coordinates of the hit, times twice the area squared: a common factor that directions do not mind.
fn weights(triangle: &Triangle, ray: &Ray, hit: &Hit) -> [f64; 3] {
    let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
    let area = triangle.cross();
    let [a, b, c] = triangle.v.map(|v| v.as_dvec3() - point);
    [b.cross(c), c.cross(a), a.cross(b)].map(|opposite| opposite.dot(area).max(0.0))
}

/// The texture coordinates of the hit, `corners` being those of the vertices.
pub(super) fn texture_coordinates(corners: &[Vec2; 3], triangle: &Triangle, ray: &Ray, hit: &Hit) -> Vec2 {
    let weights = weights(triangle, ray, hit);
    let sum: f64 = weights.iter().sum();
    if sum == 0.0 {
        return corners[0];
    }
    corners.iter().zip(weights).map(|(&uv, w)| uv * (w / sum) as f32).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: Triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);

    #[test]
    fn normals_face_the_ray_and_creases_stay() {
        let corners = [Vec3::Z, Vec3::new(0.3, 0.0, 1.0).normalize(), Vec3::Y];
        for z in [1.0, -1.0] {
            let ray = Ray::new(Vec3::new(0.5, 0.25, z), Vec3::new(0.0, 0.0, -z));
            let surface = Surface::at(&T, Some(&corners), &ray, &Hit { triangle: 0, t: 1.0 });
            assert_eq!((surface.flat, surface.is_front), (DVec3::Z * f64::from(z), z > 0.0));
            assert!(surface.normal.x * f64::from(z) > 0.05 && surface.normal.y == 0.0, "{}", surface.normal);
            assert!(surface.mirrored().dot(surface.flat) > 0.0);
        }
    }

    #[test]
    fn a_mirrored_ray_does_not_enter_the_surface() {
        let leaning = [Vec3::new(0.49, 0.0, 0.872).normalize(); 3];
        let ray = Ray::new(Vec3::new(-9.75, 0.25, 1.0), Vec3::new(10.0, 0.0, -1.0));
        let surface = Surface::at(&T, Some(&leaning), &ray, &Hit { triangle: 0, t: 1.0 });
        assert!(surface.mirrored().z > 0.0);
        let back = Surface { normal: -surface.normal, ..surface };
        assert_eq!(back.mirrored().z, surface.mirrored().z.max(back.mirrored().z));
    }

    #[test]
    fn texture_coordinates_are_interpolated() {
        let corners = [Vec2::ZERO, Vec2::new(2.0, 0.0), Vec2::new(0.0, 4.0)];
        let ray = Ray::new(Vec3::new(0.25, 0.5, 1.0), Vec3::NEG_Z);
        let at = texture_coordinates(&corners, &T, &ray, &Hit { triangle: 0, t: 1.0 });
        assert!((at - Vec2::new(0.5, 2.0)).length() < 1e-6, "{at}");
        let needle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::X * 2.0);
        assert_eq!(texture_coordinates(&corners, &needle, &ray, &Hit { triangle: 0, t: 1.0 }), corners[0]);
    }
}
