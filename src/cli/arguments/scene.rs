//! Words of the commands about one scene, and how a measurement runs.

use super::tree::TreeArguments;
use super::words::{RayWord, Recipe, Switch, kernel, recipe, seconds, size};
use bvh_lab::trace::{FirstLeafOptions, Kernel};
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

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
    /// Write the tree for other programs: nodes as .json, or boxes level by level as .obj
    #[arg(long, value_name = "FILE.json|FILE.obj")]
    pub export: Option<PathBuf>,
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
    /// Rays from a file instead: little-endian f32, eight a ray (origin, t_min, direction, t_max); with --rays any, whether they hit
    #[arg(long, value_name = "FILE.rays", conflicts_with = "size")]
    pub rays_file: Option<PathBuf>,
    /// Write one record a ray: little-endian u32 triangle id or 0xFFFFFFFF, f32 t in lengths of the direction, infinity for none;
    /// --rays any: 0 and 0 where anything is hit
    #[arg(long, value_name = "FILE")]
    pub hits_out: Option<PathBuf>,
    /// Pixels of the camera's rays
    #[arg(long, value_name = "WxH", default_value = "512x512", value_parser = size)]
    pub size: (u32, u32),
    #[command(flatten)]
    pub run: RunArguments,
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
