//! One cell of the study: its name, its row, its figures.

use super::build_cell::Built;
use super::machine::{commit, machine, version};
use super::measure::Repeats;
use super::projection::Model;
use super::text::human_seconds;
use super::trace_cell::Stage;
use crate::build::{self, Brake, BuildOptions, Builder, Engine, Input, Preset, Work};
use crate::bvh::{Bvh, tree_hash};
use crate::cost::{SahParams, epo, sah, stats};
use crate::geom::Triangle;
use crate::rows::{BuildRow, Construction, Lighting, Status, TraceRow};
use crate::trace::{FirstLeafOptions, Reading};

/// One build of the study.
#[derive(Clone, Copy, Debug)]
pub(super) struct Job<'a> {
    pub scene: &'a str,
    pub preset: Preset,
    pub construction: Construction,
    pub arity: usize,
    pub engine: Engine,
}

impl Job<'_> {
    pub fn options(&self) -> BuildOptions {
        BuildOptions { arity: self.arity, preset: self.preset, engine: self.engine, ..BuildOptions::default() }
    }

    pub fn builder(&self) -> &'static Builder {
        build::find(self.construction.id()).expect("both constructions are registered")
    }

    pub fn model(&self) -> Model {
        Model::new(self.construction, self.options())
    }
}

impl std::fmt::Display for Job<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (preset, construction) = (self.preset.id(), self.construction.id());
        write!(f, "{preset} {} {construction} arity {}, {}", self.scene, self.arity, self.engine.id())
    }
}

impl Job<'_> {
    pub fn empty_build_row(&self, stage: &Stage) -> BuildRow {
        BuildRow {
            preset: self.preset.id().into(),
            scene: self.scene.into(),
            triangles: stage.triangles.len(),
            scene_hash: stage.hash.clone(),
            construction: self.construction,
            arity: self.arity,
            engine: self.engine.id().into(),
            status: Status::Capped,
            budget_s: None,
            build_ms: None,
            build_ms_min: None,
            build_ms_max: None,
            runs: 0,
            projected_ms: None,
            note: String::new(),
            tree_hash: None,
            inner: None,
            leaves: None,
            empty: None,
            avg_degree: None,
            max_depth: None,
            max_leaf: None,
            sah: None,
            epo: None,
            bytes: None,
            combinations: 0,
            box_unions: 0,
            original_unions: 0,
            pair_distances: 0,
            nearest_searches: 0,
            dp_steps: 0,
            search_visits: 0,
            original_visits: None,
            original_list_steps: None,
            q8_nodes: 0,
            q8_duplicated: None,
            q8_hidden: None,
            threads: self.builder().threads(&self.options()),
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        }
    }

    pub fn empty_trace_row(&self, stage: &Stage, lighting: Lighting) -> TraceRow {
        TraceRow {
            preset: self.preset.id().into(),
            scene: self.scene.into(),
            triangles: stage.triangles.len(),
            construction: self.construction,
            arity: self.arity,
            lighting,
            status: Status::Capped,
            us_per_pixel: None,
            us_per_pixel_min: None,
            us_per_pixel_max: None,
            runs: 0,
            nodes_per_pixel: None,
            box_tests_per_pixel: None,
            triangle_tests_per_pixel: None,
            hit_fraction: None,
            rays: None,
            cut: None,
            tree_hash: None,
            note: String::new(),
            threads: 1,
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        }
    }

    /// The tree of a row measured by an earlier run; `None` if it does not come out the same.
    pub fn rebuild(&self, stage: &Stage, row: &BuildRow) -> Option<Bvh> {
        let boxes: Vec<_> = stage.triangles.iter().map(Triangle::aabb).collect();
        let bvh = (self.builder().timed)(Input::of_boxes(&boxes), &self.options(), &mut Brake::default()).ok()?;
        (row.tree_hash.as_deref() == Some(tree_hash(&bvh).to_string().as_str())).then_some(bvh)
    }

    pub fn trace(&self, stage: &Stage, bvh: Option<&Bvh>, build: &BuildRow, mut row: TraceRow) -> TraceRow {
        let Some(bvh) = bvh else {
            (row.status, row.note) = match build.status {
                Status::Ok => (Status::Error, "the tree could not be built again as its row has it".into()),
                Status::Error => (Status::Error, "its build failed".into()),
                Status::Capped | Status::Projected => (Status::Capped, "no tree: its build was capped".into()),
            };
            return row;
        };
        let reading = match self.preset {
            Preset::Published => Reading::Published(FirstLeafOptions::default()),
            Preset::Text | Preset::Walter => Reading::Text,
        };
        row.tree_hash.clone_from(&build.tree_hash);
        match stage.trace(bvh, row.lighting, reading, &Repeats { runs: 3, ..Repeats::default() }) {
            Ok(traced) => {
                let pixels = traced.counts.pixels as f64;
                let per_pixel = |n: u64| Some(n as f64 / pixels);
                row.status = Status::Ok;
                row.us_per_pixel = Some(traced.seconds.median * 1e6 / pixels);
                row.us_per_pixel_min = Some(traced.seconds.min * 1e6 / pixels);
                row.us_per_pixel_max = Some(traced.seconds.max * 1e6 / pixels);
                row.runs = traced.seconds.runs;
                row.nodes_per_pixel = per_pixel(traced.counts.nodes);
                row.box_tests_per_pixel = per_pixel(traced.counts.box_tests);
                row.triangle_tests_per_pixel = per_pixel(traced.counts.triangle_tests);
                row.hit_fraction = per_pixel(traced.counts.hits);
                row.rays = Some(traced.counts.rays);
                row.cut = Some(traced.counts.cut);
            }
            Err(why) => (row.status, row.note) = (Status::Error, why),
        }
        row
    }
}

