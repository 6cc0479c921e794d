//! `bvh-lab scaling`: time and work against size and arity.

use super::arguments::ScalingArguments;
use super::progress::Progress;
use super::reproduce::{finish, keep_rows_when_interrupted};
use super::{Failure, Outcome, off, wrong};
use bvh_lab::lab::{SCENES, ScalingStudy, StudyError, sizes_up_to};
use bvh_lab::scene::families::FAMILIES;

/// Sizes where none are named end here.
const MOST: usize = 1_000_000;

/// Runs the command.
pub fn run(a: &ScalingArguments) -> Outcome {
    if !FAMILIES.iter().any(|f| f.name == a.family) {
        let names: Vec<_> = FAMILIES.iter().map(|f| f.name).collect();
        return Err(off(format!("there is no family '{}'; there are {}", a.family, names.join(", "))));
    }
    keep_rows_when_interrupted(&a.out)?;
    let mut sizes: Vec<usize> = a.sizes.iter().map(|&n| n as usize).collect();
    if sizes.is_empty() {
        sizes = sizes_up_to(MOST);
    }
    sizes.sort_unstable();
    sizes.dedup();
    let rows = a.out.join("rows");
    let study = ScalingStudy {
        rows: rows.clone(),
        budget: a.budget,
        family: a.family.clone(),
        sizes,
        presets: a.preset.iter().map(|&p| p.into()).collect(),
        work_scenes: if a.scenes.is_empty() { SCENES.map(str::to_owned).to_vec() } else { a.scenes.clone() },
        threads: a.threads.into(),
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
