//! Words of the commands that leave rows, tables and figures.

use super::words::{Item, PresetWord, item, seconds};
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// No budget: literal builds run to their end, however long
    #[arg(long, conflicts_with = "budget")]
    pub full: bool,
    /// Seconds that one build may take (a cell builds twice or more: timed and counted); beyond that it is capped, and
    /// the time of a literal build projected [default: 20]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Option<Duration>,
    /// Only what these need, such as table2,table5,figure4,decisions,conjecture; bvh-lab list experiments shows more
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
