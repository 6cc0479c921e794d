//! `cargo +nightly fuzz run kernels`: triangles and rays through every kernel.
#![no_main]
// Each target uses a part of what they share.
#![allow(dead_code)]

#[path = "../../tests/fuzz/builders.rs"]
mod builders;
#[path = "../../tests/fuzz/bytes.rs"]
mod bytes;
#[path = "../../tests/fuzz/kernels.rs"]
mod kernels;
#[path = "../../tests/support/variants.rs"]
mod variants;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| kernels::run(data));
