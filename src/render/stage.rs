//! The stage: a scene made ready for pictures under a set of effects, with what those effects need and nothing else.

use super::film::Film;
use super::framing::viewpoint;
use super::integrator::{Look, Primaries, Row, ThroughPixels, Work, renderers};
use super::lights::Lights;
use super::options::{Demand, Frame, StageOptions};
use super::studio::Studio;
use super::surface::Surface;
use super::winding::{Inward, inward};
use super::{RayCounts, RayKind};
use crate::bvh::Bvh;
use crate::geom::{Hit, Ray};
use crate::rows::Lighting;
use crate::scene::{
    Bitmap, Camera, Effect, EffectSet, EffectUse, Material, Scene, Texture, smooth_normals, used_materials,
};
use crate::trace::Tracer;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A scene, its tree, and what the effects that are on need of it.
#[derive(Clone, Debug)]
pub struct Stage<'a> {
    pub(super) scene: &'a Scene,
    pub(super) tracer: Tracer<'a>,
    /// The scene's, or those of a lighting case of the thesis.
    pub(super) materials: Vec<Material>,
    /// What each material calls for, of what is on.
    pub(super) called_for: Vec<EffectSet>,
    /// Cast, uncalled for: what they see counts for nothing.
    pub(super) forced: EffectSet,
    /// Where shadows are on and something emits light.
    pub(super) lights: Option<Lights>,
    /// A picture for each material, where textures are on; else empty.
    pub(super) textures: Vec<Option<Bitmap>>,
    /// A picture for each material, where cut-outs are on; else empty.
    pub(super) cut_outs: Vec<Option<Bitmap>>,
    pub(super) depth: u32,
    pub(super) least_weight: f32,
    pub(super) background: Vec3,
    normals: Vec<[Vec3; 3]>,
    /// Where refraction is on: triangles that face into their body.
    inward: Vec<bool>,
    on: EffectSet,
    warnings: Vec<String>,
}

/// Why a scene was not made ready.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StageError {
    /// The tree has no nodes, or a triangle id that the scene does not have.
    #[error("the tree is not one over this scene's {triangles} triangles")]
    Tree {
        /// Triangles of the scene.
        triangles: usize,
    },
    /// A triangle has no material, or none of the scene's.
    #[error("the scene's materials do not fit its {triangles} triangles")]
    Materials {
        /// Triangles of the scene.
        triangles: usize,
    },
}

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Its light.
    pub film: Film,
    /// Rays that it took.
    pub rays: RayCounts,
}

impl<'a> Stage<'a> {
    /// Makes `scene` ready: decodes the pictures that its surfaces are drawn with, finds its lights, lays `bvh` out. A picture
    /// that cannot be read is left out and told in [`Self::warnings`].
    ///
    /// # Errors
    /// [`StageError`] where `bvh` or the materials are not the scene's.
    pub fn new(scene: &'a Scene, bvh: &'a Bvh, options: &StageOptions) -> Result<Self, StageError> {
        let triangles = scene.triangles.len();
        if bvh.nodes.is_empty() || bvh.triangle_ids.iter().any(|&id| id as usize >= triangles) {
            return Err(StageError::Tree { triangles });
        }
        let has_material = |&id: &u16| usize::from(id) < scene.materials.len();
        if scene.material_ids.len() != triangles || !scene.material_ids.iter().all(has_material) {
            return Err(StageError::Materials { triangles });
        }
        let materials: Vec<_> = scene.materials.iter().map(|m| under(options.demand, m)).collect();
        let is_used = used_materials(scene);
        let called_for: Vec<_> = materials
            .iter()
            .zip(is_used)
            .map(|(m, used)| if used { EffectSet::of(m) } else { EffectSet::EMPTY })
            .collect();
        let all = called_for.iter().fold(EffectSet::EMPTY, |sum, &set| sum.or(set));
        let (on, forced) = match options.demand {
            Demand::Materials | Demand::Thesis(_) => (all, EffectSet::EMPTY),
            Demand::Forced(set) => (set, set),
        };
        let (depth, least_weight) = match options.demand {
            Demand::Thesis(Lighting::Reflection) => (1, 0.0),
            Demand::Thesis(_) => (u32::try_from(crate::trace::TEXT_CHAIN).unwrap_or(u32::MAX), 0.0),
            _ => (options.depth, options.least_weight),
        };
        let mut warnings = Vec::new();
        let mut pictures = |effect: Effect, of: fn(&Material) -> &Option<Texture>| {
            let called = materials.iter().zip(&called_for).map(|(m, set)| of(m).as_ref().filter(|_| set.has(effect)));
            if on.has(effect) { called.map(|texture| decoded(texture, &mut warnings)).collect() } else { Vec::new() }
        };
        let textures = pictures(Effect::Texture, |m| &m.diffuse_map);
        let cut_outs = pictures(Effect::CutOut, |m| &m.opacity_map);
        let bends = |id: usize| {
            let material = scene.material_ids[id];
            called_for[usize::from(material)].has(Effect::Refraction).then_some(material)
        };
        let Inward { triangles: inward, bodies } =
            if on.has(Effect::Refraction) { inward(&scene.triangles, bends) } else { Inward::default() };
        if bodies > 0 {
            let objects = if bodies == 1 { "object is" } else { "objects are" };
            warnings.push(format!("{bodies} closed clear {objects} wound inwards; light bends as if turned outwards"));
        }
        let tracer = Tracer::new(options.kernel, bvh, &scene.triangles);
        let lights = on.has(Effect::Shadow).then(|| Lights::of(&scene.material_ids, &materials, &tracer)).flatten();
        Ok(Self {
            scene,
            tracer,
            called_for: called_for.into_iter().map(|set| set.and(on)).collect(),
            forced,
            background: if lights.is_some() { Vec3::ZERO } else { options.background },
            lights,
            textures,
            cut_outs,
            depth,
            least_weight,
            normals: smooth_normals(scene),
            inward,
            on,
            warnings,
            materials,
        })
    }

