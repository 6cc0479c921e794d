//! The builders by name: a new builder is one new file and one entry in [`entries`].

mod entries;
mod pipeline;

pub use entries::BUILDERS;

use super::options::{BuildOptions, Engine, Parameter, Preset};
use super::top_down::Costs;
use super::{Brake, BuildError, Counters, Input, MAX_LEAF};
use crate::bvh::{Bvh, Limits};
use crate::geom::{Aabb, Triangle};
use crate::refine::{Refinements, Step};
use rayon::prelude::*;

/// A builder as the laboratory sees it.
#[derive(Clone, Copy, Debug)]
pub struct Builder {
    /// Its name on the command line and in rows.
    pub id: &'static str,
    /// The publication it comes from.
    pub paper: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// The readings of the thesis it has; the first is its default. None for modern builders.
    pub presets: &'static [Preset],
    /// The engines it has; the first is its default. None where there is one way of working.
    pub engines: &'static [Engine],
    /// The options it understands besides arity, preset and engine.
    pub parameters: &'static [Parameter],
    /// Whether a build with these options shares its work between all threads of the current pool, or uses one.
    pub parallel: fn(&BuildOptions) -> bool,
    /// Whether a triangle may stand in several leaves, each with a part of it.
    pub spatial: bool,
    /// The arities it builds.
    pub arities: &'static [usize],
    /// Builds, for timing: nothing is counted but the steps its brake needs.
    pub timed: fn(Input, &BuildOptions, &mut Brake) -> Result<Bvh, BuildError>,
    /// Builds the same tree and counts the work.
    pub counted: fn(Input, &BuildOptions, &mut Counters) -> Result<Bvh, BuildError>,
}

/// The builder called `id`.
pub fn find(id: &str) -> Option<&'static Builder> {
    BUILDERS.iter().find(|b| b.id == id)
}

/// The most triangles that a leaf may be asked to hold.
const MOST_IN_LEAF: usize = 64;

impl Builder {
    /// Checks that the builder offers what `options` ask for.
    ///
    /// # Errors
    /// [`BuildError::Arity`] or [`BuildError::Parameter`].
    pub fn check(&self, options: &BuildOptions) -> Result<(), BuildError> {
        if !self.arities.contains(&options.arity) {
            let offered: Vec<_> = self.arities.iter().map(ToString::to_string).collect();
            let message = format!("{} has no arity {}: use {}", self.id, options.arity, offered.join(" or "));
            return Err(BuildError::Parameter(message));
        }
        if !self.presets.is_empty() && !self.presets.contains(&options.preset) {
            let offered: Vec<_> = self.presets.iter().map(|p| p.id()).collect();
            let message = format!("{} has no preset {}: use {}", self.id, options.preset.id(), offered.join(" or "));
            return Err(BuildError::Parameter(message));
        }
        if !self.engines.is_empty() && !self.engines.contains(&options.engine) {
            let offered: Vec<_> = self.engines.iter().map(|e| e.id()).collect();
            let message = format!("{} has no engine {}: use {}", self.id, options.engine.id(), offered.join(" or "));
            return Err(BuildError::Parameter(message));
        }
        for parameter in Parameter::ALL {
            if parameter.is_set(options) && !self.parameters.contains(&parameter) {
                let message = format!("{} has no use for {}", self.id, parameter.flag());
                return Err(BuildError::Parameter(message));
            }
        }
        if options.costs == Costs::Single && (options.preset, options.engine) != (Preset::Published, Engine::Literal) {
            let message = "only top-down, preset published, engine literal adds its costs in f32";
            return Err(BuildError::Parameter(message.into()));
        }
        if !self.presets.is_empty() {
            self.check_leaves(options)?;
        }
        if options.max_leaf.is_some_and(|n| !(1..=MOST_IN_LEAF).contains(&n)) {
            let message = format!("a leaf holds 1 to {MOST_IN_LEAF} triangles");
            return Err(BuildError::Parameter(message));
        }
        Ok(())
    }

    /// The thesis' builders end in leaves of their own: the one step that they take is to make them anew, in binary trees.
    fn check_leaves(&self, options: &BuildOptions) -> Result<(), BuildError> {
        let refuse = |why| Err(BuildError::Parameter(format!("{} {why}", self.id)));
        if options.refine.iter().any(|info| info.step != Step::Leaves) {
            return refuse("takes no step but +leaves");
        }
        if !options.refine.is_empty() && options.arity != 2 {
            return refuse("takes +leaves at arity 2 alone");
        }
        if options.max_leaf.is_some() && !self.limits_leaves(&options.refine) {
            return refuse("has no use for --max-leaf without +leaves");
        }
        Ok(())
    }

    /// Whether its leaves, after these steps, follow [`BuildOptions::max_leaf`]: the thesis' own do not.
    pub fn limits_leaves(&self, refine: &Refinements) -> bool {
        self.parameters.contains(&Parameter::MaxLeaf) && (self.presets.is_empty() || !refine.is_empty())
    }

    /// How many threads a build with `options` shares its work between.
    pub fn threads(&self, options: &BuildOptions) -> usize {
        if (self.parallel)(options) { rayon::current_num_threads() } else { 1 }
    }

    /// The boxes of `triangles`, which a build with `options` begins with, by as many threads as that has.
    pub fn boxes(&self, triangles: &[Triangle], options: &BuildOptions) -> Vec<Aabb> {
        if (self.parallel)(options) {
            triangles.par_iter().with_min_len(1 << 13).map(Triangle::aabb).collect()
        } else {
            triangles.iter().map(Triangle::aabb).collect()
        }
    }

    /// What its trees are held to.
    pub fn limits(&self, options: &BuildOptions) -> Limits {
        let q8 = self.parameters.contains(&Parameter::Q8)
            && (options.preset, options.arity, options.q8) == (Preset::Published, 8, true);
        Limits { max_leaf: options.max_leaf.unwrap_or(MAX_LEAF), q8, spatial: self.spatial }
    }

    /// The reading that `options` ask for, where it has readings.
    pub fn preset(&self, options: &BuildOptions) -> Option<Preset> {
        (!self.presets.is_empty()).then_some(options.preset)
    }

    /// The engine that `options` ask for, where it has engines.
    pub fn engine(&self, options: &BuildOptions) -> Option<Engine> {
        (!self.engines.is_empty()).then_some(options.engine)
    }

    /// Every reading and engine that it has at each of its arities, all else as in `options`.
    pub fn variants(&self, options: BuildOptions) -> Vec<BuildOptions> {
        let presets = if self.presets.is_empty() { &[Preset::Published][..] } else { self.presets };
        let engines = if self.engines.is_empty() { &[Engine::Exact][..] } else { self.engines };
        let mut all = Vec::new();
        for &preset in presets {
            for &engine in engines {
                all.extend(self.arities.iter().map(|&arity| BuildOptions { preset, engine, arity, ..options }));
            }
        }
        all
    }
}
