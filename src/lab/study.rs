//! The thesis' study: five geometries, two constructions, three arities, three lighting cases, two readings.
//!
//! The exact engine goes first and fills every cell: its trees are the ones that are traced. The literal engine follows
//! where its times are wanted; they are measured within a budget, projected beyond it, and its trees must be the same
//! ones. Every finished cell is on disk before the next one begins, and a second run goes on from there.

use super::aside::set_aside_other_versions;
use super::build_cell::{BuildCell, Built, Measured, measure_build, measure_uncounted};
use super::job::{Job, fill, outcome};
use super::lock::Lock;
use super::measure::Repeats;
use super::replay::original_work;
use super::trace_cell::Stage;
use super::twin::{copy_counts, same_tree, same_work, twin};
use crate::build::{self, Engine, Preset};
use crate::bvh::Bvh;
use crate::rows::{BuildRow, Construction, Experiment, Lighting, Row, RowError, RowFile, Status, TraceRow};
use crate::scene::{Scene, SceneError};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The thesis' five geometries, in rising size.
pub const SCENES: [&str; 5] = ["thesis:tiny", "thesis:small", "thesis:med", "thesis:large", "thesis:huge"];

/// Seconds per cell unless the user says otherwise.
pub const DEFAULT_BUDGET: Duration = Duration::from_secs(20);

/// Note of a row whose build was stopped at work.
const STOPPED: &str = "stopped: projected from the work done until then";

/// A cell whose time is foreseen to pass its budget by so much is not even begun.
const HOPELESS: f64 = 1.15;

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
    /// Whether the literal engine builds the trees too: only its times need that.
    pub literal: bool,
    /// Whether f32 costs are held against exact ones.
    pub decisions: bool,
    /// Experiments on the thesis' findings.
    pub experiments: Vec<Experiment>,
}

impl Scope {
    /// The whole study.
    pub fn all() -> Self {
        Self {
            builds: Self::every_build(),
            lightings: Lighting::ALL.to_vec(),
            literal: true,
            decisions: true,
            experiments: Experiment::ALL.to_vec(),
        }
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
        self.decisions |= other.decisions;
        self.experiments.extend(other.experiments);
        self.experiments.sort();
        self.experiments.dedup();
        self.builds.sort();
        self.builds.dedup();
        self.lightings.sort();
        self.lightings.dedup();
        self.literal |= other.literal;
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
        // A scene that cannot be had is told before any row is touched.
        let stages: Vec<Stage> =
            self.scenes.iter().map(|name| Scene::load(name).map(|s| Stage::new(&s))).collect::<Result<_, _>>()?;
        let _lock = Lock::take(&self.rows)?;
        set_aside_other_versions(&self.rows, watch)?;
        let mut builds = RowFile::<BuildRow>::open(&self.rows)?;
        let mut traces = RowFile::<TraceRow>::open(&self.rows)?;
        let jobs = self.jobs(&stages);
        let weights: Vec<f64> = jobs.iter().map(|(job, stage)| self.weight(job, stage, &builds)).collect();
        /// Estimated seconds of a cell about decisions.
        const DECISIONS: f64 = 0.5;
        let all = weights.iter().sum::<f64>() + DECISIONS * self.decision_cells() as f64;
        let mut done = 0.0;
        for ((job, stage), weight) in jobs.iter().zip(weights) {
            watch.begin(&job.to_string(), done / all);
            self.cell(job, stage, &mut builds, &mut traces, watch)?;
            done += weight;
        }
        self.decisions(&stages, builds.rows(), |cells| (done + DECISIONS * cells as f64) / all, watch)?;
        self.experiments(watch)
    }

