//! What the fuzz targets of `fuzz/` do with their bytes, driven without a fuzzer: a few thousand executions each in every test run,
//! and ten million on demand:
//!
//! ```text
//! FUZZ_SEED=1 cargo test --release --test fuzz -- --ignored --nocapture
//! ```
//!
//! The seed is printed, and what makes an execution fail as well; `FUZZ_ONLY=builders:1234` runs one execution again.

mod builders;
mod bytes;
mod inputs;
mod kernels;
mod loader;
#[path = "../support/variants.rs"]
mod variants;

use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// No execution may take longer; most take microseconds.
const MOST: Duration = Duration::from_secs(20);

/// Runs `target` so many times, on all threads. `input` gives the bytes of an execution from its random numbers. An execution that
/// does not end ends the process, with its number.
fn drive<T>(
    name: &str,
    seed: u64,
    executions: u64,
    input: impl Fn(&mut Pcg64Mcg) -> Vec<u8> + Sync,
    start: impl Fn() -> T + Sync,
    target: impl Fn(&T, &[u8]) + Sync,
) {
    const CHUNK: u64 = 1000;
    let begin = Instant::now();
    let micros = || begin.elapsed().as_micros() as u64;
    let slowest = AtomicU64::new(0);
    // What each thread is at, and since when; 0 for nothing.
    let at: Vec<_> = (0..rayon::current_num_threads()).map(|_| [(); 2].map(|()| AtomicU64::new(0))).collect();
    let done = AtomicBool::new(false);
    let watch = || {
        while !done.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(10));
            for [execution, since] in &at {
                let since = since.load(Ordering::Relaxed);
                if since > 0 && micros().saturating_sub(since) > MOST.as_micros() as u64 {
                    println!(
                        "target {name}, seed {seed}, execution {} does not end",
                        execution.load(Ordering::Relaxed)
                    );
                    std::process::abort();
                }
            }
        }
    };
    let chunk = |chunk: u64| {
        let state = start();
        let [execution, since] = &at[rayon::current_thread_index().unwrap_or(0)];
        for i in chunk * CHUNK..executions.min((chunk + 1) * CHUNK) {
            let data = input(&mut Pcg64Mcg::new(u128::from(seed) << 64 | u128::from(2 * i + 1)));
            let one = micros();
            execution.store(i, Ordering::Relaxed);
            since.store(one.max(1), Ordering::Relaxed);
            let ran = catch_unwind(AssertUnwindSafe(|| target(&state, &data)));
            since.store(0, Ordering::Relaxed);
            slowest.fetch_max(micros() - one, Ordering::Relaxed);
            assert!(ran.is_ok(), "target {name}, seed {seed}, execution {i}: {data:?}");
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(watch);
        // The watch ends in any case, lest a failure wait for it.
        let ran = catch_unwind(AssertUnwindSafe(|| (0..executions.div_ceil(CHUNK)).into_par_iter().for_each(chunk)));
        done.store(true, Ordering::Relaxed);
        ran.unwrap_or_else(|why| resume_unwind(why));
    });
    let (seconds, slowest) = (begin.elapsed().as_secs_f64(), slowest.into_inner());
    println!("{name}: {executions} executions, seed {seed}, {seconds:.1} s, the slowest {slowest} µs");
}

fn run(seed: u64, loader: u64, builders: u64, kernels: u64) {
    let files = inputs::files();
    let load = |folder: &tempfile::TempDir, data: &[u8]| loader::run(folder.path(), data);
    // In memory where there is such a place: a file is written for each execution.
    let memory = Path::new("/dev/shm");
    let folder = || tempfile::tempdir_in(memory).or_else(|_| tempfile::tempdir()).expect("a folder for files");
    if let Ok(only) = std::env::var("FUZZ_ONLY") {
        let (target, i) = only.split_once(':').expect("FUZZ_ONLY is TARGET:EXECUTION");
        let random =
            &mut Pcg64Mcg::new(u128::from(seed) << 64 | u128::from(2 * i.parse::<u64>().expect("a number") + 1));
        return match target {
            "loader" => load(&folder(), &inputs::damaged(&files, random)),
            "builders" => builders::run(&inputs::random(random)),
            _ => kernels::run(&inputs::random(random)),
        };
    }
    drive("loader", seed, loader, |random| inputs::damaged(&files, random), folder, load);
    drive("builders", seed, builders, inputs::random, || (), |(), data| builders::run(data));
    drive("kernels", seed, kernels, inputs::random, || (), |(), data| kernels::run(data));
}

#[test]
fn a_few_thousand_executions() {
    run(1, 4000, 4000, 8000);
}

/// The files that damage is done to are fine themselves, all but the packed fragment.
#[test]
fn whole_files_load() {
    let folder = tempfile::tempdir().unwrap();
    let mut fine = 0;
    for file in inputs::files() {
        let ending = loader::ENDINGS[usize::from(file[0])];
        let path = folder.path().join(format!("whole.{ending}"));
        std::fs::write(&path, &file[1..]).unwrap();
        let loaded = match ending {
            "bvh" => bvh_lab::bvh::file::read(&path, &loader::SCENE).map(drop).map_err(|e| e.to_string()),
            _ => bvh_lab::scene::Scene::load(path.to_str().unwrap()).map(drop).map_err(|e| e.to_string()),
        };
        match loaded {
            Ok(()) => fine += 1,
            Err(e) => println!("{e}"),
        }
    }
    assert_eq!(fine, 11);
}

#[test]
#[ignore = "takes about a quarter of an hour"]
fn ten_million_executions() {
    let seed = std::env::var("FUZZ_SEED").map_or(1, |seed| seed.parse().expect("FUZZ_SEED is a number"));
    run(seed, 5_000_000, 1_000_000, 4_000_000);
}
