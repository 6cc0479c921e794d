//! Rows of experiments, looked up and put into proportion: what claims, tables and figures about them share.

use crate::report::printed::{self, Model};
use crate::rows::{Construction, Experiment, ExperimentRow, Lighting, Status};

/// The finished rows of a report.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Experiments<'a>(pub &'a [ExperimentRow]);

/// What a row is asked for.
pub(crate) type Figure = fn(&ExperimentRow) -> Option<f64>;

/// Box and triangle tests per pixel.
pub(crate) fn tests(row: &ExperimentRow) -> Option<f64> {
    Some(row.box_tests_per_pixel? + row.triangle_tests_per_pixel?)
}

/// Pixels that do not see the closest surface.
pub(crate) fn wrong(row: &ExperimentRow) -> Option<usize> {
    Some(row.farther? + row.missed? + row.extra?)
}

impl<'a> Experiments<'a> {
    /// Finished rows of one experiment.
    pub fn of(self, experiment: Experiment) -> impl Iterator<Item = &'a ExperimentRow> {
        self.0.iter().filter(move |r| r.experiment == experiment && r.status == Status::Ok)
    }

    /// One tree of the thesis' kinds.
    pub fn tree(
        self,
        experiment: Experiment,
        scene: &str,
        (construction, arity): (Construction, usize),
        setting: &str,
    ) -> Option<&'a ExperimentRow> {
        self.of(experiment)
            .find(|r| r.scene == scene && r.builder == construction.id() && r.arity == arity && r.setting == setting)
    }

    /// Scenes of an experiment, in the order in which they were measured.
    pub fn scenes(self, experiment: Experiment) -> Vec<&'a str> {
        let mut scenes: Vec<&str> = Vec::new();
        for row in self.of(experiment) {
            if !scenes.contains(&&*row.scene) {
                scenes.push(&row.scene);
            }
        }
        scenes
    }

    /// The row of a top-down search with so many candidates, by experiment.
    pub fn search(
        self,
        experiment: Experiment,
        scene: &str,
        preset: &str,
        (arity, candidates): (usize, usize),
    ) -> Option<&'a ExperimentRow> {
        self.of(experiment)
            .find(|r| r.scene == scene && r.preset == preset && (r.arity, r.candidates) == (arity, Some(candidates)))
    }

    /// The row of a builder of another kind, on a scene of the conjecture.
    pub fn yardstick(self, scene: &str, builder: &str, arity: usize) -> Option<&'a ExperimentRow> {
        self.of(Experiment::Conjecture).find(|r| r.scene == scene && r.builder == builder && r.arity == arity)
    }

    /// Numbers of candidates that were tried on a scene, rising, with the tree's cost.
    pub fn sweep(self, scene: &str, preset: &str, arity: usize) -> Vec<(usize, f64)> {
        let rows = self.of(Experiment::Candidates);
        let rows = rows.filter(|r| r.scene == scene && r.preset == preset && r.arity == arity);
        let mut points: Vec<(usize, f64)> = rows.filter_map(|r| Some((r.candidates?, r.sah?))).collect();
        points.sort_by_key(|p| p.0);
        points
    }

    /// Every reading with its distance from the printed nodes per pixel, the nearest first.
    pub fn readings(self) -> Vec<Reading> {
        let mut readings: Vec<Reading> = Vec::new();
        for row in self.of(Experiment::Readings) {
            let construction = match row.builder.as_str() {
                "bottom-up" => Construction::BottomUp,
                _ => Construction::TopDown,
            };
            let model = Model::ALL.into_iter().find(|m| m.scene() == row.scene);
            let printed = model.and_then(|m| printed_nodes(m, construction, row.arity));
            let Some(ratio) = row.nodes_per_pixel.zip(printed).map(|(ours, theirs)| ours / theirs) else { continue };
            let known = readings.iter_mut().find(|r| r.construction == construction && r.name == row.setting);
            match known {
                Some(reading) => reading.ratios.push(ratio),
                None => readings.push(Reading { construction, name: row.setting.clone(), ratios: vec![ratio] }),
            }
        }
        readings.sort_by(|a, b| a.construction.cmp(&b.construction).then(a.distance().total_cmp(&b.distance())));
        readings
    }
}

/// A reading of what the text leaves open.
#[derive(Clone, Debug)]
pub(crate) struct Reading {
    /// Top-down or bottom-up.
    pub construction: Construction,
    /// What it reads how.
    pub name: String,
    /// Nodes per pixel, ours ÷ printed, cell by cell.
    pub ratios: Vec<f64>,
}

impl Reading {
    /// exp(mean |ln ratio|) − 1.
    pub fn distance(&self) -> f64 {
        let sum: f64 = self.ratios.iter().map(|r| r.ln().abs()).sum();
        (sum / self.ratios.len() as f64).exp() - 1.0
    }
}

fn printed_nodes(model: Model, construction: Construction, arity: usize) -> Option<f64> {
    let key = (5, model, Some(construction), Some(arity));
    let cell = printed::cells().iter().find(|c| (c.table, c.model, c.construction, c.arity) == key);
    cell?.reference().map(|f| f.value)
}

/// Rows of one lighting case.
pub(crate) fn lit<'a>(
    rows: Experiments<'a>,
    experiment: Experiment,
    scene: &'a str,
    (construction, arity): (Construction, usize),
    lighting: Lighting,
) -> Option<&'a ExperimentRow> {
    rows.of(experiment)
        .find(|r| r.scene == scene && r.builder == construction.id() && (r.arity, r.lighting) == (arity, lighting))
}
