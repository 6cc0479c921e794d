//! The words that the command line understands.

use bvh_lab::build::top_down::Costs;
use bvh_lab::build::{self, BuildOptions, Builder, Engine, Preset};
use bvh_lab::refine::{Collapse, Refinements};
use bvh_lab::scene::CameraSpec;
use bvh_lab::trace::{FirstLeafOptions, Kernel};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

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
    /// Redraw every table, figure and the page from rows alone
    Report(ReportArguments),
    /// What there is: scenes, builders, kernels, experiments
    List(ListArguments),
    /// What a scene holds
    Scene(SceneArguments),
}

#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// No budget: literal builds run to their end, however long
    #[arg(long, conflicts_with = "budget")]
    pub full: bool,
    /// Seconds that one build may take (a cell builds twice or more: timed and counted); beyond that it is capped, and
    /// the time of a literal build projected [default: 20]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Option<Duration>,
    /// Only what these need, such as table2,table5,figure4,decisions
    #[arg(long, value_name = "TABLE|FIGURE", value_delimiter = ',', value_parser = item)]
    pub only: Vec<Item>,
    /// Scenes, in rising size [default: the thesis' five]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Readings of the thesis
    #[arg(long, value_delimiter = ',', default_values = ["published", "text"])]
    pub preset: Vec<PresetWord>,
    /// Folder for rows, tables, figures and the page
    #[arg(long, value_name = "DIR", default_value = "plots/latest")]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
pub struct ScalingArguments {
    /// Seconds that one build may take (a cell builds twice or more: timed and counted); beyond that it is capped
    /// [default: 3 for literal engines, 20 for exact ones]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Option<Duration>,
    /// Triangles [default: 1,000 to 1,000,000 in half decades]
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub sizes: Vec<u32>,
    /// Family of the generated scenes; `bvh-lab list scenes` shows them
    #[arg(long, value_name = "FAMILY", default_value = "spheres")]
    pub family: String,
    /// Readings of the thesis
    #[arg(long, value_delimiter = ',', default_values = ["published", "text", "walter"])]
    pub preset: Vec<PresetWord>,
    /// Scenes for which the work of the thesis' program is put down, in rising size [default: the thesis' five]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Threads for builders that share their work between threads
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Folder for rows, tables, figures and the page
    #[arg(long, value_name = "DIR", default_value = "plots/latest")]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Folder of the row files
    #[arg(long, value_name = "DIR", default_value = "plots/latest/rows")]
    pub rows: PathBuf,
    /// Folder for tables, figures and the page
    #[arg(long, value_name = "DIR", default_value = "plots/latest")]
    pub out: PathBuf,
}

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
    /// References that spatial splits may add, in percent of the triangles [default: the builder's]
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub split_budget: Option<u32>,
    /// How a modern builder's binary tree gets more children per node [default: optimal]
    #[arg(long, value_name = "WAY", value_parser = collapse)]
    pub collapse: Option<Collapse>,
}

/// A builder and the steps that refine its tree.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    pub builder: &'static Builder,
    pub refine: Refinements,
}

#[derive(Debug, Args)]
pub struct BuildArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file
    pub scene: String,
    #[command(flatten)]
    pub tree: TreeArguments,
    /// Seconds that the build may take; beyond that it is capped and projected [default: no limit]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true, conflicts_with = "file")]
    pub budget: Option<Duration>,
    /// Every timed run in a fresh process, into fresh memory
    #[arg(long, conflicts_with = "file")]
    pub cold: bool,
    /// Write the tree
    #[arg(short, long, value_name = "TREE.bvh")]
    pub output: Option<PathBuf>,
    /// With --tree: give the tree new boxes, its scene having as many triangles whose vertices have moved
    #[arg(long, requires = "file", conflicts_with_all = ["builder", "arity", "ReadingArguments"])]
    pub refit: bool,
    /// With --refit: compare with a fresh tree by this builder
    #[arg(long, value_name = "BUILDER", value_parser = recipe, requires = "refit", conflicts_with = "builder")]
    pub against: Option<Recipe>,
    /// Measure the leaf count variability, too: over the rays of `trace --rays diffuse`
    #[arg(long)]
    pub lcv: bool,
    #[command(flatten)]
    pub run: RunArguments,
}

/// How a measurement runs and how it is shown.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Threads [default: all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Timed runs, besides one to verify, one to warm up and one to count [default: up to 5, about a second]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u16).range(1..=10_000))]
    pub runs: Option<u16>,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct TraceArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file
    pub scene: String,
    #[command(flatten)]
    pub tree: TreeArguments,
    /// Tracing kernel; `bvh-lab list kernels` shows them
    #[arg(long, value_name = "KERNEL", default_value = "scalar", value_parser = kernel)]
    pub kernel: (String, Kernel),
    /// Kernel first-leaf: find the triangle of every test by a scan over all triangles, as the thesis' program did
    #[arg(long)]
    pub linear_lookup: bool,
    /// Kernel first-leaf: the program's slip with tied entries [default: on]
    #[arg(long, value_name = "SWITCH")]
    pub tie_slip: Option<Switch>,
    /// Kind of rays
    #[arg(long, default_value = "primary")]
    pub rays: RayWord,
    /// Rays from a file instead: little-endian f32, eight a ray (origin, t_min, direction, t_max)
    #[arg(long, value_name = "FILE.rays", conflicts_with = "size")]
    pub rays_file: Option<PathBuf>,
    /// Write one record a ray: u32 triangle id or 0xFFFFFFFF, f32 t
    #[arg(long, value_name = "FILE")]
    pub hits_out: Option<PathBuf>,
    /// Pixels of the camera's rays
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    pub size: (u32, u32),
    #[command(flatten)]
    pub run: RunArguments,
}

