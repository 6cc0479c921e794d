//! Tables, figures and a page: reads rows, imports nothing else of this crate.
//!
//! [`write()`] turns the rows of a study (`rows/builds.csv`, `rows/traces.csv`, `rows/decisions.csv`, `rows/experiments.csv`, pictures) into `tables/`, `figures/` and
//! `index.html`, those of a comparison (`rows/compare.csv`) into `compare.html`, and those about accuracy (`rows/accuracy.csv`) into `accuracy.html`. The same rows give the same bytes. [`printed`] holds the thesis' own numbers.

mod accuracy;
mod cells;
mod claims;
mod comparison;
mod decisions;
mod experiments;
mod figures;
mod files;
mod fit;
pub mod gate;
mod growth;
mod number;
mod page;
mod paper;
pub mod printed;
mod summary;
mod tables;

pub use summary::{CLOSE, Counts, Summary, Within};

use crate::rows::{
    AccuracyRow, BuildRow, CompareRow, DecisionRow, ExperimentRow, Row, RowError, ScalingRow, TraceRow, WorkRow, read,
};
use accuracy::Accuracy;
use cells::Study;
use claims::Evidence;
use comparison::{Comparison, advice};
use files::Folder;
use growth::{Growth, exponents, laws};
use std::path::{Path, PathBuf};

/// The page of builders side by side.
pub const COMPARISON_PAGE: &str = "compare.html";

/// The page of the study.
pub const STUDY_PAGE: &str = "index.html";

/// The presets that are reported: what the thesis' program did, and what its words say. The first is the headline.
const PRESETS: [&str; 2] = ["published", "text"];

/// What can keep a report from being written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The rows cannot be read or do not belong together.
    #[error(transparent)]
    Rows(#[from] RowError),
    /// There is nothing to report.
    #[error("no rows in {}; measure first, or name the folder that holds builds.csv", .0.display())]
    NoRows(PathBuf),
    /// Two row files come from different programs.
    #[error("{path}: {first}; {second}; measure again into another --out", path = path.display())]
    Mixed {
        /// The rows folder.
        path: PathBuf,
        /// A file, and the version and commit of its rows.
        first: String,
        /// Another, of others.
        second: String,
    },
    /// The file system refused.
    #[error("cannot {what} {path}: {source}", path = path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The picture of Figure 3 cannot be used.
    #[error("{path}: not a readable PNG ({reason}); render it again", path = path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A figure could not be drawn.
    #[error("cannot draw {figure}: {reason}")]
    Draw {
        /// The figure's file name without its ending.
        figure: String,
        /// What went wrong.
        reason: String,
    },
}

impl ReportError {
    fn io(what: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self::Io { what, path: path.into(), source }
    }
}

/// Draws every table, figure and page of the rows in `rows_dir` into `out_dir` (made if absent).
///
/// # Errors
/// No rows; rows that are malformed, double, or of more than one program; an unreadable picture; the file system's.
/// Files already written stay, each of them whole.
pub fn write(rows_dir: &Path, out_dir: &Path) -> Result<Summary, ReportError> {
    let study = Study {
        builds: read::<BuildRow>(rows_dir)?,
        traces: read::<TraceRow>(rows_dir)?,
        decisions: read::<DecisionRow>(rows_dir)?,
        experiments: read::<ExperimentRow>(rows_dir)?,
    };
    let growth = Growth::read(rows_dir, &study.builds)?;
    let (accuracy, comparison) = (Accuracy::read(rows_dir)?, Comparison::read(rows_dir)?);
    check_origin(rows_dir, &study, &growth, &accuracy, &comparison)?;
    let mut summary = Summary::of(&study);
    summary.error_rows += growth.errors() + accuracy.errors() + comparison.errors();
    summary.study_rows = study.builds.len()
        + study.traces.len()
        + study.decisions.len()
        + study.experiments.len()
        + growth.scaling.len()
        + growth.work.len();
    (summary.accuracy_rows, summary.comparison_rows) = (accuracy.rows.len(), comparison.rows.len());
    let mut folder = Folder::new(out_dir);
    accuracy.write(&mut folder)?;
    comparison.write(&mut folder, summary.study_rows > 0)?;
    if summary.study_rows > 0 {
        write_study(&study, &growth, &summary, rows_dir, &mut folder)?;
    }
    Ok(Summary { files: folder.into_written(), ..summary })
}

