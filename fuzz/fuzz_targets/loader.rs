//! `cargo +nightly fuzz run loader`: files of every format, the first byte says which.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder for files"));

fuzz_target!(|data: &[u8]| bvh_lab_fuzz::loader::run(FOLDER.path(), data));
