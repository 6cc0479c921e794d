//! The thesis' study: five geometries, two constructions, three arities, three lighting cases, two readings.
//!
//! Every finished cell is on disk before the next one begins, and a second run goes on from there.

use super::build_cell::{BuildCell, Measured, measure_build};
use super::job::{Job, fill, outcome};
use super::machine::{commit, version};
use super::measure::Repeats;
use super::replay::original_work;
use super::trace_cell::Stage;
use crate::build::{self, Preset};
use crate::bvh::Bvh;
use crate::rows::{BuildRow, Construction, Lighting, Row, RowError, RowFile, Status, TraceRow};
use crate::scene::{Scene, SceneError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The thesis' five geometries, in rising size.
pub const SCENES: [&str; 5] = ["thesis:tiny", "thesis:small", "thesis:med", "thesis:large", "thesis:huge"];

/// Seconds per cell unless the user says otherwise.
pub const DEFAULT_BUDGET: Duration = Duration::from_secs(20);

/// A cell whose time is known beforehand to pass its budget by so much is not even begun.
const HOPELESS: f64 = 1.5;

/// What is to be measured, and where the rows go.
#[derive(Clone, Debug)]
pub struct Study {
    /// Folder of the row files.
    pub rows: PathBuf,
    /// Seconds that one build may take; no limit if `None`.
    pub budget: Option<Duration>,
    /// Scenes, in rising size: smaller ones are what projections rest on.
    pub scenes: Vec<String>,
    /// Readings.
    pub presets: Vec<Preset>,
    /// Which cells.
    pub scope: Scope,
}

/// Which cells of the study are wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scope {
    /// Builds, as construction and arity.
    pub builds: Vec<(Construction, usize)>,
    /// Lighting cases traced on every tree.
    pub lightings: Vec<Lighting>,
}

impl Scope {
    /// The whole study.
    pub fn all() -> Self {
        Self { builds: Self::every_build(), lightings: Lighting::ALL.to_vec() }
    }

    /// All six builds of a scene.
    pub fn every_build() -> Vec<(Construction, usize)> {
        let arities = |c| [2, 4, 8].map(|arity| (c, arity));
        [Construction::TopDown, Construction::BottomUp].into_iter().flat_map(arities).collect()
    }

    /// Adds what `other` wants.
    pub fn extend(&mut self, other: Self) {
        self.builds.extend(other.builds);
        self.lightings.extend(other.lightings);
        self.builds.sort();
        self.builds.dedup();
        self.lightings.sort();
        self.lightings.dedup();
    }
}

/// What the study tells while it runs.
pub trait Watch {
    /// A cell begins; `share` of the whole work, as estimated, is done.
    fn begin(&mut self, cell: &str, share: f64);
    /// A line worth reading.
    fn say(&mut self, line: &str);
}

