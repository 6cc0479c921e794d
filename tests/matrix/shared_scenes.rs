//! Every scene of `../shared/scenes` by every kernel: hits equal to brute force and to the oracle, and the same bits for any number
//! of threads and any instructions. Skipped, visibly, where the scenes are not there.

use crate::cases::SEED;
use crate::judge::{Tree, trees};
use crate::rays::mixed;
use crate::variants::variants;
use bvh_lab::geom::{Hit, Ray, WatertightRay};
use bvh_lab::scene::Scene;
use bvh_lab::simd::Simd;
use bvh_lab::trace::{
    Arithmetic, Batch, HitRecord, KERNELS, Oracle, Query, Tracer, brute_force, count_batch, diffuse_rays, hit_hash,
    primary_rays, trace_batch,
};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Triangle tests by brute force that a scene may take.
const TESTS: usize = 30_000_000;

/// Files of scenes, by name; not those whose point is what is wrong with them.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(folders) = std::fs::read_dir(folder) else { return Vec::new() };
    let folders = folders.map(|f| f.unwrap().path()).filter(|f| f.is_dir() && !f.ends_with("parser_torture"));
    let inside = folders.flat_map(|f| std::fs::read_dir(f).unwrap().map(|file| file.unwrap().path()));
    let mut files: Vec<_> = inside.filter(|file| file.extension().is_some_and(|e| e == "obj")).collect();
    files.sort();
    files
}

#[test]
fn every_shared_scene_by_every_kernel() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let files = files(&folder);
    if files.is_empty() {
        println!("skipped: there is nothing in {}", folder.display());
    }
    for file in files {
        check(&Scene::load(file.to_str().unwrap()).unwrap());
    }
}

fn check(scene: &Scene) {
    let triangles = &scene.triangles;
    let wanted = if triangles.len() > 400_000 { &[("binned-sah", 2)][..] } else { &[("binned-sah", 2), ("sbvh", 8)] };
    let built = wanted.iter().map(|&(id, arity)| variants().find(|(b, o)| b.id == id && o.arity == arity).unwrap());
    let forest = trees(triangles, &built.collect::<Vec<_>>());
    let mut rays = primary_rays(&scene.camera, 64, 48);
    rays.extend(diffuse_rays(&forest[0].bvh, triangles, &rays, SEED));
    rays.extend(mixed(triangles, SEED, 3000));
    let judged = (TESTS / triangles.len()).clamp(24, 1500);
    let step = rays.len().div_ceil(judged);
    let truths: Vec<_> =
        rays.par_iter().step_by(step).map(|ray| brute_force::<WatertightRay>(triangles, ray)).collect();
    let verdicts = rays
        .par_iter()
        .step_by(step)
        .zip(&truths)
        .map(|(ray, truth)| Oracle::new(triangles, ray, Arithmetic::Watertight).judge(*truth));
    let wrong = verdicts.filter(|v| !v.is_right()).count();
    assert_eq!(wrong, 0, "{}: the oracle has other hits than brute force", scene.name);
    for tree in &forest {
        kernels(scene, tree, &rays, step, &truths);
    }
    let name = Path::new(&scene.name).file_name().unwrap_or_default().to_string_lossy();
    println!(
        "{name}: {} triangles, {} of {} rays judged, {} trees",
        triangles.len(),
        truths.len(),
        rays.len(),
        forest.len()
    );
}

fn kernels(scene: &Scene, tree: &Tree, rays: &[Ray], step: usize, truths: &[Option<Hit>]) {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut exact: Option<String> = None;
    for info in KERNELS {
        let tracer = Tracer::new(info.kernel, &tree.bvh, &scene.triangles);
        let batch = Batch { tracer: &tracer, query: Query::Closest, rays };
        let (hits, _) = one_thread.install(|| count_batch(&batch));
        let mut again = Vec::new();
        for level in Simd::available() {
            let other = tracer.clone().at_level(level);
            trace_batch(&Batch { tracer: &other, ..batch }, &mut again);
            assert!(again == hits, "{}: {} on {} by {level:?}", scene.name, info.id, tree.name);
        }
        if info.kernel.is_exact() {
            let wrong = hits.iter().step_by(step).zip(truths).filter(|(hit, truth)| **hit != HitRecord::from(**truth));
            assert_eq!(wrong.count(), 0, "{}: {} on {}", scene.name, info.id, tree.name);
            let hash = hit_hash(&hits);
            assert_eq!(
                *exact.get_or_insert_with(|| hash.clone()),
                hash,
                "{}: {} on {}",
                scene.name,
                info.id,
                tree.name
            );
        }
    }
}
