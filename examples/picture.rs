//! A picture of a scene, and what it took: the effects that its materials call for, and rays by kind.
//!
//! `cargo run --release --example picture -- [SCENE [FILE.png]]`

use bvh_lab::build::{self, Brake, BuildOptions, Input};
use bvh_lab::render::{Frame, RayKind, Stage, StageOptions};
use bvh_lab::scene::Scene;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let scene = Scene::load(&words.next().unwrap_or_else(|| "scenes/cube.obj".into()))?;
    let path = words.next().unwrap_or_else(|| "picture.png".into());
    let builder = build::find("binned-sah").ok_or("no such builder")?;
    let boxes = scene.boxes();
    let bvh = (builder.timed)(Input::of_boxes(&boxes), &BuildOptions::default(), &mut Brake::default())?;

    let stage = Stage::new(&scene, &bvh, &StageOptions::default())?;
    let frame = Frame { width: 800, height: 600, rays_per_pixel: 16 };
    let picture = stage.render(&stage.viewpoint(), &frame);
    picture.film.save(path.as_ref(), stage.exposure(&picture.film))?;

    for call in stage.callers() {
        println!("{} is called for by {}", call.effect.id(), call.materials.join(", "));
    }
    for kind in RayKind::ALL {
        println!("{:>12} {} rays", picture.rays.of(kind), kind.id());
    }
    Ok(())
}
