//! Words of `accuracy`.

use super::words::{seconds, size};
use bvh_lab::lab::Part;
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug, Args)]
pub struct AccuracyArguments {
    /// thesis:LEVEL, gen:FAMILY:TRIANGLES[:SEED], or a file [default: thesis:large and two generated scenes]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<String>,
    /// Only these, with commas between: planes, bins, clustering, decisions, intersection, storage
    #[arg(long, value_name = "PART", value_delimiter = ',', value_parser = part)]
    pub only: Vec<Part>,
    /// Seconds that one build may take; a setting beyond that is capped [default: 5]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub budget: Option<Duration>,
    /// Timed runs of every setting, in turns with all others of its part
    #[arg(long, value_name = "R", default_value = "5", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub runs: u16,
    /// Threads
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Pixels of the camera's rays, from which the others start
    #[arg(long, value_name = "WxH", default_value = "256x256", value_parser = size)]
    pub size: (u32, u32),
    /// Folder for rows, tables, figures and the page
    #[arg(long, value_name = "DIR", default_value = "plots/latest")]
    pub out: PathBuf,
}

fn part(word: &str) -> Result<Part, String> {
    let known = Part::ALL.into_iter().find(|p| p.id() == word);
    known.ok_or_else(|| format!("one of {} is wanted", Part::ALL.map(Part::id).join(", ")))
}
