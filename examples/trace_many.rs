//! Trace a picture's rays all at once, by one kernel, and nothing besides: what a kernel does without counters.
//!
//! `cargo run --release --example trace_many -- [KERNEL] [SCENE]`

use bvh_lab::build::{Brake, BuildOptions, Input, find};
use bvh_lab::scene::Scene;
use bvh_lab::trace::{Batch, Kernel, Query, Tracer, hit_hash, primary_rays, trace_batch};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let kernel = Kernel::from_id(&words.next().unwrap_or_else(|| "bvh8".into())).ok_or("there is no such kernel")?;
    let scene = Scene::load(&words.next().unwrap_or_else(|| "gen:spheres:5000".into()))?;
    let boxes = scene.boxes();
    let builder = find("sweep-sah").ok_or("it is registered")?;
    let input = Input::of_triangles(&scene.triangles, &boxes);
    let bvh = (builder.timed)(input, &BuildOptions::default(), &mut Brake::default())?;
    let rays = primary_rays(&scene.camera, 512, 512);
    let tracer = Tracer::new(kernel, &bvh, &scene.triangles);
    let mut hits = Vec::new();
    trace_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &rays }, &mut hits);
    println!("{} rays, hits {}", rays.len(), hit_hash(&hits));
    Ok(())
}
