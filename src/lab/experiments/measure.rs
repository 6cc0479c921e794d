//! One cell of an experiment: its tree built and verified, then counted, compared or timed.

use super::pixels::{Seen, closest_hits, compare};
use super::plan::{Cell, Make, Use};
use crate::build::top_down::one_axis;
use crate::build::{self, Brake, BuildError, BuildOptions, Input};
use crate::bvh::{Bvh, Coverage, Limits, tree_hash, validate};
use crate::cost::{SahParams, sah, stats};
use crate::geom::Aabb;
use crate::lab::measure::{Repeats, repeat};
use crate::lab::trace_cell::Stage;
use crate::rows::{ExperimentRow, Spread, Status};
use crate::trace::{
    Batch, FirstLeafOptions, Kernel, Query, Reading, StudyView, Tracer, Width, count_batch, run_image, trace_batch,
    trace_image,
};
use std::time::{Duration, Instant};

/// Why a cell has no figures: the status and note of its row.
pub(super) type Unmeasured = (Status, String);

/// A scene under experiment, and what its cells share.
pub(super) struct Subject<'a> {
    pub stage: &'a Stage,
    boxes: Vec<Aabb>,
    /// What every pixel should see, once it was asked for.
    closest: Option<Vec<Seen>>,
    /// The last tree with what made it: cells that trace one tree in several ways follow each other.
    last: Option<(String, Bvh, f64, Coverage)>,
}

/// Timed runs: few, as there are many cells.
const REPEATS: Repeats = Repeats { runs: 3, enough: Duration::from_millis(400), cold: false };

impl<'a> Subject<'a> {
    pub fn new(stage: &'a Stage) -> Self {
        let boxes = stage.triangles.iter().map(crate::geom::Triangle::aabb).collect();
        Self { stage, boxes, closest: None, last: None }
    }

    /// Fills the row of a cell.
    ///
    /// # Errors
    /// Status and note of a cell that was stopped or failed its verification.
    pub fn measure(&mut self, cell: &Cell, row: &mut ExperimentRow) -> Result<(), Unmeasured> {
        if cell.action == Use::TimeCollapse {
            return self.time_collapse(cell, row);
        }
        let (bvh, ms, coverage) = self.tree(cell, row)?;
        describe(row, &bvh, ms, &coverage);
        let view = self.stage.view(&bvh);
        match cell.action {
            Use::TimeCollapse => {}
            Use::Count(reading) => count(row, &view, reading),
            Use::Time { reading, wide } => {
                count(row, &view, without_lookup(reading));
                self.time(row, &view, reading)?;
                if wide {
                    row.wide_us_per_pixel = wide_time(&view)?;
                }
            }
            Use::Compare(reading) => {
                count(row, &view, reading);
                let stage = self.stage;
                let wrong = compare(self.closest.get_or_insert_with(|| closest_hits(stage)), stage, &bvh, reading);
                (row.farther, row.missed, row.extra) = (Some(wrong.farther), Some(wrong.missed), Some(wrong.extra));
            }
        }
        row.status = Status::Ok;
        Ok(())
    }

    /// Builds and verifies; a tree that was just built is not built again.
    fn tree(&mut self, cell: &Cell, row: &ExperimentRow) -> Result<(Bvh, f64, Coverage), Unmeasured> {
        let name = format!("{:?}", cell.make);
        if let Some((last, bvh, ms, coverage)) = &self.last
            && *last == name
        {
            return Ok((bvh.clone(), *ms, *coverage));
        }
        let budget = row.budget_s.map(Duration::from_secs_f64);
        let mut brake = Brake::new(budget.and_then(|b| Instant::now().checked_add(b)));
        let begin = Instant::now();
        let bvh = self.make(cell.make, &mut brake)?;
        let first = begin.elapsed().as_secs_f64();
        let coverage = validate(&bvh, &self.boxes, &limits(cell.make)).map_err(|v| (Status::Error, v.to_string()))?;
        if coverage.hidden == 0 {
            self.stage.verify(&bvh).map_err(|why| (Status::Error, why))?;
        }
        // One more build, on warm memory, unless that takes long.
        let again = Instant::now();
        let timed = matches!(cell.action, Use::Time { .. }) && first < REPEATS.enough.as_secs_f64();
        let seconds = match timed {
            true => self.make(cell.make, &mut Brake::default()).map(|_| again.elapsed().as_secs_f64().min(first))?,
            false => first,
        };
        self.last = Some((name, bvh.clone(), seconds * 1e3, coverage));
        Ok((bvh, seconds * 1e3, coverage))
    }

    /// The six trees of the thesis' program, and how it traced them.
    pub fn published_trees(&self) -> Result<Vec<(Bvh, Reading)>, Unmeasured> {
        let one = |(make, reading)| Ok((self.make(make, &mut Brake::default())?, reading));
        super::plan::as_published().map(one).collect()
    }

    fn make(&self, make: Make, brake: &mut Brake) -> Result<Bvh, Unmeasured> {
        let built = match make {
            Make::Builder(id, options) => self.build(id, &options, brake),
            Make::OneAxis(params) => one_axis::build(&self.boxes, &params, brake),
            Make::Collapsed(id, options, rule) => {
                self.binary(id, options, brake).map(|b| rule.apply(&b, options.arity, build::MAX_LEAF))
            }
        };
        built.map_err(|e| match e {
            BuildError::Stopped(_) => (Status::Capped, "stopped by its budget".into()),
            other => (Status::Error, other.to_string()),
        })
    }

