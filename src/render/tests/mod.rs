//! Exact counts of rays by kind, and pictures that do not depend on what is not called for.

mod cost;
mod lighting;
mod pictures;

use super::integrator::Primaries;
use super::sampler::Sampler;
use super::{Demand, Frame, Picture, RayCounts, RayKind, Stage, StageOptions};
use crate::geom::{Ray, Triangle};
use crate::rows::Lighting;
use crate::scene::{Camera, Effect, EffectSet, Material, Object, Scene, smooth_normals};
use crate::trace::testing::median_split;
use crate::trace::{Kernel, PublishedCamera, Reading, StudyView, THESIS_SIZE, trace_image};
use glam::Vec3;

const FRAME: Frame = Frame { width: 40, height: 30, rays_per_pixel: 1 };
const PIXELS: u64 = 40 * 30;

/// Straight down −z; 2 units at z = 0 are the picture's height.
fn camera() -> Camera {
    Camera { eye: Vec3::new(0.0, 0.0, 2.0), look_at: Vec3::ZERO, up: Vec3::Y, fov_degrees: 53.130_1 }
}

/// A square across the picture at `z`, `half` its side's half.
fn square(z: f32, half: f32) -> [Triangle; 2] {
    let [a, b, c, d] =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x * half, y * half, z));
    [Triangle::new(a, b, c), Triangle::new(a, c, d)]
}

/// Squares, each with its material.
fn scene(squares: &[(f32, f32, Material)]) -> Scene {
    let mut scene = Scene::load("gen:soup:1").unwrap();
    scene.triangles = squares.iter().flat_map(|(z, half, _)| square(*z, *half)).collect();
    scene.material_ids = (0..squares.len() as u16).flat_map(|id| [id + 1; 2]).collect();
    scene.materials = vec![Material::default()];
    scene.materials.extend(squares.iter().map(|(.., material)| material.clone()));
    scene.objects = vec![Object { name: "all".into(), triangles: 0..scene.triangles.len() }];
    scene
}

fn matt() -> Material {
    Material::default()
}

fn mirror() -> Material {
    Material { illumination_model: 3, specular: Vec3::splat(0.9), ..matt() }
}

fn clear() -> Material {
    Material { opacity: 0.5, ..matt() }
}

fn glass() -> Material {
    Material { illumination_model: 7, refraction_index: 1.5, opacity: 0.1, ..matt() }
}

fn lamp() -> Material {
    Material { emission: Vec3::splat(5.0), ..matt() }
}

impl Primaries for PublishedCamera {
    fn ray(&self, x: u32, y: u32, _: Sampler) -> Ray {
        self.ray(x, y)
    }
}

fn picture(scene: &Scene, demand: Demand) -> Picture {
    let bvh = median_split(&scene.triangles, 4);
    let options = StageOptions { demand, ..StageOptions::default() };
    Stage::new(scene, &bvh, &options).unwrap().render(&camera(), &FRAME)
}

fn counts(rays: &RayCounts) -> [u64; 6] {
    RayKind::ALL.map(|kind| rays.of(kind))
}

#[test]
fn a_matt_scene_casts_primary_rays_only() {
    let taken = picture(&scene(&[(0.0, 0.5, matt()), (-1.0, 9.0, matt())]), Demand::Materials);
    assert_eq!(counts(&taken.rays), [PIXELS, 0, 0, 0, 0, 0]);
}

#[test]
fn one_mirror_triangle_casts_reflections_from_its_own_pixels() {
    let mut with_mirror = scene(&[(0.0, 0.5, matt()), (-1.0, 9.0, matt())]);
    with_mirror.materials.push(mirror());
    with_mirror.material_ids[0] = 3;
    let own = {
        let view = camera().view(FRAME.width, FRAME.height);
        let below_diagonal = |x: u32, y: u32| {
            let ray = view.ray(x, y);
            with_mirror.triangles[0].intersect(&ray).is_some()
        };
        (0..FRAME.height)
            .flat_map(|y| (0..FRAME.width).map(move |x| (x, y)))
            .filter(|&(x, y)| below_diagonal(x, y))
            .count()
    };
    assert!(own > 50 && own < 200, "{own}");
    let taken = picture(&with_mirror, Demand::Materials);
    assert_eq!(counts(&taken.rays), [PIXELS, 0, own as u64, 0, 0, 0]);
}

#[test]
fn clear_sheets_pass_a_ray_on_until_it_weighs_nothing() {
    let sheet = |z: f32| (z, 9.0, clear());
    let three = picture(&scene(&[sheet(0.0), sheet(-1.0), sheet(-2.0)]), Demand::Materials);
    assert_eq!(counts(&three.rays), [PIXELS, 0, 0, 0, 3 * PIXELS, 0]);
    let many: Vec<_> = (0..20).map(|i| sheet(-i as f32 * 0.1)).collect();
    // ½⁹ is the weight that is not above 1/512.
    assert_eq!(picture(&scene(&many), Demand::Materials).rays.of(RayKind::Transparency), 8 * PIXELS);
}

