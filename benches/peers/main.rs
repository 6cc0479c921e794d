//! Other libraries beside ours: the same triangles, the same rays, one process.
//!
//! `cargo bench --bench peers --features peers`; README.md in this folder says what is measured and how it is kept fair.

mod agreement;
mod builds;
mod bvh_crate;
#[cfg(feature = "peers-embree")]
mod embree;
mod obvhs;
mod ours;
mod parry;
mod rows;
mod subject;
mod tinybvh;
mod traces;
mod tree;
mod versions;

use builds::Effort;
use bvh_lab::geom::Ray;
use bvh_lab::lab;
use bvh_lab::scene::Scene;
use bvh_lab::trace::{Batch, HitRecord, Kernel, Query, Tracer, diffuse_rays, primary_rays, shadow_rays, trace_batch};
use clap::{Parser, ValueEnum};
use ours::Recipe;
use rows::{BuildRow, Origin, TraceRow};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use subject::Subject;
use traces::RaySet;

/// Scenes that are built and traced by default.
const SCENES: [&str; 4] = ["thesis:huge", "gen:spheres:89000", "gen:stadium:100000", "gen:hairball:200000"];
/// A scene that is only built by default.
const LARGE: &str = "gen:spheres:1000000";
/// Of the pictures that primary rays are shot for.
const PICTURE: u32 = 512;
/// Of the diffuse rays.
const SEED: u64 = 1;

