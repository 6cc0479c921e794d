//! Groups of trees: built and traced in turns.

use super::plan::{Part, Setting};
use super::{AccuracyStudy, Subject};
use crate::build::rounding::Flips;
use crate::build::{Brake, BuildError, Input};
use crate::bvh::{Bvh, quantised, stored_bytes, tree_hash, validate_parts};
use crate::cost::{SahParams, sah};
use crate::geom::{Aabb, Ray, Triangle};
use crate::lab::measure::spread;
use crate::rows::{AccuracyRow, Status};
use crate::trace::{Batch, HitRecord, Kernel, Query, Tracer, count_batch, trace_batch};
use std::time::Instant;

/// A setting with its tree, if it has one.
struct Entry<'a> {
    setting: &'a Setting,
    row: AccuracyRow,
    tree: Option<Tree>,
}

struct Tree {
    /// As it is traced.
    bvh: Bvh,
    hits: Vec<HitRecord>,
    build_ms: Vec<f64>,
    mrays: Vec<f64>,
}

/// Measures one group.
pub(super) fn measure(
    study: &AccuracyStudy,
    subject: &Subject,
    settings: Vec<(&Setting, AccuracyRow)>,
) -> Vec<AccuracyRow> {
    let mut entries: Vec<Entry> = Vec::with_capacity(settings.len());
    for (setting, mut row) in settings {
        let tree = match prepare(study, subject, setting, &mut row) {
            Ok(tree) => Some(tree),
            Err(BuildError::Stopped(_)) => {
                row.note = "stopped by its budget".into();
                None
            }
            Err(e) => {
                (row.status, row.note) = (Status::Error, e.to_string());
                None
            }
        };
        entries.push(Entry { setting, row, tree });
    }
    hold_to_the_first(&mut entries);
    for _ in 0..study.runs.max(1) {
        for entry in &mut entries {
            entry.time_build(subject);
        }
        for entry in &mut entries {
            entry.time_trace(subject);
        }
    }
    entries.into_iter().map(Entry::finish).collect()
}

/// Every tree and every way to store it has the same hits: those of all triangles. Fails what differs from the first.
fn hold_to_the_first(entries: &mut [Entry]) {
    let Some(expected) = entries.iter().find_map(|entry| Some(entry.tree.as_ref()?.hits.clone())) else { return };
    for entry in entries.iter_mut().filter(|entry| entry.tree.as_ref().is_some_and(|tree| tree.hits != expected)) {
        entry.fail("hits differ from those through the group's first tree");
    }
}

/// Builds, verifies and counts; also the run that warms memory up.
fn prepare(
    study: &AccuracyStudy,
    subject: &Subject,
    setting: &Setting,
    row: &mut AccuracyRow,
) -> Result<Tree, BuildError> {
    let triangles = &subject.stage.triangles;
    let mut brake = Brake::new(Instant::now().checked_add(study.budget));
    let built = build(setting, triangles, &mut brake)?;
    let boxes: Vec<Aabb> = triangles.iter().map(Triangle::aabb).collect();
    let wrong = |why: String| BuildError::Parameter(why);
    validate_parts(&built, triangles, &boxes, &setting.builder.limits(&setting.options))
        .map_err(|v| wrong(v.to_string()))?;
    row.tree_hash = Some(tree_hash(&built).to_string());
    if let Some((decision, rounding)) = setting.costs {
        let mut flips = Flips::default();
        decision.build(&boxes, |candidates| flips.note(rounding, candidates), &mut brake)?;
        row.compared = Some(flips.compared);
        row.different = Some(flips.different);
        row.largest_excess = Some(flips.largest_excess);
    }
    row.bytes = Some(built.bytes());
    let bvh = match (setting.part, setting.number) {
        (Part::Storage, Some(bits)) if setting.kernel == Kernel::Scalar => {
            row.bytes = Some(stored_bytes(&built, bits));
            if bits < 32 { quantised(&built, bits) } else { built }
        }
        _ => built,
    };
    subject.stage.verify(&bvh).map_err(wrong)?;
    row.sah = sah(&bvh, SahParams::default());
    let rays = subject.rays(setting.rays);
    let tracer = Tracer::new(setting.kernel, &bvh, triangles);
    if setting.kernel != Kernel::Scalar {
        row.bytes = Some(tracer.bytes());
    }
    let (hits, work) = count_batch(&batch(&tracer, rays));
    let per_ray = |n: u64| (!rays.is_empty()).then(|| n as f64 / rays.len() as f64);
    row.traced = Some(rays.len());
    row.nodes_per_ray = per_ray(work.nodes);
    row.box_tests_per_ray = per_ray(work.box_tests);
    row.tri_tests_per_ray = per_ray(work.triangle_tests);
    Ok(Tree { bvh, hits, build_ms: Vec::new(), mrays: Vec::new() })
}

