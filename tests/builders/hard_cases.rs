//! Scenes that builders have stumbled over, and every builder and arity on them; the table in `main.rs` says which is which.

use super::build;
use super::hard_scenes::{FAR, far, nested, without_area};
use super::variants::variants;
use bvh_lab::build::{BUILDERS, Brake, BuildOptions, Builder, Counters, Engine, Input, Parameter, Preset};
use bvh_lab::bvh::tree_hash;
use bvh_lab::geom::{Aabb, Triangle};
use bvh_lab::refine::STEPS;
use bvh_lab::scene::Scene;
use glam::Vec3;
use std::path::Path;

/// All that end in near-linear time: every builder but the literal engines.
fn fast() -> impl Iterator<Item = (&'static Builder, BuildOptions)> {
    let all = BUILDERS.iter().flat_map(|b| b.variants(BuildOptions::default()).into_iter().map(move |o| (b, o)));
    all.filter(|(builder, options)| builder.engine(options) != Some(Engine::Literal))
}

#[test]
fn triangles_without_area() {
    for triangles in without_area() {
        let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
        variants().for_each(|v| drop(build(v, &boxes)));
        // Those that cut triangles are to find nothing to cut.
        for (builder, options) in variants().filter(|(builder, _)| builder.spatial) {
            let input = Input::of_triangles(&triangles, &boxes);
            let bvh = (builder.timed)(input, &options, &mut Brake::default()).unwrap();
            bvh_lab::bvh::validate_parts(&bvh, &triangles, &boxes, &builder.limits(&options)).unwrap();
        }
    }
}

/// Near-linear is asked of counted work: four times the triangles, at most eight times the work, where all pairs would be sixteen.
/// The most is 6.6 times, `agglo-local` on equal centres.
#[test]
fn a_hundred_thousand_alike() {
    let same = |n: usize| vec![Aabb::new(Vec3::ZERO, Vec3::ONE); n];
    let same_centre = |n: usize| {
        let half = |i: usize| Vec3::splat((1 + i % 1000) as f32);
        (0..n).map(|i| Aabb::new(-half(i), half(i))).collect::<Vec<_>>()
    };
    for v @ (builder, options) in fast() {
        let work = |boxes: &[Aabb]| {
            let mut counters = Counters::default();
            (builder.counted)(Input::of_boxes(boxes), &options, &mut counters).unwrap();
            counters.nonzero().map(|(_, n)| n).sum::<u64>() as f64
        };
        // Where boxes differ, the thesis' trees part them a few at a time; how deep that goes is theirs.
        let scenes: &[&dyn Fn(usize) -> Vec<Aabb>] =
            if builder.presets.is_empty() { &[&same, &same_centre] } else { &[&same] };
        for boxes in scenes {
            let (few, many) = (work(&boxes(25_000)), work(&boxes(100_000)));
            assert!(many <= 8.0 * few, "{} {options:?}: work {few} on 25,000, {many} on 100,000", builder.id);
        }
        build(v, &same(100_000));
    }
}

#[test]
fn as_deep_as_f32_allows() {
    let boxes: Vec<_> = nested().iter().map(Triangle::aabb).collect();
    for v in fast() {
        build(v, &boxes);
    }
}

#[test]
fn any_number_of_threads() {
    let scene = Scene::load("gen:spheres:20000").unwrap();
    let boxes = scene.boxes();
    let input = Input::of_triangles(&scene.triangles, &boxes);
    let pools = [1, 2, 7].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    let same = |builder: &Builder, options: BuildOptions| {
        let hashes = pools
            .each_ref()
            .map(|pool| pool.install(|| tree_hash(&(builder.timed)(input, &options, &mut Brake::default()).unwrap())));
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{} {options:?}: {hashes:?}", builder.id);
    };
    for (builder, options) in fast() {
        same(builder, options);
    }
    for builder in BUILDERS.iter().filter(|b| b.parameters.contains(&Parameter::Refine) && b.presets.is_empty()) {
        for step in STEPS {
            same(builder, BuildOptions { refine: step.id.parse().unwrap(), ..BuildOptions::default() });
        }
    }
}

#[test]
fn slivers() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/slivers");
    let mut scenes = vec![Scene::load("gen:slivers:3000").unwrap()];
    match std::fs::read_dir(&folder) {
        Ok(files) => {
            let paths = files.map(|file| file.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "obj"));
            scenes.extend(paths.map(|path| Scene::load(path.to_str().unwrap()).unwrap()));
        }
        Err(_) => println!("skipped: ../shared/scenes/slivers is not there"),
    }
    for scene in scenes {
        let boxes = scene.boxes();
        for v in fast().filter(|(_, o)| o.preset == Preset::Published) {
            build(v, &boxes);
        }
    }
}

/// Where every coordinate, and the sum of any two, is a number of f32, a scene may stand anywhere.
#[test]
fn far_from_the_origin() {
    let scene = Scene::load("gen:soup:120").unwrap();
    // In eighths, in a cube of 1: then rounded at 10⁶, where numbers are sixteenths apart, they are what they were.
    let whole = |p: Vec3| (p * (8.0 / 100.0)).round() / 8.0;
    let near: Vec<_> = scene.triangles.iter().map(|t| Triangle { v: t.v.map(whole) }.aabb()).collect();
    let moved: Vec<_> = near.iter().map(|b| Aabb::new(b.min + FAR, b.max + FAR)).collect();
    assert!(near.iter().zip(&moved).all(|(n, f)| (f.min - FAR, f.max - FAR) == (n.min, n.max)));
    // The chain of bottom-up published starts at the triangle nearest the origin, and planes that cut triangles are rounded.
    let anywhere = |(builder, options): &(&Builder, BuildOptions)| {
        !builder.spatial && (builder.id != "bottom-up" || options.preset != Preset::Published)
    };
    for v in variants().filter(anywhere) {
        assert_eq!(tree_hash(&build(v, &near)), tree_hash(&build(v, &moved)), "{} {:?}", v.0.id, v.1);
    }
    // Where positions were rounded, trees are valid over what they became.
    let rounded: Vec<_> = far().iter().map(Triangle::aabb).collect();
    variants().for_each(|v| drop(build(v, &rounded)));
}
