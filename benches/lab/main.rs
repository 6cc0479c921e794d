//! Benchmarks of everything that makes or walks a tree, for those who change the code: builds against size, arity and builder;
//! refinement; tracing kernels. Every answer is verified once before it is timed. `benches/README.md` says how two commits
//! are compared.

mod build_scaling;
mod refine;
mod subject;
mod trace;

use criterion::{criterion_group, criterion_main};

criterion_group!(lab, build_scaling::group, refine::group, trace::group);
criterion_main!(lab);