/// Puts a measured build into its row. `twin` is the other engine's row, if it finished: what takes
/// long to compute is taken from there.
pub(super) fn fill(row: &mut BuildRow, built: &Built, stage: &Stage, twin: Option<&BuildRow>) {
    let tree = stats(&built.bvh);
    row.status = Status::Ok;
    row.build_ms = Some(built.seconds.median * 1e3);
    row.build_ms_min = Some(built.seconds.min * 1e3);
    row.build_ms_max = Some(built.seconds.max * 1e3);
    row.runs = built.seconds.runs;
    row.tree_hash = Some(built.hash.to_string());
    row.inner = Some(tree.inner);
    row.leaves = Some(tree.leaves);
    row.empty = Some(tree.empty);
    row.avg_degree = tree.avg_degree;
    row.max_depth = Some(tree.max_depth);
    row.max_leaf = Some(tree.max_leaf);
    row.sah = sah(&built.bvh, SahParams::default());
    // The hash leaves boxes out, which rule Q8 can choose freely; equal SAH says that they are equal too.
    let same = twin.filter(|t| t.tree_hash == row.tree_hash && t.sah == row.sah);
    row.epo = same.map_or_else(|| epo(&built.bvh, &stage.triangles), |t| t.epo);
    row.bytes = Some(tree.bytes);
    row.q8_duplicated = Some(built.coverage.duplicated);
    row.q8_hidden = Some(built.coverage.hidden);
    row.combinations = built.count(Work::Combinations);
    row.box_unions = built.count(Work::BoxUnions);
    row.original_unions = built.count(Work::OriginalUnions);
    row.pair_distances = built.count(Work::PairDistances);
    row.nearest_searches = built.count(Work::NearestSearches);
    row.dp_steps = built.count(Work::DpSteps);
    row.search_visits = built.count(Work::SearchVisits);
    row.q8_nodes = built.count(Work::Q8Nodes) + built.count(Work::Q8AtStart);
}

/// One line about a build that has no time of its own.
pub(super) fn outcome(row: &BuildRow) -> String {
    match (row.status, row.projected_ms) {
        (Status::Projected, Some(ms)) => format!("capped, projected to {} ({})", human_seconds(ms / 1e3), row.note),
        (Status::Error, _) => format!("failed: {}", row.note),
        _ => format!("capped ({})", row.note),
    }
}
