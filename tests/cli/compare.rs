//! `compare`: builders side by side, each with its cost and its work.

use crate::support::{Lab, check_spread, has_fields, number, word};
use bvh_lab::build::{BuildOptions, Engine};
use bvh_lab::lab::standard_recipes;
use bvh_lab::rows::{CompareRow, Row, RowFile, Status, read};
use serde_json::Value;

#[test]
fn every_builder_stands_there_with_every_figure() {
    let lab = Lab::new();
    let report = lab.json("compare gen:spheres:200 -k 2,4 --size 24x24 --runs 1");
    has_fields(&report, &["scene", "triangles", "dropped", "threads", "rays", "builders"]);
    assert_eq!(report["rays"], 24 * 24);
    let entries = report["builders"].as_array().unwrap();
    // Every reading that a builder has, at two arities.
    let all = standard_recipes().into_iter().flat_map(|(b, refine)| {
        let variants = b.variants(BuildOptions { refine, ..BuildOptions::default() }).into_iter();
        variants.filter(|o| o.engine == Engine::Exact && [2, 4].contains(&o.arity) && b.check(o).is_ok())
    });
    assert_eq!(entries.len(), all.count());
    for entry in entries {
        let figures = ["sah", "epo", "nodes_per_ray", "box_tests_per_ray", "tri_tests_per_ray", "bytes"];
        assert!(figures.iter().all(|f| number(entry, f) > 0.0), "{entry}");
        assert_eq!((check_spread(&entry["build_ms"]), &entry["status"]), (1, &"ok".into()));
        assert_eq!(entry["hit_hash"], entries[0]["hit_hash"], "all trees answer alike");
        let preset = entry["preset"].as_str().map(|preset| format!("--preset {preset}")).unwrap_or_default();
        let diffuse = &entry["diffuse"];
        let figures = ["rays", "nodes_per_ray", "box_tests_per_ray", "tri_tests_per_ray"];
        assert!(figures.iter().all(|f| number(diffuse, f) > 0.0) && number(entry, "lcv") > 0.0, "{entry}");
        assert_eq!(diffuse["hit_hash"], entries[0]["diffuse"]["hit_hash"]);
        check_spread(&diffuse["mrays_per_s"]);
        let build =
            format!("build gen:spheres:200 -b {} {preset} -k {} --runs 1", word(entry, "recipe"), entry["arity"]);
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
    let (table, advice) = text.split_once("\n\n").unwrap();
    assert!(
        ["published", "text", "walter"].iter().all(|p| table.lines().filter(|l| l.contains(p)).count() == 1),
        "{text}"
    );
    assert!(advice.lines().count() >= 3 && advice.contains("Built for every frame"), "{advice}");
}

/// Three builders on little scenes.
const SMALL: &str = "-b binned-sah,lbvh,bottom-up+leaves --preset walter --size 16x16 --runs 1";

fn rows(lab: &Lab, out: &str) -> Vec<CompareRow> {
    read(&lab.path(&format!("{out}/rows"))).unwrap()
}

/// Puts rows into `NAME/compare.csv`.
fn store(lab: &Lab, name: &str, rows: Vec<CompareRow>) {
    let mut file = RowFile::open(&lab.path(name)).unwrap();
    rows.into_iter().for_each(|row| file.put(row).unwrap());
}

#[test]
fn several_scenes_stand_in_one_object() {
    let lab = Lab::new();
    let report = lab.json(&format!("compare gen:soup:60 gen:spheres:80 gen:soup:60 {SMALL}"));
    let scenes = report["scenes"].as_array().unwrap();
    assert_eq!(scenes.iter().map(|s| word(s, "scene")).collect::<Vec<_>>(), ["gen:soup:60", "gen:spheres:80"]);
    assert!(report.get("scene").is_none() && report.get("gate").is_none());
    for scene in scenes {
        let builders = scene["builders"].as_array().unwrap();
        let recipes: Vec<_> = builders.iter().map(|b| word(b, "recipe")).collect();
        assert_eq!(recipes, ["binned-sah", "lbvh", "bottom-up+leaves"]);
        assert_eq!((&builders[2]["refine"][0], &builders[2]["preset"]), (&"leaves".into(), &"walter".into()));
    }
    let one = lab.json(&format!("compare gen:soup:60 {SMALL}"));
    assert_eq!((&one["scene"], one["scenes"].as_array().unwrap().len()), (&"gen:soup:60".into(), 1));
    assert_eq!(one["scenes"][0]["builders"], one["builders"]);
    let text = lab.fine(&format!("compare gen:soup:60 gen:spheres:80 {SMALL}"));
    assert!(text.contains("gen:soup:60: 60 triangles") && text.contains("gen:spheres:80: 80 triangles"), "{text}");
}

#[test]
fn rows_are_kept_and_a_second_run_measures_nothing() {
    let lab = Lab::new();
    let words = format!("compare gen:soup:60 gen:spheres:80 {SMALL} --out out");
    let first = lab.json(&words);
    let before = lab.read("out/rows/compare.csv");
    let known = rows(&lab, "out");
    assert_eq!(known.len(), 6);
    for row in &known {
        assert!(row.status == Status::Ok && row.note.is_empty() && row.build_ms > Some(0.0), "{row:?}");
        assert!(row.work().count() > 0 && row.leaf_limit == 4 && row.pixels == "16x16", "{row:?}");
    }
    let page = lab.read("out/compare.html");
    for file in ["tables/compare.csv", "figures/compare-2-arity2-leaf4.svg", "figures/compare-1-arity2-leaf4.png"] {
        assert!(lab.path("out").join(file).exists(), "{file}");
    }
    assert!(!lab.path("out/index.html").exists());
    assert_eq!(lab.json(&words), first);
    assert!(lab.read("out/rows/compare.csv") == before && lab.read("out/compare.html") == page);
    assert!(lab.fine("report --rows out/rows --out again").contains("compare.html"));
    assert!(lab.read("again/compare.html") == page);

    // Other conditions are another measurement; a scene with a missing row is measured as a whole.
    lab.fine(&words.replace("16x16", "17x16"));
    assert!(rows(&lab, "out").iter().all(|r| r.pixels == "17x16") && rows(&lab, "out").len() == 6);
    let mut some = known;
    some.retain(|r| r.scene != "gen:soup:60" || r.recipe != "lbvh");
    store(&lab, "some/rows", some.clone());
    lab.fine(&words.replace("--out out", "--out some"));
    let after = rows(&lab, "some");
    assert_eq!(after.len(), 6);
    for row in &some {
        let same = after.iter().find(|r| r.key() == row.key()).unwrap() == row;
        assert_eq!(same, row.scene == "gen:spheres:80", "{}", row.key());
    }
}

#[test]
fn a_tree_from_a_file_takes_part() {
    let lab = Lab::new();
    lab.fine("build gen:soup:60 -b sweep-sah -k 4 --max-leaf 2 --runs 1 -o a.bvh");
    let report = lab.json(&format!("compare gen:soup:60 {SMALL} --tree a.bvh"));
    let entry = &report["builders"][3];
    assert_eq!((&entry["builder"], &entry["tree"], &entry["arity"]), (&"file".into(), &"a.bvh".into(), &4.into()));
    assert_eq!((&entry["build_ms"]["median"], &entry["leaf_limit"]), (&Value::Null, &2.into()));
    assert!(number(entry, "sah") > 0.0 && entry["hit_hash"] == report["builders"][0]["hit_hash"]);
    let line = lab.refuse(&format!("compare gen:soup:60 gen:soup:61 {SMALL} --tree a.bvh"), 2);
    assert!(line.contains("the tree of one scene"), "{line}");
    lab.refuse(&format!("compare gen:soup:61 {SMALL} --tree a.bvh"), 1);
}

#[test]
fn a_builder_without_an_arity_is_told() {
    let run = Lab::new().run("compare gen:spheres:100 -b binned-sah,top-down -k 8,16 --size 8x8 --runs 1");
    assert_eq!(run.status, 0, "{}", run.err);
    assert!(run.err.contains("top-down has no trees of arity 16"), "{}", run.err);
    assert!(!run.err.contains("binned-sah has no"), "{}", run.err);
}

#[test]
fn a_leaf_limit_is_kept_by_all_that_follow_it() {
    let lab = Lab::new();
    let report =
        lab.json("compare gen:soup:60 -b bottom-up,bottom-up+leaves,binned-sah --max-leaf 1 --size 8x8 --runs 1");
    for entry in report["builders"].as_array().unwrap() {
        let own = entry["recipe"] == "bottom-up";
        assert_eq!((&entry["leaf_limit"], entry["max_leaf"] == 1), (&if own { 4 } else { 1 }.into(), !own), "{entry}");
    }
}

#[test]
fn the_gate_passes_what_keeps_its_bounds_and_stops_what_does_not() {
    let lab = Lab::new();
    let compare = format!("compare gen:soup:60 gen:spheres:80 {SMALL}");
    lab.fine(&format!("{compare} --out out"));
    let gate = format!("{compare} --baseline out/rows/compare.csv --fail-if");
    let exact = "sah>0%,epo>0%,lcv>0%,primary_nodes>0%,diffuse_tri_tests>0%,bytes>0%,max_depth>0%,work>0%,tree";
    assert!(lab.run(&format!("{gate} {exact}")).err.contains("figures are within their bounds"));
    let report = lab.json(&format!("{gate} {exact}"));
    assert!(report["gate"]["violations"].as_array().unwrap().is_empty() && number(&report["gate"], "compared") > 50.0);

    // A baseline that was better: by 10 % in one cost, in one kind of work, and by another tree.
    let doctored = |change: &dyn Fn(&mut CompareRow)| {
        let mut all = rows(&lab, "out");
        all.iter_mut().filter(|r| r.scene == "gen:soup:60" && r.recipe == "lbvh").for_each(change);
        let _ = std::fs::remove_dir_all(lab.path("base"));
        store(&lab, "base", all);
        let run = lab.run(&format!("{compare} --baseline base/compare.csv --fail-if sah>5%,work>0%,tree,bytes>0%"));
        let lines: Vec<String> =
            run.err.lines().filter(|l| !l.contains('%') || l.contains("arity")).map(Into::into).collect();
        (run.status, lines.into_iter().filter(|l| l.contains("leaves of")).collect::<Vec<_>>())
    };
    let (status, lines) = doctored(&|r| r.sah = r.sah.map(|sah| sah / 1.1));
    assert_eq!((status, lines.len()), (1, 1), "{lines:?}");
    for part in ["bvh-lab: gen:soup:60, lbvh, arity 2", "sah", "is 10 % above", "5 % is allowed"] {
        assert!(lines[0].contains(part), "{part}: {lines:?}");
    }
    assert_eq!(doctored(&|r| r.sah = r.sah.map(|sah| sah / 1.04)).0, 0);
    let (status, lines) = doctored(&|r| {
        r.counters = "keys_sorted=1".into();
        r.tree_hash = Some("0".into());
        r.bytes = r.bytes.map(|b| b - 1);
    });
    assert!(status == 1 && lines.len() > 3, "{lines:?}");
    for part in ["keys_sorted 60 is", "the tree is another one", "bytes"] {
        assert!(lines.iter().any(|l| l.contains(part)), "{part}: {lines:?}");
    }
    let (status, lines) = doctored(&|r| r.scene_hash = "0".into());
    assert!(status == 1 && lines.len() == 1 && lines[0].contains("the scene is another one"), "{lines:?}");
}

#[test]
fn a_row_without_counterpart_fails_the_gate_unless_allowed() {
    let lab = Lab::new();
    lab.fine(&format!("compare gen:soup:60 gen:spheres:80 {SMALL} --out out"));
    let fewer = "compare gen:soup:60 -b lbvh,ploc --size 16x16 --runs 1 --baseline out/rows/compare.csv --fail-if tree";
    let run = lab.run(fewer);
    let missing: Vec<_> = run.err.lines().filter(|l| l.ends_with("in the baseline, but not compared now")).collect();
    assert_eq!((run.status, missing.len()), (1, 5), "{run:?}");
    assert!(run.err.contains("1 rows are not in the baseline"));
    lab.fine(&format!("{fewer} --allow-missing"));
    let run = lab.run(&format!("{} --allow-missing", fewer.replace("lbvh,ploc", "ploc")));
    assert!(run.status == 1 && run.err.contains("nothing of the baseline was compared"), "{run:?}");
    lab.write("torn.csv", "scene,recipe\na,b\n");
    assert!(lab.refuse(&fewer.replace("out/rows/compare.csv", "torn.csv"), 1).contains("torn.csv:2"));
    assert!(lab.refuse(&fewer.replace("out/rows/compare.csv", "none.csv"), 1).contains("cannot read none.csv"));
}
