//! What a surface reflects of the lights: one shadow ray a hit, or the studio's light.

use super::RayKind::Shadow;
use super::integrator::{Look, Work, cast, is_blocked, is_hole};
use super::lights::Lights;
use super::optics::fresnel;
use super::reflectance::Reflectance;
use super::sampler::Choice;
use super::split::surface_filter;
use super::stage::Stage;
use super::surface::{Surface, texture_coordinates};
use crate::geom::{Hit, Ray};
use crate::scene::Effect;
use crate::trace::leave_surface;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// The light that the surface itself reflects: of the scene's lights, or else of the studio's.
#[inline(never)]
pub(super) fn reflected<
    const CLEAR: bool,
    const BENDS: bool,
    const SHADOW: bool,
    const CUT: bool,
    const TEXTURE: bool,
>(
    look: Look,
    ray: &Ray,
    hit: &Hit,
    surface: &Surface,
    choice: Choice,
    work: &mut Work,
) -> Vec3 {
    let stage = look.stage;
    let id = stage.material_id(hit);
    let material = &stage.materials[id];
    let mut diffuse = material.diffuse;
    if TEXTURE {
        let triangle = hit.triangle as usize;
        if let (Some(picture), Some(corners)) = (&stage.textures[id], stage.scene.texture_coordinates.get(triangle)) {
            diffuse *= picture.colour(texture_coordinates(corners, &stage.scene.triangles[triangle], ray, hit));
        }
    }
    if SHADOW {
        let start = leave_surface(ray, hit, &stage.scene.triangles[hit.triangle as usize]);
        if let Some(lights) = &stage.lights {
            let is_glossy = !stage.called_for[id].has(Effect::Mirror);
            let reflectance = Reflectance::of(material, diffuse, is_glossy);
            let mut light = ambient(lights, surface, diffuse);
            if let Some(direct) = choose(lights, start, surface, &reflectance, choice) {
                light += direct.light * visibility::<CLEAR, BENDS, CUT>(stage, direct.shadow, work);
            }
            return light;
        }
        // Forced, and no light to go to: towards the key light, for nothing.
        visibility::<CLEAR, BENDS, CUT>(stage, Ray::new(start, look.studio.key().as_vec3()), work);
    }
    look.studio.shade(surface, diffuse, material)
}

/// Light that was reflected more than once: towards the viewer a little brighter, so that corners show where no light reaches
/// directly.
#[inline(always)]
pub(super) fn ambient(lights: &Lights, surface: &Surface, diffuse: Vec3) -> Vec3 {
    diffuse * FRAC_1_PI * lights.ambient() * (0.75 + 0.25 * surface.cosine() as f32)
}

/// What comes from one point of a light, if nothing is between.
pub(super) struct Direct {
    /// Up to the light and not further.
    pub(super) shadow: Ray,
    /// What the surface reflects of it towards the viewer.
    pub(super) light: Vec3,
}

/// A point of a light, by one choice: of those that the lights offer, or where the surface is glossy of those that its highlight
/// shows. Either counts by what both together are likely to choose (the balance heuristic for one sample, Veach 1997, section
/// 9.2.4). None where it lies behind the surface: no shadow ray then, nor where nothing is reflected.
pub(super) fn choose(
    lights: &Lights,
    start: Vec3,
    surface: &Surface,
    reflectance: &Reflectance,
    choice: Choice,
) -> Option<Direct> {
    /// The share of the way that a shadow ray goes: the light does not block itself.
    const ALMOST: f32 = 1.0 - 1e-4;
    if reflectance.is_black() {
        return None;
    }
    let from = start.as_dvec3();
    let [u, v] = choice.pair().map(f64::from);
    let gloss = if lights.are_few() { reflectance.gloss() } else { 0.0 };
    let point = if u < gloss {
        lights.along(from, surface.normal, reflectance.sample(surface, [u / gloss, v]))?
    } else {
        lights.sample(from, surface.normal, [(u - gloss) / (1.0 - gloss), v])?
    };
    let towards = point.way.normalize_or_zero();
    let cosine = surface.normal.dot(towards);
    if !(cosine > 0.0 && surface.flat.dot(towards) > 0.0) {
        return None;
    }
    let mut density = (1.0 - gloss) * point.density;
    if gloss > 0.0 {
        density += gloss * reflectance.density(surface, towards);
    }
    let light = point.emission * reflectance.from(surface, towards) * (cosine / density) as f32;
    Some(Direct { shadow: Ray { t_max: ALMOST, ..Ray::new(start, point.way.as_vec3()) }, light })
}

/// What share of the light arrives along a shadow ray, by colour: through clear surfaces in a straight line, less what they
/// reflect, and through holes.
fn visibility<const CLEAR: bool, const BENDS: bool, const CUT: bool>(stage: &Stage, ray: Ray, work: &mut Work) -> Vec3 {
    if const { !(CLEAR || BENDS || CUT) } {
        return if is_blocked(stage, &ray, work) { Vec3::ZERO } else { Vec3::ONE };
    }
    let (mut ray, mut share) = (ray, Vec3::ONE);
    while let Some(hit) = cast(stage, &ray, Shadow, work) {
        if !(CUT && is_hole(stage, &ray, &hit)) {
            share *= passed(stage, &ray, &hit);
            if share.max_element() <= stage.least_weight {
                return Vec3::ZERO;
            }
        }
        ray.t_min = hit.t.next_up();
        if ray.t_min > ray.t_max {
            break;
        }
    }
    share
}

/// What a surface lets through of a shadow ray's light.
fn passed(stage: &Stage, ray: &Ray, hit: &Hit) -> Vec3 {
    let id = stage.material_id(hit);
    let (material, called_for) = (&stage.materials[id], stage.called_for[id]);
    if !(called_for.has(Effect::Transparency) || called_for.has(Effect::Refraction)) {
        return Vec3::ZERO;
    }
    let reflected = if called_for.has(Effect::Mirror) {
        let surface = stage.surface(ray, hit);
        fresnel(surface.cosine(), 1.0 / f64::from(material.refraction_index.max(1.0))) as f32
    } else {
        0.0
    };
    (1.0 - reflected) * material.transmittance() * surface_filter(material)
}
