//! The section on builds: time, one tree scored by one function, and whether it is a tree.

use crate::rows::BuildRow;
use crate::subject::{Built, Prepared, Subject};
use crate::tree::covers;
use bvh_lab::bvh::{Limits, validate};
use bvh_lab::cost::{SahParams, sah, stats};
use bvh_lab::geom::Aabb;
use bvh_lab::lab::spread;
use bvh_lab::refine::equal_leaves;
use bvh_lab::scene::Scene;
use std::time::{Duration, Instant};

/// The leaf limit at which trees are compared.
const MAX_LEAF: usize = 4;

/// How long and how often.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Timed runs of each subject.
    pub repeats: usize,
    /// No subject starts another run once its runs took this long.
    pub enough: Duration,
}

/// One subject on its way through the rounds.
struct Runner<'a> {
    row: BuildRow,
    prepared: Box<dyn Prepared + 'a>,
    milliseconds: Vec<f64>,
    spent: Duration,
}

/// A build, and how long it took. The tree is dropped by the caller, outside of that time.
fn timed<'a>(prepared: &'a dyn Prepared) -> (Result<Box<dyn Built + 'a>, String>, Duration) {
    let start = Instant::now();
    let built = prepared.build();
    (built, start.elapsed())
}

/// Builds one scene by all subjects: once to warm up and to look at the tree, then round by round, every subject once a
/// round, so that a disturbance hits all alike. To be called inside a rayon pool of `threads` threads.
pub fn measure(
    scene: &Scene,
    boxes: &[Aabb],
    subjects: &[&dyn Subject],
    threads: usize,
    effort: Effort,
) -> Vec<BuildRow> {
    let mut runners: Vec<_> = subjects
        .iter()
        .filter(|subject| subject.builds_with(threads))
        .map(|subject| {
            eprintln!("{}: {} x{threads}", scene.name, subject.name());
            let mut row = empty_row(scene, *subject, threads);
            let prepared = subject.prepare(&scene.triangles, threads);
            let (built, took) = timed(&*prepared);
            match &built {
                Ok(built) => look(&mut row, &**built, scene, boxes, subject.spatial()),
                Err(error) => row.status = error.clone(),
            }
            drop(built);
            // A build this long is not repeated; its first run counts.
            let long = took >= effort.enough;
            let milliseconds = if long { vec![took.as_secs_f64() * 1e3] } else { Vec::new() };
            Runner { row, prepared, milliseconds, spent: if long { took } else { Duration::ZERO } }
        })
        .collect();
    for _ in 0..effort.repeats {
        for runner in runners.iter_mut().filter(|r| r.row.status == "ok" && r.spent < effort.enough) {
            let (built, took) = timed(&*runner.prepared);
            drop(built);
            runner.milliseconds.push(took.as_secs_f64() * 1e3);
            runner.spent += took;
        }
    }
    runners.into_iter().map(finish).collect()
}

fn empty_row(scene: &Scene, subject: &dyn Subject, threads: usize) -> BuildRow {
    BuildRow {
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        library: subject.library().into(),
        version: subject.version(),
        preset: subject.preset(),
        threads,
        status: "ok".into(),
        median_ms: None,
        min_ms: None,
        max_ms: None,
        runs: 0,
        mtris_per_s: None,
        sah: None,
        sah_leaf4: None,
        max_leaf: None,
        references: None,
        loose_boxes: None,
    }
}

/// Validates and scores the tree, where the library shows one.
fn look(row: &mut BuildRow, built: &dyn Built, scene: &Scene, boxes: &[Aabb], spatial: bool) {
    let Some(tree) = built.tree() else {
        return;
    };
    let max_leaf = stats(&tree.bvh).max_leaf;
    let references = if spatial {
        covers(&tree.bvh, &scene.triangles, boxes)
    } else {
        let limits = Limits { max_leaf, ..Limits::default() };
        validate(&tree.bvh, boxes, &limits).map(|coverage| coverage.references).map_err(|e| e.to_string())
    };
    match references {
        Ok(references) => row.references = Some(references as f64 / boxes.len() as f64),
        Err(error) => row.status = error,
    }
    row.max_leaf = Some(max_leaf);
    row.loose_boxes = Some(tree.loose);
    row.sah = sah(&tree.bvh, SahParams::default());
    row.sah_leaf4 = sah(&equal_leaves(&tree.bvh, boxes, MAX_LEAF), SahParams::default());
}

fn finish(runner: Runner) -> BuildRow {
    let Runner { mut row, milliseconds, .. } = runner;
    if row.status == "ok"
        && let Some(times) = spread(milliseconds)
    {
        row.median_ms = Some(times.median);
        row.min_ms = Some(times.min);
        row.max_ms = Some(times.max);
        row.runs = times.runs;
        row.mtris_per_s = Some(row.triangles as f64 / times.median / 1e3);
    }
    row
}
