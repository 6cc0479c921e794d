//! The rows that are not about one ray at a time.

use crate::cases::SEED;
use crate::hard_scenes::nested;
use crate::judge::{Tree, name, trees};
use crate::rays::mixed;
use crate::scenes::scaled;
use crate::variants::variants;
use bvh_lab::build::{Brake, BuildError, BuildOptions, Builder, Engine, Input};
use bvh_lab::bvh::{quantised, tree_hash};
use bvh_lab::geom::{Aabb, Hit, Ray, Triangle};
use bvh_lab::refine::STEPS;
use bvh_lab::scene::Scene;
use bvh_lab::simd::Simd;
use bvh_lab::trace::{
    Batch, HitRecord, KERNELS, Kernel, KernelInfo, Query, Scratch, Tracer, count_batch, hit_bytes, trace_batch,
};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::io::Write;

type Variant = (&'static Builder, BuildOptions);

fn soup(n: usize) -> Vec<Triangle> {
    Scene::load(&format!("gen:soup:{n}")).unwrap().triangles
}

/// Answers, byte for byte.
fn answers(tracer: &Tracer, rays: &[Ray]) -> Vec<u8> {
    let mut scratch = Scratch::default();
    let hits = rays.iter().map(|ray| tracer.trace(Query::Closest, ray, &mut scratch, &mut ()).into());
    hit_bytes(&hits.collect::<Vec<HitRecord>>())
}

fn every_kernel(trees: &[Tree], check: impl Fn(&Tree, &KernelInfo) + Sync) {
    trees.par_iter().for_each(|tree| KERNELS.iter().for_each(|info| check(tree, info)));
}

/// Row 8, its first case.
#[test]
fn nothing_to_trace_is_a_clean_error() {
    for (builder, options) in variants() {
        let built = (builder.timed)(Input::of_triangles(&[], &[]), &options, &mut Brake::default());
        assert_eq!(built, Err(BuildError::NoTriangles), "{}", name(builder, &options));
    }
}

/// Row 9: on threads with hardly any stack, the deepest tree is built, refined, traced and dropped.
#[test]
fn no_call_stack_grows_with_depth() {
    // A builder's bins take 100 KiB of it. The trees are hundreds of levels deep: a call a level would take far more than the rest.
    const STACK: usize = 384 << 10;
    let work = || {
        let triangles = nested();
        let rays = mixed(&triangles, SEED, 20);
        let exact = variants().filter(|(b, o)| b.engine(o) != Some(Engine::Literal));
        let steps = crate::refined().into_iter().chain(exact);
        // One after the other: a thread that waits for its part of a build must not begin another on the same stack.
        let mut deepest = 0;
        for variant in steps {
            let tree = trees(&triangles, &[variant]).remove(0);
            deepest = deepest.max(depth(&tree));
            for info in KERNELS {
                answers(&Tracer::new(info.kernel, &tree.bvh, &triangles), &rays);
            }
        }
        println!("row 9: the deepest tree has {deepest} levels");
        assert!(deepest > 400, "{deepest}");
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(STACK).build().unwrap();
    pool.install(work);
}

fn depth(tree: &Tree) -> usize {
    let mut depths = vec![1; tree.bvh.nodes.len()];
    for node in 0..tree.bvh.nodes.len() {
        tree.bvh.children(node).for_each(|child| depths[child] = depths[node] + 1);
    }
    depths.into_iter().max().unwrap()
}

/// Row 10: at load such triangles are dropped and counted, and their neighbours stay what they were.
#[test]
fn triangles_that_are_no_numbers_are_left_out() {
    let fine = soup(40);
    let mut text = String::new();
    for (i, triangle) in fine.iter().enumerate() {
        let bad = ["nan", "inf", "-inf", "1e60"][i % 4];
        for p in triangle.v {
            text += &format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z);
        }
        text += &format!(
            "v {bad} 0 0\nf {} {} {}\nf {} {} {}\n",
            4 * i + 1,
            4 * i + 2,
            4 * i + 3,
            4 * i + 2,
            4 * i + 3,
            4 * i + 4
        );
    }
    let mut file = tempfile::Builder::new().suffix(".obj").tempfile().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    let scene = Scene::load(file.path().to_str().unwrap()).unwrap();
    assert_eq!((scene.dropped.not_finite, scene.triangles), (40, fine.clone()));
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut triangles = fine.clone();
        triangles[7].v[1].y = value;
        let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
        for (builder, options) in variants() {
            let of_triangles =
                (builder.timed)(Input::of_triangles(&triangles, &boxes), &options, &mut Brake::default());
            let mut bad = boxes.clone();
            bad[7] = Aabb::new(Vec3::splat(value), Vec3::splat(value));
            let of_boxes = (builder.timed)(Input::of_boxes(&bad), &options, &mut Brake::default());
            assert_eq!(of_boxes, Err(BuildError::InvalidBox(7)), "{}", name(builder, &options));
            // Comparisons leave a NaN out of a box: then it is a box of numbers, and builders have no cause to refuse it.
            assert!(
                of_triangles.is_ok() || of_triangles == Err(BuildError::InvalidBox(7)),
                "{}",
                name(builder, &options)
            );
        }
    }
}

