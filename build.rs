//! Tells the program what it was built from, so that every row can name it: the commit, and where the sources are not
//! those of a commit, a fingerprint of them.

use std::collections::hash_map::DefaultHasher;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

#[cfg(feature = "peers")]
#[path = "benches/peers/shim.rs"]
mod shim;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

/// Everything the program is made of.
const SOURCES: [&str; 4] = ["src", "Cargo.toml", "Cargo.lock", "build.rs"];

fn files(path: &Path, found: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| files(&entry.path(), found)),
        Err(_) => found.push(path.into()),
    }
}

fn fingerprint() -> u64 {
    let mut found = Vec::new();
    SOURCES.iter().for_each(|source| files(Path::new(source), &mut found));
    found.sort();
    let mut hasher = DefaultHasher::new();
    for file in found {
        file.hash(&mut hasher);
        std::fs::read(&file).unwrap_or_default().hash(&mut hasher);
    }
    hasher.finish()
}

fn main() {
    SOURCES.iter().for_each(|source| println!("cargo::rerun-if-changed={source}"));
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    // A package unpacked inside some other checkout must not name that checkout's commit.
    let ours = git(&["ls-files", "--error-unmatch", "build.rs"]).is_some();
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| ours);
    let changed = git(&[&["status", "--porcelain", "--"], &SOURCES[..]].concat()).is_none_or(|c| !c.is_empty());
    let name = match commit {
        Some(commit) if !changed => commit,
        Some(commit) => format!("{commit}-modified-{:016x}", fingerprint()),
        None => format!("unknown-{:016x}", fingerprint()),
    };
    println!("cargo::rustc-env=BVH_LAB_COMMIT={name}");
    #[cfg(feature = "peers")]
    shim::build();
}
