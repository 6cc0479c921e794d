//! The examples run, and print and draw what they promise; the cases that take seconds only.

use std::path::Path;
use std::process::Command;

/// Runs an example in `folder` as a user would, by the profile and into the target folder of this test; returns what it prints.
fn run(name: &str, words: &[&str], folder: &Path) -> String {
    // …/target/PROFILE/deps/examples-…
    let this = std::env::current_exe().unwrap();
    let target = this.ancestors().nth(3).unwrap();
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["run", "--quiet", "--offline", "--example", name, "--manifest-path"]).arg(manifest);
    cargo.arg("--target-dir").arg(target).current_dir(folder);
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    let output = cargo.arg("--").args(words).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{name}: {said}{}", String::from_utf8_lossy(&output.stderr));
    said
}

#[test]
fn build_and_trace_tells_of_a_tree_and_a_hit() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("build_and_trace", &["thesis:tiny"], folder.path());
    assert!(said.starts_with("thesis:tiny: 648 triangles, "), "{said}");
    assert!(said.contains("SAH ") && said.contains("the middle of the picture shows triangle "), "{said}");
}

#[test]
fn compare_builders_lists_each_with_its_cost() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("compare_builders", &["gen:spheres:2000"], folder.path());
    let lines: Vec<_> = said.lines().collect();
    assert_eq!(lines[0], "gen:spheres:2000: 2000 triangles");
    for (line, builder) in lines[1..].iter().zip(["sweep-sah", "binned-sah", "lbvh", "ploc", "sbvh"]) {
        assert!(line.starts_with(builder) && line.contains(" ms, SAH ") && !line.contains("NaN"), "{line}");
    }
    assert_eq!(lines.len(), 6, "{said}");
}

#[test]
fn picture_draws_one_and_counts_its_rays() {
    let folder = tempfile::tempdir().unwrap();
    let cube = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cube.obj");
    let said = run("picture", &[cube.to_str().unwrap(), "cube.png"], folder.path());
    assert!(said.contains("7680000 primary rays"), "{said}");
    let picture = image::open(folder.path().join("cube.png")).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (800, 600));
    assert!(picture.get_pixel(400, 300) != picture.get_pixel(0, 0), "nothing is in the middle");
}

#[test]
fn trace_many_hits_the_same_by_exact_kernels_and_counts_its_rays() {
    let folder = tempfile::tempdir().unwrap();
    let [scalar, wide, small, published] = ["scalar", "bvh8", "bvh8-q8", "first-leaf"]
        .map(|kernel| run("trace_many", &[kernel, "gen:hairball:2000"], folder.path()));
    assert!(scalar.starts_with("262144 rays, hits "), "{scalar}");
    assert_eq!((&scalar, &scalar), (&wide, &small));
    assert_ne!(scalar, published);
}

#[test]
fn several_splits_ahead_compares_every_way_at_every_arity() {
    let folder = tempfile::tempdir().unwrap();
    let said = run("several_splits_ahead", &["gen:spheres:300"], folder.path());
    let rows = said.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| tree"));
    assert_eq!(rows.count(), 8 * 3, "{said}");
    assert!(said.contains("gen:spheres:300: 300 triangles") && !said.contains("NaN"), "{said}");
}
