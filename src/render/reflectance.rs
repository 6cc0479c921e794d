//! How a surface that is neither mirror nor clear reflects: evenly, and with a highlight.

use super::studio::{has_highlight, highlight};
use super::surface::Surface;
use crate::scene::Material;
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};
use std::f64::consts::TAU;

/// Lambert's reflectance and Blinn's highlight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflectance {
    pub(super) diffuse: Vec3,
    /// Colour of the highlight; zero where there is none.
    specular: Vec3,
    shininess: f32,
}

impl Reflectance {
    /// Of `diffuse` colour, with the material's highlight if it `is_glossy`; what mirrors has none besides.
    pub(super) fn of(material: &Material, diffuse: Vec3, is_glossy: bool) -> Self {
        let specular =
            if is_glossy && has_highlight(material) { material.specular.max(Vec3::ZERO) } else { Vec3::ZERO };
        Self { diffuse, specular, shininess: material.shininess.clamp(1.0, 1e5) }
    }

    /// Whether it reflects nothing.
    pub(super) fn is_black(&self) -> bool {
        self.diffuse == Vec3::ZERO && self.specular == Vec3::ZERO
    }

    /// The share of directions that are drawn from the highlight: its part in what is reflected, at most half, as it may well miss
    /// all lights.
    pub(super) fn gloss(&self) -> f64 {
        let (specular, diffuse) = (self.specular.element_sum(), self.diffuse.max(Vec3::ZERO).element_sum());
        if specular > 0.0 { f64::from(specular / (specular + diffuse)).min(0.5) } else { 0.0 }
    }

    /// Reflected radiance per irradiance from the direction `towards`, of unit length.
    pub(super) fn from(&self, surface: &Surface, towards: DVec3) -> Vec3 {
        let mut sum = self.diffuse * FRAC_1_PI;
        if self.specular != Vec3::ZERO {
            // (n + 8)/8π makes the highlight's energy that of Ks (Akenine-Möller et al. 2008, section 7.6).
            let normalised = (self.shininess + 8.0) / (8.0 * PI);
            let half = (towards - surface.direction).normalize_or_zero();
            sum += self.specular * normalised * highlight(half.dot(surface.normal), self.shininess) as f32;
        }
        sum
    }

    /// A direction from the highlight by two numbers of [0, 1): half vectors as dense as the highlight is bright (Walter 2005).
    pub(super) fn sample(&self, surface: &Surface, [u, v]: [f64; 2]) -> DVec3 {
        let cosine = libm::pow(1.0 - u, 1.0 / (f64::from(self.shininess) + 1.0));
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (right, up) = surface.normal.any_orthonormal_pair();
        let half = surface.normal * cosine + (right * libm::cos(TAU * v) + up * libm::sin(TAU * v)) * sine;
        surface.direction - 2.0 * surface.direction.dot(half) * half
    }

    /// How dense [`Self::sample`] is about the direction `towards`, per steradian.
    pub(super) fn density(&self, surface: &Surface, towards: DVec3) -> f64 {
        let half = (towards - surface.direction).normalize_or_zero();
        let against = 4.0 * towards.dot(half).abs();
        let dense = (f64::from(self.shininess) + 1.0) / TAU * highlight(half.dot(surface.normal), self.shininess);
        if against > 0.0 { dense / against } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(direction: DVec3) -> Surface {
        Surface { flat: DVec3::Z, normal: DVec3::Z, is_front: true, direction: direction.normalize() }
    }

    fn glossy(shininess: f32) -> Reflectance {
        let material = Material { illumination_model: 2, specular: Vec3::splat(0.5), shininess, ..Material::default() };
        Reflectance::of(&material, Vec3::splat(0.5), true)
    }

    #[test]
    fn directions_are_as_dense_as_is_said() {
        // The mean of 1/density over the samples of a region is its solid angle.
        let (steep, grazing) = (DVec3::new(0.3, 0.1, -1.0), DVec3::new(1.0, 0.0, -0.5));
        for (shininess, direction) in [(1.0, steep), (40.0, steep), (40.0, grazing), (3000.0, grazing)] {
            let (surface, reflectance) = (surface(direction), glossy(shininess));
            let middle = surface.mirrored();
            // A cap that holds a good part of the highlight and is above the surface.
            let edge = 1.0 - 0.5 / f64::from(shininess + 1.0);
            let n = 400;
            let mut sum = 0.0;
            for i in 0..n * n {
                let at = [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                let towards = reflectance.sample(&surface, at);
                assert!((towards.length() - 1.0).abs() < 1e-12);
                if towards.dot(middle) > edge {
                    sum += 1.0 / reflectance.density(&surface, towards);
                }
            }
            let mean = sum / f64::from(n * n);
            assert!((mean / (TAU * (1.0 - edge)) - 1.0).abs() < 0.02, "{shininess} {direction}: {mean}");
        }
    }

    #[test]
    fn what_has_no_highlight_is_even() {
        let matt = Reflectance::of(&Material::default(), Vec3::splat(PI), true);
        let mirror = Material { illumination_model: 3, specular: Vec3::ONE, ..Material::default() };
        let polished = Reflectance::of(&mirror, Vec3::ZERO, false);
        let surface = surface(DVec3::NEG_Z);
        assert_eq!((matt.gloss(), matt.from(&surface, DVec3::Z)), (0.0, Vec3::ONE));
        assert_eq!((polished.gloss(), polished.is_black(), matt.is_black()), (0.0, true, false));
        assert_eq!(glossy(9.0).gloss(), 0.5);
        assert!(glossy(9.0).from(&surface, DVec3::Z).x > glossy(9.0).from(&surface, DVec3::X).x);
    }
}
