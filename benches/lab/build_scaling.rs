//! Group `build_scaling`: every builder, its arities, sizes from 1,000 to 100,000 triangles.

use crate::subject::Subject;
use bvh_lab::build::{BUILDERS, BuildOptions, Engine};
use criterion::{BenchmarkId, Criterion, Throughput};
use std::hint::black_box;
use std::time::Duration;

const SIZES: [usize; 3] = [1_000, 10_000, 100_000];

/// Names are `build_scaling/BUILDER[ PRESET] k=ARITY/TRIANGLES`, on the family `spheres`.
pub fn group(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("build_scaling");
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    for size in SIZES {
        let subject = Subject::load(&format!("gen:spheres:{size}"));
        group.throughput(Throughput::Elements(size as u64));
        for builder in BUILDERS {
            // What the literal engines take, `scaling` measures: minutes, not milliseconds.
            let variants = builder.variants(BuildOptions::default());
            for options in variants.into_iter().filter(|o| builder.engine(o) != Some(Engine::Literal)) {
                let preset = builder.preset(&options).map_or(String::new(), |p| format!(" {}", p.id()));
                let name = format!("{}{preset} k={}", builder.id, options.arity);
                let mut verified = false;
                group.bench_function(BenchmarkId::new(name, size), |bencher| {
                    // Here, so that what a filter leaves out costs nothing.
                    if !std::mem::replace(&mut verified, true) {
                        subject.verified(builder, &options);
                    }
                    bencher.iter(|| black_box(subject.build(builder, &options)));
                });
            }
        }
    }
    group.finish();
}
