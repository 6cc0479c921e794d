//! The light that comes back along a ray: one renderer for every set of effects.
//!
//! Recursive ray tracing (Whitted 1980) with area lights by one shadow ray a hit (Cook, Porter and Carpenter 1984). Every
//! function here is compiled once for each set of the effects that concern it, its constant parameters: what an effect would
//! do is no instruction where the set does not have it. Rays are counted where they are cast.

use super::RayCounts;
use super::RayKind::{self, CutOut, Primary, Shadow};
use super::direct::reflected;
use super::sampler::{Choice, Sampler};
use super::split::{Here, split};
use super::stage::Stage;
use super::studio::Studio;
use super::surface::texture_coordinates;
use crate::geom::{Hit, Ray};
use crate::scene::{Effect, View};
use crate::trace::{Query, Scratch};
use glam::Vec3;

/// Where primary rays come from. A parameter of the renderer and not an object behind a pointer: where nothing is hit, making
/// the ray is most of what a pixel costs.
pub(super) trait Primaries: Sync {
    /// The ray of a sample of pixel (`x`, `y`).
    fn ray(&self, x: u32, y: u32, sampler: Sampler) -> Ray;
}

/// Rays of an ordinary picture: spread over the area of each pixel, or one through its centre.
pub(super) struct ThroughPixels {
    pub(super) view: View,
    pub(super) is_spread: bool,
}

impl Primaries for ThroughPixels {
    #[inline(always)]
    fn ray(&self, x: u32, y: u32, sampler: Sampler) -> Ray {
        let [dx, dy] = if self.is_spread { sampler.choice(0).pair() } else { [0.5; 2] };
        self.view.ray_through(f64::from(x) + f64::from(dx), f64::from(y) + f64::from(dy))
    }
}

/// A stage as it is looked at: the studio's lights go with the camera.
#[derive(Clone, Copy)]
pub(super) struct Look<'a> {
    pub(super) stage: &'a Stage<'a>,
    pub(super) studio: &'a Studio,
}

/// One row of a picture.
pub(super) struct Row<'a, P> {
    pub(super) look: Look<'a>,
    pub(super) primaries: &'a P,
    pub(super) y: u32,
    pub(super) samples: u32,
}

/// Working memory of a thread, and the rays of its row.
#[derive(Debug, Default)]
pub(super) struct Work {
    pub(super) rays: RayCounts,
    scratch: Scratch,
    /// Rays still to be followed; stays without memory where nothing mirrors and nothing is clear.
    pub(super) open: Vec<Segment>,
}

/// A ray of the tree of rays behind a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) ray: Ray,
    pub(super) kind: RayKind,
    /// What its light counts for in the pixel.
    pub(super) weight: Vec3,
    pub(super) depth: u32,
}

/// Fills a row of pixels.
pub(super) type RenderRow<P> = fn(&Row<P>, &mut [Vec3], &mut Work);

/// The renderer of every set of effects, by its bits ([`crate::scene::EffectSet::bits`]).
pub(super) const fn renderers<P: Primaries>() -> [RenderRow<P>; 128] {
    seq_macro::seq!(E in 0..128 {
        [#(render_row::<
            P,
            { on(E, Effect::Mirror) },
            { on(E, Effect::Transparency) },
            { on(E, Effect::Refraction) },
            { on(E, Effect::Shadow) },
            { on(E, Effect::Emission) },
            { on(E, Effect::CutOut) },
            { on(E, Effect::Texture) },
        >,)*]
    })
}

/// Whether the set of effects with these bits has one.
const fn on(bits: u8, effect: Effect) -> bool {
    bits >> effect as u8 & 1 == 1
}

fn render_row<
    P: Primaries,
    const MIRROR: bool,
    const CLEAR: bool,
    const BENDS: bool,
    const SHADOW: bool,
    const EMISSION: bool,
    const CUT: bool,
    const TEXTURE: bool,
>(
    row: &Row<P>,
    pixels: &mut [Vec3],
    work: &mut Work,
) {
    for (x, pixel) in (0..).zip(pixels) {
        let pixel_sampler = Sampler::of_pixel(x, row.y);
        let mut sum = Vec3::ZERO;
        for index in 0..row.samples {
            let sampler = pixel_sampler.at(index);
            let ray = row.primaries.ray(x, row.y, sampler);
            sum += radiance::<MIRROR, CLEAR, BENDS, SHADOW, EMISSION, CUT, TEXTURE>(row.look, ray, sampler, work);
        }
        *pixel = sum / row.samples as f32;
    }
}

