//! The builders by name: a new builder is one new file and one entry here.

use super::bottom_up::{all_pairs_literal, centres_exact, chain_exact, chain_literal, union_area};
use super::top_down::{Costs, Published, Text, published_exact, published_literal, text_exact, text_literal};
use super::{Brake, BuildError, Counters, Probe};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use crate::refine::collapse;

/// A reading of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// What its program did.
    Published,
    /// What its text says.
    Text,
    /// Bottom-up by union area, as the paper it cites has it.
    Walter,
}

/// How the work is done; the tree does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Near-linear work, provably the same choices.
    Exact,
    /// Every combination, every pair.
    Literal,
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 3] = [Self::Published, Self::Text, Self::Walter];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Text => "text",
            Self::Walter => "walter",
        }
    }
}

impl Engine {
    /// All engines.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Literal];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Literal => "literal",
        }
    }
}

/// What a caller can ask of a builder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Children per inner node: 2, 4 or 8.
    pub arity: usize,
    /// Reading of the thesis.
    pub preset: Preset,
    /// How the work is done.
    pub engine: Engine,
    /// Candidate positions or planes per axis of a top-down search; the thesis' 200/arity if `None`.
    pub candidates: Option<usize>,
    /// Rule Q8 of the preset `published` at arity 8 (see [`Published::q8`]).
    pub q8: bool,
    /// In which numbers costs are added; only the literal `top-down published` has f32.
    pub costs: Costs,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            arity: 2,
            preset: Preset::Published,
            engine: Engine::Exact,
            candidates: None,
            q8: true,
            costs: Costs::Exact,
        }
    }
}

/// A builder as the laboratory sees it.
#[derive(Clone, Copy, Debug)]
pub struct Builder {
    /// Its name on the command line and in rows.
    pub id: &'static str,
    /// The publication it comes from.
    pub paper: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// The readings it has; the first is its default.
    pub presets: &'static [Preset],
    /// The engines it has; the first is its default.
    pub engines: &'static [Engine],
    /// The readings and engines that share their work between all threads of the current pool; all others use one.
    pub parallel: &'static [(Preset, Engine)],
    /// The arities it builds.
    pub arities: &'static [usize],
    /// Builds, for timing: nothing is counted but the steps its brake needs.
    pub timed: fn(&[Aabb], &BuildOptions, &mut Brake) -> Result<Bvh, BuildError>,
    /// Builds the same tree and counts the work.
    pub counted: fn(&[Aabb], &BuildOptions, &mut Counters) -> Result<Bvh, BuildError>,
}

/// All builders, in the order of `list builders`.
pub const BUILDERS: &[Builder] = &[
    Builder {
        id: "top-down",
        paper: "Beick 2014",
        summary: "exhaustive search over arity - 1 splits at once, on one axis (published) or mixed planes (text)",
        presets: &[Preset::Published, Preset::Text],
        engines: &Engine::ALL,
        parallel: &[],
        arities: &[2, 4, 8],
        timed: top_down::<Brake>,
        counted: top_down::<Counters>,
    },
    Builder {
        id: "bottom-up",
        paper: "Beick 2014, after Walter et al. 2008",
        summary: "agglomerative clustering, by a chain (published), the closest centres (text) or the least union (walter)",
        presets: &[Preset::Published, Preset::Text, Preset::Walter],
        engines: &Engine::ALL,
        parallel: &[(Preset::Walter, Engine::Exact)],
        arities: &[2, 4, 8],
        timed: bottom_up::<Brake>,
        counted: bottom_up::<Counters>,
    },
];

/// The builder called `id`.
pub fn find(id: &str) -> Option<&'static Builder> {
    BUILDERS.iter().find(|b| b.id == id)
}

impl Builder {
    /// Checks that the builder offers what `options` ask for.
    ///
    /// # Errors
    /// [`BuildError::Arity`] or [`BuildError::Parameter`].
    pub fn check(&self, options: &BuildOptions) -> Result<(), BuildError> {
        if !self.arities.contains(&options.arity) {
            return Err(BuildError::Arity(options.arity));
        }
        if !self.presets.contains(&options.preset) {
            let offered: Vec<_> = self.presets.iter().map(|p| p.id()).collect();
            let message = format!("{} has no preset {}: use {}", self.id, options.preset.id(), offered.join(" or "));
            return Err(BuildError::Parameter(message));
        }
        if !self.engines.contains(&options.engine) {
            let offered: Vec<_> = self.engines.iter().map(|e| e.id()).collect();
            let message = format!("{} has no engine {}: use {}", self.id, options.engine.id(), offered.join(" or "));
            return Err(BuildError::Parameter(message));
        }
        let has_f32 = (self.id, options.preset, options.engine) == ("top-down", Preset::Published, Engine::Literal);
        if options.costs == Costs::Single && !has_f32 {
            let message = "only top-down, preset published, engine literal adds its costs in f32";
            return Err(BuildError::Parameter(message.into()));
        }
        Ok(())
    }

    /// How many threads a build with `options` shares its work between.
    pub fn threads(&self, options: &BuildOptions) -> usize {
        if self.parallel.contains(&(options.preset, options.engine)) { rayon::current_num_threads() } else { 1 }
    }
}

fn top_down<P: Probe>(boxes: &[Aabb], options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    let arity = options.arity;
    let candidates = options.candidates.unwrap_or(200 / arity.max(1));
    let published = Published { arity, candidates, q8: options.q8 };
    let text = Text { arity, planes: candidates };
    match (options.preset, options.engine) {
        (Preset::Published, Engine::Exact) => published_exact::build(boxes, &published, probe),
        (Preset::Published, Engine::Literal) => published_literal::build_by(boxes, &published, options.costs, probe),
        (Preset::Text, Engine::Exact) => text_exact::build(boxes, &text, probe),
        (Preset::Text, Engine::Literal) => text_literal::build(boxes, &text, probe),
        (Preset::Walter, _) => Err(BuildError::Parameter("top-down has no preset walter".into())),
    }
}

fn bottom_up<P: Probe>(boxes: &[Aabb], options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    use all_pairs_literal::Distance;
    let binary = match (options.preset, options.engine) {
        (Preset::Published, Engine::Exact) => chain_exact::build(boxes, probe),
        (Preset::Text, Engine::Exact) => centres_exact::build(boxes, probe),
        (Preset::Walter, Engine::Exact) => union_area::build(boxes, probe),
        (Preset::Published, Engine::Literal) => chain_literal::build(boxes, probe, &mut ()),
        (Preset::Text, Engine::Literal) => all_pairs_literal::build(boxes, Distance::Centres, probe),
        (Preset::Walter, Engine::Literal) => all_pairs_literal::build(boxes, Distance::UnionArea, probe),
    }?;
    match options.arity {
        2 => Ok(binary),
        arity @ (4 | 8) => Ok(collapse(&binary, arity)),
        arity => Err(BuildError::Arity(arity)),
    }
}
