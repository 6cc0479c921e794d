//! What the fuzz targets run: the same code that `tests/fuzz` drives without a fuzzer.

#[path = "../../tests/fuzz/builders.rs"]
pub mod builders;
#[path = "../../tests/fuzz/bytes.rs"]
pub mod bytes;
#[path = "../../tests/fuzz/kernels.rs"]
pub mod kernels;
#[path = "../../tests/fuzz/loader.rs"]
pub mod loader;
#[path = "../../tests/support/variants.rs"]
pub mod variants;
