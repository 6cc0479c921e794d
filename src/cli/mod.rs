//! The command line: words to options, results to people and programs.

mod accuracy;
mod arguments;
mod build;
mod compare;
mod list;
mod output;
mod progress;
mod render;
mod reproduce;
mod scaling;
mod scene;
mod trace;
mod tree_file;

use arguments::{Arguments, Command};
use bvh_lab::scene::SceneError;
use clap::Parser;
use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

/// Why a command failed; one line for each failure.
#[derive(Debug)]
enum Failure {
    /// The input or a result is wrong: exit status 1.
    Input(String),
    /// Several results are wrong, a line each: exit status 1.
    Several(Vec<String>),
    /// The words of the call are off: exit status 2.
    Usage(String),
}

type Outcome = Result<(), Failure>;

/// A result or an input that is wrong.
fn wrong(e: impl Display) -> Failure {
    Failure::Input(e.to_string())
}

/// Words that are off.
fn off(e: impl Display) -> Failure {
    Failure::Usage(e.to_string())
}

impl From<SceneError> for Failure {
    fn from(e: SceneError) -> Self {
        match e {
            SceneError::Unknown { .. } => off(e),
            _ => wrong(e),
        }
    }
}

/// Runs the command that the process' arguments name.
pub fn main() -> ExitCode {
    // The last line of defence: whatever escapes every check still ends in one line and the right status.
    std::panic::set_hook(Box::new(|info| {
        let what = info.payload_as_str().unwrap_or("unknown");
        let place = info.location().map(|l| format!(" ({}:{})", l.file(), l.line())).unwrap_or_default();
        eprintln!("bvh-lab: internal error: {what}{place}; please report it");
    }));
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(e) => return refused(&e),
    };
    let outcome = std::panic::catch_unwind(|| run(arguments.command));
    match outcome {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(Failure::Input(line))) => fail(&line, 1),
        Ok(Err(Failure::Several(lines))) => {
            for line in &lines {
                fail(line, 1);
            }
            ExitCode::from(1)
        }
        Ok(Err(Failure::Usage(line))) => fail(&line, 2),
        Err(_) => ExitCode::from(1),
    }
}

fn run(command: Command) -> Outcome {
    if !matches!(&command, Command::Build(a) if a.cold) {
        bvh_lab::lab::keep_freed_memory();
    }
    match command {
        Command::Reproduce(a) => reproduce::run(&a),
        Command::Scaling(a) => scaling::run(&a),
        Command::Accuracy(a) => accuracy::run(&a),
        Command::Report(a) => reproduce::report(&a),
        Command::Build(a) => build::run(&a),
        Command::Trace(a) => trace::run(&a),
        Command::Render(a) => render::run(&a),
        Command::Compare(a) => compare::run(&a),
        Command::Scene(a) => scene::run(&a),
        Command::List(a) => list::run(&a),
    }
}

fn fail(line: &str, status: u8) -> ExitCode {
    eprintln!("bvh-lab: {}", line.replace('\n', " "));
    ExitCode::from(status)
}

/// Help and version go where they belong; an error becomes one line.
fn refused(e: &clap::Error) -> ExitCode {
    use clap::error::{ContextKind, ErrorKind};
    match e.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => {
            let _ = e.print();
            ExitCode::SUCCESS
        }
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
            let _ = e.print();
            ExitCode::from(2)
        }
        _ => {
            let text = e.to_string();
            // Everything up to the usage, on one line; "error: " is said by the exit status.
            let lines =
                text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more"));
            let line = lines.filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ");
            let line = line.strip_prefix("error: ").unwrap_or(&line);
            let word = e.get(ContextKind::InvalidSubcommand).map(ToString::to_string);
            match word.filter(|word| Path::new(word).is_file()) {
                Some(file) => {
                    fail(&format!("say what to do with it, as in `bvh-lab render {file}` or `compare {file}`"), 2)
                }
                None => fail(&format!("{line}; see `bvh-lab COMMAND --help`"), 2),
            }
        }
    }
}
