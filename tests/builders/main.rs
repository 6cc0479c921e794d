//! Every builder, reading, engine and arity on every generated family at small sizes: valid trees, the same ones every time.
//!
//! What the hard cases ask of builders (6 to 10, 14 and 20 to 24 of the list that builders and kernels are held to), and which
//! test holds it:
//!
//! | case | what | test |
//! |--:|---|---|
//! | 6 | triangles without area | `hard_cases::triangles_without_area` |
//! | 7 | coincident triangles, coincident centres, to 100,000 | `hard_cases::a_hundred_thousand_alike`, `deep_and_coincident_scenes_end_without_a_call_stack` |
//! | 8 | 0 to 9 triangles | `nothing_to_build_over_is_an_error`, `every_family_at_every_small_size` |
//! | 9 | nested triangles | `deep_and_coincident_scenes_end_without_a_call_stack`, `hard_cases::as_deep_as_f32_allows` |
//! | 10 | boxes that are no numbers | `boxes_without_sense_are_refused_by_name` |
//! | 14 | areas beyond f32 | `coordinates_whose_areas_overflow_f32_still_build` |
//! | 20 | two engines, one tree | `engines`, a test of its own |
//! | 21 | any number of threads | `hard_cases::any_number_of_threads`; any vectors: the tests of `binned-sah` |
//! | 22 | a teapot in a stadium | `quality`, a test of its own, at every arity |
//! | 23 | slivers | `hard_cases::slivers`, `every_family_at_every_small_size` |
//! | 24 | far from the origin | `hard_cases::far_from_the_origin` |
//!
//! Rays through all these trees, and the other cases: `tests/matrix`.

mod hard_cases;
#[path = "../support/hard_scenes.rs"]
mod hard_scenes;
#[path = "../support/variants.rs"]
mod variants;

use bvh_lab::build::{BUILDERS, Brake, BuildError, BuildOptions, Builder, Counters, Input, Parameter, Preset};
use bvh_lab::bvh::{Bvh, tree_hash, validate, validate_parts};
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::geom::Aabb;
use bvh_lab::refine::{Collapse, STEPS, Step};
use bvh_lab::scene::Scene;
use bvh_lab::scene::families::FAMILIES;
use glam::Vec3;
use variants::variants;

fn build((builder, options): (&Builder, BuildOptions), boxes: &[Aabb]) -> Bvh {
    let mut counters = Counters::default();
    let bvh = (builder.counted)(Input::of_boxes(boxes), &options, &mut counters)
        .unwrap_or_else(|e| panic!("{} {options:?}, {} triangles: {e}", builder.id, boxes.len()));
    if let Err(violations) = validate(&bvh, boxes, &builder.limits(&options)) {
        panic!("{} {options:?}, {} triangles: {violations}", builder.id, boxes.len());
    }
    assert!(bvh.nodes.iter().all(|n| n.is_leaf() || n.count() <= options.arity));
    assert!(sah(&bvh, SahParams::default()).is_none_or(f64::is_finite), "{} {options:?}", builder.id);
    let again = (builder.timed)(Input::of_boxes(boxes), &options, &mut Brake::default()).unwrap();
    assert_eq!(tree_hash(&bvh), tree_hash(&again), "{} {options:?}", builder.id);
    bvh
}

#[test]
fn every_family_at_every_small_size() {
    for family in FAMILIES {
        for n in (1..=9).chain([33, 120]) {
            let boxes = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap().boxes();
            assert_eq!(boxes.len(), n);
            variants().for_each(|v| drop(build(v, &boxes)));
        }
    }
}

#[test]
fn known_triangles_make_valid_trees_the_same_ones_every_time() {
    for family in FAMILIES {
        for n in (1..=9).chain([33, 120]) {
            let scene = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap();
            let boxes = scene.boxes();
            let input = Input::of_triangles(&scene.triangles, &boxes);
            for (builder, options) in variants().filter(|(builder, _)| builder.spatial) {
                let bvh = (builder.counted)(input, &options, &mut Counters::default()).unwrap();
                if let Err(violations) = validate_parts(&bvh, &scene.triangles, &boxes, &builder.limits(&options)) {
                    panic!("{} {options:?}, {}, {n} triangles: {violations}", builder.id, family.name);
                }
                let again = (builder.timed)(input, &options, &mut Brake::default()).unwrap();
                assert_eq!(tree_hash(&bvh), tree_hash(&again), "{} {options:?}", builder.id);
            }
        }
    }
}