/// Why the study could not go on.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Rows could not be read or written.
    #[error(transparent)]
    Rows(#[from] RowError),
    /// A scene could not be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl Study {
    /// Measures every cell that is not yet among the rows.
    ///
    /// # Errors
    /// Scenes that cannot be had, rows that cannot be read or written; a cell that fails becomes a row instead.
    pub fn run(&self, watch: &mut dyn Watch) -> Result<(), StudyError> {
        // Loads every scene once: one that cannot be had is told before any row is touched.
        let weights = self.weights()?;
        self.set_aside_other_versions(watch)?;
        let mut builds = RowFile::<BuildRow>::open(&self.rows)?;
        let mut traces = RowFile::<TraceRow>::open(&self.rows)?;
        let all: f64 = weights.iter().sum();
        let mut weights = weights.into_iter();
        let mut done = 0.0;
        for &preset in &self.presets {
            for scene_name in &self.scenes {
                let scene = Scene::load(scene_name)?;
                let stage = Stage::new(&scene);
                for &(construction, arity) in &self.scope.builds {
                    let job = Job { scene: scene_name, preset, construction, arity };
                    watch.begin(&job.to_string(), done / all);
                    self.cell(&job, &stage, &mut builds, &mut traces, watch)?;
                    done += weights.next().unwrap_or(0.0);
                }
            }
        }
        Ok(())
    }

    /// Rows of another program are moved aside, not mixed with ours and not lost.
    fn set_aside_other_versions(&self, watch: &mut dyn Watch) -> Result<(), StudyError> {
        fn other<R: Row>(dir: &Path) -> Option<String> {
            // Opened, not read: a torn last line must not hide whose rows stand before it.
            let file = RowFile::<R>::open(dir).ok()?;
            let (version, commit_of_row) = file.rows().first()?.origin();
            ((version, commit_of_row) != (self::version(), commit())).then(|| commit_of_row.to_owned())
        }
        let Some(theirs) = other::<BuildRow>(&self.rows).or_else(|| other::<TraceRow>(&self.rows)) else {
            return Ok(());
        };
        let aside = (1..)
            .map(|k| self.rows.with_file_name(format!("rows-{theirs}-{k}")))
            .find(|p| !p.exists())
            .expect("some number is free");
        std::fs::rename(&self.rows, &aside).map_err(|source| RowError::Io {
            what: "move aside",
            path: self.rows.clone(),
            source,
        })?;
        watch.say(&format!("rows of commit {theirs} moved to {}; measuring anew", aside.display()));
        Ok(())
    }

    /// Estimated seconds of every cell, in the order of [`Study::run`].
    fn weights(&self) -> Result<Vec<f64>, StudyError> {
        /// Steps per second of a literal engine, roughly; only shares matter.
        const RATE: f64 = 5e8;
        let limit = self.budget.map_or(f64::INFINITY, |b| b.as_secs_f64());
        let sizes: Vec<usize> =
            self.scenes.iter().map(|s| Scene::load(s).map(|s| s.triangles.len())).collect::<Result<_, _>>()?;
        let mut weights = Vec::new();
        for &preset in &self.presets {
            for (scene, &n) in self.scenes.iter().zip(&sizes) {
                for &(construction, arity) in &self.scope.builds {
                    let seconds = Job { scene, preset, construction, arity }.model().steps(n) / RATE;
                    let building = if seconds > HOPELESS * limit { limit / 20.0 } else { 2.0 * seconds.min(limit) };
                    weights.push(building + 0.5 * (1 + self.scope.lightings.len()) as f64);
                }
            }
        }
        Ok(weights)
    }

    /// Measures one build and its pictures, as far as there are no rows of them.
    fn cell(
        &self,
        job: &Job,
        stage: &Stage,
        builds: &mut RowFile<BuildRow>,
        traces: &mut RowFile<TraceRow>,
        watch: &mut dyn Watch,
    ) -> Result<(), StudyError> {
        let mut bvh = None;
        let row = match builds.get(&job.empty_build_row(stage.triangles.len()).key()) {
            Some(row) if self.settled(row) => row.clone(),
            _ => {
                let (row, built) = self.build(job, stage, builds.rows());
                if row.status != Status::Ok {
                    watch.say(&format!("{job}: {}", outcome(&row)));
                }
                builds.put(row.clone())?;
                bvh = built;
                row
            }
        };
        for &lighting in &self.scope.lightings {
            let empty = job.empty_trace_row(stage.triangles.len(), lighting);
            let known = traces.get(&empty.key());
            if known.is_some_and(|t| t.status == Status::Ok || row.status != Status::Ok) {
                continue;
            }
            if row.status == Status::Ok && bvh.is_none() {
                bvh = job.rebuild(stage, &row);
            }
            traces.put(job.trace(stage, bvh.as_ref(), &row, empty))?;
        }
        Ok(())
    }

    /// Whether a row needs no second measurement: it has its figure, or no greater budget than its own is there now.
    fn settled(&self, row: &BuildRow) -> bool {
        let seconds = self.budget.map_or(f64::INFINITY, |b| b.as_secs_f64());
        match row.status {
            Status::Ok => true,
            Status::Capped | Status::Projected => row.budget_s.is_none_or(|b| b >= seconds),
            Status::Error => false,
        }
    }

    fn build(&self, job: &Job, stage: &Stage, known: &[BuildRow]) -> (BuildRow, Option<Bvh>) {
        let n = stage.triangles.len();
        let mut row = job.empty_build_row(n);
        row.budget_s = self.budget.map(|b| b.as_secs_f64());
        if let Some((ms, from)) = self.foreseen(job, n, known) {
            row.status = Status::Projected;
            row.projected_ms = Some(ms);
            row.note = format!("not begun: projected from {from} by the work in closed form");
            return (row, None);
        }
        let cell = BuildCell {
            builder: build::find(job.construction.id()).expect("both constructions are registered"),
            options: job.options(),
            budget: self.budget,
            repeats: Repeats::default(),
        };
        match measure_build(&stage.triangles, &cell) {
            Measured::Ok(built) => {
                fill(&mut row, &built, stage);
                self.replay(job, stage, known, &mut row);
                (row, Some(built.bvh))
            }
            Measured::Capped { projected_ms } => {
                row.status = if projected_ms.is_some() { Status::Projected } else { Status::Capped };
                row.projected_ms = projected_ms;
                row.note = "stopped by its budget: projected from the work done until then".into();
                (row, None)
            }
            Measured::Failed(why) => {
                (row.status, row.note) = (Status::Error, why);
                (row, None)
            }
        }
    }

    /// Counts what the original's kd-tree would have done, once a scene. Where that took too long on a smaller scene,
    /// it is not tried.
    fn replay(&self, job: &Job, stage: &Stage, known: &[BuildRow], row: &mut BuildRow) {
        /// Seconds that a replay may take unless there is no budget at all.
        const LONGEST: f64 = 5.0;
        if (job.preset, job.construction, job.arity) != (Preset::Published, Construction::BottomUp, 2) {
            return;
        }
        let tried = |r: &&BuildRow| r.triangles < row.triangles && r.build_key() == row.build_key();
        let gave_up = known.iter().filter(tried).any(|r| r.original_visits.is_none());
        if gave_up && self.budget.is_some() {
            return;
        }
        let boxes: Vec<_> = stage.triangles.iter().map(crate::geom::Triangle::aabb).collect();
        let limit = self.budget.map(|b| Duration::from_secs_f64(b.as_secs_f64().min(LONGEST)));
        // Its errors are the chain's, which has just succeeded on the same boxes.
        if let Ok(Some(work)) = original_work(&boxes, limit.map(|l| Instant::now() + l)) {
            row.original_visits = Some(work.visited);
            row.original_list_steps = Some(work.list_steps);
        }
    }

    /// A build time far beyond the budget, foreseen from the same builder's greatest smaller scene, and that scene.
    fn foreseen(&self, job: &Job, n: usize, known: &[BuildRow]) -> Option<(f64, String)> {
        let budget = self.budget?.as_secs_f64() * 1e3;
        let row = job.empty_build_row(n);
        let same = |r: &&BuildRow| r.triangles < n && r.build_key() == row.build_key();
        let smaller = known.iter().filter(same).max_by_key(|r| r.triangles)?;
        let ms = smaller.build_ms.or(smaller.projected_ms)?;
        let ms = job.model().from_smaller(n, smaller.triangles, ms)?;
        (ms > HOPELESS * budget).then(|| (ms, smaller.scene.clone()))
    }
}
