//! One scene's contest: everybody verified and looked at, then rounds of builds, then rounds of traces.

use super::reference::{RaySet, Reference};
use super::{Comparison, Contestant};
use crate::build::{Brake, BuildOptions, Builder, Counters, Input};
use crate::bvh::{Bvh, Coverage, tree_hash};
use crate::cost::{SahParams, epo, leaf_counts, sah, stats};
use crate::geom::Triangle;
use crate::lab::{BuildCell, EPO_LIMIT, Measured, Repeats, measure_build, spread};
use crate::rows::{CompareRow, Spread, Status};
use crate::scene::Scene;
use crate::trace::{HitRecord, Tracer, trace_batch};
use std::time::Instant;

/// Shares of the time, roughly, that a scene spends before its builds are timed, and then before its traces are.
const PREPARED: f64 = 0.3;
const BUILT: f64 = 0.7;

/// A contestant at work.
struct Runner<'a> {
    contestant: &'a Contestant,
    /// The row it had before anything was measured: what an error row says besides its error.
    empty: CompareRow,
    row: CompareRow,
    /// A tree that passed its verification.
    tree: Option<Bvh>,
    /// Whether rays find through it what they should.
    traced: bool,
    builds: Times,
    primary: Times,
    diffuse: Times,
}

/// Seconds of the runs so far.
#[derive(Default)]
struct Times {
    seconds: Vec<f64>,
    /// Whether no more are wanted.
    done: bool,
}

impl Times {
    fn add(&mut self, seconds: f64, repeats: &Repeats) {
        self.seconds.push(seconds);
        let spent: f64 = self.seconds.iter().sum();
        self.done |= self.seconds.len() >= repeats.runs.max(1) || spent >= repeats.enough.as_secs_f64();
    }
}

pub(super) struct Contest<'a> {
    comparison: &'a Comparison,
    scene: &'a Scene,
    runners: Vec<Runner<'a>>,
}

impl<'a> Contest<'a> {
    pub fn new(comparison: &'a Comparison, scene: &'a Scene, empty: Vec<CompareRow>) -> Self {
        let runner = |(contestant, empty): (&'a Contestant, CompareRow)| Runner {
            contestant,
            row: empty.clone(),
            empty,
            tree: None,
            traced: false,
            builds: Times::default(),
            primary: Times::default(),
            diffuse: Times::default(),
        };
        Self { comparison, scene, runners: comparison.contestants.iter().zip(empty).map(runner).collect() }
    }

    /// Measures everything. `watch` is told what begins, and the share of the work that is done.
    pub fn run(mut self, watch: &mut dyn FnMut(&str, f64)) -> Vec<CompareRow> {
        watch("rays and their hits", 0.0);
        let reference = match Reference::new(self.scene, self.comparison.kernel, self.comparison.size) {
            Ok(reference) => reference,
            Err(why) => {
                self.runners.iter_mut().for_each(|r| r.fail(format!("no answers to hold it to: {why}")));
                return self.runners.into_iter().map(|r| r.row).collect();
            }
        };
        let all = self.runners.len().max(1) as f64;
        for (i, runner) in self.runners.iter_mut().enumerate() {
            watch(&format!("{}, arity {}", runner.row.name(), runner.row.arity), PREPARED * i as f64 / all);
            runner.prepare(self.comparison, self.scene, &reference);
        }
        let repeats = &self.comparison.repeats;
        for round in 0..repeats.runs.max(1) {
            let part = round as f64 / repeats.runs.max(1) as f64;
            watch(&format!("building, round {}", round + 1), PREPARED + (BUILT - PREPARED) * part);
            self.runners.iter_mut().for_each(|r| r.build(&self.scene.triangles, repeats));
        }
        let mut hits = Vec::new();
        for round in 0..repeats.runs.max(1) {
            let part = round as f64 / repeats.runs.max(1) as f64;
            watch(&format!("tracing, round {}", round + 1), BUILT + (1.0 - BUILT) * part);
            self.runners.iter_mut().for_each(|r| r.trace(self.comparison, self.scene, &reference, &mut hits));
        }
        self.runners.into_iter().map(|r| r.finish(&reference)).collect()
    }
}

