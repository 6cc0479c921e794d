//! `cargo +nightly fuzz run builders`: boxes and triangles through a builder.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| bvh_lab_fuzz::builders::run(data));
