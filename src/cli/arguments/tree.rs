//! Words that say which tree: a builder with its options, or a file.

use super::words::{CostsWord, EngineWord, PresetWord, Recipe, Switch, arity, collapse, recipe};
use bvh_lab::build::top_down::Costs;
use bvh_lab::build::{self, BuildOptions, Engine, Preset};
use bvh_lab::refine::Collapse;
use clap::Args;
use std::path::PathBuf;

/// The tree of a command.
#[derive(Debug, Args)]
pub struct TreeArguments {
    /// Builder, and what refines its tree: BUILDER[+STEP…], as in sbvh+leaves; `bvh-lab list builders` and
    /// `list refinements` show them
    #[arg(short, long, value_name = "BUILDER", default_value = "top-down", value_parser = recipe)]
    pub builder: Recipe,
    /// Children per inner node: 2, 4 or 8; modern builders also 16
    #[arg(short = 'k', long = "arity", value_name = "K", default_value = "2", value_parser = arity)]
    pub arity: usize,
    #[command(flatten)]
    pub reading: ReadingArguments,
    /// Instead of a builder: a tree from a file, as `build SCENE -o TREE.bvh` or any other program wrote it
    #[arg(long = "tree", value_name = "TREE.bvh", conflicts_with_all = ["builder", "arity", "ReadingArguments"])]
    pub file: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct ReadingArguments {
    /// Reading of the thesis [default: the builder's first]
    #[arg(long)]
    pub preset: Option<PresetWord>,
    /// How the thesis' builders work, the tree being the same [default: exact]
    #[arg(long)]
    pub engine: Option<EngineWord>,
    /// Rule Q8 of top-down `published` at arity 8; off: one child per triangle instead
    #[arg(long, default_value = "on")]
    pub q8: Switch,
    /// Numbers in which top-down `published`, engine literal, adds its costs: exact, or the original's f32
    #[arg(long, default_value = "exact")]
    pub costs: CostsWord,
    /// Candidates per axis of a top-down search [default: 200 / arity]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub candidates: Option<u32>,
    /// Modern builders: the most triangles in a leaf [default: 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub max_leaf: Option<u32>,
    /// Bins per axis of a binned search [default: the builder's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub bins: Option<u32>,
    /// Neighbours looked at on either side, or candidates kept for each cluster [default: the builder's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=128))]
    pub radius: Option<u32>,
    /// Triangles of a cluster that the search for splits takes as a whole [default: the builder's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub cluster: Option<u32>,
    /// References that spatial splits may add, in percent of the triangles [default: the builder's]
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub split_budget: Option<u32>,
    /// How a modern builder's binary tree gets more children per node: thesis, greedy or optimal [default: optimal]
    #[arg(long, value_name = "WAY", value_parser = collapse)]
    pub collapse: Option<Collapse>,
}

impl TreeArguments {
    /// Options of the builder asked for.
    pub fn options(&self) -> Result<BuildOptions, build::BuildError> {
        self.reading.options(&self.builder, self.arity, None)
    }
}

impl ReadingArguments {
    /// Options of `recipe` at `arity`; `preset` overrides the one asked for. An error where a word is not for this builder.
    pub fn options(
        &self,
        recipe: &Recipe,
        arity: usize,
        preset: Option<Preset>,
    ) -> Result<BuildOptions, build::BuildError> {
        let Recipe { builder, refine } = *recipe;
        let wide = |n: Option<u32>| n.map(|n| n as usize);
        let options = BuildOptions {
            arity,
            preset: preset
                .or(self.preset.map(Into::into))
                .or(builder.presets.first().copied())
                .unwrap_or(Preset::Published),
            engine: self.engine.map(Into::into).or(builder.engines.first().copied()).unwrap_or(Engine::Exact),
            candidates: wide(self.candidates),
            q8: self.q8 == Switch::On,
            costs: match self.costs {
                CostsWord::Exact => Costs::Exact,
                CostsWord::F32 => Costs::Single,
            },
            max_leaf: wide(self.max_leaf),
            bins: wide(self.bins),
            radius: wide(self.radius),
            cluster: wide(self.cluster),
            split_budget: wide(self.split_budget),
            refine,
            collapse: self.collapse,
        };
        let only_of_the_thesis = |what| Err(build::BuildError::Parameter(format!("{} has no {what}", builder.id)));
        if self.preset.is_some() && builder.presets.is_empty() {
            return only_of_the_thesis("presets");
        }
        if self.engine.is_some() && builder.engines.is_empty() {
            return only_of_the_thesis("engines");
        }
        builder.check(&options)?;
        Ok(options)
    }
}