#[test]
fn parts_of_triangles_stay_covered_through_every_step() {
    let mut cut = 0;
    for family in FAMILIES {
        for n in [9, 33, 300] {
            let scene = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap();
            let boxes = scene.boxes();
            let input = Input::of_triangles(&scene.triangles, &boxes);
            for builder in BUILDERS.iter().filter(|builder| builder.spatial) {
                for (step, arity) in STEPS.iter().flat_map(|step| builder.arities.iter().map(move |&k| (step, k))) {
                    let refine = step.id.parse().unwrap();
                    let options = BuildOptions { arity, refine, ..BuildOptions::default() };
                    let bvh = (builder.timed)(input, &options, &mut Brake::default()).unwrap();
                    let limits = builder.limits(&options);
                    if let Err(violations) = validate_parts(&bvh, &scene.triangles, &boxes, &limits) {
                        panic!("{}+{} k={arity}, {}, {n} triangles: {violations}", builder.id, step.id, family.name);
                    }
                    cut += bvh.triangle_ids.len() - scene.triangles.len();
                }
            }
        }
    }
    assert!(cut > 1000, "{cut} parts beyond the first of a triangle");
}

#[test]
fn nothing_to_build_over_is_an_error() {
    for (builder, options) in variants() {
        assert_eq!(
            (builder.timed)(Input::of_boxes(&[]), &options, &mut Brake::default()),
            Err(BuildError::NoTriangles)
        );
    }
}

#[test]
fn boxes_without_sense_are_refused_by_name() {
    let good = Aabb::new(Vec3::ZERO, Vec3::ONE);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let boxes = [good, Aabb::new(Vec3::splat(bad), Vec3::ONE), good];
        for (builder, options) in variants() {
            assert_eq!(
                (builder.timed)(Input::of_boxes(&boxes), &options, &mut Brake::default()),
                Err(BuildError::InvalidBox(1))
            );
        }
    }
}

#[test]
fn doubling_the_scene_changes_no_tree() {
    let boxes = Scene::load("gen:soup:90").unwrap().boxes();
    for scale in [2f32.powi(40), 2f32.powi(-40)] {
        let scaled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * scale, b.max * scale)).collect();
        for v in variants() {
            assert_eq!(tree_hash(&build(v, &boxes)), tree_hash(&build(v, &scaled)), "{} {:?}", v.0.id, v.1);
        }
    }
}

#[test]
fn coordinates_whose_areas_overflow_f32_still_build() {
    let boxes: Vec<_> = Scene::load("gen:soup:60").unwrap().boxes();
    let huge: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * 1e19, b.max * 1e19)).collect();
    variants().for_each(|v| drop(build(v, &huge)));
}

#[test]
fn deep_and_coincident_scenes_end_without_a_call_stack() {
    for scene in ["gen:nested:2000", "gen:coincident:2000"] {
        let boxes = Scene::load(scene).unwrap().boxes();
        for v in variants().filter(|(_, o)| o.preset == Preset::Published) {
            build(v, &boxes);
        }
    }
}

#[test]
fn every_step_and_every_collapse_after_every_builder() {
    let takes_steps = BUILDERS.iter().filter(|b| b.parameters.contains(&Parameter::Refine));
    let scenes = ["gen:soup:1", "gen:soup:2", "gen:soup:5", "gen:soup:400", "gen:nested:400", "gen:coincident:400"];
    let scenes = scenes.map(|scene| Scene::load(scene).unwrap().boxes());
    for builder in takes_steps {
        for step in STEPS {
            for (arity, collapse) in [(2, None)].into_iter().chain(Collapse::ALL.map(|c| (8, Some(c)))) {
                let refine = step.id.parse().unwrap();
                let options = BuildOptions { arity, collapse, refine, ..BuildOptions::default() };
                let thesis = !builder.presets.is_empty();
                if thesis && (step.step != Step::Leaves || arity > 2) {
                    assert!(builder.check(&options).is_err(), "{}+{}", builder.id, step.id);
                    continue;
                }
                builder.check(&options).unwrap();
                for boxes in &scenes {
                    let doubled: Vec<_> = boxes.iter().map(|b| Aabb::new(b.min * 2.0, b.max * 2.0)).collect();
                    let hashes = [boxes, &doubled].map(|boxes| tree_hash(&build((builder, options), boxes)));
                    assert_eq!(hashes[0], hashes[1], "{}+{}", builder.id, step.id);
                }
            }
        }
    }
}
