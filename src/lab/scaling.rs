//! Time and work against size: every builder, reading and engine over one family of scenes that grows, and the work of
//! the thesis' program on its own scenes in closed form.
//!
//! Sizes rise, so that what a build will take is foreseen from the same build of the size before. Every row is on disk
//! before the next cell begins, and a second run goes on from there. Two engines' trees over the same triangles must be
//! the same.

use super::aside::set_aside_other_versions;
use super::build_cell::{BuildCell, Built, Measured, measure_build};
use super::closed_form::literal_work;
use super::lock::Lock;
use super::machine::{commit, machine, version};
use super::measure::{Repeats, repeat};
use super::projection::Model;
use super::study::{StudyError, Watch};
use super::work::WorkStudy;
use crate::build::{BUILDERS, BuildOptions, Builder, Engine, Input, Preset, Work};
use crate::bvh::{Bvh, Limits, tree_hash, validate};
use crate::geom::{Aabb, Triangle};
use crate::refine::collapse;
use crate::rows::{Construction, Row, RowFile, ScalingRow, Spread, Status};
use crate::scene::{Scene, SceneError};
use std::path::PathBuf;
use std::time::Duration;

/// Seconds that one build may take unless the user says otherwise: literal engines, whose growth shows early.
pub const LITERAL_BUDGET: Duration = Duration::from_secs(3);

/// The same for exact engines, which are to be followed to the greatest size.
pub const EXACT_BUDGET: Duration = Duration::from_secs(20);

/// A build that is foreseen to pass its budget by so much is not begun.
const HOPELESS: f64 = 1.15;

/// The name of the collapse among the builders of a row.
const COLLAPSE: &str = "collapse";

/// What is to be measured, and where the rows go.
#[derive(Clone, Debug)]
pub struct ScalingStudy {
    /// Folder of the row files.
    pub rows: PathBuf,
    /// Seconds that one build may take; [`LITERAL_BUDGET`] and [`EXACT_BUDGET`] if `None`.
    pub budget: Option<Duration>,
    /// Family of the scenes, such as `spheres`.
    pub family: String,
    /// Triangles, rising.
    pub sizes: Vec<usize>,
    /// Readings.
    pub presets: Vec<Preset>,
    /// Scenes whose work is put down in closed form, in rising size.
    pub work_scenes: Vec<String>,
    /// Threads for builders that share their work between threads.
    pub threads: usize,
}

/// 1,000 to `most` in half decades.
pub fn sizes_up_to(most: usize) -> Vec<usize> {
    let half_decades = (6..).map(|i| 10f64.powf(f64::from(i) / 2.0).round() as usize);
    half_decades.take_while(|&n| n <= most).collect()
}

/// One series at one size.
#[derive(Clone, Copy)]
struct Job {
    builder: &'static Builder,
    options: BuildOptions,
}

/// A scene as builders see it.
struct Subject {
    name: String,
    hash: String,
    triangles: Vec<Triangle>,
}