/// Which builder for which use, computed from the rows of a comparison: one line a use, none where there is nothing to choose.
pub fn advice(rows: &[CompareRow]) -> Vec<String> {
    let counsel = advice::counsel(&Comparison::of(rows.to_vec()));
    counsel.uses.iter().map(|advice| format!("{}: {}: {}", advice.purpose, advice.pick, advice.why)).collect()
}

/// The study of the thesis: its tables, figures and page.
fn write_study(
    study: &Study,
    growth: &Growth,
    summary: &Summary,
    rows_dir: &Path,
    folder: &mut Folder,
) -> Result<(), ReportError> {
    for preset in PRESETS {
        let dir = if preset == PRESETS[0] { "tables" } else { "tables/text" };
        for number in 1..=9 {
            let text = tables::csv_text(&study.table(preset, number));
            folder.write(&format!("{dir}/table{number}.csv"), text.as_bytes())?;
        }
        let engines = tables::engines_csv(&study.table(preset, 2), &study.exact_times(preset));
        folder.write(&format!("{dir}/table2-exact.csv"), engines.as_bytes())?;
    }

    match &study.decisions[..] {
        [] => folder.remove("tables/decisions.csv")?,
        rows => folder.write("tables/decisions.csv", decisions::csv_text(rows).as_bytes())?,
    }

    let (laws, exponents) = (laws::laws(growth), exponents::exponents(growth));
    let residuals = laws::residuals(growth, &laws);
    let growth_tables = [
        ("tables/scaling.csv", exponents::csv_text(&exponents)),
        ("tables/why.csv", laws::laws_csv(&laws)),
        ("tables/why-cells.csv", laws::residuals_csv(&residuals)),
    ];
    for (name, text) in growth_tables {
        match growth.is_empty() {
            true => folder.remove(name)?,
            false => folder.write(name, text.as_bytes())?,
        }
    }

    let mut figures = figures::draw_all(study, rows_dir)?;
    let shown = if growth.is_empty() { &[][..] } else { &residuals };
    figures.extend(study, growth, shown)?;
    figures.write(folder)?;
    let fits = page::growth::Fits { growth, laws: &laws, residuals: &residuals, exponents: &exponents };
    let evidence = Evidence { study, growth };
    let verdicts = page::Verdicts { judged: claims::judge(&evidence), suspects: claims::suspects(&evidence) };
    folder.write("claims.csv", claims::csv_text(&verdicts.judged).as_bytes())?;
    folder.write("claims.json", claims::json_text(&verdicts.judged).as_bytes())?;
    let others = [
        (summary.study_rows, paper::PAPER, "the replication as a paper"),
        (summary.accuracy_rows, accuracy::PAGE, "what accuracy costs in time"),
        (summary.comparison_rows, COMPARISON_PAGE, "builders side by side"),
    ];
    let text = paper::html(study, summary, &verdicts.judged, &figures)?;
    folder.write(paper::PAPER, text.as_bytes())?;
    let others: Vec<_> = others.iter().filter(|o| o.0 > 0).map(|o| (o.1, o.2)).collect();
    folder.write(STUDY_PAGE, page::html(study, summary, &figures, &fits, &verdicts, &others).as_bytes())
}

fn check_origin(
    rows_dir: &Path,
    study: &Study,
    growth: &Growth,
    accuracy: &Accuracy,
    comparison: &Comparison,
) -> Result<(), ReportError> {
    let files = [
        (BuildRow::FILE, study.builds.first().map(Row::origin)),
        (TraceRow::FILE, study.traces.first().map(Row::origin)),
        (DecisionRow::FILE, study.decisions.first().map(Row::origin)),
        (ExperimentRow::FILE, study.experiments.first().map(Row::origin)),
        (ScalingRow::FILE, growth.scaling.first().map(Row::origin)),
        (WorkRow::FILE, growth.work.first().map(Row::origin)),
        (CompareRow::FILE, comparison.rows.first().map(Row::origin)),
        (AccuracyRow::FILE, accuracy.rows.first().map(Row::origin)),
    ];
    let mut origins = files.into_iter().filter_map(|(file, origin)| Some((file, origin?)));
    let Some(first) = origins.next() else {
        return Err(ReportError::NoRows(rows_dir.into()));
    };
    let name = |(file, (version, commit)): (&str, (&str, &str))| format!("{file} is of {version} ({commit})");
    match origins.find(|other| other.1 != first.1) {
        Some(other) => Err(ReportError::Mixed { path: rows_dir.into(), first: name(first), second: name(other) }),
        None => Ok(()),
    }
}
