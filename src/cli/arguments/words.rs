//! Single words: names from a list, and values that a word is read as.

use bvh_lab::build::{self, Builder, Engine, Preset};
use bvh_lab::refine::{Collapse, Refinements};
use bvh_lab::rows::{Experiment, Lighting};
use bvh_lab::scene::{EffectSet, UnknownEffect};
use bvh_lab::trace::Kernel;
use clap::ValueEnum;
use std::time::Duration;

/// A builder and the steps that refine its tree.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    pub builder: &'static Builder,
    pub refine: Refinements,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PresetWord {
    /// What the thesis' program did
    Published,
    /// What its text says
    Text,
    /// Bottom-up by union area, as Walter et al. 2008
    Walter,
}

impl From<PresetWord> for Preset {
    fn from(word: PresetWord) -> Self {
        match word {
            PresetWord::Published => Self::Published,
            PresetWord::Text => Self::Text,
            PresetWord::Walter => Self::Walter,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineWord {
    /// Near-linear work, provably the same tree
    Exact,
    /// Every combination, every pair
    Literal,
}

impl From<EngineWord> for Engine {
    fn from(word: EngineWord) -> Self {
        match word {
            EngineWord::Exact => Self::Exact,
            EngineWord::Literal => Self::Literal,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CostsWord {
    /// Integers: ties are ties
    Exact,
    /// Single precision, from left to right, as the thesis' program did
    F32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    On,
    Off,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RayWord {
    /// From the camera through every pixel
    Primary,
    /// From what the camera sees, cosine-weighted
    Diffuse,
    /// Shadow rays, from what the camera sees to points on the sphere around the scene: is anything in between?
    Any,
}

impl RayWord {
    pub const fn id(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Diffuse => "diffuse",
            Self::Any => "any",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HeatWord {
    /// Nodes entered
    Nodes,
    /// Triangles tested
    Tests,
    /// Nanoseconds
    Time,
}

/// `auto`, or a set of effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectWord {
    Auto,
    Set(EffectSet),
}

/// A lighting case of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightingWord {
    /// Primary rays only
    Primary,
    /// Every surface a mirror, one reflection deep
    Reflection,
    /// Every surface of opacity ½
    Opacity,
}

impl From<LightingWord> for Lighting {
    fn from(word: LightingWord) -> Self {
        match word {
            LightingWord::Primary => Self::Primary,
            LightingWord::Reflection => Self::Reflection,
            LightingWord::Opacity => Self::Opacity,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ListWord {
    Scenes,
    Builders,
    Kernels,
    Experiments,
    Refinements,
}

/// What can be asked of the study: a table or figure of the thesis, or a table beyond it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    Table(u8),
    Figure(u8),
    /// The table of decisions by f32 costs.
    Decisions,
    /// Experiments on the thesis' findings.
    Experiments(Vec<Experiment>),
}

pub fn seconds(word: &str) -> Result<Duration, String> {
    let number: f64 = word.parse().map_err(|_| "a number of seconds is wanted".to_owned())?;
    match Duration::try_from_secs_f64(number) {
        Ok(limit) if !limit.is_zero() => Ok(limit),
        _ => Err("a number of seconds above 0 is wanted; leave it out for the default".into()),
    }
}

pub fn item(word: &str) -> Result<Item, String> {
    let numbered = |prefix: &str| word.to_ascii_lowercase().strip_prefix(prefix).and_then(|n| n.parse::<u8>().ok());
    match (numbered("table"), numbered("figure")) {
        (Some(n @ 1..=9), _) => Ok(Item::Table(n)),
        (_, Some(n @ 3..=5)) => Ok(Item::Figure(n)),
        _ => match word.to_ascii_lowercase().as_str() {
            "decisions" => Ok(Item::Decisions),
            "experiments" => Ok(Item::Experiments(Experiment::ALL.to_vec())),
            // Those that show what is an artefact of the program.
            "artefacts" => Ok(Item::Experiments(Experiment::ALL[..5].to_vec())),
            name => match Experiment::ALL.into_iter().find(|e| e.id() == name) {
                Some(experiment) => Ok(Item::Experiments(vec![experiment])),
                None => {
                    let names: Vec<_> = Experiment::ALL.iter().map(|e| e.id()).collect();
                    Err(format!(
                        "table1 … table9, figure3 … figure5, decisions, experiments, artefacts or one of {} are wanted",
                        names.join(", ")
                    ))
                }
            },
        },
    }
}

pub fn arity(word: &str) -> Result<usize, String> {
    match word {
        "2" => Ok(2),
        "4" => Ok(4),
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("2, 4, 8 or 16 are wanted".into()),
    }
}

pub fn size(word: &str) -> Result<(u32, u32), String> {
    const LARGEST: u32 = 1 << 14;
    let parsed = word.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match parsed {
        Some((w @ 1..=LARGEST, h @ 1..=LARGEST)) => Ok((w, h)),
        _ => Err(format!("WIDTHxHEIGHT in pixels is wanted, each 1 to {LARGEST}")),
    }
}

pub fn effects(word: &str) -> Result<EffectWord, String> {
    match word {
        "auto" => Ok(EffectWord::Auto),
        _ => word.parse().map(EffectWord::Set).map_err(|e: UnknownEffect| format!("{e}; or auto")),
    }
}

/// A number of stops.
pub fn stops(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(stops) if stops.abs() <= 64.0 => Ok(stops),
        _ => Err("a number of stops from -64 to 64 is wanted".into()),
    }
}

pub fn recipe(word: &str) -> Result<Recipe, String> {
    let (id, steps) = word.split_once('+').unwrap_or((word, ""));
    let builder = build::find(id).ok_or_else(|| {
        let ids: Vec<_> = build::BUILDERS.iter().map(|b| b.id).collect();
        format!("there is no such builder; there are {}", ids.join(", "))
    })?;
    Ok(Recipe { builder, refine: steps.parse()? })
}

pub fn collapse(word: &str) -> Result<Collapse, String> {
    let ids = Collapse::ALL.map(Collapse::id);
    Collapse::ALL.into_iter().find(|c| c.id() == word).ok_or_else(|| format!("{} are wanted", ids.join(" or ")))
}

pub fn kernel(word: &str) -> Result<(String, Kernel), String> {
    match Kernel::from_id(word) {
        Some(kernel) => Ok((word.to_owned(), kernel)),
        None => {
            let ids: Vec<_> = bvh_lab::trace::KERNELS.iter().map(|k| k.id).collect();
            Err(format!("there is no such kernel; there are {}", ids.join(", ")))
        }
    }
}
