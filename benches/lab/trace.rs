//! Group `trace`: every kernel on primary, diffuse and any-hit rays, one thread.

use crate::subject::Subject;
use bvh_lab::build::{BuildOptions, find};
use bvh_lab::geom::WatertightRay;
use bvh_lab::trace::{
    Batch, KERNELS, Query, Tracer, brute_force, count_batch, diffuse_rays, primary_rays, shadow_rays, trace_batch,
};
use criterion::{BenchmarkId, Criterion, Throughput};
use std::hint::black_box;
use std::time::Duration;

const SCENES: [&str; 2] = ["gen:spheres:89000", "gen:hairball:20000"];

/// Names are `trace/KERNEL k=ARITY KIND/SCENE`, on trees of `binned-sah`.
pub fn group(criterion: &mut Criterion) {
    /// Every so many rays one is held against brute force.
    const CHECKED: usize = 997;
    let mut group = criterion.benchmark_group("trace");
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    // One thread: what is compared is kernels, not schedulers.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    let builder = find("binned-sah").expect("it is registered");
    for name in SCENES {
        let subject = Subject::load(name);
        let triangles = &subject.scene.triangles;
        for arity in [2, 8] {
            let bvh = subject.verified(builder, &BuildOptions { arity, ..BuildOptions::default() });
            let primary = primary_rays(&subject.scene.camera, 256, 256);
            let diffuse = diffuse_rays(&bvh, triangles, &primary, 1);
            let shadow = shadow_rays(&bvh, triangles, &primary, 1);
            let sets = [
                ("primary", Query::Closest, &primary),
                ("diffuse", Query::Closest, &diffuse),
                ("any", Query::Any, &shadow),
            ];
            for (kind, query, rays) in sets {
                group.throughput(Throughput::Elements(rays.len() as u64));
                for info in KERNELS {
                    let tracer = Tracer::new(info.kernel, &bvh, triangles);
                    let batch = Batch { tracer: &tracer, query, rays };
                    let id = BenchmarkId::new(format!("{} k={arity} {kind}", info.id), name);
                    group.bench_function(id, |bencher| {
                        let (expected, _) = count_batch(&batch);
                        let watertight = info.kernel.is_exact();
                        for (ray, found) in rays.iter().zip(&expected).step_by(CHECKED).filter(|_| watertight) {
                            let closest = brute_force::<WatertightRay>(triangles, ray);
                            assert_eq!(found.is_hit(), closest.is_some(), "{}", info.id);
                            let same = closest
                                .is_none_or(|c| query == Query::Any || (c.triangle, c.t) == (found.triangle, found.t));
                            assert!(same, "{}", info.id);
                        }
                        let mut hits = Vec::new();
                        one.install(|| trace_batch(&batch, &mut hits));
                        assert!(hits == expected, "{}: a timed pass must see what a counted one saw", info.id);
                        one.install(|| bencher.iter(|| trace_batch(black_box(&batch), &mut hits)));
                    });
                }
            }
        }
    }
    group.finish();
}
