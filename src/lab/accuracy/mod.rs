//! What accuracy costs in time: more candidates, more neighbours, truer hits, tighter boxes, each against the time it takes.
//!
//! Everything that is compared with each other on one scene is one group: first every tree is built, verified and counted,
//! then builds and traces are timed in turns, so that a disturbance of the machine meets all settings alike. A group's rows
//! are on disk before the next group begins; a second run goes on from there.

mod hits;
mod plan;
mod trees;

use super::aside::set_aside_other_versions;
use super::leaf_counts::RAY_SEED;
use super::lock::Lock;
use super::machine::{commit, machine, version};
use super::scaling::triangles_hash;
use super::study::{StudyError, Watch};
use super::trace_cell::Stage;
use crate::build::{self, Brake, BuildOptions, Input};
use crate::geom::Ray;
use crate::rows::{AccuracyRow, Row, RowError, RowFile, Status};
use crate::scene::Scene;
use crate::trace::{diffuse_rays, primary_rays};
use std::path::PathBuf;
use std::time::Duration;

pub use plan::Part;

/// Scenes unless the user names some: the thesis' greatest but one, and two of other natures.
pub const ACCURACY_SCENES: [&str; 3] = ["thesis:large", "gen:spheres:20000", "gen:hairball:20000"];

/// Seconds that one build may take unless the user says otherwise.
pub const ACCURACY_BUDGET: Duration = Duration::from_secs(5);

/// What is to be measured, and where the rows go.
#[derive(Clone, Debug)]
pub struct AccuracyStudy {
    /// Folder of the row files.
    pub rows: PathBuf,
    /// Scenes.
    pub scenes: Vec<String>,
    /// Parts of the study; each is a group a scene.
    pub parts: Vec<Part>,
    /// Seconds that one build may take; a setting that takes longer is capped.
    pub budget: Duration,
    /// Timed runs of every setting.
    pub runs: usize,
    /// Threads.
    pub threads: usize,
    /// Pixels of the camera's rays, from which the others start.
    pub size: (u32, u32),
}

/// A scene with its rays.
struct Subject {
    stage: Stage,
    primary: Vec<Ray>,
    diffuse: Vec<Ray>,
}

impl AccuracyStudy {
    /// Measures every group that is not yet among the rows.
    ///
    /// # Errors
    /// Scenes that cannot be had, rows that cannot be read or written; a setting that fails becomes a row instead.
    pub fn run(&self, watch: &mut dyn Watch) -> Result<(), StudyError> {
        // A scene that cannot be had is told before any row is touched.
        for scene in &self.scenes {
            Scene::load(scene)?;
        }
        let _lock = Lock::take(&self.rows)?;
        set_aside_other_versions(&self.rows, watch)?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads.max(1)).build().map_err(|e| {
            RowError::Io { what: "start threads for", path: self.rows.clone(), source: std::io::Error::other(e) }
        })?;
        let mut rows = RowFile::<AccuracyRow>::open(&self.rows)?;
        let groups = self.scenes.len() * self.parts.len();
        for (s, scene) in self.scenes.iter().enumerate() {
            let scene = Scene::load(scene)?;
            let hash = triangles_hash(&scene.triangles);
            let mut subject = None;
            for (p, part) in self.parts.iter().enumerate() {
                let done = s * self.parts.len() + p;
                watch.begin(&format!("{}, {}", scene.name, part.id()), done as f64 / groups as f64);
                let wanted = part.settings();
                let settled = |row: &AccuracyRow| {
                    rows.get(&row.key()).is_some_and(|known| {
                        known.scene_hash == hash
                            && known.threads == row.threads
                            && known.status != Status::Error
                            && (known.status == Status::Ok || known.budget_s >= row.budget_s)
                    })
                };
                let empty: Vec<_> = wanted
                    .iter()
                    .map(|setting| self.empty_row(setting, &scene.name, &hash, scene.triangles.len()))
                    .collect();
                if empty.iter().all(settled) {
                    continue;
                }
                let subject = subject.get_or_insert_with(|| pool.install(|| self.subject(&scene)));
                let measured = pool.install(|| match part {
                    Part::Intersection => hits::measure(self, subject, empty),
                    _ => trees::measure(self, subject, wanted.iter().zip(empty).collect()),
                });
                for row in measured {
                    if row.status == Status::Error {
                        watch.say(&format!("{}, {} {}: failed: {}", row.scene, row.study, row.method, row.note));
                    }
                    rows.put(row)?;
                }
            }
        }
        Ok(())
    }

    fn subject(&self, scene: &Scene) -> Subject {
        let stage = Stage::new(scene);
        let primary = primary_rays(&scene.camera, self.size.0, self.size.1);
        let tree = reference_tree(&stage);
        let diffuse = diffuse_rays(&tree, &stage.triangles, &primary, RAY_SEED);
        Subject { stage, primary, diffuse }
    }

    fn empty_row(&self, setting: &plan::Setting, scene: &str, hash: &str, triangles: usize) -> AccuracyRow {
        AccuracyRow {
            study: setting.part.id().into(),
            scene: scene.into(),
            triangles,
            scene_hash: hash.into(),
            method: setting.method.clone(),
            setting: setting.number,
            arity: setting.options.arity,
            rays: setting.rays.into(),
            status: Status::Capped,
            budget_s: self.budget.as_secs_f64(),
            note: String::new(),
            build_ms: None,
            build_ms_min: None,
            build_ms_max: None,
            runs: 0,
            tree_hash: None,
            sah: None,
            bytes: None,
            traced: None,
            mrays_per_s: None,
            mrays_per_s_min: None,
            mrays_per_s_max: None,
            nodes_per_ray: None,
            box_tests_per_ray: None,
            tri_tests_per_ray: None,
            missed: None,
            other: None,
            off: None,
            largest_ulp: None,
            oracle_rays: None,
            compared: None,
            different: None,
            largest_excess: None,
            threads: self.threads.max(1),
            machine: machine(),
            version: version().into(),
            commit: commit().into(),
        }
    }
}

impl Subject {
    fn rays(&self, kind: &str) -> &[Ray] {
        if kind == "primary" { &self.primary } else { &self.diffuse }
    }
}

/// The tree through which rays are drawn and kernels are compared.
fn reference_tree(stage: &Stage) -> crate::bvh::Bvh {
    let boxes: Vec<_> = stage.triangles.iter().map(crate::geom::Triangle::aabb).collect();
    let builder = build::find("sweep-sah").expect("it is registered");
    (builder.timed)(Input::of_triangles(&stage.triangles, &boxes), &BuildOptions::default(), &mut Brake::default())
        .expect("a scene that was loaded has triangles, and no budget stops this build")
}
