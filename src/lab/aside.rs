//! Rows of another program: moved aside, not mixed with ours and not lost.

use super::lock::Lock;
use super::machine::{commit, version};
use super::study::Watch;
use crate::rows::{AccuracyRow, BuildRow, CompareRow, DecisionRow, Row, RowError, ScalingRow, TraceRow, WorkRow, read};
use std::path::Path;

/// Moves all that lies in the folder `rows` into a new one beside it, if any row there is of another program than this.
///
/// # Errors
/// Rows that cannot be read, the file system's.
pub(super) fn set_aside_other_versions(rows: &Path, watch: &mut dyn Watch) -> Result<(), RowError> {
    let theirs = [
        other::<BuildRow>(rows)?,
        other::<TraceRow>(rows)?,
        other::<DecisionRow>(rows)?,
        other::<ScalingRow>(rows)?,
        other::<WorkRow>(rows)?,
        other::<AccuracyRow>(rows)?,
        other::<CompareRow>(rows)?,
    ];
    let Some(theirs) = theirs.into_iter().flatten().next() else {
        return Ok(());
    };
    let aside = (1..)
        .map(|k| rows.with_file_name(format!("rows-{theirs}-{k}")))
        .find(|p| !p.exists())
        .expect("some number is free");
    let io = |what| move |source| RowError::Io { what, path: rows.into(), source };
    std::fs::create_dir(&aside).map_err(io("set aside"))?;
    for entry in std::fs::read_dir(rows).map_err(io("read"))? {
        let entry = entry.map_err(io("read"))?;
        if entry.file_name() != Lock::FILE {
            std::fs::rename(entry.path(), aside.join(entry.file_name())).map_err(io("set aside"))?;
        }
    }
    watch.say(&format!("rows of commit {theirs} moved to {}; measuring anew", aside.display()));
    Ok(())
}

/// The commit of rows of this kind, if it is not ours.
fn other<R: Row>(dir: &Path) -> Result<Option<String>, RowError> {
    let rows = read::<R>(dir)?;
    let foreign = rows.first().filter(|r| r.origin() != (version(), commit()));
    Ok(foreign.map(|r| r.origin().1.to_owned()))
}
