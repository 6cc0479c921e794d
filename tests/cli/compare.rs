//! `compare`: builders side by side, each with its cost and its work.

use crate::support::{Lab, check_spread, has_fields, number, word};
use bvh_lab::build::{BUILDERS, BuildOptions, Engine};

#[test]
fn every_builder_stands_there_with_every_figure() {
    let lab = Lab::new();
    let report = lab.json("compare gen:spheres:200 -k 2,4 --size 24x24 --runs 1");
    has_fields(&report, &["scene", "triangles", "dropped", "threads", "rays", "builders"]);
    assert_eq!(report["rays"], 24 * 24);
    let entries = report["builders"].as_array().unwrap();
    // Every reading that a builder has, at two arities.
    let all = BUILDERS.iter().flat_map(|b| b.variants(BuildOptions::default()));
    assert_eq!(entries.len(), all.filter(|o| o.engine == Engine::Exact && [2, 4].contains(&o.arity)).count());
    for entry in entries {
        let figures = ["sah", "epo", "nodes_per_ray", "box_tests_per_ray", "tri_tests_per_ray", "bytes"];
        assert!(figures.iter().all(|f| number(entry, f) > 0.0), "{entry}");
        assert_eq!((check_spread(&entry["build_ms"]), &entry["status"]), (1, &"ok".into()));
        assert_eq!(entry["hit_hash"], entries[0]["hit_hash"], "all trees answer alike");
        let preset = entry["preset"].as_str().map(|preset| format!("--preset {preset}")).unwrap_or_default();
        let build =
            format!("build gen:spheres:200 -b {} {preset} -k {} --runs 1", word(entry, "builder"), entry["arity"]);
        assert_eq!(lab.json(&build)["tree_hash"], entry["tree_hash"], "{build}");
    }
}

#[test]
fn a_capped_builder_leaves_a_gap_and_stops_nobody() {
    let lab = Lab::new();
    let words = "compare thesis:small -b top-down,bottom-up -k 8 --preset published --engine literal --budget 0.002 --size 8x8 --runs 1";
    let report = lab.json(words);
    let entries = report["builders"].as_array().unwrap();
    assert_eq!(entries.len(), 2);
    assert!(["capped", "projected"].contains(&word(&entries[0], "status").as_str()), "{}", entries[0]);
    assert!(entries[0]["build_ms"]["median"].is_null());
    for field in ["sah", "nodes_per_ray", "mrays_per_s", "hit_hash"] {
        assert!(entries[0][field].is_null(), "{field}");
    }
    let text = lab.fine(words);
    assert!(text.contains("capped") && text.contains("bottom-up"), "{text}");
}

#[test]
fn either_engine_compares() {
    let lab = Lab::new();
    let hashes = ["exact", "literal"].map(|engine| {
        let report =
            lab.json(&format!("compare gen:slivers:80 -b top-down,bottom-up --engine {engine} --size 8x8 --runs 1"));
        let entries = report["builders"].as_array().unwrap().clone();
        assert!(entries.len() == 5 && entries.iter().all(|e| e["engine"] == engine));
        entries.iter().map(|e| word(e, "tree_hash")).collect::<Vec<_>>()
    });
    assert_eq!(hashes[0], hashes[1]);
}

#[test]
fn the_table_has_a_line_per_builder() {
    let lab = Lab::new();
    let text = lab.fine("compare gen:soup:30 -b bottom-up --size 8x8 --runs 1");
    assert!(
        ["published", "text", "walter"].iter().all(|p| text.lines().filter(|l| l.contains(p)).count() == 1),
        "{text}"
    );
}
