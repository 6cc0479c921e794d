//! The headline: how the cells ended, and how near they came.

use crate::report::cells::{CellStatus, Study};
use crate::report::printed::{Flag, Model};
use crate::rows::Status;
use std::fmt;
use std::path::PathBuf;

/// How close counts as reproduced: 6 %.
pub const CLOSE: f64 = 0.06;

/// How close counts for an average degree: 0.2 children.
pub const DEGREES_CLOSE: f64 = 0.2;

/// Cells by how our side of them ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Measured and verified.
    pub ok: usize,
    /// Stopped by a budget.
    pub capped: usize,
    /// Capped, with a projected time.
    pub projected: usize,
    /// Failed their verification.
    pub error: usize,
    /// Without a row.
    pub missing: usize,
}

/// How many cells came within [`CLOSE`] of the corrected (else printed) figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Within {
    /// Within.
    pub within: usize,
    /// Cells with a figure on both sides.
    pub compared: usize,
    /// Cells with a printed figure.
    pub printed: usize,
}

/// What a report wrote, and its headline numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Cells of Tables 2 to 9, preset `published`.
    pub cells: Counts,
    /// Rows of any preset that failed their verification.
    pub error_rows: usize,
    /// Rows of the study.
    pub study_rows: usize,
    /// Rows about accuracy.
    pub accuracy_rows: usize,
    /// Rows of builders side by side.
    pub comparison_rows: usize,
    /// Table 5, preset `published`, Tiny to Large, arity 2 and 4: the cells free of rule Q8.
    pub table5: Within,
    /// The same over all cells of Table 5.
    pub table5_all: Within,
    /// Average degrees of Table 3, preset `published`.
    pub table3: Within,
    /// Trees of any preset that two engines built and that are the same, of those that two engines built.
    pub engines_agree: (usize, usize),
}

impl Summary {
    pub(crate) fn of(study: &Study) -> Self {
        let mut cells = Counts::default();
        for cell in (2..=9).flat_map(|t| study.table("published", t)) {
            *match cell.status {
                CellStatus::Ok => &mut cells.ok,
                CellStatus::Capped => &mut cells.capped,
                CellStatus::Projected => &mut cells.projected,
                CellStatus::Error => &mut cells.error,
                CellStatus::Missing => &mut cells.missing,
            } += 1;
        }
        let failed = |s: &Status| *s == Status::Error;
        let builds = study.builds.iter().map(|r| &r.status);
        let traces = study.traces.iter().map(|r| &r.status);
        let decisions = study.decisions.iter().map(|r| &r.status);
        let experiments = study.experiments.iter().map(|r| &r.status);
        Self {
            files: Vec::new(),
            cells,
            study_rows: 0,
            accuracy_rows: 0,
            comparison_rows: 0,
            error_rows: builds.chain(traces).chain(decisions).chain(experiments).filter(|s| failed(s)).count(),
            table5: within(study, 5, |model, arity| model != Model::Huge && arity != Some(8)),
            table5_all: within(study, 5, |_, _| true),
            table3: near(study, 3, DEGREES_CLOSE),
            engines_agree: engines_agree(study),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let c = &self.cells;
        let others =
            [(self.accuracy_rows, "rows about accuracy"), (self.comparison_rows, "rows of builders side by side")];
        for (rows, about) in others.iter().filter(|o| o.0 > 0) {
            write!(f, "{rows} {about}; ")?;
        }
        if self.study_rows == 0 {
            return write!(f, "{} files", self.files.len());
        }
        write!(
            f,
            "Table 5: {} of {} measured cells within 6 % (Tiny to Large, arity 2 and 4; {} are printed); Tables 2 to 9, preset \
             published: {} ok, {} projected, {} capped, {} error, {} missing; {} of {} trees that two engines built are the \
             same; {} files",
            self.table5.within,
            self.table5.compared,
            self.table5.printed,
            c.ok,
            c.projected,
            c.capped,
            c.error,
            c.missing,
            self.engines_agree.0,
            self.engines_agree.1,
            self.files.len()
        )
    }
}

fn within(study: &Study, table: u8, counts: impl Fn(Model, Option<usize>) -> bool) -> Within {
    let mut found = Within::default();
    for cell in study.table("published", table) {
        if !counts(cell.printed.model, cell.printed.arity) || cell.printed.flag == Flag::Capped {
            continue;
        }
        found.printed += 1;
        if let Some(ratio) = cell.ratio().filter(|_| cell.status == CellStatus::Ok) {
            found.compared += 1;
            found.within += usize::from((ratio - 1.0).abs() <= CLOSE);
        }
    }
    found
}

/// Cells of a table within so much, as a difference.
fn near(study: &Study, table: u8, difference: f64) -> Within {
    let mut found = Within::default();
    for cell in study.table("published", table).iter().filter(|c| c.printed.flag != Flag::Capped) {
        found.printed += 1;
        if let Some((ours, printed)) = cell.ours.zip(cell.printed.reference()).filter(|_| cell.status == CellStatus::Ok)
        {
            found.compared += 1;
            found.within += usize::from((ours - printed.value).abs() <= difference);
        }
    }
    found
}

/// Pairs of rows about one tree, compared by hash; a row that failed because its tree is another one counts too.
fn engines_agree(study: &Study) -> (usize, usize) {
    let mut found = (0, 0);
    for (i, a) in study.builds.iter().enumerate() {
        let twin = study.builds[i + 1..]
            .iter()
            .find(|b| (&b.preset, &b.scene, b.construction, b.arity) == (&a.preset, &a.scene, a.construction, a.arity));
        if let Some((ours, theirs)) = twin.and_then(|b| a.tree_hash.as_ref().zip(b.tree_hash.as_ref())) {
            found.0 += usize::from(ours == theirs);
            found.1 += 1;
        }
    }
    found
}
