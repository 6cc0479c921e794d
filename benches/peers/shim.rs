//! Part of the build script under the feature `peers`: compiles the shim on tinybvh's header where that lies in its
//! package, and tells the benchmark the versions of all peers.

use std::path::PathBuf;
use std::process::Command;

/// Packages whose version the benchmark names in its rows.
const PEERS: [&str; 4] = ["bvh", "obvhs", "parry3d", "tinybvh-rs"];

/// Where the header lies in the package tinybvh-rs, which has no `links` key that would tell.
const HEADER: &str = "ffi/tinybvh";

/// Asks cargo for the packages, compiles, and passes on what the benchmark needs.
pub fn build() {
    println!("cargo::rerun-if-changed=benches/peers/tinybvh.cpp");
    println!("cargo::rerun-if-changed=benches/peers/shim.rs");
    let packages = packages();
    let versions =
        PEERS.map(|peer| format!("{peer}={}", packages.iter().find(|p| p.name == peer).map_or("?", |p| &p.version)));
    println!("cargo::rustc-env=BVH_LAB_PEERS={}", versions.join(","));
    let tinybvh = packages.iter().find(|p| p.name == "tinybvh-rs").expect("the feature peers depends on tinybvh-rs");
    // As tinybvh-rs compiles it.
    cc::Build::new()
        .cpp(true)
        .std("c++20")
        .flag("-march=native")
        .warnings(false)
        .include(tinybvh.folder.join(HEADER))
        .file("benches/peers/tinybvh.cpp")
        .compile("bvh_lab_tinybvh");
}

struct Package {
    name: String,
    version: String,
    folder: PathBuf,
}

fn packages() -> Vec<Package> {
    let variable = |name| std::env::var(name).expect("cargo sets it for build scripts");
    let output = Command::new(variable("CARGO"))
        .args(["metadata", "--format-version", "1", "--offline", "--features", "peers", "--filter-platform"])
        .arg(variable("TARGET"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata prints JSON");
    let all = metadata["packages"].as_array().expect("cargo metadata lists packages");
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let package = |p: &serde_json::Value| {
        let mut folder = PathBuf::from(text(&p["manifest_path"]));
        folder.pop();
        Package { name: text(&p["name"]), version: text(&p["version"]), folder }
    };
    all.iter().map(package).collect()
}