impl Runner<'_> {
    /// Takes back every figure: nothing is to be said of a contestant that was wrong.
    fn fail(&mut self, why: String) {
        self.row = CompareRow { status: Status::Error, note: why, ..self.empty.clone() };
        (self.tree, self.traced) = (None, false);
    }

    /// Builds once, verifies tree and hits, and puts down all that does not depend on the clock.
    fn prepare(&mut self, comparison: &Comparison, scene: &Scene, reference: &Reference) {
        let (bvh, coverage) = match self.contestant {
            Contestant::Tree { tree, .. } => (tree.bvh.clone(), tree.coverage),
            Contestant::Recipe { builder, options } => {
                // The very first build counts where it takes all the time there is.
                let repeats = Repeats { cold: true, ..comparison.repeats };
                let cell = BuildCell { builder, options: *options, budget: Some(comparison.budget), repeats };
                match measure_build(&scene.triangles, &cell) {
                    Measured::Ok(built) => {
                        let first = built.seconds.median;
                        if first >= comparison.repeats.enough.as_secs_f64() {
                            self.builds.add(first, &comparison.repeats);
                        }
                        self.row.counters = counters_text(&built.counters);
                        self.row.peak_bytes = built.peak_bytes;
                        (built.bvh, built.coverage)
                    }
                    Measured::Capped { projected_ms } => {
                        self.row.status = if projected_ms.is_some() { Status::Projected } else { Status::Capped };
                        self.row.projected_ms = projected_ms;
                        self.row.note = "stopped by its budget".into();
                        return;
                    }
                    Measured::Failed(why) => return self.fail(why),
                }
            }
        };
        self.row.status = Status::Ok;
        self.describe(&bvh, &coverage, scene, reference);
        self.look_through(&bvh, &coverage, comparison, &scene.triangles, reference);
        if self.row.status == Status::Ok {
            self.tree = Some(bvh);
        }
    }

    fn describe(&mut self, bvh: &Bvh, coverage: &Coverage, scene: &Scene, reference: &Reference) {
        let (row, tree) = (&mut self.row, stats(bvh));
        row.tree_hash = Some(tree_hash(bvh).to_string());
        row.inner = Some(tree.inner);
        row.leaves = Some(tree.leaves);
        row.empty = Some(tree.empty);
        row.avg_degree = tree.avg_degree;
        row.max_depth = Some(tree.max_depth);
        row.max_leaf = Some(tree.max_leaf);
        row.references = Some(coverage.references);
        row.duplicated = Some(coverage.duplicated);
        row.hidden = Some(coverage.hidden);
        row.bytes = Some(tree.bytes);
        row.sah = sah(bvh, SahParams::default());
        row.epo = (scene.triangles.len() <= EPO_LIMIT).then(|| epo(bvh, &scene.triangles)).flatten();
        row.lcv = leaf_counts(bvh, &reference.leaf_rays).map(|counts| counts.lcv);
    }

    /// Counts the work of both ray sets, and holds the hits to the expected ones.
    fn look_through(
        &mut self,
        bvh: &Bvh,
        coverage: &Coverage,
        comparison: &Comparison,
        triangles: &[Triangle],
        reference: &Reference,
    ) {
        let tracer = Tracer::new(comparison.kernel, bvh, triangles);
        let count = |set: &RaySet| set.count(&tracer);
        let (primary, primary_wrong) = count(&reference.primary);
        let (diffuse, diffuse_wrong) = count(&reference.diffuse);
        match (primary_wrong + diffuse_wrong, coverage.hidden) {
            (0, _) => self.traced = true,
            (wrong, 0) => return self.fail(format!("{wrong} rays hit something else than they should")),
            (wrong, hidden) => {
                self.row.note =
                    format!("not traced: {hidden} triangles are hidden by rule Q8, and {wrong} rays miss them");
                return;
            }
        }
        let row = &mut self.row;
        let per_ray = |n: u64, set: &RaySet| (!set.rays.is_empty()).then(|| n as f64 / set.rays.len() as f64);
        row.primary_nodes = per_ray(primary.nodes, &reference.primary);
        row.primary_box_tests = per_ray(primary.box_tests, &reference.primary);
        row.primary_tri_tests = per_ray(primary.triangle_tests, &reference.primary);
        row.diffuse_nodes = per_ray(diffuse.nodes, &reference.diffuse);
        row.diffuse_box_tests = per_ray(diffuse.box_tests, &reference.diffuse);
        row.diffuse_tri_tests = per_ray(diffuse.triangle_tests, &reference.diffuse);
    }

    /// One timed build.
    fn build(&mut self, triangles: &[Triangle], repeats: &Repeats) {
        let Contestant::Recipe { builder, options } = self.contestant else { return };
        if self.tree.is_none() || self.builds.done {
            return;
        }
        match timed_build(builder, options, triangles) {
            Ok(seconds) => self.builds.add(seconds, repeats),
            Err(why) => self.fail(why),
        }
    }

    /// One timed pass of both ray sets.
    fn trace(&mut self, comparison: &Comparison, scene: &Scene, reference: &Reference, hits: &mut Vec<HitRecord>) {
        let Some(bvh) = self.tree.as_ref().filter(|_| self.traced) else { return };
        let tracer = Tracer::new(comparison.kernel, bvh, &scene.triangles);
        let sets = [(&reference.primary, &mut self.primary), (&reference.diffuse, &mut self.diffuse)];
        let mut wrong = false;
        for (set, times) in sets {
            if times.done || set.rays.is_empty() {
                continue;
            }
            let batch = set.batch(&tracer);
            let begin = Instant::now();
            trace_batch(&batch, hits);
            times.add(begin.elapsed().as_secs_f64(), &comparison.repeats);
            wrong |= *hits != set.expected;
        }
        if wrong {
            self.fail("a timed pass saw other hits than the counted one".into());
        }
    }

    fn finish(self, reference: &Reference) -> CompareRow {
        let Self { mut row, builds, primary, diffuse, .. } = self;
        (row.primary_rays, row.diffuse_rays) = (reference.primary.rays.len(), reference.diffuse.rays.len());
        if row.status != Status::Ok {
            return row;
        }
        if let Some(s) = spread(builds.seconds) {
            row.build_ms = Some(s.median * 1e3);
            (row.build_ms_min, row.build_ms_max) = (Some(s.min * 1e3), Some(s.max * 1e3));
            row.build_runs = s.runs;
        }
        if let Some(s) = rate(primary, &reference.primary) {
            row.primary_mrays = Some(s.median);
            (row.primary_mrays_min, row.primary_mrays_max) = (Some(s.min), Some(s.max));
            row.primary_runs = s.runs;
            row.primary_hit_hash = Some(crate::trace::hit_hash(&reference.primary.expected));
        }
        if let Some(s) = rate(diffuse, &reference.diffuse) {
            row.diffuse_mrays = Some(s.median);
            (row.diffuse_mrays_min, row.diffuse_mrays_max) = (Some(s.min), Some(s.max));
            row.diffuse_runs = s.runs;
            row.diffuse_hit_hash = Some(crate::trace::hit_hash(&reference.diffuse.expected));
        }
        row
    }
}

/// Million rays per second.
fn rate(times: Times, set: &RaySet) -> Option<Spread> {
    let rays = set.rays.len() as f64;
    spread(times.seconds.into_iter().filter(|s| *s > 0.0).map(|s| rays * 1e-6 / s).collect())
}

fn timed_build(builder: &Builder, options: &BuildOptions, triangles: &[Triangle]) -> Result<f64, String> {
    let begin = Instant::now();
    // Boxes are part of the build: it starts from triangles.
    let boxes = builder.boxes(triangles, options);
    let built = (builder.timed)(Input::of_triangles(triangles, &boxes), options, &mut Brake::default());
    let seconds = begin.elapsed().as_secs_f64();
    built.map(|_| seconds).map_err(|e| e.to_string())
}

fn counters_text(counters: &Counters) -> String {
    counters.nonzero().map(|(kind, n)| format!("{kind}={n}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
