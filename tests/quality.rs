//! What every modern builder's trees cost, against sweeps over all splits and against the exact trees of the thesis.
//!
//! Cost is the surface area heuristic at arity 2, leaves of at most four triangles, by one function. Trees are the same on every
//! machine, so costs are held twice: by promises, made here for each builder, and by `quality.txt`, which has every cost as it
//! was; a cost more than 1 % above it fails. `BVH_LAB_UPDATE=1 cargo test --release --test quality` writes the file anew.
//! With `--nocapture` the table is printed.

use bvh_lab::build::{BUILDERS, Brake, BuildOptions, Builder, Input, Preset, find};
use bvh_lab::bvh::{Bvh, Limits, validate};
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::refine::{STEPS, equal_leaves};
use bvh_lab::scene::Scene;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The greatest leaf of all trees compared.
const MAX_LEAF: usize = 4;

/// What a builder's trees may cost.
struct Promise {
    builder: &'static str,
    /// Geometric mean over [`SCENES`], relative to `sweep-sah`.
    mean: f64,
    /// The worst of them.
    worst: f64,
    /// A small dense object in a large sparse one (hard case 22): 5 % at most, but where said.
    stadium: f64,
    /// The worst of a few real models.
    real: f64,
}

const fn promise(builder: &'static str, mean: f64, worst: f64, stadium: f64, real: f64) -> Promise {
    Promise { builder, mean, worst, stadium, real }
}

/// One for every modern builder: those without one fail. Each is its measured figure rounded up to the next percent.
const PROMISES: &[Promise] = &[
    promise("sweep-sah", 1.0, 1.0, 1.0, 1.0),
    promise("binned-sah", 1.02, 1.05, 1.02, 1.08),
    // Spatial splits are chosen one by one; on the stadium one of them costs its subtree more than it wins.
    promise("sbvh", 0.95, 1.06, 1.06, 1.0),
    promise("kway-sah", 0.98, 1.01, 0.97, 1.03),
    promise("kway-slab", 1.0, 1.03, 1.01, 1.01),
    // Merging pairs of least union is no search for the least cost: worse where triangles fill space evenly.
    promise("agglo-local", 1.03, 1.15, 0.97, 1.15),
    promise("agglo-kd", 1.05, 1.31, 0.97, 1.18),
    promise("ploc", 1.05, 1.14, 0.99, 1.14),
    // Nothing is searched at all: hard case 22 allows 1.8.
    promise("lbvh", 1.15, 1.24, 1.12, 1.35),
];

/// Of several natures, small enough for every run of the tests.
const SCENES: [&str; 10] = [
    "thesis:tiny",
    "thesis:small",
    "thesis:med",
    "gen:spheres:6000",
    "gen:terrain:6000",
    "gen:soup:6000",
    "gen:hairball:6000",
    "gen:stadium:6000",
    "gen:slivers:6000",
    "gen:grid:6000",
];

fn cost(bvh: &Bvh) -> f64 {
    sah(bvh, SahParams::default()).expect("these scenes have area")
}

fn tree(builder: &Builder, scene: &Scene, options: &BuildOptions) -> Bvh {
    let boxes = scene.boxes();
    (builder.timed)(Input::of_triangles(&scene.triangles, &boxes), options, &mut Brake::default())
        .unwrap_or_else(|e| panic!("{} on {}: {e}", builder.id, scene.name))
}

fn modern() -> impl Iterator<Item = &'static Builder> {
    BUILDERS.iter().filter(|b| b.presets.is_empty())
}

/// The exact trees of the thesis, their leaves made by cost as the others' are.
fn originals(scene: &Scene) -> Vec<(String, f64)> {
    let boxes = scene.boxes();
    let readings = [("top-down", Preset::Published), ("bottom-up", Preset::Published), ("bottom-up", Preset::Walter)];
    let one = |(id, preset): (&str, Preset)| {
        let options = BuildOptions { preset, ..BuildOptions::default() };
        let bvh = equal_leaves(&tree(find(id).unwrap(), scene, &options), &boxes, MAX_LEAF);
        validate(&bvh, &boxes, &Limits { max_leaf: MAX_LEAF, ..Limits::default() }).unwrap();
        (format!("{id} {}", preset.id()), cost(&bvh))
    };
    readings.map(one).into()
}

/// The cost of every modern builder, and of the thesis' trees, on one scene.
fn costs(scene: &Scene) -> Vec<(String, f64)> {
    let options = BuildOptions { max_leaf: Some(MAX_LEAF), ..BuildOptions::default() };
    let modern = modern().map(|b| (b.id.to_owned(), cost(&tree(b, scene, &options))));
    modern.chain(originals(scene)).collect()
}

fn of(costs: &[(String, f64)], name: &str) -> f64 {
    costs.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no cost of {name}")).1
}

