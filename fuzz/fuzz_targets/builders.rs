//! `cargo +nightly fuzz run builders`: boxes and triangles through a builder.
#![no_main]
// Each target uses a part of what they share.
#![allow(dead_code)]

#[path = "../../tests/fuzz/builders.rs"]
mod builders;
#[path = "../../tests/fuzz/bytes.rs"]
mod bytes;
#[path = "../../tests/support/variants.rs"]
mod variants;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| builders::run(data));
