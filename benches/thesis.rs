//! Benchmarks of the thesis' builders by both engines, of its traversal beside an exact one, and of the collapse.
//!
//! Every answer is verified once before it is timed. Rows for reports come from `bvh-lab reproduce`; this is for those
//! who change the code and want to know what it did to its speed.

use bvh_lab::build::{self, Brake, BuildOptions, Builder, Engine, Input, Preset};
use bvh_lab::bvh::{Bvh, Limits, tree_hash, validate};
use bvh_lab::geom::{Aabb, WatertightRay};
use bvh_lab::refine::collapse;
use bvh_lab::scene::Scene;
use bvh_lab::trace::{
    Batch, FirstLeafOptions, Kernel, Query, Tracer, brute_force, count_batch, primary_rays, trace_batch,
};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

/// One tree of the thesis as its program built it, for timing.
struct Tree {
    builder: &'static Builder,
    options: BuildOptions,
    boxes: Vec<Aabb>,
}

impl Tree {
    fn new(scene: &Scene, id: &str, arity: usize, engine: Engine) -> Self {
        let builder = build::find(id).expect("the benchmark names builders that are registered");
        let options = BuildOptions { arity, preset: Preset::Published, engine, ..BuildOptions::default() };
        Self { builder, options, boxes: scene.boxes() }
    }

    fn build(&self) -> Bvh {
        (self.builder.timed)(Input::of_boxes(&self.boxes), &self.options, &mut Brake::default())
            .expect("thesis scenes can be built over")
    }

    /// A tree that is valid and comes out the same twice.
    fn verified(&self) -> Bvh {
        let bvh = self.build();
        let limits = Limits::default();
        validate(&bvh, &self.boxes, &limits).expect("only valid trees are timed");
        assert_eq!(tree_hash(&bvh), tree_hash(&self.build()));
        bvh
    }
}

fn load(name: &str) -> Scene {
    Scene::load(name).expect("thesis scenes are generated")
}

fn builds(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("build");
    group.sample_size(10);
    for name in ["thesis:tiny", "thesis:small"] {
        let scene = load(name);
        group.throughput(Throughput::Elements(scene.triangles.len() as u64));
        for (id, arity) in [("top-down", 2), ("top-down", 4), ("bottom-up", 2)] {
            let trees = Engine::ALL.map(|engine| Tree::new(&scene, id, arity, engine));
            let hashes = trees.each_ref().map(|tree| tree_hash(&tree.verified()));
            assert_eq!(hashes[0], hashes[1], "both engines build the same tree");
            for tree in &trees {
                let cell = format!("{id} published {arity} {}", tree.options.engine.id());
                group.bench_function(BenchmarkId::new(cell, name), |bencher| {
                    bencher.iter(|| black_box(tree.build()));
                });
            }
        }
    }
    group.finish();
}

fn traces(criterion: &mut Criterion) {
    /// Every so many rays one is held against brute force.
    const CHECKED: usize = 149;
    let mut group = criterion.benchmark_group("trace");
    group.sample_size(20);
    let scene = load("thesis:med");
    let bvh = Tree::new(&scene, "top-down", 2, Engine::Exact).verified();
    let rays = primary_rays(&scene.camera, 256, 256);
    group.throughput(Throughput::Elements(rays.len() as u64));
    // One thread: what is compared is kernels, not schedulers.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    for (id, kernel) in [("scalar", Kernel::Scalar), ("first-leaf", Kernel::FirstLeaf(FirstLeafOptions::default()))] {
        let tracer = Tracer::new(kernel, &bvh, &scene.triangles);
        let batch = Batch { tracer: &tracer, query: Query::Closest, rays: &rays };
        let (expected, _) = count_batch(&batch);
        for (ray, found) in rays.iter().zip(&expected).step_by(CHECKED).filter(|_| kernel.is_exact()) {
            let closest = brute_force::<WatertightRay>(&scene.triangles, ray);
            assert_eq!(found.is_hit().then_some((found.triangle, found.t)), closest.map(|hit| (hit.triangle, hit.t)));
        }
        let mut hits = Vec::new();
        one.install(|| trace_batch(&batch, &mut hits));
        assert!(hits == expected, "{id}: a timed pass must see what a counted one saw");
        group.bench_function(BenchmarkId::new(id, "thesis:med primary"), |bencher| {
            one.install(|| bencher.iter(|| trace_batch(black_box(&batch), &mut hits)));
        });
    }
    group.finish();
}

fn collapses(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("collapse");
    let scene = load("thesis:med");
    let tree = Tree::new(&scene, "bottom-up", 2, Engine::Exact);
    let binary = tree.verified();
    group.throughput(Throughput::Elements(binary.nodes.len() as u64));
    for arity in [4, 8] {
        let wide = collapse(&binary, arity);
        validate(&wide, &tree.boxes, &Limits::default()).expect("a collapsed tree is valid");
        group.bench_function(BenchmarkId::new(arity.to_string(), "thesis:med bottom-up"), |bencher| {
            bencher.iter(|| black_box(collapse(&binary, arity)));
        });
    }
    group.finish();
}

criterion_group!(thesis, builds, traces, collapses);
criterion_main!(thesis);
