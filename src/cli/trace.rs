//! `bvh-lab trace`: rays per second and work per ray, through one tree.

use super::arguments::{RayWord, TraceArguments, TreeArguments};
use super::build::{load, repeats, set_threads};
use super::output::{json, say, short, spread_text};
use super::tree_file;
use super::{Failure, Outcome, off, wrong};
use bvh_lab::build::{Brake, Engine, Input, Preset};
use bvh_lab::bvh::{Bvh, tree_hash};
use bvh_lab::geom::Ray;
use bvh_lab::lab::{RAY_SEED, Repeats, human_seconds, repeat};
use bvh_lab::rows::Spread;
use bvh_lab::scene::Scene;
use bvh_lab::trace::{
    Batch, Query, Tracer, count_batch, diffuse_rays, hit_hash, primary_rays, read_rays, shadow_rays, trace_batch,
    write_hits,
};
use serde::Serialize;

/// The JSON object of `trace`.
#[derive(Debug, Serialize)]
struct TraceReport {
    scene: String,
    triangles: usize,
    dropped: usize,
    /// `file` where the tree came from one.
    builder: &'static str,
    tree: Option<String>,
    arity: usize,
    refine: String,
    preset: Option<&'static str>,
    engine: Option<&'static str>,
    tree_hash: String,
    threads: usize,
    kernel: String,
    /// Laying the tree out as the kernel wants it.
    prepare_ms: f64,
    /// Of what the kernel walks: its own layout with triangles, or the tree without them.
    kernel_bytes: usize,
    rays: usize,
    /// Rays with NaN, infinity, no direction or an empty interval: documented misses.
    untraceable_rays: usize,
    ray_kind: &'static str,
    mrays_per_s: Spread,
    hits: usize,
    hit_hash: String,
    nodes_per_ray: Option<f64>,
    box_tests_per_ray: Option<f64>,
    tri_tests_per_ray: Option<f64>,
    version: &'static str,
    commit: &'static str,
}

/// What tracing a ray set took.
#[derive(Debug)]
pub struct Measured {
    pub mrays_per_s: Spread,
    pub hits: usize,
    pub hit_hash: String,
    pub nodes_per_ray: Option<f64>,
    pub box_tests_per_ray: Option<f64>,
    pub tri_tests_per_ray: Option<f64>,
}

/// Counts, then times; the timed passes must see what the counted one saw.
pub fn measure(batch: &Batch, repeats: &Repeats) -> Result<Measured, Failure> {
    let (expected, work) = count_batch(batch);
    let mut hits = Vec::new();
    let seconds = repeat(repeats, || {
        trace_batch(batch, &mut hits);
        Ok::<(), Failure>(())
    })?;
    let hash = hit_hash(&expected);
    if hit_hash(&hits) != hash {
        return Err(wrong("a timed pass saw other hits than the counted one"));
    }
    let rays = batch.rays.len() as f64;
    let per_ray = |n: u64| (rays > 0.0).then(|| n as f64 / rays);
    let rate = |s: f64| if s > 0.0 { rays * 1e-6 / s } else { 0.0 };
    Ok(Measured {
        mrays_per_s: Spread {
            median: rate(seconds.median),
            min: rate(seconds.max),
            max: rate(seconds.min),
            runs: seconds.runs,
        },
        hits: expected.iter().filter(|h| h.is_hit()).count(),
        hit_hash: hash,
        nodes_per_ray: per_ray(work.nodes),
        box_tests_per_ray: per_ray(work.box_tests),
        tri_tests_per_ray: per_ray(work.triangle_tests),
    })
}

/// Builds or reads the tree that a command asks for, without measuring.
pub fn tree(scene: &Scene, a: &TreeArguments) -> Result<Bvh, Failure> {
    if let Some(path) = &a.file {
        return Ok(tree_file::read(path, scene)?.bvh);
    }
    let options = a.options().map_err(off)?;
    (a.builder.builder.timed)(Input::of_triangles(&scene.triangles, &scene.boxes()), &options, &mut Brake::default())
        .map_err(wrong)
}

