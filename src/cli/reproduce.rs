//! `bvh-lab reproduce` and `bvh-lab report`: the study, and what it leaves.

use super::arguments::{Item, ReportArguments, ReproduceArguments};
use super::output::say;
use super::progress::Progress;
use super::{Failure, Outcome, wrong};
use bvh_lab::lab::{DEFAULT_BUDGET, SCENES, Scope, Study, StudyError, figure3};
use bvh_lab::report;
use bvh_lab::rows::{Construction, Lighting};

/// Runs `reproduce`.
pub fn run(a: &ReproduceArguments) -> Outcome {
    keep_rows_when_interrupted(&a.out)?;
    let rows = a.out.join("rows");
    let scenes = if a.scenes.is_empty() { SCENES.map(str::to_owned).to_vec() } else { a.scenes.clone() };
    let study = Study {
        rows: rows.clone(),
        budget: if a.full { None } else { Some(a.budget.unwrap_or(DEFAULT_BUDGET)) },
        scenes,
        presets: a.preset.iter().map(|&p| p.into()).collect(),
        scope: scope(&a.only),
    };
    let mut progress = Progress::new();
    let done = study.run(&mut progress);
    progress.end();
    done.map_err(|e| match e {
        StudyError::Scene(e) => Failure::from(e),
        other => wrong(other),
    })?;
    if a.only.is_empty() || a.only.contains(&Item::Figure(3)) {
        figure3(&rows).map_err(wrong)?;
    }
    finish(&rows, &a.out)
}

/// Runs `report`.
pub fn report(a: &ReportArguments) -> Outcome {
    finish(&a.rows, &a.out)
}

/// Rows are on disk as they finish, so an interruption loses one cell; it ends with a line that says so.
pub(super) fn keep_rows_when_interrupted(out: &std::path::Path) -> Outcome {
    let out = out.to_owned();
    let interrupted = move || {
        eprintln!("\nbvh-lab: interrupted; finished rows are in {}, the same command goes on from them", out.display());
        std::process::exit(130);
    };
    ctrlc::set_handler(interrupted).map_err(wrong)
}

/// Draws the report and names its pages.
pub(super) fn finish(rows: &std::path::Path, out: &std::path::Path) -> Outcome {
    let summary = report::write(rows, out).map_err(wrong)?;
    let pages = summary.files.iter().filter(|f| f.extension().is_some_and(|e| e == "html"));
    let pages: String = pages.map(|page| format!("\n{}", page.display())).collect();
    say(&format!("{summary}{pages}"))?;
    match summary.error_rows {
        0 => Ok(()),
        n => Err(wrong(format!(
            "{n} cells failed their verification: see status and note of the rows in {}",
            rows.display()
        ))),
    }
}

/// The cells that the wanted tables and figures need; all of them if none is named.
fn scope(only: &[Item]) -> Scope {
    if only.is_empty() {
        return Scope::all();
    }
    let mut scope = Scope::default();
    let pictures = |lighting| Scope { builds: Scope::every_build(), lightings: vec![lighting], ..Scope::default() };
    for item in only {
        let every_build = Scope::every_build();
        scope.extend(match *item {
            // The sizes stand in every build row, and a picture wants some row beside it; the cheapest build will do.
            Item::Table(1) | Item::Figure(3) => Scope { builds: vec![(Construction::TopDown, 2)], ..Scope::default() },
            Item::Table(3) => {
                let collapsed = every_build.into_iter().filter(|&(c, k)| c == Construction::BottomUp && k > 2);
                Scope { builds: collapsed.collect(), ..Scope::default() }
            }
            // The thesis' times are those of the literal work; all else follows from the trees.
            Item::Table(2) | Item::Figure(4) => Scope { builds: every_build, literal: true, ..Scope::default() },
            Item::Table(4 | 5) | Item::Figure(_) => pictures(Lighting::Primary),
            Item::Table(6 | 7) => pictures(Lighting::Reflection),
            Item::Table(_) => pictures(Lighting::Opacity),
            Item::Experiments(ref wanted) => Scope { experiments: wanted.clone(), ..Scope::default() },
            Item::Decisions => Scope { decisions: true, ..Scope::default() },
        });
    }
    scope
}
