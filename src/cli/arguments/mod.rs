//! The words that the command line understands: the commands here, their own words in a file a family.

mod accuracy;
mod compare;
mod render;
mod scene;
mod study;
mod tree;
mod words;

pub use accuracy::AccuracyArguments;
pub use compare::CompareArguments;
pub use render::RenderArguments;
pub use scene::{BuildArguments, RunArguments, SceneArguments, TraceArguments};
pub use study::{ReportArguments, ReproduceArguments, ScalingArguments};
pub use tree::TreeArguments;
pub use words::{HeatWord, Item, ListWord, RayWord, Recipe};

use clap::{Args, Parser, Subcommand};

/// How bounding volume hierarchies for ray tracing are built, what a build costs, and what the tree is worth.
#[derive(Debug, Parser)]
#[command(name = "bvh-lab", version, subcommand_required = true, arg_required_else_help = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// The whole study of the thesis: rows, tables, figures and a page
    Reproduce(ReproduceArguments),
    /// Time and work against size and arity, with fitted exponents
    Scaling(ScalingArguments),
    /// Build one tree: time, work, statistics
    Build(BuildArguments),
    /// Trace rays through one tree: rays per second, work per ray
    Trace(TraceArguments),
    /// Render a picture or a heat map
    Render(RenderArguments),
    /// Builders side by side on one scene
    Compare(CompareArguments),
    /// What accuracy costs in time: planes, bins, neighbours, rounded costs, triangle tests, bits of boxes
    Accuracy(AccuracyArguments),
    /// Redraw every table, figure and the page from rows alone
    Report(ReportArguments),
    /// What there is: scenes, builders, refinements, kernels, experiments
    List(ListArguments),
    /// What a scene holds
    Scene(SceneArguments),
}

#[derive(Debug, Args)]
pub struct ListArguments {
    /// What to list
    pub what: ListWord,
    /// One JSON array on standard output
    #[arg(long)]
    pub json: bool,
}