fn rays(a: &TraceArguments, scene: &Scene, bvh: &Bvh) -> Result<Vec<Ray>, Failure> {
    if let Some(path) = &a.rays_file {
        if a.rays == RayWord::Diffuse {
            return Err(off(
                "rays of a file are traced as they are; beside --rays-file, --rays takes primary (the closest hit) or any",
            ));
        }
        return read_rays(path).map_err(|e| wrong(format!("cannot read {e}")));
    }
    let primary = primary_rays(&scene.camera, a.size.0, a.size.1);
    Ok(match a.rays {
        RayWord::Primary => primary,
        RayWord::Diffuse => diffuse_rays(bvh, &scene.triangles, &primary, RAY_SEED),
        RayWord::Any => shadow_rays(bvh, &scene.triangles, &primary, RAY_SEED),
    })
}

/// Runs the command.
pub fn run(a: &TraceArguments) -> Outcome {
    set_threads(&a.run)?;
    let options = a.tree.options().map_err(off)?;
    let builder = a.tree.builder.builder;
    let kernel = a.kernel().map_err(off)?;
    let scene = load(&a.scene)?;
    let bvh = tree(&scene, &a.tree)?;
    let rays = rays(a, &scene, &bvh)?;
    if rays.is_empty() {
        return Err(wrong("there are no rays to trace: the file is empty"));
    }
    let untraceable = rays.iter().filter(|r| !r.is_traceable()).count();
    if untraceable > 0 {
        eprintln!(
            "bvh-lab: {untraceable} of {} rays hold NaN, an infinite origin or direction, no direction or an empty interval: they miss",
            rays.len()
        );
    }
    let query = if a.rays == RayWord::Any { Query::Any } else { Query::Closest };
    let begin = std::time::Instant::now();
    let tracer = Tracer::new(kernel, &bvh, &scene.triangles);
    let prepare_ms = begin.elapsed().as_secs_f64() * 1e3;
    let batch = Batch { tracer: &tracer, query, rays: &rays };
    let measured = measure(&batch, &repeats(&a.run))?;
    if let Some(path) = &a.hits_out {
        let (hits, _) = count_batch(&batch);
        write_hits(path, &hits).map_err(|e| wrong(format!("cannot write {}: {e}", path.display())))?;
    }
    let report = TraceReport {
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        dropped: scene.dropped.total(),
        builder: if a.tree.file.is_some() { "file" } else { builder.id },
        tree: a.tree.file.as_ref().map(|path| path.display().to_string()),
        refine: options.refine.to_string(),
        arity: bvh.arity,
        preset: builder.preset(&options).filter(|_| a.tree.file.is_none()).map(Preset::id),
        engine: builder.engine(&options).filter(|_| a.tree.file.is_none()).map(Engine::id),
        tree_hash: tree_hash(&bvh).to_string(),
        threads: rayon::current_num_threads(),
        kernel: a.kernel.0.clone(),
        prepare_ms,
        kernel_bytes: tracer.bytes(),
        rays: rays.len(),
        untraceable_rays: untraceable,
        ray_kind: if a.rays_file.is_some() { "file" } else { a.rays.id() },
        mrays_per_s: measured.mrays_per_s,
        hits: measured.hits,
        hit_hash: measured.hit_hash,
        nodes_per_ray: measured.nodes_per_ray,
        box_tests_per_ray: measured.box_tests_per_ray,
        tri_tests_per_ray: measured.tri_tests_per_ray,
        version: bvh_lab::lab::version(),
        commit: bvh_lab::lab::commit(),
    };
    if a.run.json { json(&report) } else { say(&text(&report)) }
}

fn text(r: &TraceReport) -> String {
    let per_ray = |x: Option<f64>| x.map_or_else(|| "–".into(), short);
    let reading = r.preset.zip(r.engine).map_or_else(String::new, |(preset, engine)| format!(" ({preset}, {engine})"));
    [
        format!("{}: {} triangles ({} dropped)", r.scene, r.triangles, r.dropped),
        format!("tree        {}{}{reading}, arity {}", r.tree.as_deref().unwrap_or(r.builder), r.refine, r.arity),
        format!("kernel      {}, {} {} rays, {} threads", r.kernel, r.rays, r.ray_kind, r.threads),
        format!("layout      {} bytes, made of the tree in {}", r.kernel_bytes, human_seconds(r.prepare_ms / 1e3)),
        format!("speed       {}", spread_text(&r.mrays_per_s, "MRays/s")),
        format!("hits        {} of {} ({})", r.hits, r.rays, r.hit_hash),
        format!(
            "per ray     {} nodes, {} box tests, {} triangle tests",
            per_ray(r.nodes_per_ray),
            per_ray(r.box_tests_per_ray),
            per_ray(r.tri_tests_per_ray)
        ),
    ]
    .join("\n")
}
