//! `cargo +nightly fuzz run kernels`: triangles and rays through every kernel.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| bvh_lab_fuzz::kernels::run(data));
