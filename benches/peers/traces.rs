//! The section on traces: closest and any hits by every library's own traversal of its own tree, checked ray by ray.

use crate::agreement::{compare, compare_occlusion};
use crate::builds::Effort;
use crate::rows::TraceRow;
use crate::subject::{Built, Subject};
use bvh_lab::geom::Ray;
use bvh_lab::lab::spread;
use bvh_lab::scene::Scene;
use bvh_lab::trace::{HitRecord, Query};
use std::time::{Duration, Instant};

/// Share of the rays that may have another answer than the reference before a cell is an error.
const TOLERATED: f64 = 1e-4;

/// Rays with a name, and the reference's answers.
pub struct RaySet {
    /// What the rows call it.
    pub name: &'static str,
    /// What is asked of them.
    pub query: Query,
    /// The rays, of unit length.
    pub rays: Vec<Ray>,
    /// The answers, by an exact kernel of the laboratory.
    pub expected: Vec<HitRecord>,
}

struct Runner<'a> {
    row: TraceRow,
    tree: usize,
    traversal: usize,
    set: &'a RaySet,
    seconds: Vec<f64>,
    spent: Duration,
}

/// Traces the ray sets through the trees of all subjects: once to check the answers, then round by round. To be called
/// inside a rayon pool of one thread.
pub fn measure(scene: &Scene, sets: &[RaySet], subjects: &[&dyn Subject], effort: Effort) -> Vec<TraceRow> {
    let inputs: Vec<_> = subjects.iter().map(|subject| subject.prepare(&scene.triangles, 1)).collect();
    let mut rows = Vec::new();
    let mut trees: Vec<Box<dyn Built + '_>> = Vec::new();
    let mut runners = Vec::new();
    let size = scene.bounds().extent().max_element() as f32;
    let mut hits = Vec::new();
    for (subject, input) in subjects.iter().zip(&inputs) {
        let tree = match input.build() {
            Ok(tree) => tree,
            Err(error) => {
                rows.push(TraceRow { status: error, ..empty_row(scene, *subject) });
                continue;
            }
        };
        for set in sets {
            for (traversal, name) in tree.traversals(set.query).into_iter().enumerate() {
                eprintln!("{}: {} {name}, {} rays", scene.name, subject.name(), set.name);
                let mut row = empty_row(scene, *subject);
                (row.traversal, row.rays, row.count) = (name.into(), set.name.into(), set.rays.len());
                hits.clear();
                hits.resize(set.rays.len(), HitRecord::MISS);
                tree.trace(set.query, traversal, &set.rays, &mut hits);
                let found = match set.query {
                    Query::Closest => compare(&scene.triangles, &set.rays, &set.expected, &hits, size),
                    Query::Any => compare_occlusion(&set.expected, &hits),
                };
                (row.differ_at_edges, row.differ_elsewhere) = (found.at_edges, found.elsewhere);
                let differ = (found.at_edges + found.elsewhere) as f64;
                if differ > TOLERATED * set.rays.len() as f64 {
                    row.status = format!("{differ} of {} answers differ", set.rays.len());
                    rows.push(row);
                    continue;
                }
                let tree = trees.len();
                runners.push(Runner { row, tree, traversal, set, seconds: Vec::new(), spent: Duration::ZERO });
            }
        }
        trees.push(tree);
    }
    let tracers: Vec<_> = runners.iter().map(|r| trees[r.tree].tracer(r.set.query, r.traversal)).collect();
    for _ in 0..effort.repeats {
        for (runner, trace) in runners.iter_mut().zip(&tracers).filter(|(r, _)| r.spent < effort.enough) {
            hits.resize(runner.set.rays.len(), HitRecord::MISS);
            let start = Instant::now();
            trace(&runner.set.rays, &mut hits);
            let took = start.elapsed();
            runner.seconds.push(took.as_secs_f64());
            runner.spent += took;
        }
    }
    rows.extend(runners.into_iter().map(finish));
    rows
}

fn empty_row(scene: &Scene, subject: &dyn Subject) -> TraceRow {
    TraceRow {
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        rays: String::new(),
        count: 0,
        library: subject.library().into(),
        version: subject.version(),
        preset: subject.preset(),
        traversal: String::new(),
        status: "ok".into(),
        median_mrays: None,
        min_mrays: None,
        max_mrays: None,
        runs: 0,
        differ_at_edges: 0,
        differ_elsewhere: 0,
    }
}

fn finish(runner: Runner) -> TraceRow {
    let Runner { mut row, set, seconds, .. } = runner;
    let mrays = |s: f64| set.rays.len() as f64 / s / 1e6;
    if let Some(speeds) = spread(seconds.into_iter().map(mrays).collect()) {
        row.median_mrays = Some(speeds.median);
        row.min_mrays = Some(speeds.min);
        row.max_mrays = Some(speeds.max);
        row.runs = speeds.runs;
    }
    row
}
