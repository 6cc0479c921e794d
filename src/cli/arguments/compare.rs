//! Words of `compare`.

use super::scene::RunArguments;
use super::words::{EngineWord, PresetWord, Recipe, arity, kernel, recipe, seconds, size};
use bvh_lab::report::gate::Bound;
use bvh_lab::trace::Kernel;
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
pub struct CompareArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file; several compare
    #[arg(value_name = "SCENE", required = true)]
    pub scenes: Vec<String>,
    /// BUILDER[+STEP…], as in binned-sah,sbvh,ploc+reinsertion [default: every builder, and some with steps]
    #[arg(short, long, value_name = "BUILDER", value_delimiter = ',', value_parser = recipe)]
    pub builders: Vec<Recipe>,
    /// A tree from a file besides, as `build SCENE -o TREE.bvh` or any other program wrote it
    #[arg(long = "tree", value_name = "TREE.bvh")]
    pub trees: Vec<PathBuf>,
    /// Children per inner node: 2, 4, 8 or 16, or several with commas between
    #[arg(short = 'k', long = "arity", value_name = "K", value_delimiter = ',', default_value = "2", value_parser = arity)]
    pub arities: Vec<usize>,
    /// Readings of the thesis [default: each that a builder has]
    #[arg(long, value_delimiter = ',')]
    pub preset: Vec<PresetWord>,
    /// How the work of the thesis' builders is done; the trees are the same
    #[arg(long, default_value = "exact")]
    pub engine: EngineWord,
    /// The most triangles in a leaf; the thesis' builders follow it only with +leaves [default: 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub max_leaf: Option<u32>,
    /// Seconds that one build may take
    #[arg(long, value_name = "SECONDS", default_value = "20", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Duration,
    /// Tracing kernel whose answers do not depend on the tree; `bvh-lab list kernels` shows them
    #[arg(long, value_name = "KERNEL", default_value = "scalar", value_parser = kernel)]
    pub kernel: (String, Kernel),
    /// Pixels of the camera's rays
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    pub size: (u32, u32),
    /// Folder for rows and the page; what its rows have already is not measured again
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Rows of an earlier comparison (DIR/rows/compare.csv) to hold this one against
    #[arg(long, value_name = "ROWS.csv", requires = "fail_if")]
    pub baseline: Option<PathBuf>,
    /// Exit with status 1 where a figure passes a bound: METRIC>P% is more than P percent above the baseline, METRIC<P% more than P
    /// percent below, `work>P%` any kind of counted work, `tree` another tree; as in 'sah>1%,build_ms>20%,diffuse_mrays<10%'.
    /// Metrics: build_ms, peak_bytes, sah, epo, lcv, inner, leaves, max_depth, bytes; primary_ and diffuse_ nodes, box_tests, tri_tests, mrays
    #[arg(long, value_name = "BOUND", value_delimiter = ',', requires = "baseline")]
    pub fail_if: Vec<Bound>,
    /// A row of the baseline that is not compared now is no failure
    #[arg(long, requires = "baseline")]
    pub allow_missing: bool,
    #[command(flatten)]
    pub run: RunArguments,
}
