//! Builders side by side on your own scene: cost of the tree, and work per ray that the camera's picture sends out.
//!
//! `cargo run --release --example compare_builders -- [SCENE]`

use bvh_lab::build::{self, Brake, BuildOptions, Input};
use bvh_lab::bvh::validate;
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::scene::Scene;
use bvh_lab::trace::{Batch, Kernel, Query, Tracer, count_batch, diffuse_rays, primary_rays};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::load(&std::env::args().nth(1).unwrap_or_else(|| "gen:spheres:20000".into()))?;
    let (boxes, options) = (scene.boxes(), BuildOptions::default());
    let primary = primary_rays(&scene.camera, 256, 256);
    println!("{}: {} triangles", scene.name, boxes.len());
    for id in ["sweep-sah", "binned-sah", "lbvh", "ploc", "sbvh"] {
        let builder = build::find(id).ok_or("no such builder")?;
        let begin = Instant::now();
        let bvh = (builder.timed)(Input::of_triangles(&scene.triangles, &boxes), &options, &mut Brake::default())?;
        let ms = begin.elapsed().as_secs_f64() * 1e3;
        validate(&bvh, &boxes, &builder.limits(&options))?;
        // What the camera sees is lit from everywhere: rays that go all over the scene.
        let rays = diffuse_rays(&bvh, &scene.triangles, &primary, 1);
        let tracer = Tracer::new(Kernel::Scalar, &bvh, &scene.triangles);
        let (_, work) = count_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &rays });
        let per_ray = |n: u64| n as f64 / rays.len() as f64;
        println!(
            "{id:11} {ms:7.1} ms, SAH {:6.2}, {:5.1} nodes and {:5.2} triangle tests per ray",
            sah(&bvh, SahParams::default()).unwrap_or(f64::NAN),
            per_ray(work.nodes),
            per_ray(work.triangle_tests)
        );
    }
    Ok(())
}
