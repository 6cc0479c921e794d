//! Growth: what rows say of time and work against size, and of why the thesis' builds took what they took.

pub(crate) mod exponents;
pub(crate) mod laws;
pub(crate) mod samples;

use crate::rows::{BuildRow, RowError, ScalingRow, Status, WorkRow, read};
use std::path::Path;

/// All rows about growth.
#[derive(Debug)]
pub(crate) struct Growth {
    /// Builds and collapses against size.
    pub scaling: Vec<ScalingRow>,
    /// The work of the thesis' program.
    pub work: Vec<WorkRow>,
    /// Builds of the study.
    pub builds: Vec<BuildRow>,
}

impl Growth {
    /// Reads them.
    ///
    /// # Errors
    /// Rows that cannot be read.
    pub fn read(rows_dir: &Path, builds: &[BuildRow]) -> Result<Self, RowError> {
        Ok(Self { scaling: read(rows_dir)?, work: read(rows_dir)?, builds: builds.to_vec() })
    }

    /// Whether there is anything of its own to tell.
    pub fn is_empty(&self) -> bool {
        self.scaling.is_empty() && self.work.is_empty()
    }

    /// Rows that failed their verification.
    pub fn errors(&self) -> usize {
        self.scaling.iter().filter(|r| r.status == Status::Error).count()
    }
}

/// Elementary steps counted: combinations, distances, transitions of a dynamic program, entries of a search structure.
pub(crate) fn steps(row: &ScalingRow) -> Option<f64> {
    let steps = row.combinations + row.pair_distances + row.dp_steps + row.search_visits;
    (row.status == Status::Ok && steps > 0).then_some(steps as f64)
}

/// Milliseconds of a finished row.
pub(crate) fn milliseconds(row: &ScalingRow) -> Option<f64> {
    row.build_ms.filter(|ms| row.status == Status::Ok && ms.is_finite() && *ms > 0.0)
}