#[test]
fn a_glass_slab_reflects_and_refracts_at_both_sides() {
    let mut slab = scene(&[(0.0, 9.0, glass()), (-0.5, 9.0, glass())]);
    // Behind, out is away from the viewer.
    for triangle in &mut slab.triangles[2..] {
        triangle.v.swap(1, 2);
    }
    let once = StageOptions { depth: 2, ..StageOptions::default() };
    let bvh = median_split(&slab.triangles, 2);
    let rays = Stage::new(&slab, &bvh, &once).unwrap().render(&camera(), &FRAME).rays;
    // In front one of each; of the refracted one, behind, one of each: its share of 0.04 · 0.86 is above 1/512.
    assert_eq!(counts(&rays), [PIXELS, 0, 2 * PIXELS, 2 * PIXELS, 0, 0]);
}

#[test]
fn shadow_rays_go_from_where_a_light_can_be() {
    // The lamp hangs behind the viewer and faces a wall that fills the picture.
    let lit = scene(&[(-1.0, 9.0, matt()), (3.0, 0.2, lamp())]);
    let taken = picture(&lit, Demand::Materials);
    assert_eq!(counts(&taken.rays), [PIXELS, PIXELS, 0, 0, 0, 0]);
    // A small screen between: in its pixels, both it and nothing else is lit; what is behind it is not.
    let screened = scene(&[(-1.0, 9.0, matt()), (3.0, 0.2, lamp()), (2.5, 5.0, matt())]);
    let dark = picture(&screened, Demand::Materials);
    assert_eq!(counts(&dark.rays), [PIXELS, PIXELS, 0, 0, 0, 0]);
    assert!(dark.film.pixels.iter().zip(&taken.film.pixels).all(|(d, t)| d.x < t.x));
    let without = picture(&lit, Demand::Forced(EffectSet::EMPTY));
    assert_eq!(counts(&without.rays), [PIXELS, 0, 0, 0, 0, 0]);
}

#[test]
fn a_shadow_ray_is_cast_anew_behind_each_clear_sheet() {
    let between = |material| scene(&[(-1.0, 9.0, matt()), (3.0, 0.2, lamp()), (2.5, 5.0, material)]);
    let open = picture(&scene(&[(-1.0, 9.0, matt()), (3.0, 0.2, lamp())]), Demand::Materials);
    let half = picture(&between(clear()), Demand::Materials);
    assert_eq!(counts(&half.rays), [PIXELS, 2 * PIXELS, 0, 0, 0, 0]);
    let red = Material { transmission_filter: Vec3::new(1.0, 0.25, 0.0), opacity: 0.0, ..clear() };
    let red = picture(&between(red), Demand::Materials);
    // Up to what is reflected more than once, which depends on all surfaces.
    for ((open, half), red) in open.film.pixels.iter().zip(&half.film.pixels).zip(&red.film.pixels) {
        assert!(half.x < open.x && red.y < red.x && red.z < red.y);
    }
}

#[test]
fn what_is_forced_but_not_called_for_changes_no_pixel_and_casts_more_rays() {
    let scenes = [
        scene(&[(0.0, 0.5, matt()), (-1.0, 9.0, matt())]),
        scene(&[(0.0, 0.5, mirror()), (-1.0, 9.0, matt()), (3.0, 5.0, lamp())]),
        scene(&[(0.0, 0.5, glass()), (-0.5, 0.5, glass()), (-1.0, 9.0, matt())]),
        scene(&[(0.0, 0.5, clear()), (-0.5, 0.5, glass()), (-1.0, 9.0, mirror()), (3.0, 5.0, lamp())]),
        Scene::load("thesis:tiny").unwrap(),
    ];
    for scene in &scenes {
        let asked = picture(scene, Demand::Materials);
        let forced = picture(scene, Demand::Forced(EffectSet::ALL));
        assert!(asked.film == forced.film);
        assert_eq!(asked.rays.of(RayKind::Primary), forced.rays.of(RayKind::Primary));
        assert!(forced.rays.total() > asked.rays.total(), "{:?} {:?}", asked.rays, forced.rays);
        for (asked, forced) in counts(&asked.rays).into_iter().zip(counts(&forced.rays)) {
            assert!(asked <= forced);
        }
    }
    // On matt surfaces alone, the forced rays are one of each kind at every hit; holes and textures cast none.
    let forced = picture(&scenes[0], Demand::Forced(EffectSet::ALL));
    assert_eq!(counts(&forced.rays), [PIXELS, PIXELS, PIXELS, PIXELS, PIXELS, 0]);
    let only = EffectSet::EMPTY.with(Effect::Mirror);
    assert_eq!(counts(&picture(&scenes[0], Demand::Forced(only)).rays), [PIXELS, 0, PIXELS, 0, 0, 0]);
}

