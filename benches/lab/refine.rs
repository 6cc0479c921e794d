//! Group `refine`: every step and every collapse on trees of one triangle a leaf, and the refit.

use crate::subject::Subject;
use bvh_lab::build::{BuildOptions, MAX_LEAF, find};
use bvh_lab::bvh::{Bvh, Limits, validate};
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::refine::{Collapse, STEPS, Watch, refit};
use criterion::{BatchSize, BenchmarkId, Criterion, Throughput};
use std::hint::black_box;
use std::time::Duration;

const SCENES: [&str; 2] = ["gen:spheres:20000", "gen:hairball:20000"];

/// Names are `refine/STEP/SCENE` and `refine/collapse-WAY k=ARITY/SCENE`.
pub fn group(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("refine");
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    for name in SCENES {
        let subject = Subject::load(name);
        group.throughput(Throughput::Elements(subject.boxes.len() as u64));
        let ploc = find("ploc").expect("it is registered");
        let single = subject.verified(ploc, &BuildOptions { max_leaf: Some(1), ..BuildOptions::default() });
        let limits = Limits { max_leaf: MAX_LEAF, ..Limits::default() };
        let cost = |bvh: &Bvh| sah(bvh, SahParams::default());
        for info in STEPS {
            group.bench_function(BenchmarkId::new(info.id, name), |bencher| {
                let refined = (info.apply)(&single, MAX_LEAF, &mut Watch::new(&mut |_| true));
                validate(&refined, &subject.boxes, &limits).expect("a refined tree is valid");
                assert!(cost(&refined) <= cost(&single), "{}", info.id);
                bencher.iter(|| black_box((info.apply)(&single, MAX_LEAF, &mut Watch::new(&mut |_| true))));
            });
        }
        for way in Collapse::ALL {
            for arity in [4, 8, 16] {
                let id = BenchmarkId::new(format!("collapse-{} k={arity}", way.id()), name);
                group.bench_function(id, |bencher| {
                    let wide = way.apply(&single, arity, MAX_LEAF);
                    validate(&wide, &subject.boxes, &limits).expect("a collapsed tree is valid");
                    bencher.iter(|| black_box(way.apply(&single, arity, MAX_LEAF)));
                });
            }
        }
        group.bench_function(BenchmarkId::new("refit", name), |bencher| {
            bencher.iter_batched_ref(|| single.clone(), |bvh| refit(bvh, &subject.boxes), BatchSize::LargeInput);
        });
    }
    group.finish();
}