#[derive(Debug, Args)]
pub struct RenderArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file
    pub scene: String,
    #[command(flatten)]
    pub tree: TreeArguments,
    /// The picture [default: the scene's name with .png]
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = size)]
    pub size: (u32, u32),
    /// Camera, such as eye=1,2,3,look=0,0,0,up=0,1,0,fov=45; what is not given is the scene's
    #[arg(long, value_name = "SPEC")]
    pub camera: Option<CameraSpec>,
    /// Rays along each side of a pixel: 2 means 4 rays a pixel
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub samples: u32,
    /// Work per pixel instead of the picture
    #[arg(long)]
    pub heatmap: Option<HeatWord>,
}

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

#[derive(Debug, Args)]
pub struct ListArguments {
    /// What to list
    pub what: ListWord,
    /// One JSON array on standard output
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct SceneArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file
    pub scene: String,
    /// One JSON object on standard output
    #[arg(long)]
    pub json: bool,
    /// Write the triangles as an OBJ file
    #[arg(long, value_name = "FILE.obj")]
    pub export: Option<PathBuf>,
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EngineWord {
    /// Near-linear work, provably the same tree
    Exact,
    /// Every combination, every pair
    Literal,
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
    /// Shadow rays: is anything in between?
    Any,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HeatWord {
    /// Nodes entered
    Nodes,
    /// Triangles tested
    Tests,
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    Table(u8),
    Figure(u8),
    /// The table of decisions by f32 costs.
    Decisions,
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

impl From<EngineWord> for Engine {
    fn from(word: EngineWord) -> Self {
        match word {
            EngineWord::Exact => Self::Exact,
            EngineWord::Literal => Self::Literal,
        }
    }
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

impl TraceArguments {
    /// The kernel with its switches; an error where they are not its own.
    pub fn kernel(&self) -> Result<Kernel, String> {
        match self.kernel.1 {
            Kernel::FirstLeaf(_) => Ok(Kernel::FirstLeaf(FirstLeafOptions {
                tie_slip: self.tie_slip != Some(Switch::Off),
                linear_lookup: self.linear_lookup,
            })),
            _ if self.linear_lookup || self.tie_slip.is_some() => {
                Err("--linear-lookup and --tie-slip are switches of --kernel first-leaf".into())
            }
            kernel => Ok(kernel),
        }
    }
}

impl TreeArguments {
    /// Options of the builder asked for.
    pub fn options(&self) -> Result<BuildOptions, build::BuildError> {
        self.reading.options(&self.builder, self.arity, None)
    }
}

fn seconds(word: &str) -> Result<Duration, String> {
    let number: f64 = word.parse().map_err(|_| "a number of seconds is wanted".to_owned())?;
    match Duration::try_from_secs_f64(number) {
        Ok(limit) if !limit.is_zero() => Ok(limit),
        _ => Err("a number of seconds above 0 is wanted; leave it out for the default".into()),
    }
}

fn item(word: &str) -> Result<Item, String> {
    let numbered = |prefix: &str| word.to_ascii_lowercase().strip_prefix(prefix).and_then(|n| n.parse::<u8>().ok());
    match (numbered("table"), numbered("figure")) {
        (Some(n @ 1..=9), _) => Ok(Item::Table(n)),
        (_, Some(n @ 3..=5)) => Ok(Item::Figure(n)),
        _ if word.eq_ignore_ascii_case("decisions") => Ok(Item::Decisions),
        _ => Err("table1 … table9, figure3 … figure5 or decisions are wanted".into()),
    }
}

fn arity(word: &str) -> Result<usize, String> {
    match word {
        "2" => Ok(2),
        "4" => Ok(4),
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("2, 4, 8 or 16 are wanted".into()),
    }
}

fn size(word: &str) -> Result<(u32, u32), String> {
    const LARGEST: u32 = 1 << 14;
    let parsed = word.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match parsed {
        Some((w @ 1..=LARGEST, h @ 1..=LARGEST)) => Ok((w, h)),
        _ => Err(format!("WIDTHxHEIGHT in pixels is wanted, each 1 to {LARGEST}")),
    }
}

fn recipe(word: &str) -> Result<Recipe, String> {
    let (id, steps) = word.split_once('+').unwrap_or((word, ""));
    let builder = build::find(id).ok_or_else(|| {
        let ids: Vec<_> = build::BUILDERS.iter().map(|b| b.id).collect();
        format!("there is no such builder; there are {}", ids.join(", "))
    })?;
    Ok(Recipe { builder, refine: steps.parse()? })
}

fn collapse(word: &str) -> Result<Collapse, String> {
    let ids = Collapse::ALL.map(Collapse::id);
    Collapse::ALL.into_iter().find(|c| c.id() == word).ok_or_else(|| format!("{} are wanted", ids.join(" or ")))
}

fn kernel(word: &str) -> Result<(String, Kernel), String> {
    match Kernel::from_id(word) {
        Some(kernel) => Ok((word.to_owned(), kernel)),
        None => {
            let ids: Vec<_> = bvh_lab::trace::KERNELS.iter().map(|k| k.id).collect();
            Err(format!("there is no such kernel; there are {}", ids.join(", ")))
        }
    }
}
