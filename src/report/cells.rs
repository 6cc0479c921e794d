//! Cells: each printed number joined with the rows about it.

use crate::report::printed::{self, Model, Printed};
use crate::rows::{BuildRow, Construction, DecisionRow, ExperimentRow, Lighting, Status, TraceRow};

/// All rows of a study.
#[derive(Debug)]
pub(crate) struct Study {
    /// Builds.
    pub builds: Vec<BuildRow>,
    /// Traversals.
    pub traces: Vec<TraceRow>,
    /// Decisions by f32 costs.
    pub decisions: Vec<DecisionRow>,
    /// Experiments on the thesis' findings.
    pub experiments: Vec<ExperimentRow>,
}

/// How our side of a cell ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellStatus {
    /// Measured and verified.
    Ok,
    /// Stopped by its budget, or no tree to trace.
    Capped,
    /// Capped, with a projected time.
    Projected,
    /// Failed its verification.
    Error,
    /// No row about it.
    Missing,
}

impl CellStatus {
    /// Its name in tables.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Capped => "capped",
            Self::Projected => "projected",
            Self::Error => "error",
            Self::Missing => "missing",
        }
    }
}

/// A printed number beside ours.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// What is printed.
    pub printed: &'static Printed,
    /// Our figure, in the table's unit; projected where the status says so.
    pub ours: Option<f64>,
    /// How it ended.
    pub status: CellStatus,
    /// Seconds our build was allowed, where it was capped by them.
    pub budget: Option<f64>,
    /// The row's note.
    pub note: String,
    /// The engine that built the tree, empty where the row does not say.
    pub engine: String,
    /// Seconds that the exact engine took for the same tree (Table 2).
    pub exact: Option<f64>,
}

impl Cell {
    /// How often the exact engine's time goes into ours.
    pub fn exact_ratio(&self) -> Option<f64> {
        let exact = self.exact.filter(|&s| s > 0.0)?;
        self.ours.map(|literal| literal / exact)
    }

    /// Ours ÷ the corrected (else the printed) figure.
    pub fn ratio(&self) -> Option<f64> {
        let reference = self.printed.reference()?.value;
        self.ours.filter(|_| reference > 0.0).map(|ours| ours / reference)
    }

    /// Whether it is about this construction and arity.
    pub fn is(&self, construction: Construction, arity: usize) -> bool {
        self.printed.construction == Some(construction) && self.printed.arity == Some(arity)
    }

    fn missing(printed: &'static Printed) -> Self {
        Self {
            printed,
            ours: None,
            status: CellStatus::Missing,
            budget: None,
            note: String::new(),
            engine: String::new(),
            exact: None,
        }
    }

    /// Takes a row's outcome; a row that claims a figure and has none counts as missing.
    fn outcome(mut self, status: Status, measured: Option<f64>, projected: Option<f64>, note: &str) -> Self {
        let finite = |x: Option<f64>| x.filter(|v| v.is_finite());
        (self.status, self.ours) = match status {
            Status::Ok => (CellStatus::Ok, finite(measured)),
            Status::Projected => (CellStatus::Projected, finite(projected)),
            Status::Capped => (CellStatus::Capped, None),
            Status::Error => (CellStatus::Error, None),
        };
        self.note = note.to_owned();
        if self.ours.is_none() && matches!(status, Status::Ok | Status::Projected) {
            self.status = CellStatus::Missing;
            self.note = "its row has no figure".to_owned();
        }
        self
    }
}

impl Study {
    /// The commit whose program measured the rows; empty without rows.
    pub fn commit(&self) -> &str {
        let builds = self.builds.iter().map(|r| &r.commit);
        let traces = self.traces.iter().map(|r| &r.commit);
        let experiments = self.experiments.iter().map(|r| &r.commit);
        builds.chain(traces).chain(experiments).next().map_or("", String::as_str)
    }

    /// Whether any row is about this preset.
    pub fn has(&self, preset: &str) -> bool {
        self.builds.iter().any(|r| r.preset == preset) || self.traces.iter().any(|r| r.preset == preset)
    }

    /// The cells of a table for one preset, in print order.
    pub fn table(&self, preset: &str, number: u8) -> Vec<Cell> {
        printed::cells()
            .iter()
            .filter(|p| p.table == number && !p.is_size_column())
            .map(|p| self.cell(preset, p))
            .collect()
    }