#[test]
fn every_builder_keeps_its_promise() {
    let mut ratios: BTreeMap<String, Vec<(String, f64)>> = BTreeMap::new();
    let mut to_originals: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for scene in SCENES {
        let costs = costs(&Scene::load(scene).unwrap());
        let sweep = of(&costs, "sweep-sah");
        let best = costs.iter().filter(|(n, _)| n.contains(' ')).map(|c| c.1).fold(f64::INFINITY, f64::min);
        for (name, cost) in costs {
            to_originals.entry(name.clone()).or_default().push(cost / best);
            ratios.entry(name).or_default().push((scene.to_owned(), cost / sweep));
        }
    }
    let mean = |values: &[f64]| (values.iter().map(|v| v.ln()).sum::<f64>() / values.len() as f64).exp();
    let mut broken = String::new();
    for builder in modern() {
        let Some(promise) = PROMISES.iter().find(|p| p.builder == builder.id) else {
            panic!("{} has no promise: state what its trees may cost", builder.id);
        };
        let of_builder = &ratios[builder.id];
        let values: Vec<f64> = of_builder.iter().map(|r| r.1).collect();
        let worst = of_builder.iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let stadium = of_builder.iter().find(|r| r.0.contains("stadium")).unwrap().1;
        println!(
            "{:12} over sweep-sah: mean {:.3}, worst {:.3} ({}), stadium {stadium:.3}; over the thesis' best exact tree: mean {:.3}",
            builder.id,
            mean(&values),
            worst.1,
            worst.0,
            mean(&to_originals[builder.id]),
        );
        let held = [
            ("mean", mean(&values), promise.mean),
            ("worst", worst.1, promise.worst),
            ("stadium", stadium, promise.stadium),
        ];
        for (what, is, may) in held {
            // The last digits are rounding's.
            if is > may + 1e-9 {
                writeln!(broken, "{}: {what} {is:.4}, promised {may}", builder.id).unwrap();
            }
        }
        assert!(promise.stadium <= if builder.id == "lbvh" { 1.8 } else { 1.06 }, "hard case 22");
    }
    assert!(broken.is_empty(), "\n{broken}");
    assert_eq!(PROMISES.len(), modern().count(), "a promise for a builder that is not registered");
}

#[test]
fn no_cost_rises_above_what_it_was() {
    /// A change of rounding is no loss.
    const SLACK: f64 = 1.01;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/quality.txt");
    let mut now = String::new();
    let mut all = Vec::new();
    for scene in SCENES {
        let scene = Scene::load(scene).unwrap();
        for (name, cost) in costs(&scene) {
            writeln!(now, "{} | {name} | {cost:.5}", scene.name).unwrap();
            all.push((format!("{} | {name}", scene.name), cost));
        }
    }
    if std::env::var_os("BVH_LAB_UPDATE").is_some() {
        std::fs::write(&path, &now).unwrap();
        return;
    }
    let then = std::fs::read_to_string(&path).unwrap();
    let then: BTreeMap<&str, f64> =
        then.lines().map(|l| l.rsplit_once(" | ").unwrap()).map(|(k, v)| (k, v.parse().unwrap())).collect();
    let mut lost = String::new();
    for (key, cost) in &all {
        match then.get(key.as_str()) {
            Some(was) if *cost <= was * SLACK => {}
            Some(was) => writeln!(lost, "{key}: {cost:.5}, was {was}").unwrap(),
            None => writeln!(lost, "{key}: not in quality.txt").unwrap(),
        }
    }
    assert!(lost.is_empty(), "costs rose; if they must, BVH_LAB_UPDATE=1 writes quality.txt anew:\n{lost}");
    assert_eq!(then.len(), all.len(), "quality.txt has builders or scenes that are not measured");
}

#[test]
fn no_step_raises_the_cost() {
    for scene in ["thesis:small", "gen:hairball:3000", "gen:stadium:3000", "gen:coincident:500", "gen:nested:500"] {
        let scene = Scene::load(scene).unwrap();
        for builder in ["lbvh", "ploc", "binned-sah", "agglo-local"] {
            let builder = find(builder).unwrap();
            let cost_after = |steps: &str| {
                cost(&tree(
                    builder,
                    &scene,
                    &BuildOptions { refine: steps.parse().unwrap(), ..BuildOptions::default() },
                ))
            };
            // Every step is given leaves of one triangle, and leaves by cost follow it: so that is what it starts from.
            let before = cost_after("leaves");
            for step in STEPS {
                let after = cost_after(step.id);
                assert!(
                    after <= before * (1.0 + 1e-9),
                    "{}+{} on {}: {before} {after}",
                    builder.id,
                    step.id,
                    scene.name
                );
            }
        }
    }
}

#[test]
fn refinement_brings_fast_builders_below_sweeps() {
    for (recipe, mean) in [("lbvh", 0.97), ("ploc", 0.97), ("binned-sah", 0.96)] {
        let options = BuildOptions { refine: "reinsertion+treelets".parse().unwrap(), ..BuildOptions::default() };
        let logs = SCENES.map(|scene| {
            let scene = Scene::load(scene).unwrap();
            let refined = cost(&tree(find(recipe).unwrap(), &scene, &options));
            (refined / cost(&tree(find("sweep-sah").unwrap(), &scene, &BuildOptions::default()))).ln()
        });
        let is = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
        println!("{recipe}+reinsertion+treelets over sweep-sah: mean {is:.4}");
        assert!(is <= mean, "{recipe}: {is}");
    }
}

#[test]
fn real_models_keep_their_promise() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let models = ["stanford_bunny", "teapot", "teapot_in_stadium", "spot", "slivers"];
    for model in models {
        let Some(file) = first_obj(&folder.join(model)) else {
            println!("skipped: {model} is not in ../shared/scenes");
            continue;
        };
        let scene = Scene::load(file.to_str().unwrap()).unwrap();
        let options = BuildOptions::default();
        let sweep = cost(&tree(find("sweep-sah").unwrap(), &scene, &options));
        for promise in PROMISES {
            let is = cost(&tree(find(promise.builder).unwrap(), &scene, &options)) / sweep;
            println!("{model} {:12} {is:.3}", promise.builder);
            assert!(is <= promise.real + 1e-9, "{model} {}: {is:.4}", promise.builder);
        }
    }
}

fn first_obj(folder: &Path) -> Option<std::path::PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).ok()?.filter_map(|e| Some(e.ok()?.path())).collect();
    files.sort();
    files.into_iter().find(|p| p.extension().is_some_and(|e| e == "obj"))
}