    /// All cells, in the order in which they are measured: exact engines first, so that all trees are there early, and
    /// smaller scenes first, as projections start from them.
    fn jobs<'a>(&'a self, stages: &'a [Stage]) -> Vec<(Job<'a>, &'a Stage)> {
        let mut jobs = Vec::new();
        for engine in [Engine::Exact, Engine::Literal].into_iter().filter(|&e| e == Engine::Exact || self.scope.literal)
        {
            for &preset in &self.presets {
                for (scene, stage) in self.scenes.iter().zip(stages) {
                    let of_scene = |(construction, arity)| (Job { scene, preset, construction, arity, engine }, stage);
                    jobs.extend(self.builds(preset).map(of_scene));
                }
            }
        }
        jobs
    }

    /// The wanted builds that have this reading.
    fn builds(&self, preset: Preset) -> impl Iterator<Item = (Construction, usize)> + '_ {
        let has = move |c: Construction| build::find(c.id()).is_some_and(|b| b.presets.contains(&preset));
        self.scope.builds.iter().copied().filter(move |&(c, _)| has(c))
    }

    /// Estimated seconds of a cell.
    fn weight(&self, job: &Job, stage: &Stage, builds: &RowFile<BuildRow>) -> f64 {
        /// Seconds of an exact build per triangle, roughly, verified, timed and counted.
        const EXACT: f64 = 2e-5;
        let row = job.empty_build_row(stage);
        if builds.get(&row.key()).is_some_and(|r| self.settled(r, stage)) {
            return 0.01;
        }
        if job.engine == Engine::Exact {
            return EXACT * stage.triangles.len() as f64 + 0.3 * (1 + self.scope.lightings.len()) as f64;
        }
        let limit = self.budget.map_or(f64::INFINITY, |b| b.as_secs_f64());
        let seconds = literal_seconds(job, stage);
        if seconds > HOPELESS * limit { limit / 20.0 } else { 0.5 + 2.0 * seconds.min(limit) }
    }

    /// Measures one build, and the pictures of an exact one, as far as there are no rows of them.
    fn cell(
        &self,
        job: &Job,
        stage: &Stage,
        builds: &mut RowFile<BuildRow>,
        traces: &mut RowFile<TraceRow>,
        watch: &mut dyn Watch,
    ) -> Result<(), StudyError> {
        let mut bvh = None;
        let known = builds.get(&job.empty_build_row(stage).key()).cloned();
        let row = match known {
            Some(row) if self.settled(&row, stage) => row,
            known => {
                let (row, built) = self.build(job, stage, builds.rows(), known);
                if row.status != Status::Ok {
                    watch.say(&format!("{job}: {}", outcome(&row)));
                }
                builds.put(row.clone())?;
                bvh = built;
                row
            }
        };
        let pictures = if job.engine == Engine::Exact { &self.scope.lightings[..] } else { &[] };
        for &lighting in pictures {
            let empty = job.empty_trace_row(stage, lighting);
            if traces.get(&empty.key()).is_some_and(|t| belongs(t, &row)) {
                continue;
            }
            if row.status == Status::Ok && bvh.is_none() {
                watch.say(&format!("{job}: its tree once more, for the pictures"));
                bvh = job.rebuild(stage, &row);
            }
            traces.put(job.trace(stage, bvh.as_ref(), &row, empty))?;
        }
        Ok(())
    }

    /// Whether a row needs no second measurement: it is about these triangles, and has its figure, or no greater budget
    /// than its own is there now.
    fn settled(&self, row: &BuildRow, stage: &Stage) -> bool {
        let seconds = self.budget.map_or(f64::INFINITY, |b| b.as_secs_f64());
        row.scene_hash == stage.hash
            && match row.status {
                Status::Ok => true,
                Status::Capped | Status::Projected => row.budget_s.is_none_or(|b| b >= seconds),
                Status::Error => false,
            }
    }

    /// Measures a build; `before` is what an earlier run, of a smaller budget, knew of it.
    fn build(&self, job: &Job, stage: &Stage, known: &[BuildRow], before: Option<BuildRow>) -> (BuildRow, Option<Bvh>) {
        let mut row = job.empty_build_row(stage);
        row.budget_s = self.budget.map(|b| b.as_secs_f64());
        if let Some((ms, note)) = self.foreseen(&row, job, known) {
            // A projection from this very build's own work is the better one.
            if let Some(stopped) = before.filter(|b| b.note == STOPPED && b.scene_hash == stage.hash) {
                return (BuildRow { budget_s: row.budget_s, ..stopped }, None);
            }
            (row.status, row.projected_ms, row.note) = (Status::Projected, Some(ms), note);
            return (row, None);
        }
        let cell = BuildCell {
            builder: job.builder(),
            options: job.options(),
            budget: self.allowed(job, stage),
            repeats: Repeats::default(),
        };
        let counts = same_work(known, &row);
        let measure = if counts.is_some() { measure_uncounted } else { measure_build };
        match measure(&stage.triangles, &cell) {
            Measured::Ok(built) => {
                let other = twin(known, &row);
                row.tree_hash = Some(built.hash.to_string());
                if let Err(why) = self.checks(job, stage, known, &built, &mut row) {
                    (row.status, row.note) = (Status::Error, why);
                    return (row, None);
                }
                fill(&mut row, &built, stage, other);
                counts.into_iter().for_each(|from| copy_counts(from, &mut row));
                (row, Some(built.bvh))
            }
            Measured::Capped { projected_ms: Some(ms) } => {
                (row.status, row.projected_ms, row.note) = (Status::Projected, Some(ms), STOPPED.into());
                (row, None)
            }
            Measured::Capped { projected_ms: None } => {
                (row.status, row.note) = (Status::Capped, "stopped by its budget".into());
                (row, None)
            }
            Measured::Failed(why) => {
                (row.status, row.note) = (Status::Error, why);
                (row, None)
            }
        }
    }

    /// Seconds that a build may take. One that is far beyond its budget by the model alone, with no smaller scene to
    /// foresee that from, is only tried: what it does in a third of the time projects it as well.
    fn allowed(&self, job: &Job, stage: &Stage) -> Option<Duration> {
        /// The model's rate is rough: so much beyond the budget is beyond doubt.
        const FAR: f64 = 10.0;
        let budget = self.budget?;
        let far = job.engine == Engine::Literal && literal_seconds(job, stage) > FAR * budget.as_secs_f64();
        Some(if far { budget / 3 } else { budget })
    }

    /// What a tree must pass before its figures count, and what its row holds beyond them.
    fn checks(
        &self,
        job: &Job,
        stage: &Stage,
        known: &[BuildRow],
        built: &Built,
        row: &mut BuildRow,
    ) -> Result<(), String> {
        if let Some(other) = twin(known, row) {
            same_tree(&built.hash.to_string(), other)?;
        }
        // Rule Q8 can hide triangles from rays; everything else must show a ray what brute force shows it.
        if built.coverage.hidden == 0 {
            stage.verify(&built.bvh)?;
        }
        let chain = (Preset::Published, Construction::BottomUp, 2, Engine::Literal);
        if (job.preset, job.construction, job.arity, job.engine) == chain {
            self.replay(stage, known, row)?;
        }
        Ok(())
    }

    /// Counts what the original's kd-tree would have done, once a scene. Where that took too long on a smaller scene,
    /// it is not tried.
    fn replay(&self, stage: &Stage, known: &[BuildRow], row: &mut BuildRow) -> Result<(), String> {
        /// Seconds that a replay may take unless there is no budget at all.
        const LONGEST: f64 = 5.0;
        let tried = |r: &&BuildRow| r.triangles < row.triangles && r.build_key() == row.build_key();
        let gave_up = known.iter().filter(tried).any(|r| r.original_visits.is_none());
        if gave_up && self.budget.is_some() {
            return Ok(());
        }
        let boxes: Vec<_> = stage.triangles.iter().map(crate::geom::Triangle::aabb).collect();
        let limit = self.budget.map(|b| Duration::from_secs_f64(b.as_secs_f64().min(LONGEST)));
        if let Some(work) = original_work(&boxes, limit.map(|l| Instant::now() + l))? {
            row.original_visits = Some(work.visited);
            row.original_list_steps = Some(work.list_steps);
        }
        Ok(())
    }

    /// A build time far beyond the budget, foreseen from the same builder on the greatest smaller scene that was
    /// measured, else on the greatest that was stopped at work; and the row's note.
    fn foreseen(&self, row: &BuildRow, job: &Job, known: &[BuildRow]) -> Option<(f64, String)> {
        if job.engine != Engine::Literal {
            return None;
        }
        let budget = self.budget?.as_secs_f64() * 1e3;
        let smaller = || known.iter().filter(|r| r.triangles < row.triangles && r.build_key() == row.build_key());
        let measured = smaller().filter(|r| r.build_ms.is_some()).max_by_key(|r| r.triangles);
        let stopped = || smaller().filter(|r| r.note == STOPPED).max_by_key(|r| r.triangles);
        let from = measured.or_else(stopped)?;
        let kind = if from.build_ms.is_some() { "the time measured" } else { "the time projected" };
        let ms = job.model().from_smaller(row.triangles, from.triangles, from.build_ms.or(from.projected_ms)?)?;
        let note = format!("not begun: projected from {kind} on {} by the work in closed form", from.scene);
        (ms > HOPELESS * budget).then_some((ms, note))
    }
}

/// Seconds of a literal build by the model alone, at the rate of a machine of 2026.
fn literal_seconds(job: &Job, stage: &Stage) -> f64 {
    /// Steps per second, roughly.
    const RATE: f64 = 5e8;
    job.model().steps(stage.triangles.len()) / RATE
}

/// Whether a picture's row needs no second measurement: it shows this very tree, or says that there is none.
fn belongs(trace: &TraceRow, build: &BuildRow) -> bool {
    match build.status {
        Status::Ok => trace.status == Status::Ok && trace.tree_hash == build.tree_hash,
        Status::Error => trace.status == Status::Error,
        Status::Capped | Status::Projected => trace.status == Status::Capped,
    }
}
