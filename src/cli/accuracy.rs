//! `bvh-lab accuracy`: what accuracy costs in time.

use super::arguments::AccuracyArguments;
use super::progress::Progress;
use super::reproduce::{finish, keep_rows_when_interrupted};
use super::{Failure, Outcome, wrong};
use bvh_lab::lab::{ACCURACY_BUDGET, ACCURACY_SCENES, AccuracyStudy, Part, StudyError};

/// Runs the command.
pub fn run(a: &AccuracyArguments) -> Outcome {
    keep_rows_when_interrupted(&a.out)?;
    let rows = a.out.join("rows");
    let study = AccuracyStudy {
        rows: rows.clone(),
        scenes: if a.scenes.is_empty() { ACCURACY_SCENES.map(str::to_owned).to_vec() } else { a.scenes.clone() },
        parts: if a.only.is_empty() { Part::ALL.to_vec() } else { a.only.clone() },
        budget: a.budget.unwrap_or(ACCURACY_BUDGET),
        runs: a.runs.into(),
        threads: a.threads.into(),
        size: a.size,
    };
    let mut progress = Progress::new();
    let done = study.run(&mut progress);
    progress.end();
    done.map_err(|e| match e {
        StudyError::Scene(e) => Failure::from(e),
        other => wrong(other),
    })?;
    finish(&rows, &a.out)
}