    fn cell(&self, preset: &str, printed: &'static Printed) -> Cell {
        let (Some(construction), Some(arity)) = (printed.construction, printed.arity) else {
            return self.size_cell(printed);
        };
        match printed.table {
            2 => Cell {
                exact: self.time_cell(preset, printed, "exact").ours,
                ..self.time_cell(preset, printed, "literal")
            },
            3 => self.degree_cell(preset, printed, construction, arity),
            _ => self.trace_cell(preset, printed, construction, arity),
        }
    }

    fn size_cell(&self, printed: &'static Printed) -> Cell {
        let scene = printed.model.scene();
        let builds = self.builds.iter().map(|r| (&r.scene, r.triangles));
        let traces = self.traces.iter().map(|r| (&r.scene, r.triangles));
        let size = builds.chain(traces).find(|r| *r.0 == scene).map(|r| r.1);
        size.map_or(Cell::missing(printed), |n| Cell::missing(printed).outcome(Status::Ok, Some(n as f64), None, ""))
    }

    /// Table 2 once more, with the exact engine's times.
    pub fn exact_times(&self, preset: &str) -> Vec<Cell> {
        let cells = printed::cells().iter().filter(|p| p.table == 2 && !p.is_size_column());
        cells.map(|p| self.time_cell(preset, p, "exact")).collect()
    }

    /// Rows about one tree, the exact engine's first.
    pub fn builds_of(&self, preset: &str, model: Model, construction: Construction, arity: usize) -> Vec<&BuildRow> {
        let scene = model.scene();
        let mut rows: Vec<_> = self
            .builds
            .iter()
            .filter(|r| r.preset == preset && r.scene == scene && r.construction == construction && r.arity == arity)
            .collect();
        rows.sort_by_key(|r| r.engine != "exact");
        rows
    }

    /// The time of one engine. The thesis' times are those of the literal work: no other engine's may stand in for them.
    fn time_cell(&self, preset: &str, printed: &'static Printed, engine: &str) -> Cell {
        let rows = printed.construction.zip(printed.arity).map(|(c, k)| self.builds_of(preset, printed.model, c, k));
        let Some(row) = rows.into_iter().flatten().find(|r| r.engine == engine) else {
            return Cell::missing(printed);
        };
        let seconds = |ms: Option<f64>| ms.map(|ms| ms / 1000.0);
        let (measured, projected) = (seconds(row.build_ms), seconds(row.projected_ms));
        Cell {
            engine: row.engine.clone(),
            budget: row.budget_s,
            ..Cell::missing(printed).outcome(row.status, measured, projected, &row.note)
        }
    }

    /// Any engine that finished will do: they build the same tree.
    fn degree_cell(&self, preset: &str, printed: &'static Printed, construction: Construction, arity: usize) -> Cell {
        let rows = self.builds_of(preset, printed.model, construction, arity);
        let finished = rows.iter().find(|r| r.status == Status::Ok && r.avg_degree.is_some());
        let Some(row) = finished.or(rows.first()) else {
            return Cell::missing(printed);
        };
        // A projection is one of time: it says nothing of the tree.
        let status = match row.status {
            Status::Projected => Status::Capped,
            other => other,
        };
        Cell { engine: row.engine.clone(), ..Cell::missing(printed).outcome(status, row.avg_degree, None, &row.note) }
    }

    fn trace_cell(&self, preset: &str, printed: &'static Printed, construction: Construction, arity: usize) -> Cell {
        let scene = printed.model.scene();
        let lighting = lighting(printed.table);
        let row = self.traces.iter().find(|r| {
            r.preset == preset
                && r.scene == scene
                && r.construction == construction
                && r.arity == arity
                && r.lighting == lighting
        });
        let Some(row) = row else {
            return Cell::missing(printed);
        };
        let figure = match printed::is_time(printed.table) {
            true => row.us_per_pixel,
            false => row.nodes_per_pixel,
        };
        Cell::missing(printed).outcome(row.status, figure, figure, &row.note)
    }
}

/// The lighting case of Tables 4 to 9.
pub(crate) const fn lighting(table: u8) -> Lighting {
    match table {
        6 | 7 => Lighting::Reflection,
        8 | 9 => Lighting::Opacity,
        _ => Lighting::Primary,
    }
}
