//! The camera of the thesis' program, with its integer pixel offsets.

use crate::geom::Ray;
use crate::scene::Camera;
use glam::DVec3;

/// The thesis' picture: 300 × 300 pixels.
pub const THESIS_SIZE: (u32, u32) = (300, 300);

/// Rays through `look + offset · 2·tan(fov/2)/width` along u = look × up and v = look × u, all of unit length.
///
/// Offsets are the *integers* trunc((2·p + 1 − size)/2), so where the size is even the two middle columns coincide, and
/// so do the two middle rows. Computed in f64 and rounded to f32 once, direction normalised.
///
/// Row 0 is the side of −v. With the thesis' up vector (0, −1, 0), v points up and u to the left in the world, so its
/// picture comes out turned by 180° (upside down, not mirrored); [`Self::upright`] turns it back.
#[derive(Clone, Copy, Debug)]
pub struct PublishedCamera {
    eye: DVec3,
    look: DVec3,
    u: DVec3,
    v: DVec3,
    step: f64,
    width: u32,
    height: u32,
}

impl PublishedCamera {
    /// The program's camera at `camera`, for a picture of `width` × `height` pixels.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let eye = camera.eye.as_dvec3();
        let look = (camera.look_at.as_dvec3() - eye).normalize();
        let u = look.cross(camera.up.as_dvec3()).normalize();
        let half_angle = f64::from(camera.fov_degrees).to_radians() * 0.5;
        Self {
            eye,
            look,
            u,
            v: look.cross(u),
            // libm's tangent: the platform's differs between systems in the last bit.
            step: 2.0 * libm::tan(half_angle) / f64::from(width),
            width,
            height,
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The camera turned by 180° about its line of sight if its picture is upside down (world up is +y): the same rays,
    /// pixel (x, y) being the other's (width − 1 − x, height − 1 − y).
    #[must_use]
    pub fn upright(mut self) -> Self {
        if self.v.y > 0.0 {
            (self.u, self.v) = (-self.u, -self.v);
        }
        self
    }

    /// The primary ray of pixel (`x`, `y`), from t = 0 without an end.
    pub fn ray(&self, x: u32, y: u32) -> Ray {
        // Integer division truncates towards zero, as the program's cast did.
        let offset = |p: u32, size: u32| ((2 * i64::from(p) + 1 - i64::from(size)) / 2) as f64 * self.step;
        let direction = self.look + offset(x, self.width) * self.u + offset(y, self.height) * self.v;
        Ray::new(self.eye.as_vec3(), direction.normalize().as_vec3())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn thesis() -> PublishedCamera {
        let camera =
            Camera { eye: Vec3::new(22.0, 22.0, 32.0), look_at: Vec3::ZERO, up: Vec3::NEG_Y, fov_degrees: 30.0 };
        PublishedCamera::new(&camera, THESIS_SIZE.0, THESIS_SIZE.1)
    }

    #[test]
    fn the_two_middle_columns_and_rows_coincide() {
        let camera = thesis();
        for p in [0, 77, 149, 150, 299] {
            assert_eq!(camera.ray(149, p), camera.ray(150, p));
            assert_eq!(camera.ray(p, 149), camera.ray(p, 150));
        }
        assert_ne!(camera.ray(148, 0), camera.ray(149, 0));
        assert_ne!(camera.ray(150, 0), camera.ray(151, 0));
        let middle = camera.ray(150, 150);
        let look = DVec3::new(-22.0, -22.0, -32.0).normalize().as_vec3();
        assert_eq!((middle.origin, middle.direction), (Vec3::new(22.0, 22.0, 32.0), look));
    }

    #[test]
    fn the_outermost_offset_is_149_steps() {
        let camera = thesis();
        let look = camera.ray(150, 150).direction.as_dvec3();
        let edge = camera.ray(0, 150).direction.as_dvec3();
        let angle = edge.cross(look).length() / edge.dot(look);
        assert!((angle - 149.0 * 2.0 * 15f64.to_radians().tan() / 300.0).abs() < 1e-6, "{angle}");
    }

    #[test]
    fn the_picture_is_turned_by_180_degrees_and_can_be_turned_back() {
        let (camera, upright) = (thesis(), thesis().upright());
        // Seen from the camera, the world's right is along look × (+y).
        let right = Vec3::new(-22.0, -22.0, -32.0).cross(Vec3::Y);
        assert!(camera.ray(150, 0).direction.y < camera.ray(150, 299).direction.y);
        assert!(camera.ray(0, 150).direction.dot(right) > camera.ray(299, 150).direction.dot(right));
        assert!(upright.ray(150, 0).direction.y > upright.ray(150, 299).direction.y);
        assert!(upright.ray(0, 150).direction.dot(right) < upright.ray(299, 150).direction.dot(right));
        for (x, y) in [(0, 0), (3, 200), (149, 299), (150, 150)] {
            assert_eq!(upright.ray(x, y), camera.ray(299 - x, 299 - y));
        }
        assert_eq!(upright.upright().ray(1, 2), upright.ray(1, 2));
    }
}