    fn build(&self, id: &str, options: &BuildOptions, brake: &mut Brake) -> Result<Bvh, BuildError> {
        let builder = build::find(id).expect("experiments name builders that are registered");
        (builder.timed)(Input::of_triangles(&self.stage.triangles, &self.boxes), options, brake)
    }

    /// The binary tree that a rule collapses.
    fn binary(&self, id: &str, options: BuildOptions, brake: &mut Brake) -> Result<Bvh, BuildError> {
        self.build(id, &BuildOptions { arity: 2, ..options }, brake)
    }

    fn time_collapse(&mut self, cell: &Cell, row: &mut ExperimentRow) -> Result<(), Unmeasured> {
        let Make::Collapsed(id, options, rule) = cell.make else {
            return Err((Status::Error, "there is no collapse to time".into()));
        };
        let fail = |e: BuildError| (Status::Error, e.to_string());
        let binary = self.binary(id, options, &mut Brake::default()).map_err(fail)?;
        let collapse = || rule.apply(&binary, options.arity, build::MAX_LEAF);
        let bvh = collapse();
        let coverage = validate(&bvh, &self.boxes, &Limits::default()).map_err(|v| (Status::Error, v.to_string()))?;
        let seconds = repeat(&REPEATS, || {
            drop(std::hint::black_box(collapse()));
            Ok::<_, Unmeasured>(())
        })?;
        describe(row, &bvh, seconds.median * 1e3, &coverage);
        row.status = Status::Ok;
        Ok(())
    }

    /// Times a picture, which must be the one that was counted.
    fn time(&self, row: &mut ExperimentRow, view: &StudyView, reading: Reading) -> Result<(), Unmeasured> {
        let expected = trace_image(view, row.lighting, without_lookup(reading)).digest();
        let lighting = row.lighting;
        let seconds = repeat(&REPEATS, || {
            let same = run_image(view, lighting, reading) == expected;
            same.then_some(()).ok_or((Status::Error, "the timed picture differs from the counted one".to_owned()))
        })?;
        let Spread { median, min, max, .. } = per_pixel(view, seconds);
        (row.us_per_pixel, row.us_per_pixel_min, row.us_per_pixel_max) = (Some(median), Some(min), Some(max));
        Ok(())
    }
}

/// The same reading; what is looked up how changes no result.
fn without_lookup(reading: Reading) -> Reading {
    match reading {
        Reading::Published(options) => Reading::Published(FirstLeafOptions { linear_lookup: false, ..options }),
        Reading::Text => Reading::Text,
    }
}

fn limits(make: Make) -> Limits {
    match make {
        Make::Builder(id, options) => build::find(id).map_or_else(Limits::default, |b| b.limits(&options)),
        Make::OneAxis(_) | Make::Collapsed(..) => Limits::default(),
    }
}

fn describe(row: &mut ExperimentRow, bvh: &Bvh, ms: f64, coverage: &Coverage) {
    let tree = stats(bvh);
    row.build_ms = Some(ms);
    row.tree_hash = Some(tree_hash(bvh).to_string());
    (row.inner, row.leaves, row.avg_degree) = (Some(tree.inner), Some(tree.leaves), tree.avg_degree);
    row.sah = sah(bvh, SahParams::default());
    row.q8_nodes = Some(coverage.q8_nodes as u64);
    (row.q8_duplicated, row.q8_hidden) = (Some(coverage.duplicated), Some(coverage.hidden));
}

fn count(row: &mut ExperimentRow, view: &StudyView, reading: Reading) {
    let counts = trace_image(view, row.lighting, reading);
    let per_pixel = |n: u64| Some(n as f64 / counts.pixels as f64);
    row.nodes_per_pixel = per_pixel(counts.nodes);
    row.box_tests_per_pixel = per_pixel(counts.box_tests);
    row.triangle_tests_per_pixel = per_pixel(counts.triangle_tests);
    row.hit_fraction = per_pixel(counts.hits);
    (row.rays, row.cut) = (Some(counts.rays), Some(counts.cut));
}

fn per_pixel(view: &StudyView, seconds: Spread) -> Spread {
    let pixels = f64::from(view.camera.width()) * f64::from(view.camera.height());
    let of = |s: f64| s * 1e6 / pixels;
    Spread { median: of(seconds.median), min: of(seconds.min), max: of(seconds.max), runs: seconds.runs }
}

/// Microseconds per pixel by the kernel that tests four or eight boxes at once, on one thread; none for binary trees.
fn wide_time(view: &StudyView) -> Result<Option<f64>, Unmeasured> {
    let width = match view.bvh.arity {
        4 => Width::Four,
        8 => Width::Eight,
        _ => return Ok(None),
    };
    let (w, h) = (view.camera.width(), view.camera.height());
    let rays: Vec<_> = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| view.camera.ray(x, y)).collect();
    let tracer = Tracer::new(Kernel::Wide { width, fast: false }, view.bvh, view.triangles);
    let batch = Batch { tracer: &tracer, query: Query::Closest, rays: &rays };
    let expected = count_batch(&batch).0;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| (Status::Error, e.to_string()))?;
    let mut hits = Vec::new();
    let seconds = pool.install(|| {
        repeat(&REPEATS, || {
            trace_batch(&batch, &mut hits);
            (hits == expected).then_some(()).ok_or((Status::Error, "a timed pass saw other hits".to_owned()))
        })
    })?;
    Ok(Some(per_pixel(view, seconds).median))
}