impl ScalingStudy {
    /// Measures every cell that is not yet among the rows.
    ///
    /// # Errors
    /// Scenes that cannot be had, rows that cannot be read or written; a cell that fails becomes a row instead.
    pub fn run(&self, watch: &mut dyn Watch) -> Result<(), StudyError> {
        // A scene that cannot be had is told before any row is touched.
        for scene in self.work_scenes.iter().chain(&self.sizes.first().map(|&n| self.scene(n))) {
            Scene::load(scene)?;
        }
        let _lock = Lock::take(&self.rows)?;
        set_aside_other_versions(&self.rows, watch)?;
        // Pools are for builds alone: what watches them need not cross threads.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads.max(1)).build().map_err(|e| {
            crate::rows::RowError::Io {
                what: "start threads for",
                path: self.rows.clone(),
                source: std::io::Error::other(e),
            }
        })?;
        let mut rows = RowFile::<ScalingRow>::open(&self.rows)?;
        let all: usize = self.sizes.iter().sum();
        /// Share of the whole that goes into the sizes; the rest is the closed forms.
        const SIZES: f64 = 0.85;
        let mut done = 0;
        for &size in &self.sizes {
            let subject = self.subject(size)?;
            let jobs = self.jobs();
            for (i, job) in jobs.iter().enumerate() {
                let share = (done as f64 + size as f64 * i as f64 / jobs.len() as f64) / all as f64;
                watch.begin(&format!("{}, {job}", subject.name), SIZES * share);
                let (row, tree) = self.cell(job, &subject, &rows, &pool, watch);
                if let Some(row) = row {
                    rows.put(row)?;
                }
                if let Some(tree) = tree {
                    for row in self.collapses(job, &subject, &tree) {
                        rows.put(row)?;
                    }
                }
            }
            done += size;
        }
        let work = WorkStudy { rows: &self.rows, budget: self.budget.unwrap_or(EXACT_BUDGET), presets: &self.presets };
        work.run(&self.work_scenes, &mut |cell, share| watch.begin(cell, SIZES + (1.0 - SIZES) * share))
    }

    fn scene(&self, size: usize) -> String {
        format!("gen:{}:{size}", self.family)
    }

    fn subject(&self, size: usize) -> Result<Subject, SceneError> {
        let name = self.scene(size);
        let triangles = Scene::load(&name)?.triangles;
        Ok(Subject { hash: triangles_hash(&triangles), name, triangles })
    }

    /// Every series: all builders, the wanted readings they have, their engines, their arities; bottom-up trees are
    /// binary, the collapse is a series of its own.
    fn jobs(&self) -> Vec<Job> {
        let mut jobs = Vec::new();
        for builder in BUILDERS {
            let arities = if builder.id == Construction::BottomUp.id() { &[2][..] } else { builder.arities };
            for &engine in builder.engines {
                for &preset in builder.presets.iter().filter(|p| self.presets.contains(p)) {
                    for &arity in arities {
                        let options = BuildOptions { arity, preset, engine, ..BuildOptions::default() };
                        jobs.push(Job { builder, options });
                    }
                }
            }
        }
        jobs
    }

    fn budget(&self, engine: Engine) -> Duration {
        self.budget.unwrap_or(if engine == Engine::Literal { LITERAL_BUDGET } else { EXACT_BUDGET })
    }

    /// Measures one build unless its row is there; returns a new row, and the tree where a collapse of it is wanted.
    fn cell(
        &self,
        job: &Job,
        subject: &Subject,
        rows: &RowFile<ScalingRow>,
        pool: &rayon::ThreadPool,
        watch: &mut dyn Watch,
    ) -> (Option<ScalingRow>, Option<Bvh>) {
        let mut row = job.empty_row(self, subject);
        let budget = self.budget(job.options.engine);
        let settled = |r: &&ScalingRow| {
            r.scene_hash == subject.hash
                && r.threads == row.threads
                && (r.status == Status::Ok
                    || r.status != Status::Error && r.budget_s.is_none_or(|b| b >= budget.as_secs_f64()))
        };
        if let Some(known) = rows.get(&row.key()).filter(settled) {
            let is_measured = |arity: usize| {
                let row = rows.get(&self.empty_collapse(job, subject, arity).key());
                row.is_some_and(|r| r.status == Status::Ok && r.scene_hash == subject.hash)
            };
            let all_measured = [4, 8].into_iter().all(is_measured);
            let missing = job.is_collapsed() && known.status == Status::Ok && !all_measured;
            return (None, if missing { pool.install(|| job.build(&subject.triangles)) } else { None });
        }
        row.budget_s = Some(budget.as_secs_f64());
        if let Some((projected, note)) = job.foreseen(&row, rows.rows(), budget) {
            row.status = if projected.is_some() { Status::Projected } else { Status::Capped };
            (row.projected_ms, row.note) = (projected, note);
            return (Some(row), None);
        }
        let cell = BuildCell {
            builder: job.builder,
            options: job.options,
            budget: Some(job.allowed(subject.triangles.len(), budget)),
            repeats: Repeats { enough: job.enough(), ..Repeats::default() },
        };
        let mut tree = None;
        match pool.install(|| measure_build(&subject.triangles, &cell)) {
            Measured::Ok(built) => match job.same_as_twin(&row, rows.rows(), &built) {
                Ok(()) => {
                    job.fill(&mut row, &built);
                    tree = job.is_collapsed().then_some(built.bvh);
                }
                Err(why) => (row.status, row.note) = (Status::Error, why),
            },
            Measured::Capped { projected_ms: Some(ms) } => {
                (row.status, row.projected_ms, row.note) = (Status::Projected, Some(ms), STOPPED.into());
            }
            Measured::Capped { projected_ms: None } => {
                (row.status, row.note) = (Status::Capped, "stopped by its budget".into());
            }
            Measured::Failed(why) => (row.status, row.note) = (Status::Error, why),
        }
        if row.status == Status::Error {
            watch.say(&format!("{}, {job}: failed: {}", subject.name, row.note));
        }
        (Some(row), tree)
    }

    fn empty_collapse(&self, job: &Job, subject: &Subject, arity: usize) -> ScalingRow {
        let row = job.empty_row(self, subject);
        ScalingRow { builder: COLLAPSE.into(), arity, engine: String::new(), model_steps: None, threads: 1, ..row }
    }

    /// The collapse of a binary tree, on its own: checked, then timed.
    fn collapses(&self, job: &Job, subject: &Subject, binary: &Bvh) -> Vec<ScalingRow> {
        let boxes: Vec<Aabb> = subject.triangles.iter().map(Triangle::aabb).collect();
        let one = |arity| {
            let mut row = self.empty_collapse(job, subject, arity);
            let wide = collapse(binary, arity);
            if let Err(why) = validate(&wide, &boxes, &Limits::default()) {
                (row.status, row.note) = (Status::Error, why.to_string());
                return row;
            }
            row.tree_hash = Some(tree_hash(&wide).to_string());
            let repeats = Repeats { enough: Duration::from_millis(500), ..Repeats::default() };
            let seconds = repeat(&repeats, || {
                std::hint::black_box(collapse(binary, arity));
                Ok::<(), std::convert::Infallible>(())
            });
            let Ok(seconds) = seconds;
            put_times(&mut row, &seconds);
            row
        };
        [4, 8].map(one).into()
    }
}

