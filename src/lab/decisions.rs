//! The study's cells about decisions: the tree by f32 costs beside the one by exact costs, node by node and as a whole.

use super::machine::{commit, machine, version};
use super::study::{Study, StudyError, Watch};
use super::trace_cell::Stage;
use crate::build::top_down::{Published, published_decisions};
use crate::build::{Brake, BuildError, Preset};
use crate::bvh::{Bvh, Limits, tree_hash, validate};
use crate::cost::{SahParams, epo, sah};
use crate::geom::{Aabb, Triangle};
use crate::rows::{BuildRow, Construction, DecisionRow, Lighting, RowFile, Status};
use crate::trace::{FirstLeafOptions, Reading, trace_image};
use std::time::{Duration, Instant};

/// Time that the two trees of a cell may take unless there is no budget at all.
const LONGEST: Duration = Duration::from_secs(5);

/// The arities of the thesis.
const ARITIES: [usize; 3] = [2, 4, 8];

/// What a tree is worth.
struct Worth {
    hash: String,
    sah: Option<f64>,
    epo: Option<f64>,
    nodes_per_pixel: f64,
}

/// Why a cell has no figures.
enum Unmeasured {
    Stopped,
    Wrong(String),
}

impl Study {
    /// Number of cells about decisions.
    pub(super) fn decision_cells(&self) -> usize {
        let wanted = self.scope.decisions && self.presets.contains(&Preset::Published);
        if wanted { self.scenes.len() * ARITIES.len() } else { 0 }
    }

    /// Measures every cell about decisions that is not yet among the rows; `share` tells how much of the whole study is
    /// done before a cell.
    pub(super) fn decisions(
        &self,
        stages: &[Stage],
        builds: &[BuildRow],
        share: impl Fn(usize) -> f64,
        watch: &mut dyn Watch,
    ) -> Result<(), StudyError> {
        if self.decision_cells() == 0 {
            return Ok(());
        }
        let mut rows = RowFile::<DecisionRow>::open(&self.rows)?;
        let cells = self.scenes.iter().zip(stages).flat_map(|cell| ARITIES.map(|arity| (cell, arity)));
        for (done, ((scene, stage), arity)) in cells.enumerate() {
            let cell = format!("decisions {scene} arity {arity}");
            watch.begin(&cell, share(done));
            let mut row = self.empty_row(scene, stage, arity);
            if rows.get(crate::rows::Row::key(&row).as_str()).is_some_and(|known| settled(known, &row)) {
                continue;
            }
            match self.measure(&mut row, stage, builds) {
                Ok(()) => row.status = Status::Ok,
                Err(Unmeasured::Stopped) => row.note = "stopped by its budget".into(),
                Err(Unmeasured::Wrong(why)) => (row.status, row.note) = (Status::Error, why),
            }
            if row.status != Status::Ok {
                watch.say(&format!("{cell}: {}", row.note));
            }
            rows.put(row)?;
        }
        Ok(())
    }

    fn empty_row(&self, scene: &str, stage: &Stage, arity: usize) -> DecisionRow {
        DecisionRow {
            preset: Preset::Published.id().into(),
            scene: scene.into(),
            triangles: stage.triangles.len(),
            scene_hash: stage.hash.clone(),
            arity,
            status: Status::Capped,
            budget_s: self.budget.map(|b| b.min(LONGEST).as_secs_f64()),
            note: String::new(),
            compared: None,
            different: None,
            rounded_ties: None,
            same_cost: None,
            largest_excess: None,
            exact_tree_hash: None,
            f32_tree_hash: None,
            exact_sah: None,
            f32_sah: None,
            exact_epo: None,
            f32_epo: None,
            exact_nodes_per_pixel: None,
            f32_nodes_per_pixel: None,
            threads: 1,
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        }
    }

    fn measure(&self, row: &mut DecisionRow, stage: &Stage, builds: &[BuildRow]) -> Result<(), Unmeasured> {
        let limit = self.budget.map(|b| b.min(LONGEST));
        let mut brake = Brake::new(limit.map(|l| Instant::now() + l));
        let params = Published::at_arity(row.arity);
        let boxes: Vec<Aabb> = stage.triangles.iter().map(Triangle::aabb).collect();
        let (exact, decisions) = published_decisions::compare(&boxes, &params, &mut brake)?;
        let single = published_decisions::build_single(&boxes, &params, &mut brake)?;
        let exact = worth(&exact, stage, &boxes)?;
        let single = worth(&single, stage, &boxes)?;
        // Whichever engine built it.
        let mut built = builds.iter().filter(|b| {
            (b.preset.as_str(), b.scene.as_str(), b.construction, b.arity, b.status)
                == (&row.preset, &row.scene, Construction::TopDown, row.arity, Status::Ok)
        });
        if built.any(|b| b.tree_hash.as_ref() != Some(&exact.hash)) {
            return Err(Unmeasured::Wrong("its exact tree is not the one of the build's row".into()));
        }
        row.compared = Some(decisions.compared);
        row.different = Some(decisions.different);
        row.rounded_ties = Some(decisions.rounded_ties);
        row.same_cost = Some(decisions.same_cost);
        row.largest_excess = Some(decisions.largest_excess);
        (row.exact_tree_hash, row.f32_tree_hash) = (Some(exact.hash), Some(single.hash));
        (row.exact_sah, row.f32_sah) = (exact.sah, single.sah);
        (row.exact_epo, row.f32_epo) = (exact.epo, single.epo);
        row.exact_nodes_per_pixel = Some(exact.nodes_per_pixel);
        row.f32_nodes_per_pixel = Some(single.nodes_per_pixel);
        Ok(())
    }
}

impl From<BuildError> for Unmeasured {
    fn from(e: BuildError) -> Self {
        match e {
            BuildError::Stopped(_) => Self::Stopped,
            other => Self::Wrong(other.to_string()),
        }
    }
}

/// Whether a row needs no second measurement: `wanted` is the same cell without figures, with the budget there is now.
fn settled(known: &DecisionRow, wanted: &DecisionRow) -> bool {
    let seconds = wanted.budget_s.unwrap_or(f64::INFINITY);
    known.scene_hash == wanted.scene_hash
        && match known.status {
            Status::Ok => true,
            Status::Capped | Status::Projected => known.budget_s.is_none_or(|b| b >= seconds),
            Status::Error => false,
        }
}

/// Verifies a tree, then takes its figures.
fn worth(bvh: &Bvh, stage: &Stage, boxes: &[Aabb]) -> Result<Worth, Unmeasured> {
    let limits = Limits { q8: bvh.arity == 8, ..Limits::default() };
    let coverage = validate(bvh, boxes, &limits).map_err(|v| Unmeasured::Wrong(v.to_string()))?;
    if coverage.hidden == 0 {
        stage.verify(bvh).map_err(Unmeasured::Wrong)?;
    }
    let counts = trace_image(&stage.view(bvh), Lighting::Primary, Reading::Published(FirstLeafOptions::default()));
    Ok(Worth {
        hash: tree_hash(bvh).to_string(),
        sah: sah(bvh, SahParams::default()),
        epo: epo(bvh, &stage.triangles),
        nodes_per_pixel: counts.nodes as f64 / counts.pixels as f64,
    })
}
