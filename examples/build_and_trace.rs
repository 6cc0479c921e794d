//! Load a scene, build a tree over it, ask what it is worth, trace a ray: where a user of the library starts.
//!
//! `cargo run --release --example build_and_trace -- [SCENE]`

use bvh_lab::build::top_down::{Published, published_literal};
use bvh_lab::bvh::{Limits, validate};
use bvh_lab::cost::{SahParams, epo, sah};
use bvh_lab::scene::Scene;
use bvh_lab::trace::{Kernel, Query, Scratch, Tracer};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::load(&std::env::args().nth(1).unwrap_or_else(|| "thesis:small".into()))?;
    let boxes = scene.boxes();
    let bvh = published_literal::build(&boxes, &Published::at_arity(4), &mut ())?;
    validate(&bvh, &boxes, &Limits::default())?;
    println!("{}: {} triangles, {} nodes", scene.name, scene.triangles.len(), bvh.nodes.len());
    println!("SAH {:?}, EPO {:?}", sah(&bvh, SahParams::default()), epo(&bvh, &scene.triangles));
    let ray = scene.camera.view(101, 101).ray(50, 50);
    let tracer = Tracer::new(Kernel::Scalar, &bvh, &scene.triangles);
    let hit = tracer.trace(Query::Closest, &ray, &mut Scratch::default(), &mut ());
    match hit {
        Some(hit) => println!("the middle of the picture shows triangle {} at {}", hit.triangle, ray.at(hit.t)),
        None => println!("the middle of the picture shows nothing"),
    }
    Ok(())
}