/// Row 12. The thesis' thresholds are absolute: for its kernel only that no answer makes trouble.
#[test]
fn powers_of_two_scale_t_and_nothing_else() {
    let here = soup(60);
    let rays = mixed(&here, SEED, 70);
    let variants: Vec<_> = variants().collect();
    let trees_here = trees(&here, &variants);
    let mut published_differs = 0;
    for exponent in [-36, 30] {
        let factor = 2f32.powi(exponent);
        let there = scaled(&here, exponent);
        for (tree, other) in trees_here.iter().zip(trees(&there, &variants)) {
            assert_eq!(tree_hash(&tree.bvh), tree_hash(&other.bvh), "{} times 2^{exponent}", tree.name);
            for info in KERNELS {
                let mut scratch = Scratch::default();
                let [a, b] = [(&tree.bvh, &here), (&other.bvh, &there)].map(|(b, t)| Tracer::new(info.kernel, b, t));
                for ray in &rays {
                    let far = Ray {
                        origin: ray.origin * factor,
                        t_min: ray.t_min * factor,
                        t_max: ray.t_max * factor,
                        ..*ray
                    };
                    let hit = a.trace(Query::Closest, ray, &mut scratch, &mut ());
                    let scaled = b.trace(Query::Closest, &far, &mut scratch, &mut ());
                    let same = hit.map(|h| Hit { t: h.t * factor, ..h }) == scaled;
                    if matches!(info.kernel, Kernel::FirstLeaf(_)) {
                        published_differs += usize::from(!same);
                    } else {
                        assert!(same, "{} on {} times 2^{exponent}, {ray:?}: {hit:?} {scaled:?}", info.id, tree.name);
                    }
                }
            }
        }
    }
    println!("row 12: first-leaf answers {published_differs} rays otherwise in a scaled scene");
    assert!(published_differs > 0, "the thesis' thresholds are absolute");
}

/// Row 19, and that tracing by such boxes changes no answer.
#[test]
fn boxes_in_few_bits_contain_the_exact_ones() {
    for triangles in [soup(100), nested(), crate::hard_scenes::far()] {
        let exact = variants().filter(|(b, o)| b.engine(o) != Some(Engine::Literal));
        let rays = mixed(&triangles, SEED, 40);
        for tree in trees(&triangles, &exact.collect::<Vec<_>>()) {
            for bits in [4, 8, 16] {
                let stored = quantised(&tree.bvh, bits);
                let around = stored.nodes.iter().zip(&tree.bvh.nodes).all(|(s, e)| s.aabb.contains(&e.aabb));
                assert!(around, "{} in {bits} bits", tree.name);
                for kernel in [Kernel::Scalar, Kernel::from_id("bvh8").unwrap()] {
                    let [a, b] = [&tree.bvh, &stored].map(|bvh| answers(&Tracer::new(kernel, bvh, &triangles), &rays));
                    assert!(a == b, "{} in {bits} bits", tree.name);
                }
            }
        }
    }
}

/// Row 20; on the thesis' scenes in `tests/engines`.
#[test]
fn engines_build_the_same_trees() {
    let all: Vec<Variant> = variants().filter(|(b, _)| b.engines.len() > 1).collect();
    for triangles in [soup(90), crate::scenes::grid(SEED, 90), nested().into_iter().step_by(6).collect()] {
        let mut hashes: HashMap<String, _> = HashMap::new();
        for (tree, (builder, options)) in trees(&triangles, &all).iter().zip(&all) {
            let reading = name(builder, &BuildOptions { engine: Engine::Exact, ..*options });
            let hash = tree_hash(&tree.bvh);
            assert_eq!(*hashes.entry(reading).or_insert(hash), hash, "{}", tree.name);
        }
        assert_eq!(hashes.len(), all.len() / 2);
    }
}

/// Row 21.
#[test]
fn order_threads_and_instructions_change_nothing() {
    let triangles = soup(3000);
    let rays = mixed(&triangles, SEED, 3000);
    let exact: Vec<_> =
        variants().filter(|(b, o)| b.engine(o) != Some(Engine::Literal) && b.presets.is_empty()).collect();
    let pools = [1, 2, 5].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    let forests = pools.each_ref().map(|pool| pool.install(|| trees(&triangles, &exact)));
    for i in 0..exact.len() {
        let hashes = forests.each_ref().map(|trees| tree_hash(&trees[i].bvh));
        assert!(hashes.iter().all(|h| *h == hashes[0]), "{}", forests[0][i].name);
    }
    // A step of 1,009, a prime, visits all 3,000 once.
    let order: Vec<_> = (0..rays.len()).map(|i| i * 1009 % rays.len()).collect();
    let permuted: Vec<_> = order.iter().map(|&i| rays[i]).collect();
    every_kernel(&forests[0], |tree, info| {
        let tracer = Tracer::new(info.kernel, &tree.bvh, &triangles);
        let batch = Batch { tracer: &tracer, query: Query::Closest, rays: &rays };
        let (expected, _) = count_batch(&batch);
        let mut hits = Vec::new();
        for pool in &pools {
            pool.install(|| trace_batch(&batch, &mut hits));
            assert!(hit_bytes(&hits) == hit_bytes(&expected), "{} on {}", info.id, tree.name);
        }
        let (other_order, _) = count_batch(&Batch { rays: &permuted, ..batch });
        assert!(order.iter().zip(&other_order).all(|(&i, hit)| *hit == expected[i]), "{} on {}", info.id, tree.name);
        for level in Simd::available() {
            let other = tracer.clone().at_level(level);
            trace_batch(&Batch { tracer: &other, ..batch }, &mut hits);
            assert!(hit_bytes(&hits) == hit_bytes(&expected), "{} on {} by {level:?}", info.id, tree.name);
        }
    });
    assert!(STEPS.len() > 2 && exact.len() > 20);
}
