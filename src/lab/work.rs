//! The work of the thesis' program on its own scenes, without a time: closed forms over the trees that an exact engine
//! builds at once, and the replay of the program's kd-tree.

use super::closed_form::literal_work;
use super::machine::{commit, version};
use super::projection::Model;
use super::replay::sampled_work;
use super::scaling::triangles_hash;
use super::study::StudyError;
use crate::build::{self, Brake, BuildOptions, Builder, Input, Preset};
use crate::bvh::{Bvh, tree_hash};
use crate::geom::Aabb;
use crate::rows::{Construction, Row, RowFile, WorkRow};
use crate::scene::Scene;
use std::path::Path;
use std::time::{Duration, Instant};

/// The closed forms of a set of scenes.
pub(super) struct WorkStudy<'a> {
    /// Folder of the row files.
    pub rows: &'a Path,
    /// Seconds that one tree, or one replay, may take.
    pub budget: Duration,
    /// Readings.
    pub presets: &'a [Preset],
}

impl WorkStudy<'_> {
    /// Puts down every row that is not there. `begin` is told each cell, and what share is done.
    ///
    /// # Errors
    /// Scenes that cannot be had, rows that cannot be read or written.
    pub fn run(&self, scenes: &[String], begin: &mut dyn FnMut(&str, f64)) -> Result<(), StudyError> {
        let mut rows = RowFile::<WorkRow>::open(self.rows)?;
        for (i, name) in scenes.iter().enumerate() {
            let scene = Scene::load(name)?;
            let (boxes, hash) = (scene.boxes(), triangles_hash(&scene.triangles));
            for (construction, options) in self.cells() {
                let row = empty_row(name, boxes.len(), &hash, construction, options);
                let settled = |r: &&WorkRow| {
                    r.scene_hash == hash
                        && (r.note.is_empty() || r.budget_s.is_none_or(|b| b >= self.budget.as_secs_f64()))
                };
                if rows.get(&row.key()).is_some_and(|r| settled(&r)) {
                    continue;
                }
                let cell = format!("work of {} {name} {} arity {}", row.preset, construction.id(), row.arity);
                begin(&cell, i as f64 / scenes.len() as f64);
                rows.put(self.count(row, &boxes, construction, options, rows.rows()))?;
            }
        }
        Ok(())
    }

    fn cells(&self) -> Vec<(Construction, BuildOptions)> {
        let mut cells = Vec::new();
        for (construction, arities) in [(Construction::TopDown, &[2, 4, 8][..]), (Construction::BottomUp, &[2])] {
            let presets = build::find(construction.id()).map_or(&[][..], |b| b.presets);
            for &preset in presets.iter().filter(|p| self.presets.contains(p)) {
                let options = |&arity| (construction, BuildOptions { arity, preset, ..BuildOptions::default() });
                cells.extend(arities.iter().map(options));
            }
        }
        cells
    }

    fn count(
        &self,
        mut row: WorkRow,
        boxes: &[Aabb],
        construction: Construction,
        options: BuildOptions,
        known: &[WorkRow],
    ) -> WorkRow {
        row.budget_s = Some(self.budget.as_secs_f64());
        if (construction, options.preset) == (Construction::BottomUp, Preset::Published) {
            self.replay(&mut row, boxes, known);
            return row;
        }
        let builder = build::find(construction.id()).expect("both constructions are registered");
        match self.tree(builder, options, boxes) {
            Some(bvh) => {
                let work = literal_work(&bvh, construction, &options).unwrap_or_default();
                row.tree_hash = Some(tree_hash(&bvh).to_string());
                row.literal_steps = Some(work.steps);
                row.literal_unions = Some(work.unions).filter(|&u| u > 0.0);
            }
            None => row.note = "no engine built the tree within the budget".into(),
        }
        row
    }

    /// The tree by the first engine that has it in time.
    fn tree(&self, builder: &Builder, options: BuildOptions, boxes: &[Aabb]) -> Option<Bvh> {
        builder.engines.iter().find_map(|&engine| {
            let mut brake = Brake::new(Instant::now().checked_add(self.budget));
            (builder.timed)(Input::of_boxes(boxes), &BuildOptions { engine, ..options }, &mut brake).ok()
        })
    }

    /// Replays the program's kd-tree, unless the greatest smaller scene shows that it would take too long.
    fn replay(&self, row: &mut WorkRow, boxes: &[Aabb], known: &[WorkRow]) {
        let tried = |r: &&WorkRow| {
            r.triangles < row.triangles && (&r.preset, r.construction) == (&row.preset, row.construction)
        };
        if known.iter().filter(tried).any(|r| r.original_steps.is_none()) {
            row.note = "not replayed: a smaller scene passed the budget".into();
            return;
        }
        let every = one_in(boxes.len());
        match sampled_work(boxes, every, Instant::now().checked_add(self.budget)) {
            Ok(Some(work)) => {
                row.original_every = Some(every);
                row.original_queries = Some(work.queries);
                row.original_visits = Some(work.visited);
                row.original_list_steps = Some(work.list_steps);
                row.original_steps = Some(work.steps());
            }
            Ok(None) => row.note = "the replay was stopped by its budget".into(),
            Err(why) => row.note = why,
        }
    }
}

/// One search in how many is replayed over `n` triangles: all of them on small scenes; beyond, so few that the whole costs
/// about the same, as both the number of searches and the cost of one grow with n.
fn one_in(n: usize) -> u64 {
    /// Triangles up to which all searches are made.
    const ALL: f64 = 4000.0;
    ((n as f64 / ALL).powi(2).round() as u64).max(1)
}

fn empty_row(scene: &str, n: usize, hash: &str, construction: Construction, options: BuildOptions) -> WorkRow {
    WorkRow {
        preset: options.preset.id().into(),
        scene: scene.into(),
        triangles: n,
        scene_hash: hash.into(),
        construction,
        arity: options.arity,
        tree_hash: None,
        model_steps: Model::new(construction, options).steps(n),
        literal_steps: None,
        literal_unions: None,
        original_every: None,
        original_queries: None,
        original_visits: None,
        original_list_steps: None,
        original_steps: None,
        budget_s: None,
        note: String::new(),
        version: version().into(),
        commit: commit().into(),
    }
}