/// Other libraries beside ours: builds and closest hits.
#[derive(Debug, Parser)]
#[command(name = "peers")]
struct Arguments {
    /// Scenes: thesis:LEVEL, gen:NAME:TRIANGLES[:SEED], or files [default: four, and one that is only built]
    #[arg(long, value_name = "SCENE", value_delimiter = ',')]
    scenes: Vec<String>,
    /// Only subjects whose "library preset" contains one of these words
    #[arg(long, value_name = "WORD", value_delimiter = ',')]
    subjects: Vec<String>,
    /// Builders of the laboratory, each BUILDER[:RADIUS, CLUSTER or BINS][+STEP…] [default: all modern ones, some refined]
    #[arg(long, value_name = "RECIPE", value_delimiter = ',')]
    ours: Vec<Recipe>,
    /// What is measured
    #[arg(long, value_delimiter = ',', default_values = ["builds", "traces"])]
    sections: Vec<Section>,
    /// Numbers of threads of the builds; traces have one
    #[arg(long, value_name = "N", value_delimiter = ',', default_values = ["1", "2"])]
    threads: Vec<usize>,
    /// Timed runs of each cell, at most
    #[arg(long, value_name = "N", default_value = "5")]
    repeats: usize,
    /// Seconds after which a cell is not run again
    #[arg(long, value_name = "SECONDS", default_value = "1.0")]
    enough: f64,
    /// Folder for builds.csv and traces.csv
    #[arg(long, value_name = "DIR", default_value = "target/peers")]
    out: PathBuf,
    /// What cargo passes to every benchmark
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Section {
    /// Build times and trees
    Builds,
    /// Closest hits
    Traces,
}

fn main() -> ExitCode {
    // First touches of fresh pages would otherwise be part of what is measured.
    lab::keep_freed_memory();
    match run(Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// All libraries with all presets, those that were asked for.
fn subjects(arguments: &Arguments) -> Result<Vec<Box<dyn Subject>>, String> {
    let mut all: Vec<Box<dyn Subject>> = Vec::new();
    if arguments.ours.is_empty() {
        for word in ours::default_recipes() {
            all.push(Box::new(word.parse::<Recipe>()?));
        }
    }
    all.extend(arguments.ours.iter().map(|recipe| Box::new(recipe.clone()) as Box<dyn Subject>));
    all.extend(obvhs::subjects());
    all.extend(bvh_crate::subjects());
    all.extend(parry::subjects());
    all.extend(tinybvh::subjects());
    #[cfg(feature = "peers-embree")]
    all.extend(embree::subjects()?);
    let wanted = |subject: &dyn Subject| {
        arguments.subjects.is_empty() || arguments.subjects.iter().any(|word| subject.name().contains(word.as_str()))
    };
    all.retain(|subject| wanted(&**subject));
    if all.is_empty() { Err("no subject has such a name".into()) } else { Ok(all) }
}

/// Whether every cell was in order.
fn run(arguments: Arguments) -> Result<bool, Box<dyn std::error::Error>> {
    let subjects = subjects(&arguments)?;
    let subjects: Vec<&dyn Subject> = subjects.iter().map(|subject| &**subject).collect();
    let effort = Effort { repeats: arguments.repeats, enough: Duration::try_from_secs_f64(arguments.enough)? };
    let origin = Origin { machine: lab::machine(), commit: lab::commit().into(), rust_target: rust_target() };
    println!("{}\nbvh-lab {}, Rust libraries compiled for {}", origin.machine, origin.commit, origin.rust_target);
    let scenes: Vec<(String, bool)> = if arguments.scenes.is_empty() {
        SCENES.map(|scene| (scene.into(), true)).into_iter().chain([(LARGE.into(), false)]).collect()
    } else {
        arguments.scenes.iter().map(|scene| (scene.clone(), true)).collect()
    };
    let (mut all_builds, mut all_traces) = (Vec::<BuildRow>::new(), Vec::<TraceRow>::new());
    for (name, traced) in scenes {
        let scene = Scene::load(&name)?;
        println!("\n{name}, {} triangles", scene.triangles.len());
        if arguments.sections.contains(&Section::Builds) {
            let boxes = scene.boxes();
            let mut rows = Vec::new();
            for &threads in &arguments.threads {
                rows.extend(pool(threads)?.install(|| builds::measure(&scene, &boxes, &subjects, threads, effort)));
            }
            println!("{}", rows::build_table(&rows));
            all_builds.extend(rows);
            rows::write(&arguments.out.join("builds.csv"), &origin, &all_builds)?;
        }
        if traced && arguments.sections.contains(&Section::Traces) {
            let traced: Vec<&dyn Subject> = subjects.iter().copied().filter(|subject| subject.traced()).collect();
            let sets = ray_sets(&scene)?;
            let rows = pool(1)?.install(|| traces::measure(&scene, &sets, &traced, effort));
            println!("{}", rows::trace_table(&rows));
            all_traces.extend(rows);
            rows::write(&arguments.out.join("traces.csv"), &origin, &all_traces)?;
        }
    }
    let builds_ok = all_builds.iter().all(|row| row.status == "ok");
    Ok(builds_ok && all_traces.iter().all(|row| row.status == "ok"))
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build()
}

/// Primary, diffuse and shadow rays of unit length with the laboratory's exact answers.
fn ray_sets(scene: &Scene) -> Result<Vec<RaySet>, String> {
    let reference: Recipe = REFERENCE.parse()?;
    let bvh = reference.tree(&scene.triangles)?;
    let unit = |rays: Vec<Ray>| -> Vec<Ray> {
        rays.into_iter().map(|ray| Ray { direction: ray.direction.normalize(), ..ray }).collect()
    };
    let primary = unit(primary_rays(&scene.camera, PICTURE, PICTURE));
    let diffuse = unit(diffuse_rays(&bvh, &scene.triangles, &primary, SEED));
    // Length 1 up to the light: so t ends there.
    let shadow = shadow_rays(&bvh, &scene.triangles, &primary, SEED).into_iter().map(|ray| {
        let length = ray.direction.length();
        Ray { direction: ray.direction / length, t_max: ray.t_max * length, ..ray }
    });
    let answered = |(name, query, rays): (&'static str, Query, Vec<Ray>)| {
        let mut expected = vec![HitRecord::MISS; rays.len()];
        let tracer = Tracer::new(Kernel::Scalar, &bvh, &scene.triangles);
        trace_batch(&Batch { tracer: &tracer, query, rays: &rays }, &mut expected);
        RaySet { name, query, rays, expected }
    };
    let sets = [
        ("primary", Query::Closest, primary),
        ("diffuse", Query::Closest, diffuse),
        ("shadow", Query::Any, shadow.collect()),
    ];
    Ok(sets.into_iter().map(answered).collect())
}

/// The builder of the tree that the reference's answers come from; they are those of brute force, whatever the tree.
const REFERENCE: &str = "top-down";

/// The vector instructions that rustc was allowed to use everywhere.
const fn rust_target() -> &'static str {
    if cfg!(target_feature = "avx512f") {
        "avx512"
    } else if cfg!(target_feature = "avx2") {
        "avx2"
    } else if cfg!(target_feature = "sse2") {
        "sse2"
    } else {
        "baseline"
    }
}