/// Note of a row whose build was stopped at work.
const STOPPED: &str = "stopped: projected from the work done until then";

impl Job {
    fn construction(&self) -> Option<Construction> {
        [Construction::TopDown, Construction::BottomUp].into_iter().find(|c| c.id() == self.builder.id)
    }

    fn model(&self) -> Option<Model> {
        self.construction().map(|c| Model::new(c, self.options))
    }

    /// Whether the collapse is measured on this job's tree: once for each reading, on the first engine's.
    fn is_collapsed(&self) -> bool {
        self.construction() == Some(Construction::BottomUp)
            && Some(&self.options.engine) == self.builder.engines.first()
    }

    fn build(&self, triangles: &[Triangle]) -> Option<Bvh> {
        let boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
        (self.builder.timed)(Input::of_triangles(triangles, &boxes), &self.options, &mut crate::build::Brake::default())
            .ok()
    }

    fn empty_row(&self, study: &ScalingStudy, subject: &Subject) -> ScalingRow {
        let n = subject.triangles.len();
        // What a builder shares between threads it would share between those of the study's pool.
        let parallel = (self.builder.parallel)(&self.options);
        ScalingRow {
            scene: subject.name.clone(),
            family: format!("gen:{}", study.family),
            triangles: n,
            scene_hash: subject.hash.clone(),
            builder: self.builder.id.into(),
            preset: self.options.preset.id().into(),
            arity: self.options.arity,
            engine: self.options.engine.id().into(),
            status: Status::Capped,
            budget_s: None,
            build_ms: None,
            build_ms_min: None,
            build_ms_max: None,
            runs: 0,
            projected_ms: None,
            note: String::new(),
            tree_hash: None,
            combinations: 0,
            child_costs: 0,
            box_unions: 0,
            original_unions: 0,
            pair_distances: 0,
            nearest_searches: 0,
            merges: 0,
            dp_steps: 0,
            search_visits: 0,
            model_steps: self.model().map(|mut m| m.steps(n)),
            literal_steps: None,
            literal_unions: None,
            threads: if parallel { study.threads.max(1) } else { 1 },
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        }
    }

