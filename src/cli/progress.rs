//! Progress: a bar with an estimate on a terminal, plain lines elsewhere.

use bvh_lab::lab::{Watch, human_seconds};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Shows how far the study is.
#[derive(Debug)]
pub struct Progress {
    begin: Instant,
    bar: Option<ProgressBar>,
}

/// The bar counts shares in so many parts.
const PARTS: u64 = 10_000;

impl Progress {
    /// A bar if standard error is a terminal.
    pub fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:30} {percent:>3}% {elapsed} {msg}");
            let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_millis(250));
            bar
        });
        Self { begin: Instant::now(), bar }
    }

    /// Takes the bar away.
    pub fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn left(&self, share: f64) -> String {
        // Too early, the estimate would be noise.
        if share < 0.01 {
            return String::new();
        }
        let left = self.begin.elapsed().as_secs_f64() * (1.0 - share) / share;
        format!("; about {} left", human_seconds(left.max(1.0)))
    }
}

/// Shows how far a large file has been read.
#[derive(Debug)]
pub struct Reading {
    name: String,
    begin: Instant,
    bar: Option<ProgressBar>,
    /// Tenths that have been told.
    tenths: u64,
}

/// Bytes from which a file is worth a word.
const LARGE: u64 = 64 << 20;

impl Reading {
    /// Nothing is shown before a large file is met.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), begin: Instant::now(), bar: None, tenths: 0 }
    }

    /// `done` of `size` bytes have been read.
    pub fn tell(&mut self, done: u64, size: u64) {
        if size < LARGE {
            return;
        }
        if std::io::stderr().is_terminal() {
            let bar = self.bar.get_or_insert_with(|| {
                let style =
                    ProgressStyle::with_template("{bar:30} {percent:>3}% {bytes}/{total_bytes}, {eta} left {msg}");
                let bar = ProgressBar::with_draw_target(Some(size), ProgressDrawTarget::stderr());
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                bar.set_message(self.name.clone());
                bar
            });
            bar.set_position(done);
            return;
        }
        let tenths = done * 10 / size;
        if tenths > self.tenths && tenths < 10 {
            self.tenths = tenths;
            let left = self.begin.elapsed().as_secs_f64() * (size - done) as f64 / done as f64;
            let left = human_seconds(left.max(1.0));
            eprintln!("bvh-lab: {}: {}0% read; about {left} left", self.name, tenths);
        }
    }

    /// Takes the bar away.
    pub fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Watch for Progress {
    fn begin(&mut self, cell: &str, share: f64) {
        let left = self.left(share);
        match &self.bar {
            Some(bar) => {
                bar.set_position((share * PARTS as f64) as u64);
                bar.set_message(format!("{cell}{left}"));
            }
            None => eprintln!("bvh-lab: {:3.0}% {cell}{left}", share * 100.0),
        }
    }

    fn say(&mut self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None => eprintln!("bvh-lab: {line}"),
        }
    }
}