#[test]
fn every_set_of_effects_has_its_renderer() {
    let mixed = scene(&[(0.0, 0.5, clear()), (-0.5, 0.5, glass()), (-1.0, 9.0, mirror()), (3.0, 5.0, lamp())]);
    for bits in 0..=EffectSet::ALL.bits() {
        let set = EffectSet::from_bits(bits);
        let rays = picture(&mixed, Demand::Forced(set)).rays;
        let casts = |kind: RayKind, effect: Effect| assert_eq!(rays.of(kind) > 0, set.has(effect), "{set}: {kind:?}");
        casts(RayKind::Shadow, Effect::Shadow);
        casts(RayKind::Reflection, Effect::Mirror);
        casts(RayKind::Refraction, Effect::Refraction);
        casts(RayKind::Transparency, Effect::Transparency);
        assert_eq!(rays.of(RayKind::CutOut), 0);
    }
}

#[test]
fn the_lighting_cases_of_the_thesis_cast_the_rays_of_its_text() {
    for (name, size) in [("thesis:tiny", THESIS_SIZE), ("thesis:small", (90, 90))] {
        let scene = Scene::load(name).unwrap();
        let bvh = median_split(&scene.triangles, 4);
        let camera = PublishedCamera::new(&scene.camera, size.0, size.1);
        let normals = smooth_normals(&scene);
        let view = StudyView { bvh: &bvh, triangles: &scene.triangles, normals: &normals, camera };
        let frame = Frame { width: size.0, height: size.1, rays_per_pixel: 1 };
        for (case, kind) in [
            (Lighting::Primary, RayKind::Primary),
            (Lighting::Reflection, RayKind::Reflection),
            (Lighting::Opacity, RayKind::Transparency),
        ] {
            let options = StageOptions { demand: Demand::Thesis(case), ..StageOptions::default() };
            let stage = Stage::new(&scene, &bvh, &options).unwrap();
            let rays = stage.render_rays(&scene.camera, &frame, &camera).rays;
            let study = trace_image(&view, case, Reading::Text);
            assert_eq!((rays.total(), study.cut), (study.rays, 0), "{name} {case:?}");
            let secondary = if kind == RayKind::Primary { 0 } else { rays.of(kind) };
            assert_eq!(rays.of(RayKind::Primary) + secondary, rays.total());
        }
    }
}

#[test]
fn threads_kernels_and_trees_change_nothing() {
    let mixed = scene(&[(0.0, 0.5, clear()), (-0.5, 0.5, glass()), (-1.0, 9.0, mirror()), (3.0, 5.0, lamp())]);
    let take = |threads: usize, kernel: &str, arity: usize| {
        let bvh = median_split(&mixed.triangles, arity);
        let kernel = Kernel::from_id(kernel).unwrap();
        let stage = Stage::new(&mixed, &bvh, &StageOptions { kernel, ..StageOptions::default() }).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| stage.render(&camera(), &Frame { rays_per_pixel: 3, ..FRAME }))
    };
    let first = take(1, "scalar", 2);
    assert!(first == take(3, "scalar", 2));
    assert!(first == take(2, "bvh8", 4));
    assert!(first == take(2, "bvh4", 8));
}

#[test]
fn trees_and_materials_that_are_not_the_scenes_are_refused() {
    let ours = scene(&[(0.0, 0.5, matt())]);
    let other = scene(&[(0.0, 0.5, matt()), (1.0, 0.5, matt())]);
    let (bvh, options) = (median_split(&ours.triangles, 2), StageOptions::default());
    let message = |scene: &Scene, bvh| Stage::new(scene, bvh, &options).unwrap_err().to_string();
    let larger = median_split(&other.triangles, 2);
    assert!(message(&ours, &larger).contains("2 triangles"));
    let empty = crate::bvh::Bvh { nodes: Vec::new(), ..bvh.clone() };
    assert!(message(&ours, &empty).starts_with("the tree is not"));
    let mut bare = ours.clone();
    bare.materials.truncate(1);
    assert!(message(&bare, &bvh).starts_with("the scene's materials"));
}

#[test]
fn upright_turns_the_thesis_picture_by_180_degrees() {
    let scene = Scene::load("thesis:tiny").unwrap();
    let bvh = median_split(&scene.triangles, 4);
    let stage = Stage::new(&scene, &bvh, &StageOptions::default()).unwrap();
    let background = StageOptions::default().background;
    let silhouette = |camera: &Camera| -> Vec<bool> {
        stage.render(camera, &FRAME).film.pixels.iter().map(|&p| p == background).collect()
    };
    let (mut turned, shown) = (silhouette(&scene.camera), silhouette(&scene.camera.upright()));
    turned.reverse();
    let different = turned.iter().zip(&shown).filter(|(a, b)| a != b).count();
    assert!(different <= 5, "{different}");
    assert!(shown.iter().any(|&b| b) && shown.iter().any(|&b| !b));
}
