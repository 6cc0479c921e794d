//! `build`: every field of its object, one hash per tree, budgets.

use crate::support::{Lab, check_spread, has_fields, number, tri_bytes, word};
use serde_json::Value;

/// What the interface promises.
const FIELDS: [&str; 23] = [
    "scene",
    "triangles",
    "dropped",
    "builder",
    "arity",
    "preset",
    "engine",
    "costs",
    "threads",
    "status",
    "build_ms",
    "tree_hash",
    "inner",
    "leaves",
    "empty",
    "avg_degree",
    "max_depth",
    "max_leaf",
    "sah",
    "epo",
    "bytes",
    "counters",
    "commit",
];

/// Checks a finished build against itself.
fn check(report: &Value) {
    has_fields(report, &FIELDS);
    assert_eq!(report["status"], "ok", "{report}");
    let count = |field: &str| report[field].as_u64().unwrap_or_else(|| panic!("{field} in {report}"));
    check_spread(&report["build_ms"]);
    let hash = word(report, "tree_hash");
    assert!(hash.len() >= 16 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{hash}");
    let (inner, leaves) = (count("inner"), count("leaves"));
    assert!(leaves >= 1 && count("empty") < leaves && count("max_leaf") <= 4);
    if inner > 0 {
        let degree = (inner + leaves - 1) as f64 / inner as f64;
        assert!((number(report, "avg_degree") - degree).abs() < 1e-9, "{report}");
        assert!(degree <= count("arity") as f64 && count("max_depth") >= 1);
    } else {
        assert!(report["avg_degree"].is_null() && count("max_depth") == 0, "{report}");
    }
    let histogram: Vec<u64> =
        report["leaf_histogram"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
    assert_eq!(histogram.iter().sum::<u64>(), leaves);
    let slots: u64 = (0..).zip(&histogram).map(|(size, n)| size * n).sum();
    assert!(slots >= count("triangles") && (slots == count("triangles") || count("duplicated") > 0), "{report}");
    assert!(count("bytes") >= 4 * slots && number(report, "sah") > 0.0 && number(report, "epo") >= 0.0);
    let counters = report["counters"].as_object().unwrap();
    assert!(inner == 0 || !counters.is_empty() && counters.values().all(Value::is_u64), "{report}");
}

#[test]
fn every_builder_reading_and_arity_answers_in_full() {
    let lab = Lab::new();
    let presets = [("top-down", &["published", "text"][..]), ("bottom-up", &["published", "text", "walter"])];
    for (builder, presets) in presets {
        for preset in presets {
            for arity in [2, 4, 8] {
                let words = format!("gen:spheres:60 -b {builder} -k {arity} --preset {preset} --runs 2");
                let report = lab.json(&format!("build {words}"));
                check(&report);
                assert_eq!(report["build_ms"]["runs"], 2);
                for (field, value) in [("builder", builder), ("preset", preset), ("engine", "exact")] {
                    assert_eq!(report[field], value, "{words}");
                }
                assert_eq!((&report["arity"], &report["triangles"]), (&arity.into(), &60.into()));
                assert_eq!((&report["scene"], &report["dropped"]), (&"gen:spheres:60".into(), &0.into()));
                let again = lab.json(&format!("build {words}"));
                for field in ["tree_hash", "inner", "leaves", "sah", "epo", "bytes", "counters"] {
                    assert_eq!(report[field], again[field], "{words}: {field}");
                }
                // The text's literal search over all planes at arity 8 takes minutes; nine candidates an axis do.
                let few = if (builder, *preset, arity) == ("top-down", "text", 8) { "--candidates 9" } else { "" };
                let [exact, literal] =
                    ["exact", "literal"].map(|e| lab.json(&format!("build {words} {few} --engine {e}")));
                check(&literal);
                assert_eq!(literal["engine"], "literal");
                for field in ["tree_hash", "inner", "leaves", "sah", "epo"] {
                    assert_eq!(exact[field], literal[field], "{words}: {field}");
                }
                assert_ne!(exact["counters"], literal["counters"], "{words}: the work differs");
            }
        }
    }
}

#[test]
fn threads_change_nothing_but_their_number() {
    let lab = Lab::new();
    for builder in ["top-down", "bottom-up", "bottom-up --preset walter", "top-down --preset text"] {
        let reports = [1, 2, 7].map(|threads| {
            let report = lab.json(&format!("build gen:spheres:200 -b {builder} --runs 1 --threads {threads}"));
            // What a build used: one, but where an engine shares its work.
            assert_eq!(report["threads"], if builder.contains("walter") { threads } else { 1 });
            ["tree_hash", "sah", "epo", "counters"].map(|f| report[f].clone())
        });
        assert!(reports[0] == reports[1] && reports[0] == reports[2], "{builder}: {reports:?}");
    }
}

#[test]
fn other_words_other_trees() {
    let lab = Lab::new();
    let hash = |words: &str| word(&lab.json(&format!("build {words} --runs 1")), "tree_hash");
    let mut hashes = vec![
        hash("thesis:tiny"),
        hash("thesis:tiny -k 4"),
        hash("thesis:tiny -b bottom-up"),
        hash("thesis:tiny --candidates 7"),
        hash("thesis:small"),
        hash("gen:soup:648"),
        hash("gen:soup:648:2"),
    ];
    assert_eq!(hash("gen:soup:648:1"), hashes[5], "the seed is 1 unless given");
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 7);
}

#[test]
fn rule_q8_can_be_switched_off_at_arity_8_and_nowhere_else() {
    let lab = Lab::new();
    let build = |words: &str| lab.json(&format!("build gen:spheres:300 --candidates 9 --runs 1 {words}"));
    let (on, off) = (build("-k 8"), build("-k 8 --q8 off"));
    check(&on);
    check(&off);
    assert_eq!(on["tree_hash"], build("-k 8 --q8 on")["tree_hash"]);
    assert_ne!(on["tree_hash"], off["tree_hash"]);
    assert!(number(&on, "duplicated") > 0.0 && number(&on, "empty") > 0.0);
    let q8_nodes = |r: &Value| r["counters"].get("q8_nodes").map_or(0, |n| n.as_u64().unwrap());
    assert!(q8_nodes(&on) > 0 && q8_nodes(&off) == 0);
    assert_eq!([&off["duplicated"], &off["q8_hidden"], &off["empty"]], [0, 0, 0]);
    assert_eq!(build("-k 4")["tree_hash"], build("-k 4 --q8 off")["tree_hash"]);
}

#[test]
fn a_budget_that_is_too_small_caps_and_projects() {
    let lab = Lab::new();
    for words in ["thesis:med -k 8", "thesis:tiny -k 8 --preset text", "thesis:large -b bottom-up --preset walter"] {
        let words = format!("{words} --engine literal");
        let report = lab.json(&format!("build {words} --budget 0.001"));
        has_fields(&report, &FIELDS);
        let projected = report["projected_ms"].as_f64();
        match word(&report, "status").as_str() {
            "projected" => assert!(projected > Some(1.0), "{report}"),
            "capped" => assert_eq!(projected, None),
            other => panic!("{words}: {other}"),
        }
        assert_eq!(report["build_ms"], serde_json::json!({"median": null, "min": null, "max": null, "runs": 0}));
        for field in ["tree_hash", "inner", "leaves", "avg_degree", "max_depth", "sah", "epo", "bytes"] {
            assert!(report[field].is_null(), "{words}: {field} in {report}");
        }
        assert!(lab.fine(&format!("build {words} --budget 0.001")).contains("capped"));
    }
}

#[test]
fn an_exact_build_over_its_budget_is_capped_without_a_projection() {
    let lab = Lab::new();
    let report = lab.json("build thesis:large --preset text -k 4 --budget 0.001");
    has_fields(&report, &FIELDS);
    assert_eq!((&report["status"], &report["engine"]), (&"capped".into(), &"exact".into()));
    assert!(
        report["projected_ms"].is_null() && report["tree_hash"].is_null() && report["build_ms"]["median"].is_null()
    );
}

#[test]
fn cold_runs_are_as_many_as_asked_for_and_of_the_same_tree() {
    let lab = Lab::new();
    let warm = lab.json("build gen:spheres:100 -b bottom-up --runs 3");
    for words in ["--cold --runs 3", "--runs=3 --cold --budget=60", "--cold --budget 60 --runs 1"] {
        let cold = lab.json(&format!("build gen:spheres:100 -b bottom-up {words}"));
        check(&cold);
        assert_eq!(cold["tree_hash"], warm["tree_hash"]);
        assert_eq!(check_spread(&cold["build_ms"]), if words.ends_with('1') { 1 } else { 3 });
    }
}

#[test]
fn undefined_figures_are_null() {
    let lab = Lab::new();
    // Five times the same point: no area to divide by.
    lab.write("point.tri", [0; 5 * 36]);
    let report = lab.json("build point.tri --runs 1");
    has_fields(&report, &FIELDS);
    assert_eq!((&report["status"], &report["triangles"]), (&"ok".into(), &5.into()));
    assert!(report["sah"].is_null() && report["epo"].is_null(), "{report}");
    let single = lab.json("build gen:soup:1 --runs 1");
    check(&single);
    assert_eq!((&single["inner"], &single["leaves"], &single["sah"]), (&0.into(), &1.into(), &1.0.into()));
}

#[test]
fn raw_triangles_are_built_exactly_as_they_are() {
    let lab = Lab::new();
    let mut bytes = tri_bytes("thesis:tiny");
    lab.write("tiny.tri", &bytes);
    let of = |scene: &str| lab.json(&format!("build {scene} --runs 1"));
    let (generated, raw) = (of("thesis:tiny"), of("tiny.tri"));
    for field in ["triangles", "tree_hash", "sah", "epo", "counters"] {
        assert_eq!(generated[field], raw[field], "{field}");
    }
    assert_eq!(raw["scene"], "tiny.tri");
    // One triangle in front that no builder can use: dropped and counted, the ids close up.
    let mut with_nan = vec![0xff; 36];
    with_nan.append(&mut bytes);
    lab.write("nan.TRI", with_nan);
    let dropped = of("nan.TRI");
    assert_eq!((&dropped["dropped"], &dropped["triangles"]), (&1.into(), &648.into()));
    assert_eq!(dropped["tree_hash"], raw["tree_hash"]);
}

#[test]
fn the_text_says_what_the_object_says() {
    let lab = Lab::new();
    let (text, report) = (lab.fine("build thesis:tiny --runs 1"), lab.json("build thesis:tiny --runs 1"));
    assert!(text.contains(&word(&report, "tree_hash")) && text.contains("648 triangles (0 dropped)"), "{text}");
    assert!(text.contains(&format!("{} inner, {} leaves", report["inner"], report["leaves"])), "{text}");
}

#[test]
fn costs_in_f32_build_another_tree_and_say_so() {
    let lab = Lab::new();
    let build = |costs: &str| lab.json(&format!("build thesis:tiny -k 4 --engine literal --runs 1 {costs}"));
    let (exact, single) = (build(""), build("--costs f32"));
    check(&single);
    assert_eq!((&exact["costs"], &single["costs"]), (&"exact".into(), &"f32".into()));
    assert_eq!(exact["tree_hash"], build("--costs exact")["tree_hash"]);
    assert_ne!(exact["tree_hash"], single["tree_hash"]);
    assert_eq!(exact["counters"]["combinations"].as_u64().unwrap() / 10_000, 144);
    assert!(lab.fine("build thesis:tiny --engine literal --runs 1 --costs f32").contains("f32 costs"));
}

#[test]
fn spatial_splits_add_references_within_their_budget() {
    let lab = Lab::new();
    let slots = |words: &str| -> (u64, Value) {
        let report = lab.json(&format!("build gen:hairball:2000 -b sbvh --runs 2 {words}"));
        check(&report);
        let histogram = report["leaf_histogram"].as_array().unwrap().clone();
        ((0..).zip(&histogram).map(|(size, n)| size * n.as_u64().unwrap()).sum(), report)
    };
    let (none, without) = slots("--split-budget 0");
    let (some, with) = slots("--split-budget 50");
    assert!(none == 2000 && some > 2000 && some <= 3000, "{some}");
    assert!(number(&with, "sah") < number(&without, "sah"));
    let text = lab.fine("build gen:hairball:2000 -b sbvh --runs 2 --split-budget 50");
    assert!(text.contains(&format!("references  {some},")) && !text.contains("rule Q8"), "{text}");
}
