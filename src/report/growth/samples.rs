//! Samples: a time beside the work that it should follow from, one cell or one build each.

use super::{Growth, milliseconds};
use crate::report::printed::{self, Flag, Model};
use crate::rows::{BuildRow, Construction, Status, WorkRow};

/// Whose times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Times {
    /// Table 2 of the thesis, corrected.
    Printed,
    /// Our literal engines.
    Ours,
}

/// A time and the counts that may explain it.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    /// Whose time.
    pub times: Times,
    /// Top-down or bottom-up.
    pub construction: Construction,
    /// Reading.
    pub preset: String,
    /// Scene.
    pub scene: String,
    /// Children per inner node.
    pub arity: usize,
    /// Triangles.
    pub triangles: f64,
    /// Seconds; of a capped cell the least that it took.
    pub seconds: f64,
    /// Combinations or distances of the literal engine.
    pub steps: Option<f64>,
    /// What the program did: box unions, or steps of its kd-tree.
    pub work: Option<f64>,
    /// How far the time can be taken at its word: only [`Flag::Printed`] and [`Flag::Corrected`] are fitted.
    pub flag: Flag,
    /// Whether the work is continued by a power law from smaller scenes.
    pub extrapolated: bool,
}

impl Sample {
    /// Whether it takes part in fits.
    pub fn fits(&self) -> bool {
        matches!(self.flag, Flag::Printed | Flag::Corrected) && !self.extrapolated
    }
}

/// The thesis gave builds up after eleven days.
pub(crate) const CAP_SECONDS: f64 = 11.0 * 24.0 * 3600.0;

impl Growth {
    /// Triangles and work of the thesis' program for one of its builds: box unions from the top down, steps of its kd-tree
    /// from the bottom up (at any arity: the collapse is left out).
    pub fn program_work(&self, scene: &str, construction: Construction, arity: usize) -> Option<(usize, f64)> {
        let arity = if construction == Construction::BottomUp { 2 } else { arity };
        let row = self.work.iter().find(|r| {
            r.preset == "published" && r.scene == scene && r.construction == construction && r.arity == arity
        })?;
        let work = match construction {
            Construction::TopDown => row.literal_unions,
            Construction::BottomUp => row.original_steps.map(|n| n as f64),
        };
        Some((row.triangles, work?))
    }

    /// The row about the work of a build; from the bottom up that of the binary tree.
    fn work_of(&self, preset: &str, scene: &str, construction: Construction, arity: usize) -> Option<&WorkRow> {
        let arity = if construction == Construction::BottomUp { 2 } else { arity };
        let is =
            |r: &&WorkRow| (&*r.preset, &*r.scene, r.construction, r.arity) == (preset, scene, construction, arity);
        self.work.iter().find(is)
    }

    /// Combinations or distances of a literal build in closed form; the chain has none.
    fn closed_form(&self, preset: &str, scene: &str, construction: Construction, arity: usize) -> Option<f64> {
        self.work_of(preset, scene, construction, arity)?.literal_steps
    }

    /// The same, the model's where there is none: it knows the number of triangles alone.
    fn literal_steps(&self, preset: &str, scene: &str, construction: Construction, arity: usize) -> Option<f64> {
        let row = self.work_of(preset, scene, construction, arity)?;
        row.literal_steps.or(Some(row.model_steps))
    }

    /// Every cell of Table 2 with the work of the program.
    pub fn printed_samples(&self) -> Vec<Sample> {
        let cells = printed::cells().iter().filter(|p| p.table == 2);
        cells
            .filter_map(|p| {
                let (construction, arity) = (p.construction?, p.arity?);
                let scene = p.model.scene();
                let replayed = self.program_work(&scene, construction, arity);
                let continued = || self.continued_kd_work(p.model).filter(|_| construction == Construction::BottomUp);
                Some(Sample {
                    times: Times::Printed,
                    construction,
                    preset: "published".into(),
                    steps: self.literal_steps("published", &scene, construction, arity),
                    scene,
                    arity,
                    triangles: p.size as f64,
                    seconds: p.reference().map_or(CAP_SECONDS, |f| f.value),
                    work: replayed.map(|w| w.1).or_else(continued),
                    flag: p.flag,
                    extrapolated: replayed.is_none(),
                })
            })
            .collect()
    }

    /// The kd-tree's work on a scene that was not replayed, by the power law through at least three that were.
    fn continued_kd_work(&self, model: Model) -> Option<f64> {
        let points: Vec<_> = Model::ALL
            .into_iter()
            .filter_map(|m| self.program_work(&m.scene(), Construction::BottomUp, 2))
            .map(|(n, work)| (n as f64, work))
            .collect();
        let law = crate::report::fit::PowerLaw::through(&points).filter(|law| law.points >= 3)?;
        let n = self.work.iter().find(|r| r.scene == model.scene())?.triangles;
        Some(law.at(n as f64))
    }

    /// Every literal build of ours that finished: the study's, and those of growing scenes.
    pub fn our_samples(&self) -> Vec<Sample> {
        let study = self.builds.iter().filter(|r| finished(r)).map(|r| Sample {
            times: Times::Ours,
            construction: r.construction,
            preset: r.preset.clone(),
            scene: r.scene.clone(),
            arity: r.arity,
            triangles: r.triangles as f64,
            seconds: r.build_ms.unwrap_or_default() / 1e3,
            steps: self
                .closed_form(&r.preset, &r.scene, r.construction, r.arity)
                .or(counted(r.combinations + r.pair_distances)),
            work: None,
            flag: Flag::Printed,
            extrapolated: false,
        });
        let growing = self.scaling.iter().filter(|r| r.engine == "literal").filter_map(|r| {
            let construction =
                [Construction::TopDown, Construction::BottomUp].into_iter().find(|c| c.id() == r.builder)?;
            Some(Sample {
                times: Times::Ours,
                construction,
                preset: r.preset.clone(),
                scene: r.scene.clone(),
                arity: r.arity,
                triangles: r.triangles as f64,
                seconds: milliseconds(r)? / 1e3,
                steps: r.literal_steps.or(counted(r.combinations + r.pair_distances)),
                work: None,
                flag: Flag::Printed,
                extrapolated: false,
            })
        });
        study.chain(growing).collect()
    }
}

fn finished(row: &BuildRow) -> bool {
    row.engine == "literal" && row.status == Status::Ok && row.build_ms.is_some_and(|ms| ms.is_finite() && ms > 0.0)
}

/// Steps that a literal build counted.
fn counted(steps: u64) -> Option<f64> {
    (steps > 0).then_some(steps as f64)
}