    /// A time far beyond the budget, foreseen from the greatest smaller size of the series: by the model of literal work,
    /// or, for an engine whose work is near-linear, as if it were linear. No time where that is only a bound.
    fn foreseen(&self, row: &ScalingRow, known: &[ScalingRow], budget: Duration) -> Option<(Option<f64>, String)> {
        let smaller = known.iter().filter(|r| r.series() == row.series() && r.triangles < row.triangles);
        let from = smaller.max_by_key(|r| r.triangles)?;
        let limit = HOPELESS * budget.as_secs_f64() * 1e3;
        if self.options.engine == Engine::Exact {
            let least = from.build_ms.map(|ms| ms * row.triangles as f64 / from.triangles as f64);
            let over = least.map_or(from.status != Status::Error, |ms| ms > limit);
            return over.then(|| (None, format!("not begun: capped, foreseen from {}", from.scene)));
        }
        let measured = from.build_ms.or(from.projected_ms)?;
        let ms = self.model()?.from_smaller(row.triangles, from.triangles, measured)?;
        let kind = if from.build_ms.is_some() { "the time measured" } else { "the time projected" };
        let note = format!("not begun: projected from {kind} on {} by the work in closed form", from.scene);
        (ms > limit).then_some((Some(ms), note))
    }

    /// How long a build is timed: an exact one often enough that its memory is warm at the greatest sizes too.
    fn enough(&self) -> Duration {
        Duration::from_millis(if self.options.engine == Engine::Exact { 3000 } else { 500 })
    }

    /// What a build is allowed; one that is far beyond its budget by the model alone is only tried.
    fn allowed(&self, n: usize, budget: Duration) -> Duration {
        /// Literal steps per second, roughly.
        const RATE: f64 = 5e8;
        const FAR: f64 = 10.0;
        let seconds = self.model().filter(|_| self.options.engine == Engine::Literal).map(|mut m| m.steps(n) / RATE);
        if seconds.is_some_and(|s| s > FAR * budget.as_secs_f64()) { budget / 3 } else { budget }
    }

    /// Checks that another engine's tree over the same triangles is this one.
    fn same_as_twin(&self, row: &ScalingRow, known: &[ScalingRow], built: &Built) -> Result<(), String> {
        let cell = |r: &ScalingRow| (r.scene_hash.clone(), r.builder.clone(), r.preset.clone(), r.arity);
        let hash = built.hash.to_string();
        let twin = known.iter().find(|r| r.status == Status::Ok && cell(r) == cell(row) && r.engine != row.engine);
        match twin.and_then(|t| t.tree_hash.as_ref().filter(|h| **h != hash).map(|h| (h, &t.engine))) {
            Some((theirs, engine)) => Err(format!("the tree is {hash}, but that of the {engine} engine is {theirs}")),
            None => Ok(()),
        }
    }

    fn fill(&self, row: &mut ScalingRow, built: &Built) {
        put_times(row, &built.seconds);
        row.tree_hash = Some(built.hash.to_string());
        row.combinations = built.count(Work::Combinations);
        row.child_costs = built.count(Work::ChildCosts);
        row.box_unions = built.count(Work::BoxUnions);
        row.original_unions = built.count(Work::OriginalUnions);
        row.pair_distances = built.count(Work::PairDistances);
        row.nearest_searches = built.count(Work::NearestSearches);
        row.merges = built.count(Work::Merges);
        row.dp_steps = built.count(Work::DpSteps);
        row.search_visits = built.count(Work::SearchVisits);
        let work = self.construction().and_then(|c| literal_work(&built.bvh, c, &self.options));
        row.literal_steps = work.map(|w| w.steps);
        row.literal_unions = work.map(|w| w.unions).filter(|&u| u > 0.0);
    }
}

impl std::fmt::Display for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let o = &self.options;
        write!(f, "{} {} arity {}, {}", o.preset.id(), self.builder.id, o.arity, o.engine.id())
    }
}

fn put_times(row: &mut ScalingRow, seconds: &Spread) {
    row.status = Status::Ok;
    row.build_ms = Some(seconds.median * 1e3);
    row.build_ms_min = Some(seconds.min * 1e3);
    row.build_ms_max = Some(seconds.max * 1e3);
    row.runs = seconds.runs;
}

/// The hash of triangles that rows carry.
pub(super) fn triangles_hash(triangles: &[Triangle]) -> String {
    blake3::hash(bytemuck::cast_slice(triangles)).to_hex()[..16].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_rise_by_half_decades() {
        assert_eq!(sizes_up_to(1_000_000), [1000, 3162, 10_000, 31_623, 100_000, 316_228, 1_000_000]);
        assert!(sizes_up_to(999).is_empty());
    }
}
