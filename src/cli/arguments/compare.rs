//! Words of `compare`.

use super::scene::RunArguments;
use super::words::{EngineWord, PresetWord, Recipe, arity, recipe, seconds, size};
use clap::Args;
use std::time::Duration;

#[derive(Debug, Args)]
pub struct CompareArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file
    pub scene: String,
    /// Builders [default: all]
    #[arg(short, long, value_name = "BUILDER", value_delimiter = ',', value_parser = recipe)]
    pub builders: Vec<Recipe>,
    /// Children per inner node; several compare
    #[arg(short = 'k', long = "arity", value_name = "K", value_delimiter = ',', default_value = "2", value_parser = arity)]
    pub arities: Vec<usize>,
    /// Readings of the thesis [default: each that a builder has]
    #[arg(long, value_delimiter = ',')]
    pub preset: Vec<PresetWord>,
    /// How the work is done; the trees are the same
    #[arg(long, default_value = "exact")]
    pub engine: EngineWord,
    /// Seconds that one build may take
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Duration,
    /// Pixels of the camera's rays
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    pub size: (u32, u32),
    #[command(flatten)]
    pub run: RunArguments,
}
