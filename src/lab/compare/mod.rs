//! Builders side by side: every contestant verified, then all of them timed in turn, round by round.
//!
//! Times of two builders compare only if both were taken under the same conditions, and a machine is never quiet for long: so a
//! round builds once with every contestant, and whatever disturbs it disturbs all alike. The same holds for tracing. A scene is
//! measured as a whole or, where all its rows are there already, not at all.

mod contest;
mod reference;
mod standard;

pub use standard::standard_recipes;

use super::aside::set_aside_other_versions;
use super::lock::Lock;
use super::machine::{commit, machine, version};
use super::measure::Repeats;
use super::scaling::triangles_hash;
use super::study::Watch;
use crate::build::{BuildOptions, Builder, Engine, Preset};
use crate::bvh::file::SavedTree;
use crate::bvh::tree_hash;
use crate::rows::{CompareRow, Row, RowError, RowFile, Status};
use crate::scene::Scene;
use crate::trace::Kernel;
use contest::Contest;
use std::path::PathBuf;
use std::time::Duration;

/// Who takes part.
#[derive(Clone, Debug)]
pub enum Contestant {
    /// A builder.
    Recipe {
        /// Its entry in the register.
        builder: &'static Builder,
        /// Its options, steps and arity included.
        options: BuildOptions,
    },
    /// A tree that was built elsewhere: it has no time.
    Tree {
        /// What rows call it.
        name: String,
        /// The tree, read and checked against its scene.
        tree: Box<SavedTree>,
    },
}

/// What is compared, and how.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Who takes part, in the order of the rows.
    pub contestants: Vec<Contestant>,
    /// Folder of the row files; rows of an earlier run are taken from there. Nothing is kept if `None`.
    pub rows: Option<PathBuf>,
    /// Seconds that one build may take.
    pub budget: Duration,
    /// Rounds of builds, and of traces.
    pub repeats: Repeats,
    /// The kernel, one of those whose answers do not depend on the tree ([`Kernel::is_exact`]).
    pub kernel: Kernel,
    /// Its id.
    pub kernel_id: String,
    /// Pixels of the camera's rays.
    pub size: (u32, u32),
}

impl Comparison {
    /// Rows of every scene, in the order of the contestants. A contestant that fails has an error row.
    ///
    /// # Errors
    /// Rows that cannot be read or written.
    pub fn run(&self, scenes: &[Scene], watch: &mut dyn Watch) -> Result<Vec<Vec<CompareRow>>, RowError> {
        let (_lock, mut file) = match &self.rows {
            Some(dir) => {
                let lock = Lock::take(dir)?;
                set_aside_other_versions(dir, watch)?;
                (Some(lock), Some(RowFile::<CompareRow>::open(dir)?))
            }
            None => (None, None),
        };
        let mut all = Vec::new();
        for (i, scene) in scenes.iter().enumerate() {
            let empty: Vec<_> = self.contestants.iter().map(|c| self.empty_row(c, scene)).collect();
            let known = |row: &CompareRow| file.as_ref()?.get(&row.key()).filter(|k| self.is_settled(k, row)).cloned();
            if let Some(rows) = empty.iter().map(known).collect::<Option<Vec<_>>>() {
                watch.say(&format!("{}: measured before, in {}", scene.name, CompareRow::FILE));
                all.push(rows);
                continue;
            }
            let share = |of_scene: f64| (i as f64 + of_scene) / scenes.len() as f64;
            let rows = Contest::new(self, scene, empty).run(&mut |what, done| {
                watch.begin(&format!("{}: {what}", scene.name), share(done));
            });
            for row in &rows {
                if row.status == Status::Error {
                    watch.say(&format!("{}: failed: {}", row.key(), row.note));
                }
                if let Some(file) = &mut file {
                    file.put(row.clone())?;
                }
            }
            all.push(rows);
        }
        Ok(all)
    }

    /// Whether a known row answers what `wanted`, still without figures, asks for: the same triangles under the same conditions.
    fn is_settled(&self, known: &CompareRow, wanted: &CompareRow) -> bool {
        let conditions = |r: &CompareRow| {
            (r.scene_hash.clone(), r.kernel.clone(), r.pixels.clone(), r.threads, r.trace_threads, r.machine.clone())
        };
        let finished = match known.status {
            Status::Ok => true,
            Status::Capped | Status::Projected => known.budget_s >= wanted.budget_s,
            Status::Error => false,
        };
        let same_tree = wanted.tree_hash.is_none() || wanted.tree_hash == known.tree_hash;
        let runs_enough = self.repeats.enough < Duration::MAX || known.primary_runs >= self.repeats.runs;
        finished && same_tree && runs_enough && conditions(known) == conditions(wanted)
    }

    fn empty_row(&self, contestant: &Contestant, scene: &Scene) -> CompareRow {
        let threads = rayon::current_num_threads();
        let blank = CompareRow {
            scene: scene.name.clone(),
            triangles: scene.triangles.len(),
            scene_hash: triangles_hash(&scene.triangles),
            recipe: String::new(),
            builder: String::new(),
            preset: String::new(),
            engine: String::new(),
            arity: 0,
            leaf_limit: 0,
            status: Status::Capped,
            budget_s: None,
            note: String::new(),
            build_ms: None,
            build_ms_min: None,
            build_ms_max: None,
            build_runs: 0,
            projected_ms: None,
            tree_hash: None,
            inner: None,
            leaves: None,
            empty: None,
            avg_degree: None,
            max_depth: None,
            max_leaf: None,
            references: None,
            duplicated: None,
            hidden: None,
            sah: None,
            epo: None,
            lcv: None,
            bytes: None,
            peak_bytes: None,
            counters: String::new(),
            kernel: self.kernel_id.clone(),
            pixels: format!("{}x{}", self.size.0, self.size.1),
            primary_rays: 0,
            primary_nodes: None,
            primary_box_tests: None,
            primary_tri_tests: None,
            primary_mrays: None,
            primary_mrays_min: None,
            primary_mrays_max: None,
            primary_runs: 0,
            primary_hit_hash: None,
            diffuse_rays: 0,
            diffuse_nodes: None,
            diffuse_box_tests: None,
            diffuse_tri_tests: None,
            diffuse_mrays: None,
            diffuse_mrays_min: None,
            diffuse_mrays_max: None,
            diffuse_runs: 0,
            diffuse_hit_hash: None,
            threads,
            trace_threads: threads,
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        };
        match contestant {
            Contestant::Recipe { builder, options } => CompareRow {
                recipe: format!("{}{}", builder.id, options.refine),
                builder: builder.id.into(),
                preset: builder.preset(options).map_or("", Preset::id).into(),
                engine: builder.engine(options).map_or("", Engine::id).into(),
                arity: options.arity,
                leaf_limit: builder.limits(options).max_leaf,
                budget_s: Some(self.budget.as_secs_f64()),
                threads: builder.threads(options),
                ..blank
            },
            Contestant::Tree { name, tree } => CompareRow {
                recipe: name.clone(),
                builder: "file".into(),
                arity: tree.bvh.arity,
                leaf_limit: tree.limits.max_leaf,
                tree_hash: Some(tree_hash(&tree.bvh).to_string()),
                ..blank
            },
        }
    }
}
