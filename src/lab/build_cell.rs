//! One build: verified, timed and counted apart, or stopped by its budget and projected.

use super::measure::{Repeats, repeat};
use super::memory::peak_of;
use super::projection::Model;
use crate::build::{Brake, BuildError, BuildOptions, Builder, Counters, Engine, Input, Unfinished, Work};
use crate::bvh::{Bvh, Coverage, TreeHash, tree_hash, validate_parts};
use crate::geom::{Aabb, Triangle};
use crate::rows::{Construction, Spread};
use std::time::{Duration, Instant};

/// EPO is left out above so many triangles, where it would take longer than anything else.
pub const EPO_LIMIT: usize = 1_000_000;

/// What is to be built, and what it may cost.
#[derive(Clone, Copy, Debug)]
pub struct BuildCell<'a> {
    /// The builder.
    pub builder: &'a Builder,
    /// Its options.
    pub options: BuildOptions,
    /// Seconds that one build may take.
    pub budget: Option<Duration>,
    /// How often it is timed.
    pub repeats: Repeats,
}

/// A tree that passed its verification, and what it took.
#[derive(Clone, Debug)]
pub struct Built {
    /// The tree.
    pub bvh: Bvh,
    /// Its canonical hash.
    pub hash: TreeHash,
    /// What the validation counted.
    pub coverage: Coverage,
    /// Seconds of one build, from triangles to tree.
    pub seconds: Spread,
    /// Work, from a separate pass.
    pub counters: Counters,
    /// The most bytes that this pass held beyond the triangles, the boxes and the tree included; none where nobody counts
    /// them ([`super::peak_of`]) or there was no such pass.
    pub peak_bytes: Option<usize>,
}

/// How a measurement ended.
#[derive(Clone, Debug)]
pub enum Measured {
    /// With a tree.
    Ok(Box<Built>),
    /// Stopped by the budget; milliseconds that it would have taken, where the work done allows a projection.
    Capped {
        /// Projected build time.
        projected_ms: Option<f64>,
    },
    /// With a wrong tree or an error; one line.
    Failed(String),
}

/// Builds once and verifies, then times, then counts; in this order, so that no number comes from a wrong tree.
pub fn measure_build(triangles: &[Triangle], cell: &BuildCell) -> Measured {
    match measure_uncounted(triangles, cell) {
        Measured::Ok(built) => counted(triangles, cell, built),
        unfinished => unfinished,
    }
}

/// The same without the pass that counts: all counters are 0.
pub(super) fn measure_uncounted(triangles: &[Triangle], cell: &BuildCell) -> Measured {
    let build = |brake: &mut Brake| {
        // Boxes are part of the build: it starts from triangles.
        let boxes = cell.builder.boxes(triangles, &cell.options);
        (cell.builder.timed)(Input::of_triangles(triangles, &boxes), &cell.options, brake)
    };
    let begin = Instant::now();
    // A budget that the clock cannot hold is no limit.
    let mut brake = Brake::new(cell.budget.and_then(|b| begin.checked_add(b)));
    let first = build(&mut brake);
    let first_seconds = begin.elapsed().as_secs_f64();
    let bvh = match first {
        Ok(bvh) => bvh,
        Err(BuildError::Stopped(left)) => return capped(triangles.len(), cell, &left, brake.steps(), first_seconds),
        Err(e) => return Measured::Failed(e.to_string()),
    };
    let boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let coverage = match validate_parts(&bvh, triangles, &boxes, &cell.builder.limits(&cell.options)) {
        Ok(coverage) => coverage,
        Err(violations) => return Measured::Failed(violations.to_string()),
    };
    let hash = tree_hash(&bvh);
    let seconds = if cell.repeats.cold || first_seconds >= cell.repeats.enough.as_secs_f64() {
        Spread { median: first_seconds, min: first_seconds, max: first_seconds, runs: 1 }
    } else {
        match repeat(&cell.repeats, || build(&mut Brake::default()).map(|bvh| drop(std::hint::black_box(bvh)))) {
            Ok(seconds) => seconds,
            Err(e) => return Measured::Failed(e.to_string()),
        }
    };
    Measured::Ok(Box::new(Built { bvh, hash, coverage, seconds, counters: Counters::default(), peak_bytes: None }))
}

/// Builds once more, counts, and checks that it is the same tree.
fn counted(triangles: &[Triangle], cell: &BuildCell, mut built: Box<Built>) -> Measured {
    let counters = &mut built.counters;
    let (again, peak) = peak_of(|| {
        let boxes = cell.builder.boxes(triangles, &cell.options);
        (cell.builder.counted)(Input::of_triangles(triangles, &boxes), &cell.options, counters)
    });
    built.peak_bytes = peak;
    match again {
        Ok(again) if tree_hash(&again) == built.hash => {}
        Ok(_) => return Measured::Failed("two builds of the same triangles gave different trees".into()),
        Err(e) => return Measured::Failed(e.to_string()),
    }
    if built.coverage.q8_nodes as u64 != built.count(Work::Q8Nodes) {
        return Measured::Failed("the builder counts other nodes of rule Q8 than the tree holds".into());
    }
    Measured::Ok(built)
}

/// The thesis' construction that a builder is, if it is one.
fn construction(builder: &Builder) -> Option<Construction> {
    [Construction::TopDown, Construction::BottomUp].into_iter().find(|c| c.id() == builder.id)
}

/// The model of the projection knows the work of literal engines alone.
fn capped(n: usize, cell: &BuildCell, left: &Unfinished, steps: u64, seconds: f64) -> Measured {
    let projected_ms = construction(cell.builder)
        .filter(|_| cell.options.engine == Engine::Literal)
        .and_then(|c| Model::new(c, cell.options).from_stopped(n, left, steps, seconds * 1e3));
    Measured::Capped { projected_ms }
}

impl Built {
    /// How often one kind of work was done.
    pub fn count(&self, work: Work) -> u64 {
        self.counters.get(work)
    }
}
