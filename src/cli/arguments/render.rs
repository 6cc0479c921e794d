//! Words of `render`.

use super::tree::TreeArguments;
use super::words::{EffectWord, HeatWord, LightingWord, Recipe, effects, recipe, size, stops};
use bvh_lab::render::Demand;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub struct RenderArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file
    pub scene: String,
    #[command(flatten)]
    pub tree: TreeArguments,
    /// The picture: PNG, or linear light as EXR [default: the scene's name with .png]
    #[arg(short, long, value_name = "FILE.png|FILE.exr")]
    pub output: Option<PathBuf>,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = size)]
    pub size: (u32, u32),
    /// Camera, such as eye=1,2,3,look=0,0,0,up=0,1,0,fov=45, what is not given being the scene's; or the name of a camera in its
    /// file, or all of them. Several: a picture each, numbered
    #[arg(long, value_name = "SPEC|NAME|all")]
    pub camera: Vec<String>,
    /// Rays a pixel [default: 4; 16 where the scene has lights]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub spp: Option<u32>,
    /// Rays along each side of a pixel: 2 means --spp 4
    #[arg(long, value_name = "N", conflicts_with = "spp", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: Option<u32>,
    /// Effects: auto, as the materials call for them; or exactly these on every surface, called for or not: all, none, or names
    /// with commas between (shadow, mirror, transparency, refraction, emission, cut-out, texture)
    #[arg(long, value_name = "EFFECTS", default_value = "auto", value_parser = effects)]
    pub effects: EffectWord,
    /// Instead of the scene's materials: a lighting case of the thesis
    #[arg(long, value_name = "CASE", conflicts_with = "effects")]
    pub lighting: Option<LightingWord>,
    /// Mirrors and clear surfaces that a ray is followed over
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub depth: u32,
    /// Brighter by so many stops (factors of 2) than the exposure found
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = stops, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Say which effects are on, which materials call for them, what rays each cast, and what all effects would have cost
    #[arg(long, conflicts_with = "heatmap")]
    pub explain: bool,
    /// One JSON object on standard output
    #[arg(long, conflicts_with = "heatmap")]
    pub json: bool,
    /// Work per pixel instead of the picture
    #[arg(long, conflicts_with_all = ["effects", "lighting", "spp", "samples", "exposure"])]
    pub heatmap: Option<HeatWord>,
    /// With --heatmap: beside it, on the same scale, that of a tree by this builder
    #[arg(long, value_name = "BUILDER", value_parser = recipe, requires = "heatmap")]
    pub against: Option<Recipe>,
}

impl RenderArguments {
    /// What the picture is asked to show.
    pub fn demand(&self) -> Demand {
        match (self.lighting, self.effects) {
            (Some(case), _) => Demand::Thesis(case.into()),
            (None, EffectWord::Auto) => Demand::Materials,
            (None, EffectWord::Set(set)) => Demand::Forced(set),
        }
    }

    /// Rays a pixel, where they were asked for.
    pub fn rays_per_pixel(&self) -> Option<u32> {
        self.spp.or(self.samples.map(|side| side * side))
    }
}