fn build(setting: &Setting, triangles: &[Triangle], brake: &mut Brake) -> Result<Bvh, BuildError> {
    // Boxes are part of the build: it starts from triangles.
    let boxes = setting.builder.boxes(triangles, &setting.options);
    if let Some((decision, rounding)) = setting.costs {
        return decision.build(&boxes, |candidates| rounding.least(candidates), brake);
    }
    (setting.builder.timed)(Input::of_triangles(triangles, &boxes), &setting.options, brake)
}

fn batch<'a>(tracer: &'a Tracer<'a>, rays: &'a [Ray]) -> Batch<'a> {
    Batch { tracer, query: Query::Closest, rays }
}

impl Entry<'_> {
    fn time_build(&mut self, subject: &Subject) {
        let Some(tree) = &mut self.tree else { return };
        let begin = Instant::now();
        let built = build(self.setting, &subject.stage.triangles, &mut Brake::default());
        tree.build_ms.push(begin.elapsed().as_secs_f64() * 1e3);
        let same = built.is_ok_and(|b| Some(tree_hash(&b).to_string()) == self.row.tree_hash);
        if !same {
            self.fail("a timed build made another tree than the first one");
        }
    }

    fn time_trace(&mut self, subject: &Subject) {
        let Some(tree) = &mut self.tree else { return };
        let rays = subject.rays(self.setting.rays);
        let tracer = Tracer::new(self.setting.kernel, &tree.bvh, &subject.stage.triangles);
        let mut hits = Vec::new();
        let begin = Instant::now();
        trace_batch(&batch(&tracer, rays), &mut hits);
        tree.mrays.push(rays.len() as f64 * 1e-6 / begin.elapsed().as_secs_f64());
        if hits != tree.hits {
            self.fail("a timed pass saw other hits than the counted one");
        }
    }

    fn fail(&mut self, why: &str) {
        (self.row.status, self.row.note, self.tree) = (Status::Error, why.into(), None);
    }

    fn finish(self) -> AccuracyRow {
        let mut row = self.row;
        let Some(tree) = self.tree else {
            return AccuracyRow {
                sah: None,
                bytes: None,
                traced: None,
                nodes_per_ray: None,
                box_tests_per_ray: None,
                tri_tests_per_ray: None,
                compared: None,
                different: None,
                largest_excess: None,
                ..row
            };
        };
        row.status = Status::Ok;
        row.runs = tree.build_ms.len();
        if let Some(ms) = spread(tree.build_ms) {
            (row.build_ms, row.build_ms_min, row.build_ms_max) = (Some(ms.median), Some(ms.min), Some(ms.max));
        }
        if let Some(rate) = spread(tree.mrays) {
            put_rate(&mut row, rate);
        }
        row
    }
}

/// Puts a rate into its row.
pub(super) fn put_rate(row: &mut AccuracyRow, rate: crate::rows::Spread) {
    (row.mrays_per_s, row.mrays_per_s_min, row.mrays_per_s_max) = (Some(rate.median), Some(rate.min), Some(rate.max));
}
