//! What a scene without mirrors and clear surfaces costs, against a renderer that knows of nothing else.
//!
//! In instructions, less those of the scene's own making (`plain` − `setup` against `specialised` − `setup`):
//!
//! ```sh
//! cargo test --release --lib --no-run
//! for part in setup plain specialised; do
//!     valgrind --tool=callgrind target/release/deps/bvh_lab-… --ignored --exact render::tests::cost::$part
//! done
//! ```

use crate::bvh::Bvh;
use crate::geom::{Ray, Triangle};
use crate::render::direct::{ambient, choose};
use crate::render::reflectance::Reflectance;
use crate::render::sampler::Sampler;
use crate::render::{Frame, RayCounts, RayKind, Stage, StageOptions};
use crate::scene::{Camera, Effect, Material, Scene};
use crate::trace::testing::median_split;
use crate::trace::{Query, Scratch, leave_surface};
use glam::Vec3;
use std::time::Instant;

const FRAME: Frame = Frame { width: 160, height: 120, rays_per_pixel: 4 };

/// Spheres, some of them glossy, under a lamp.
fn lit_spheres() -> (Scene, Bvh) {
    let mut scene = Scene::load("gen:spheres:4000").unwrap();
    let bounds = scene.bounds();
    let (low, high) = (bounds.min, bounds.max + Vec3::Y * bounds.extent().y as f32);
    scene.materials.push(Material {
        illumination_model: 2,
        specular: Vec3::splat(0.3),
        shininess: 40.0,
        ..Material::default()
    });
    scene.materials.push(Material { emission: Vec3::splat(4.0), ..Material::default() });
    scene.material_ids = (0..scene.triangles.len()).map(|id| u16::from(id % 1000 < 300)).collect();
    let corner = |x, z| Vec3::new(x, high.y, z);
    scene.triangles.push(Triangle::new(corner(low.x, low.z), corner(high.x, low.z), corner(low.x, high.z)));
    scene.material_ids.push(2);
    let bvh = median_split(&scene.triangles, 4);
    (scene, bvh)
}

/// The picture by a renderer that has primary rays, shadow rays and area lights, and nothing else.
#[inline(never)]
fn plain_picture(stage: &Stage, camera: &Camera, frame: &Frame) -> (Vec<Vec3>, [u64; 2]) {
    let (scene, lights) = (stage.scene, stage.lights.as_ref().unwrap());
    let view = camera.view(frame.width, frame.height);
    let mut scratch = Scratch::default();
    let mut rays = [0; 2];
    let mut light_along = |ray: &Ray, sampler: Sampler| {
        rays[0] += 1;
        let Some(hit) = stage.tracer.trace(Query::Closest, ray, &mut scratch, &mut ()) else { return Vec3::ZERO };
        let id = hit.triangle as usize;
        let surface = stage.surface(ray, &hit);
        let material = &stage.materials[usize::from(scene.material_ids[id])];
        let start = leave_surface(ray, &hit, &scene.triangles[id]);
        let mut sum = ambient(lights, &surface, material.diffuse);
        let reflectance = Reflectance::of(material, material.diffuse, true);
        if let Some(direct) = choose(lights, start, &surface, &reflectance, sampler.choice(1)) {
            rays[1] += 1;
            if stage.tracer.trace(Query::Any, &direct.shadow, &mut scratch, &mut ()).is_none() {
                sum += direct.light;
            }
        }
        sum + material.emission
    };
    let mut pixels = Vec::new();
    for y in 0..frame.height {
        for x in 0..frame.width {
            let pixel_sampler = Sampler::of_pixel(x, y);
            let mut sum = Vec3::ZERO;
            for index in 0..frame.rays_per_pixel {
                let sampler = pixel_sampler.at(index);
                let [dx, dy] = sampler.choice(0).pair();
                let ray = view.ray_through(f64::from(x) + f64::from(dx), f64::from(y) + f64::from(dy));
                sum += light_along(&ray, sampler);
            }
            pixels.push(sum / frame.rays_per_pixel as f32);
        }
    }
    (pixels, rays)
}

fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(work)
}

#[test]
fn the_plain_renderer_takes_the_same_picture_with_the_same_rays() {
    let (scene, bvh) = lit_spheres();
    let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
    assert!(stage.effects().iter().eq([Effect::Shadow, Effect::Emission]));
    let frame = Frame { width: 40, height: 30, ..FRAME };
    let (pixels, [primary, shadow]) = plain_picture(&stage, &scene.camera, &frame);
    let picture = stage.render(&scene.camera, &frame);
    assert!(picture.film.pixels == pixels && pixels.iter().any(|p| p.x > 0.0));
    let count = |rays: &RayCounts| (rays.of(RayKind::Primary), rays.of(RayKind::Shadow), rays.total());
    assert_eq!(count(&picture.rays), (primary, shadow, primary + shadow));
}

/// Medians of interleaved runs: what the specialised renderer takes over the plain one.
#[test]
#[ignore = "a measurement"]
fn in_time() {
    let (scene, bvh) = lit_spheres();
    let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
    let mut seconds = [const { Vec::new() }; 2];
    on_one_thread(|| {
        for _ in 0..41 {
            let begin = Instant::now();
            std::hint::black_box(plain_picture(&stage, &scene.camera, &FRAME));
            seconds[0].push(begin.elapsed().as_secs_f64());
            let begin = Instant::now();
            std::hint::black_box(stage.render(&scene.camera, &FRAME));
            seconds[1].push(begin.elapsed().as_secs_f64());
        }
    });
    let [plain, specialised] = seconds.map(|mut runs| {
        runs.sort_unstable_by(f64::total_cmp);
        runs[runs.len() / 2]
    });
    println!("plain {plain:.4} s, specialised {specialised:.4} s: {:.3}", specialised / plain);
}

#[test]
#[ignore = "a measurement, by callgrind"]
fn setup() {
    let (scene, bvh) = lit_spheres();
    std::hint::black_box(Stage::new(&scene, &bvh, &StageOptions::default()).unwrap());
}

#[test]
#[ignore = "a measurement, by callgrind"]
fn plain() {
    let (scene, bvh) = lit_spheres();
    let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
    std::hint::black_box(on_one_thread(|| plain_picture(&stage, &scene.camera, &FRAME)));
}

#[test]
#[ignore = "a measurement, by callgrind"]
fn specialised() {
    let (scene, bvh) = lit_spheres();
    let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
    std::hint::black_box(on_one_thread(|| stage.render(&scene.camera, &FRAME)));
}
