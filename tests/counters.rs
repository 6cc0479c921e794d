//! Work counted exactly: what every builder, step and kernel does on fixed small scenes, held against `counters.txt`.
//!
//! Counts need no quiet machine and no repeats: they are the same on every machine, whatever the number of threads and the width of
//! its vectors, so any difference is a change of the algorithm. `BVH_LAB_UPDATE=1 cargo test --release --test counters` writes the
//! file anew; its diff then says what the change costs.

use bvh_lab::build::{BUILDERS, BuildOptions, Builder, Counters, Engine, Input, Parameter, Preset, find};
use bvh_lab::bvh::{Bvh, tree_hash};
use bvh_lab::refine::{Collapse, STEPS};
use bvh_lab::scene::Scene;
use bvh_lab::trace::{Batch, KERNELS, Query, Tracer, count_batch, diffuse_rays, primary_rays, shadow_rays};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

const SCENES: [&str; 2] = ["gen:spheres:240", "gen:stadium:200"];

/// A build's counts and the beginning of its tree's hash.
fn counted(builder: &Builder, options: &BuildOptions, scene: &Scene) -> (Bvh, String) {
    let boxes = scene.boxes();
    let mut counters = Counters::default();
    let bvh = (builder.counted)(Input::of_triangles(&scene.triangles, &boxes), options, &mut counters)
        .unwrap_or_else(|e| panic!("{} {options:?}: {e}", builder.id));
    let mut text = format!("tree={}", &tree_hash(&bvh).to_string()[..8]);
    for (name, count) in counters.nonzero() {
        write!(text, " {name}={count}").unwrap();
    }
    (bvh, text)
}

/// Every builder, reading, engine and arity; the literal search of mixed planes with few candidates.
fn builds(lines: &mut String, scene: &Scene) {
    for builder in BUILDERS {
        for options in builder.variants(BuildOptions::default()) {
            let slow = builder.id == "top-down" && (options.preset, options.engine) == (Preset::Text, Engine::Literal);
            let candidates = (slow && options.arity > 2).then_some(if options.arity == 4 { 12 } else { 5 });
            let options = BuildOptions { candidates, ..options };
            let mut name = builder.id.to_owned();
            if let (Some(preset), Some(engine)) = (builder.preset(&options), builder.engine(&options)) {
                write!(name, " {} {}", preset.id(), engine.id()).unwrap();
            }
            let (_, counts) = counted(builder, &options, scene);
            writeln!(lines, "{} | {name} k={} | {counts}", scene.name, options.arity).unwrap();
        }
    }
}

fn steps(lines: &mut String, scene: &Scene) {
    let builder = find("ploc").unwrap();
    for step in STEPS {
        let options = BuildOptions { refine: step.id.parse().unwrap(), ..BuildOptions::default() };
        let (_, counts) = counted(builder, &options, scene);
        writeln!(lines, "{} | ploc+{} | {counts}", scene.name, step.id).unwrap();
    }
    for collapse in Collapse::ALL {
        let options = BuildOptions { arity: 8, collapse: Some(collapse), ..BuildOptions::default() };
        assert!(builder.parameters.contains(&Parameter::Collapse));
        let (_, counts) = counted(builder, &options, scene);
        writeln!(lines, "{} | ploc k=8 {collapse:?} | {counts}", scene.name).unwrap();
    }
}

fn traces(lines: &mut String, scene: &Scene) {
    for arity in [2, 8] {
        let options = BuildOptions { arity, ..BuildOptions::default() };
        let (bvh, _) = counted(find("binned-sah").unwrap(), &options, scene);
        let primary = primary_rays(&scene.camera, 40, 30);
        let diffuse = diffuse_rays(&bvh, &scene.triangles, &primary, 1);
        let shadow = shadow_rays(&bvh, &scene.triangles, &primary, 1);
        let sets = [
            ("primary", Query::Closest, &primary),
            ("diffuse", Query::Closest, &diffuse),
            ("any", Query::Any, &shadow),
        ];
        for info in KERNELS {
            for (kind, query, rays) in sets {
                let tracer = Tracer::new(info.kernel, &bvh, &scene.triangles);
                let batch = Batch { tracer: &tracer, query, rays };
                let (hits, work) = count_batch(&batch);
                writeln!(
                    lines,
                    "{} | {} k={arity} {kind} | rays={} hits={} nodes={} box-tests={} triangle-tests={}",
                    scene.name,
                    info.id,
                    rays.len(),
                    hits.iter().filter(|h| h.is_hit()).count(),
                    work.nodes,
                    work.box_tests,
                    work.triangle_tests,
                )
                .unwrap();
            }
        }
    }
}

fn all() -> String {
    let mut lines = String::new();
    for scene in SCENES {
        let scene = Scene::load(scene).unwrap();
        builds(&mut lines, &scene);
        steps(&mut lines, &scene);
        traces(&mut lines, &scene);
    }
    lines
}

fn by_cell(text: &str) -> BTreeMap<&str, &str> {
    text.lines().map(|l| l.rsplit_once(" | ").unwrap()).collect()
}

#[test]
fn every_count_is_what_it_was() {
    let now = all();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/counters.txt");
    if std::env::var_os("BVH_LAB_UPDATE").is_some() {
        std::fs::write(&path, &now).unwrap();
        return;
    }
    let then = std::fs::read_to_string(&path).unwrap();
    let (was, is) = (by_cell(&then), by_cell(&now));
    let mut changed = String::new();
    for (cell, counts) in &is {
        match was.get(cell) {
            Some(old) if old == counts => {}
            Some(old) => writeln!(changed, "{cell}\n  was {old}\n  is  {counts}").unwrap(),
            None => writeln!(changed, "{cell}\n  is new: {counts}").unwrap(),
        }
    }
    for cell in was.keys().filter(|cell| !is.contains_key(*cell)) {
        writeln!(changed, "{cell}\n  is gone").unwrap();
    }
    assert!(changed.is_empty(), "work changed; where it should, BVH_LAB_UPDATE=1 writes counters.txt anew:\n{changed}");
}

#[test]
fn counts_do_not_depend_on_the_number_of_threads() {
    let [one, seven] = [1, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(all)
    });
    assert!(one == seven);
}
