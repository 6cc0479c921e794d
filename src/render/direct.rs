//! What a surface reflects of the lights: one shadow ray a hit, or the studio's light.

use super::RayKind::Shadow;
use super::integrator::{Row, Work, cast, is_blocked, is_hole};
use super::lights::LightPoint;
use super::optics::fresnel;
use super::sampler::Sampler;
use super::split::surface_filter;
use super::stage::Stage;
use super::studio::{has_highlight, highlight};
use super::surface::{Surface, texture_coordinates};
use crate::geom::{Hit, Ray};
use crate::scene::{Effect, Material};
use crate::trace::leave_surface;
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// The light that the surface itself reflects: of the scene's lights, or else of the studio's.
#[inline(never)]
pub(super) fn reflected<
    const CLEAR: bool,
    const BENDS: bool,
    const SHADOW: bool,
    const CUT: bool,
    const TEXTURE: bool,
>(
    row: &Row,
    ray: &Ray,
    hit: &Hit,
    surface: &Surface,
    (sampler, pair): (&Sampler, u32),
    work: &mut Work,
) -> Vec3 {
    let stage = row.stage;
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
            let light =
                lights.sample(&stage.scene.triangles, &stage.scene.material_ids, &stage.materials, sampler.pair(pair));
            let glossy = has_highlight(material) && !stage.called_for[id].has(Effect::Mirror);
            let glossy = if glossy { Some(material) } else { None };
            // Towards the viewer a little brighter, so that corners show where no light reaches directly.
            let facing = 0.75 + 0.25 * surface.cosine() as f32;
            let ambient = diffuse * FRAC_1_PI * lights.ambient() * facing;
            return ambient + lit::<CLEAR, BENDS, CUT>(stage, start, surface, &light, (diffuse, glossy), work);
        }
        // Forced, and no light to go to: towards the key light, for nothing.
        visibility::<CLEAR, BENDS, CUT>(stage, Ray::new(start, row.studio.key().as_vec3()), work);
    }
    row.studio.shade(surface, diffuse, material)
}

/// The light of one point of a light: no shadow ray where it lies behind the surface.
#[inline(always)]
fn lit<const CLEAR: bool, const BENDS: bool, const CUT: bool>(
    stage: &Stage,
    start: Vec3,
    surface: &Surface,
    light: &LightPoint,
    (diffuse, glossy): (Vec3, Option<&Material>),
    work: &mut Work,
) -> Vec3 {
    /// The share of the way that a shadow ray goes: the light does not block itself.
    const ALMOST: f32 = 1.0 - 1e-4;
    let way = light.point - start.as_dvec3();
    let squared = way.length_squared();
    let towards = way / squared.sqrt();
    let (cosine, at_light) = (surface.normal.dot(towards), light.cosine(towards));
    if !(cosine > 0.0 && surface.flat.dot(towards) > 0.0 && at_light > 0.0) {
        return Vec3::ZERO;
    }
    let seen = visibility::<CLEAR, BENDS, CUT>(stage, Ray { t_max: ALMOST, ..Ray::new(start, way.as_vec3()) }, work);
    if seen == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let mut reflectance = diffuse * FRAC_1_PI;
    if let Some(material) = glossy {
        let half: DVec3 = (towards - surface.direction).normalize_or_zero();
        // (n + 8)/8π makes the highlight's energy that of Ks (Akenine-Möller et al. 2008, section 7.6).
        let normalised = (material.shininess.clamp(1.0, 1e5) + 8.0) / (8.0 * PI);
        reflectance += material.specular * normalised * highlight(half.dot(surface.normal), material.shininess) as f32;
    }
    seen * light.radiance * reflectance * (cosine * at_light / squared) as f32
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