    /// The effects that are on.
    pub fn effects(&self) -> EffectSet {
        self.on
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The effects that are on, each with the materials in use that call for it; none where it is forced.
    pub fn callers(&self) -> Vec<EffectUse> {
        let named = |effect: Effect| {
            let calling = self.materials.iter().zip(&self.called_for).filter(|(_, set)| set.has(effect));
            EffectUse { effect, materials: calling.map(|(material, _)| material.name.clone()).collect() }
        };
        self.on.iter().map(named).collect()
    }

    /// Where to look at the scene from: the camera of its file, upright, or of a file without one a place that shows what there
    /// is: inside of a room, before an open side, near what most triangles are in.
    pub fn viewpoint(&self) -> Camera {
        viewpoint(self.scene, &self.tracer)
    }

    /// Whether a ray that comes from the front of the triangle, or from its back, is outside of what it bounds.
    pub(super) fn is_outside(&self, hit: &Hit, from_front: bool) -> bool {
        from_front != self.inward.get(hit.triangle as usize).is_some_and(|&inward| inward)
    }

    /// What was not as it should be, a line each: pictures that could not be read, clear bodies that are wound inwards.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The factor that suits a film of this stage: of a scene with lights, what makes its mean middle grey; else 1, as the
    /// studio's lights are made for it.
    pub fn exposure(&self, film: &Film) -> f32 {
        if self.lights.is_some() { film.auto_exposure() } else { 1.0 }
    }

    /// Takes a picture, on the current rayon pool: the same light and the same counts for any number of threads.
    pub fn render(&self, camera: &Camera, frame: &Frame) -> Picture {
        let view = camera.view(frame.width, frame.height);
        self.render_rays(camera, frame, &ThroughPixels { view, is_spread: frame.rays_per_pixel > 1 })
    }

    /// As [`Self::render`], by any primary rays; the camera says where the studio's lights stand.
    pub(super) fn render_rays<P: Primaries>(&self, camera: &Camera, frame: &Frame, primaries: &P) -> Picture {
        let (width, height) = (frame.width as usize, frame.height as usize);
        let mut pixels = vec![Vec3::ZERO; width * height];
        let studio = Studio::of(camera);
        let look = Look { stage: self, studio: &studio };
        let run = const { renderers::<P>() }[usize::from(self.on.bits())];
        let rays = pixels
            .par_chunks_mut(width.max(1))
            .enumerate()
            .map_init(Work::default, |work, (y, pixels)| {
                let samples = frame.rays_per_pixel.max(1);
                let row = Row { look, primaries, y: y as u32, samples };
                work.rays = RayCounts::default();
                run(&row, pixels, work);
                work.rays
            })
            .reduce(RayCounts::default, |a, b| a + b);
        Picture { film: Film { width: frame.width, pixels }, rays }
    }

    #[inline]
    pub(super) fn material_id(&self, hit: &Hit) -> usize {
        usize::from(self.scene.material_ids[hit.triangle as usize])
    }

    // Not inlined, so that it is compiled once and not once for each set of effects.
    #[inline(never)]
    pub(super) fn surface(&self, ray: &Ray, hit: &Hit) -> Surface {
        let id = hit.triangle as usize;
        Surface::at(&self.scene.triangles[id], self.normals.get(id), ray, hit)
    }

    /// Radiance from where nothing is. What mirrors and glass show of it is darker below and brighter above, so that they have
    /// a shape.
    pub(super) fn nothing(&self, kind: RayKind, direction: Vec3) -> Vec3 {
        match kind {
            RayKind::Reflection | RayKind::Refraction => {
                let height = direction.as_dvec3().normalize_or_zero().dot(DVec3::Y) as f32;
                self.background * (0.6 + 0.4 * height)
            }
            _ => self.background,
        }
    }
}

/// The material, or what a lighting case of the thesis makes of it.
fn under(demand: Demand, material: &Material) -> Material {
    let matt = Material { name: material.name.clone(), diffuse: material.diffuse, ..Material::default() };
    match demand {
        Demand::Materials | Demand::Forced(_) => material.clone(),
        Demand::Thesis(Lighting::Primary) => matt,
        Demand::Thesis(Lighting::Reflection) => Material { illumination_model: 3, specular: Vec3::splat(0.5), ..matt },
        Demand::Thesis(Lighting::Opacity) => Material { opacity: 0.5, ..matt },
    }
}

fn decoded(texture: Option<&Texture>, warnings: &mut Vec<String>) -> Option<Bitmap> {
    match texture?.decode() {
        Ok(bitmap) => Some(bitmap),
        Err(error) => {
            warnings.push(error.to_string());
            None
        }
    }
}