/// The light along a primary ray: the sum over all segments of its tree, of each its hit's light times its weight.
fn radiance<
    const MIRROR: bool,
    const CLEAR: bool,
    const BENDS: bool,
    const SHADOW: bool,
    const EMISSION: bool,
    const CUT: bool,
    const TEXTURE: bool,
>(
    look: Look,
    ray: Ray,
    sampler: Sampler,
    work: &mut Work,
) -> Vec3 {
    let mut segment = Segment { ray, kind: Primary, weight: Vec3::ONE, depth: 0 };
    let mut sum = Vec3::ZERO;
    // Choice 0 of the sampler is the place in the pixel.
    let mut number = 1;
    loop {
        let choice = sampler.choice(number);
        sum += segment.weight
            * along::<MIRROR, CLEAR, BENDS, SHADOW, EMISSION, CUT, TEXTURE>(look, &segment, choice, work);
        if const { !(MIRROR || CLEAR || BENDS) } {
            return sum;
        }
        match work.open.pop() {
            Some(next) => segment = next,
            None => return sum,
        }
        number += 1;
    }
}

/// The light of a segment's own hit; what is seen in or through it is put aside to be followed.
fn along<
    const MIRROR: bool,
    const CLEAR: bool,
    const BENDS: bool,
    const SHADOW: bool,
    const EMISSION: bool,
    const CUT: bool,
    const TEXTURE: bool,
>(
    look: Look,
    segment: &Segment,
    choice: Choice,
    work: &mut Work,
) -> Vec3 {
    let stage = look.stage;
    let mut ray = segment.ray;
    let Some(hit) = closest::<CUT>(stage, &mut ray, segment.kind, work) else {
        return stage.nothing(segment.kind, ray.direction);
    };
    let surface = stage.surface(&ray, &hit);
    let id = stage.material_id(&hit);
    let material = &stage.materials[id];
    let mut opaque = Vec3::ONE;
    if const { MIRROR || CLEAR || BENDS } {
        let here = Here { stage, ray: &ray, hit: &hit, surface: &surface, material, id };
        opaque = split::<MIRROR, CLEAR, BENDS>(&here, segment, work);
    }
    let mut light = Vec3::ZERO;
    // What lets all light through or mirrors all of it has none to reflect by itself.
    if const { !(MIRROR || CLEAR || BENDS) } || opaque != Vec3::ZERO || stage.forced.has(Effect::Shadow) {
        light = opaque * reflected::<CLEAR, BENDS, SHADOW, CUT, TEXTURE>(look, &ray, &hit, &surface, choice, work);
    }
    if EMISSION {
        light += material.emission;
    }
    light
}

/// The closest hit that is not in a hole; behind a hole, `ray` goes on.
fn closest<const CUT: bool>(stage: &Stage, ray: &mut Ray, kind: RayKind, work: &mut Work) -> Option<Hit> {
    let hit = cast(stage, ray, kind, work)?;
    if CUT {
        let mut hit = hit;
        while is_hole(stage, ray, &hit) {
            ray.t_min = hit.t.next_up();
            hit = cast(stage, ray, CutOut, work)?;
        }
        return Some(hit);
    }
    Some(hit)
}

/// Whether a picture cuts the surface out at the hit: where it is less than half opaque.
pub(super) fn is_hole(stage: &Stage, ray: &Ray, hit: &Hit) -> bool {
    let id = hit.triangle as usize;
    let Some(picture) = &stage.cut_outs[stage.material_id(hit)] else { return false };
    let Some(corners) = stage.scene.texture_coordinates.get(id) else { return false };
    picture.opacity(texture_coordinates(corners, &stage.scene.triangles[id], ray, hit)) < 0.5
}

#[inline(always)]
pub(super) fn cast(stage: &Stage, ray: &Ray, kind: RayKind, work: &mut Work) -> Option<Hit> {
    work.rays.add(kind);
    stage.tracer.trace(Query::Closest, ray, &mut work.scratch, &mut ())
}

#[inline(always)]
pub(super) fn is_blocked(stage: &Stage, ray: &Ray, work: &mut Work) -> bool {
    work.rays.add(Shadow);
    stage.tracer.trace(Query::Any, ray, &mut work.scratch, &mut ()).is_some()
}
