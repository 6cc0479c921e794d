//! What a picture took: effects, who called for them, rays by kind, and what it would have taken with every effect on.

use crate::cli::{Failure, wrong};
use bvh_lab::bvh::Bvh;
use bvh_lab::render::{Demand, Frame, Picture, RayCounts, RayKind, Stage, StageOptions};
use bvh_lab::scene::{Camera, Effect, EffectSet, Scene};
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The JSON object of `render`.
#[derive(Debug, Serialize)]
pub struct Report {
    scene: String,
    output: String,
    width: u32,
    height: u32,
    rays_per_pixel: u32,
    /// What is on.
    effects: Vec<Effect>,
    /// Materials that call for each effect, in the order of `effects`; none where it is forced.
    called_for_by: Vec<Vec<String>>,
    /// Rays by kind.
    rays: RayCounts,
    render_ms: f64,
    /// With `--explain`: the same picture with every effect on, on every surface.
    all_effects: Option<AllEffects>,
}

/// A picture with every effect on.
#[derive(Debug, Serialize)]
struct AllEffects {
    rays: RayCounts,
    render_ms: f64,
    same_picture: bool,
}

impl Report {
    pub fn new(path: &Path, stage: &Stage, frame: &Frame, picture: &Picture, seconds: f64) -> Self {
        let callers = stage.callers();
        Self {
            scene: stage.scene().name.clone(),
            output: path.display().to_string(),
            width: frame.width,
            height: frame.height,
            rays_per_pixel: frame.rays_per_pixel,
            effects: callers.iter().map(|call| call.effect).collect(),
            called_for_by: callers.into_iter().map(|call| call.materials).collect(),
            rays: picture.rays,
            render_ms: seconds * 1e3,
            all_effects: None,
        }
    }

    /// Takes the picture once more with every effect on.
    pub fn force(
        &mut self,
        (scene, bvh): (&Scene, &Bvh),
        options: &StageOptions,
        camera: &Camera,
        frame: &Frame,
        picture: &Picture,
    ) -> Result<(), Failure> {
        let options = StageOptions { demand: Demand::Forced(EffectSet::ALL), ..*options };
        let stage = Stage::new(scene, bvh, &options).map_err(wrong)?;
        let begin = Instant::now();
        let forced = stage.render(camera, frame);
        let render_ms = begin.elapsed().as_secs_f64() * 1e3;
        self.all_effects = Some(AllEffects { rays: forced.rays, render_ms, same_picture: forced.film == picture.film });
        Ok(())
    }

    /// How many rays an effect cast.
    fn cast_by(&self, effect: Effect) -> String {
        match ray_kind(effect).map(|kind| self.rays.of(kind)) {
            None => ": no ray of its own".into(),
            Some(0) if effect == Effect::Transparency && self.effects.contains(&Effect::Refraction) => {
                ": its rays are those of refraction".into()
            }
            Some(rays) => format!(": {rays} rays"),
        }
    }

    pub fn text(&self) -> String {
        let mut lines = vec![format!(
            "{}: {} × {} pixels, {} rays a pixel",
            self.output, self.width, self.height, self.rays_per_pixel
        )];
        for (effect, materials) in self.effects.iter().zip(&self.called_for_by) {
            let who = match materials.as_slice() {
                [] => "forced, nothing calls for it".into(),
                some => format!("called for by {}", some.join(", ")),
            };
            lines.push(format!("on          {}, {who}{}", effect.id(), self.cast_by(*effect)));
        }
        let off: Vec<_> = Effect::ALL.iter().filter(|e| !self.effects.contains(e)).map(|e| e.id()).collect();
        if !off.is_empty() {
            lines.push(format!("off         {}: no ray", off.join(", ")));
        }
        let kinds = RayKind::ALL.iter().filter(|&&kind| self.rays.of(kind) > 0);
        let kinds: Vec<_> = kinds.map(|&kind| format!("{} {}", self.rays.of(kind), kind.id())).collect();
        lines.push(format!("rays        {} in {:.0} ms: {}", self.rays.total(), self.render_ms, kinds.join(", ")));
        if let Some(all) = &self.all_effects {
            lines.push(format!(
                "all effects {} rays in {:.0} ms, {:.2} times the rays and {:.2} times the time; {} picture",
                all.rays.total(),
                all.render_ms,
                all.rays.total() as f64 / self.rays.total().max(1) as f64,
                all.render_ms / self.render_ms,
                if all.same_picture { "the same" } else { "another" }
            ));
        }
        lines.join("\n")
    }
}

/// The kind of ray that an effect casts, if it casts any.
const fn ray_kind(effect: Effect) -> Option<RayKind> {
    match effect {
        Effect::Shadow => Some(RayKind::Shadow),
        Effect::Mirror => Some(RayKind::Reflection),
        Effect::Transparency => Some(RayKind::Transparency),
        Effect::Refraction => Some(RayKind::Refraction),
        Effect::CutOut => Some(RayKind::CutOut),
        Effect::Emission | Effect::Texture => None,
    }
}
