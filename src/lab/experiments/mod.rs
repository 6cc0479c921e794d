//! Experiments: the thesis' findings put to the test, one tree a row.
//!
//! A scene is loaded once and its cells follow each other; each is verified, measured and on disk before the next one begins, and a
//! second run goes on from there.

mod measure;
mod pixels;
mod plan;

use super::machine::{commit, machine, version};
use super::study::{Study, StudyError, Watch};
use super::trace_cell::Stage;
use crate::rows::{Experiment, ExperimentRow, Row, RowFile, Status};
use crate::scene::Scene;
use measure::Subject;
use plan::{Cell, Make, Use};

pub use pixels::PIXELS_FILE;

/// Scenes of other natures than the thesis', of which the conjecture is asked besides.
pub const OTHER_SCENES: [&str; 5] =
    ["gen:spheres:10000", "gen:terrain:10000", "gen:soup:10000", "gen:stadium:10000", "gen:hairball:10000"];

impl Study {
    /// The scenes of the experiments: the study's, and where those are the thesis', others too.
    fn experiment_scenes(&self) -> Vec<String> {
        let others = self.scenes.iter().map(String::as_str).eq(super::SCENES);
        let others = if others { &OTHER_SCENES[..] } else { &[] };
        self.scenes.iter().cloned().chain(others.iter().map(|s| (*s).to_owned())).collect()
    }

    /// Makes every experiment that is wanted and not yet among the rows.
    ///
    /// # Errors
    /// Scenes that cannot be had, rows that cannot be read or written; a cell that fails becomes a row instead.
    pub(super) fn experiments(&self, watch: &mut dyn Watch) -> Result<(), StudyError> {
        if self.scope.experiments.is_empty() {
            return Ok(());
        }
        let mut rows = RowFile::<ExperimentRow>::open(&self.rows)?;
        let scenes = self.experiment_scenes();
        for (i, name) in scenes.iter().enumerate() {
            watch.begin(&format!("experiments on {name}"), i as f64 / scenes.len() as f64);
            let scene = Scene::load(name)?;
            let stage = Stage::new(&scene);
            let wanted = self.scope.experiments.iter().flat_map(|e| plan::cells(*e, name, stage.triangles.len()));
            let open: Vec<(Cell, ExperimentRow)> = wanted
                .map(|cell| (self.empty_experiment_row(&cell, name, &stage), cell))
                .filter(|(row, _)| !rows.get(&row.key()).is_some_and(|known| settled(known, row)))
                .map(|(row, cell)| (cell, row))
                .collect();
            if open.is_empty() && !self.wants_pixels(name) {
                continue;
            }
            let mut subject = Subject::new(&stage);
            for (cell, mut row) in open {
                watch.begin(&row.key(), i as f64 / scenes.len() as f64);
                if let Err(why) = subject.measure(&cell, &mut row) {
                    (row.status, row.note) = why;
                    watch.say(&format!("{}: {}", row.key(), row.note));
                }
                rows.put(row)?;
            }
            if self.wants_pixels(name) {
                pixels::picture(&self.rows, &subject)?;
            }
        }
        Ok(())
    }

    /// Whether the picture of wrong pixels is of this scene.
    fn wants_pixels(&self, scene: &str) -> bool {
        scene == pixels::SCENE && self.scope.experiments.contains(&Experiment::FirstLeaf)
    }

    fn empty_experiment_row(&self, cell: &Cell, scene: &str, stage: &Stage) -> ExperimentRow {
        let (builder, preset, arity, candidates) = match cell.make {
            Make::Builder(id, o) | Make::Collapsed(id, o, _) => {
                let has = crate::build::find(id).and_then(|b| b.preset(&o));
                (id, has.map_or("", |p| p.id()), o.arity, o.candidates)
            }
            Make::OneAxis(o) => ("one-axis", "", o.arity, Some(o.candidates)),
        };
        ExperimentRow {
            experiment: cell.experiment,
            scene: scene.into(),
            triangles: stage.triangles.len(),
            scene_hash: stage.hash.clone(),
            builder: builder.into(),
            preset: preset.into(),
            arity,
            setting: cell.setting.clone(),
            candidates,
            lighting: cell.lighting,
            status: Status::Capped,
            budget_s: self.budget.map(|b| b.as_secs_f64()),
            note: String::new(),
            build_ms: None,
            tree_hash: None,
            inner: None,
            leaves: None,
            avg_degree: None,
            sah: None,
            kernel: cell.action.kernel().into(),
            us_per_pixel: None,
            us_per_pixel_min: None,
            us_per_pixel_max: None,
            wide_us_per_pixel: None,
            nodes_per_pixel: None,
            box_tests_per_pixel: None,
            triangle_tests_per_pixel: None,
            hit_fraction: None,
            rays: None,
            cut: None,
            farther: None,
            missed: None,
            extra: None,
            q8_nodes: None,
            q8_duplicated: None,
            q8_hidden: None,
            threads: 1,
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        }
    }
}

impl Use {
    const fn kernel(self) -> &'static str {
        match self {
            Self::TimeCollapse => "",
            Self::Count(reading) | Self::Compare(reading) | Self::Time { reading, .. } => match reading {
                crate::trace::Reading::Published(_) => "first-leaf",
                crate::trace::Reading::Text => "scalar",
            },
        }
    }
}

/// Whether a row needs no second measurement: `wanted` is the same cell without figures, with the budget there is now.
fn settled(known: &ExperimentRow, wanted: &ExperimentRow) -> bool {
    let seconds = wanted.budget_s.unwrap_or(f64::INFINITY);
    known.scene_hash == wanted.scene_hash
        && match known.status {
            Status::Ok => true,
            Status::Capped | Status::Projected => known.budget_s.is_none_or(|b| b >= seconds),
            Status::Error => false,
        }
}
