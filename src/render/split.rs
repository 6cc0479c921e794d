//! What is seen in a surface and through it: mirrors, glass, clear sheets.

use super::RayKind::{self, Reflection, Refraction, Transparency};
use super::integrator::{Segment, Work, cast};
use super::optics::{fresnel, refract};
use super::stage::Stage;
use super::surface::Surface;
use crate::geom::{Hit, Ray, Triangle};
use crate::scene::{Effect, Material};
use crate::trace::{enter_surface, leave_surface};
use glam::Vec3;

/// A hit with all that is known of it.
pub(super) struct Here<'a> {
    pub(super) stage: &'a Stage<'a>,
    pub(super) ray: &'a Ray,
    pub(super) hit: &'a Hit,
    pub(super) surface: &'a Surface,
    pub(super) material: &'a Material,
    pub(super) id: usize,
}

impl Here<'_> {
    fn triangle(&self) -> &Triangle {
        &self.stage.scene.triangles[self.hit.triangle as usize]
    }

    fn mirrored(&self) -> Ray {
        Ray::new(leave_surface(self.ray, self.hit, self.triangle()), self.surface.mirrored().as_vec3())
    }

    fn straight_on(&self) -> Ray {
        Ray { t_min: self.hit.t.next_up(), ..*self.ray }
    }

    /// The ray on the other side; none beyond the critical angle. A smooth normal can bend it back out of the surface; the flat one
    /// then takes its place.
    fn refracted(&self, eta: f64) -> Option<Ray> {
        let Surface { direction, normal, flat, .. } = *self.surface;
        let smooth = refract(direction, normal, eta)?;
        let direction = if smooth.dot(flat) < 0.0 { smooth } else { refract(direction, flat, eta)? };
        Some(Ray::new(enter_surface(self.ray, self.hit, self.triangle()), direction.as_vec3()))
    }

    /// The index of refraction on the ray's side over that behind: of what is around bodies it is 1.
    fn eta(&self) -> f64 {
        let index = f64::from(self.material.refraction_index).max(f64::from(f32::MIN_POSITIVE));
        if self.stage.is_outside(self.hit, self.surface.is_front) { 1.0 / index } else { index }
    }
}

/// Puts aside what is seen in and through the surface; returns the share of the light that is left to the surface itself.
// Not inlined, as all that does not concern every effect: one for each set of its own.
#[inline(never)]
pub(super) fn split<const MIRROR: bool, const CLEAR: bool, const BENDS: bool>(
    here: &Here,
    segment: &Segment,
    work: &mut Work,
) -> Vec3 {
    let stage = here.stage;
    let called_for = stage.called_for[here.id];
    let mut left = Vec3::ONE;
    let bends = BENDS && called_for.has(Effect::Refraction);
    let clear = (CLEAR && called_for.has(Effect::Transparency)) || bends;
    // Without refraction a surface is a thin sheet, whichever side is seen.
    let eta = if bends { here.eta() } else { 1.0 / f64::from(here.material.refraction_index.max(1.0)) };
    let mut push = |ray: Ray, kind: RayKind, share: Vec3| {
        let weight = segment.weight * share;
        if segment.depth < stage.depth && weight.max_element() > stage.least_weight {
            work.open.push(Segment { ray, kind, weight, depth: segment.depth + 1 });
        }
    };
    if MIRROR && called_for.has(Effect::Mirror) {
        let cosine = here.surface.cosine();
        if clear {
            let share = fresnel(cosine, eta) as f32;
            // Beyond the critical angle it is the refracted ray that turns back.
            if share < 1.0 || !bends {
                push(here.mirrored(), Reflection, Vec3::splat(share));
                left *= 1.0 - share;
            }
        } else {
            push(here.mirrored(), Reflection, polished(here.material, cosine));
        }
    }
    if clear {
        let through = here.material.transmittance();
        let passes = left * through * surface_filter(here.material);
        if !bends {
            push(here.straight_on(), Transparency, passes);
        } else if let Some(ray) = here.refracted(eta) {
            push(ray, Refraction, passes);
        } else {
            // Total internal reflection.
            push(here.mirrored(), Refraction, left);
            left = Vec3::ZERO;
        }
        left *= 1.0 - through;
    }
    forced::<MIRROR, CLEAR, BENDS>(here, work);
    left
}

/// Casts what is on but not called for here, and looks away.
fn forced<const MIRROR: bool, const CLEAR: bool, const BENDS: bool>(here: &Here, work: &mut Work) {
    let uncalled = here.stage.forced.without(here.stage.called_for[here.id]);
    let mut look_away = |ray: Ray, kind| {
        cast(here.stage, &ray, kind, work);
    };
    if MIRROR && uncalled.has(Effect::Mirror) {
        look_away(here.mirrored(), Reflection);
    }
    if CLEAR && uncalled.has(Effect::Transparency) {
        look_away(here.straight_on(), Transparency);
    }
    if BENDS && uncalled.has(Effect::Refraction) {
        look_away(here.refracted(here.eta()).unwrap_or_else(|| here.mirrored()), Refraction);
    }
}

/// What a polished surface reflects: `Ks`, and with illumination model 5 more at grazing angles (Schlick 1994).
fn polished(material: &Material, cosine: f64) -> Vec3 {
    let straight = material.specular;
    if material.illumination_model != 5 {
        return straight;
    }
    let grazing = (1.0 - cosine as f32).powi(5);
    straight + (Vec3::ONE - straight).max(Vec3::ZERO) * grazing
}

/// What one surface lets through, by colour: a body has two, and `Tf` is of the whole of it.
pub(super) fn surface_filter(material: &Material) -> Vec3 {
    material.transmission_filter.max(Vec3::ZERO).map(f32::sqrt)
}
