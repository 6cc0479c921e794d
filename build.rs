//! Tells the program which commit it was built from, so that every row can name it.

use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=src");
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    // A package unpacked inside some other checkout must not name that checkout's commit.
    let ours = git(&["ls-files", "--error-unmatch", "build.rs"]).is_some();
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| ours).map(|commit| {
        let changed = git(&["status", "--porcelain", "--untracked-files=no", "src", "Cargo.toml"]);
        if changed.is_some_and(|c| !c.is_empty()) { format!("{commit}-modified") } else { commit }
    });
    println!("cargo::rustc-env=BVH_LAB_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}
