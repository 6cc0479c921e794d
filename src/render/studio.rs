//! Light for what brings none of its own: a headlight, and a key light from over the viewer's left shoulder.

use super::surface::Surface;
use crate::scene::{Camera, Material};
use glam::{DVec3, Vec3};

/// Two lights that go with the camera. They cast no shadow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Studio {
    /// Towards the key light.
    key: DVec3,
}

impl Studio {
    pub(super) fn of(camera: &Camera) -> Self {
        let look = (camera.look_at.as_dvec3() - camera.eye.as_dvec3()).normalize_or(DVec3::NEG_Z);
        let up = camera.up.as_dvec3().normalize_or(DVec3::Y);
        Self { key: (up - look.cross(up) * 0.6 - look * 0.5).normalize_or(up) }
    }

    /// Towards the key light.
    pub(super) fn key(&self) -> DVec3 {
        self.key
    }

    /// What a surface of diffuse colour `diffuse` reflects towards the viewer.
    pub(super) fn shade(&self, surface: &Surface, diffuse: Vec3, material: &Material) -> Vec3 {
        let headlight = surface.cosine();
        let key = surface.normal.dot(self.key).max(0.0);
        let mut light = diffuse * (0.12 + 0.4 * headlight + 0.55 * key) as f32;
        if has_highlight(material) && key > 0.0 {
            let half = (self.key - surface.direction).normalize_or_zero();
            light += material.specular * (0.55 * highlight(half.dot(surface.normal), material.shininess)) as f32;
        }
        light
    }
}

/// Whether the material has a highlight (illumination models 2 and up, MTL format).
pub(super) fn has_highlight(material: &Material) -> bool {
    material.illumination_model >= 2 && material.specular != Vec3::ZERO
}

/// Blinn's highlight: cosⁿ of the angle between normal and half vector.
pub(super) fn highlight(cosine: f64, exponent: f32) -> f64 {
    libm::pow(cosine.clamp(0.0, 1.0), f64::from(exponent.clamp(1.0, 1e5)))
}
