//! Trees on disk: `build -o`, and `--tree` instead of a builder.

use crate::support::{Lab, check_spread, number, word};
use serde_json::Value;

#[test]
fn a_tree_from_its_file_is_the_tree_that_was_built() {
    let lab = Lab::new();
    let trees = [
        "-b top-down -k 4",
        "-b top-down -k 8 --candidates 9",
        "-b bottom-up -k 8 --preset walter",
        "-b sweep-sah",
        "-b binned-sah+leaves -k 16 --max-leaf 7",
    ];
    for tree in trees {
        let built = lab.json(&format!("build gen:spheres:300 {tree} --runs 1 --lcv -o tree.bvh"));
        let read = lab.json("build gen:spheres:300 --tree tree.bvh --lcv");
        assert_eq!(
            (&read["builder"], &read["tree"], &read["status"]),
            (&"file".into(), &"tree.bvh".into(), &"ok".into())
        );
        assert!(built["tree"].is_null() && read["preset"].is_null() && read["build_ms"]["median"].is_null(), "{read}");
        let fields =
            ["inner", "leaves", "empty", "avg_degree", "max_depth", "max_leaf", "leaf_histogram", "sah", "epo"];
        for field in fields.iter().chain(&["arity", "tree_hash", "lcv", "bytes", "duplicated", "q8_hidden"]) {
            assert_eq!(built[field], read[field], "{tree} {field}");
        }
        assert!(number(&read, "lcv") > 0.0);
        for rays in ["primary", "any"] {
            let trace = |tree: &str| {
                let report = lab.json(&format!("trace gen:spheres:300 {tree} --rays {rays} --size 40x30 --runs 1"));
                let fields = ["arity", "tree_hash", "rays", "hits", "hit_hash", "nodes_per_ray", "tri_tests_per_ray"];
                fields.map(|f| report[f].clone())
            };
            assert_eq!(trace(tree), trace("--tree tree.bvh"), "{tree}");
        }
    }
    let trace = lab.json("trace gen:spheres:300 --tree tree.bvh --size 9x9 --runs 1");
    assert_eq!((&trace["builder"], &trace["tree"]), (&"file".into(), &"tree.bvh".into()));
    assert!(trace["preset"].is_null() && trace["engine"].is_null());
    let text = lab.fine("trace gen:spheres:300 --tree tree.bvh --size 9x9 --runs 1");
    assert!(
        text.contains("tree        tree.bvh, arity 16")
            && text.contains(&format!("hits        {} of 81", trace["hits"]))
    );
    assert!(text.contains(&format!("layout      {} bytes", trace["kernel_bytes"])), "{text}");
    lab.fine("render gen:spheres:300 --tree tree.bvh --size 30x20 --samples 1 -o from_file.png");
    lab.fine("render gen:spheres:300 --size 30x20 --samples 1 -o built.png");
    assert!(lab.read("from_file.png") == lab.read("built.png"));
    // Read and written again: the same bytes.
    lab.fine("build gen:spheres:300 --tree tree.bvh -o again.BVH");
    assert!(lab.read("tree.bvh") == lab.read("again.BVH"));
}

#[test]
fn the_leaf_count_variability_is_there_only_if_asked_for() {
    let lab = Lab::new();
    let lcv = |words: &str| lab.json(&format!("build gen:spheres:200 -b sweep-sah --runs 1 {words}"))["lcv"].clone();
    assert!(lcv("").is_null());
    let one = lcv("--lcv --threads 1");
    assert!(one.as_f64().unwrap() > 0.1 && one == lcv("--lcv --threads 3"));
    assert_ne!(one, lcv("--lcv --max-leaf 1"));
    assert!(lab.fine("build gen:spheres:200 -b sweep-sah --runs 1 --lcv").contains(", LCV "));
    // One leaf: every ray that meets it meets one leaf.
    assert!(number(&lab.json("build gen:soup:1 --runs 1 --lcv"), "lcv") <= 0.5);
}

#[test]
fn refitting_follows_a_scene_that_moves_and_tells_what_it_costs() {
    let lab = Lab::new();
    let built = lab.json("build gen:spheres:2000 -b sweep-sah -k 4 --runs 1 -o still.bvh");
    let refit = |angle: u32, more: &str| -> Value {
        let words = format!("build gen:spheres:2000+twist={angle} --tree still.bvh --refit --runs 2 {more}");
        lab.json(&words)
    };
    let mut last = 0.999_999;
    for angle in [0, 90, 300, 1000] {
        let report = refit(angle, "--against sweep-sah -o moved.bvh");
        assert_eq!(report["tree_hash"], built["tree_hash"], "the topology stays");
        let refitted = &report["refit"];
        assert_eq!(refitted["sah_before"], built["sah"]);
        assert_eq!(check_spread(&refitted["ms"]), 2);
        let [growth, over_fresh] = ["growth", "growth_over_fresh"].map(|f| number(refitted, f));
        assert!((growth - number(&report, "sah") / number(&built, "sah")).abs() < 1e-12);
        assert!(growth > last, "{angle}: {growth} {last}");
        last = growth;
        assert_eq!(word(refitted, "against"), "sweep-sah");
        if angle == 0 {
            assert_eq!((growth, over_fresh), (1.0, 1.0));
        }
        // What was written is a tree of the moved scene.
        let moved = format!("gen:spheres:2000+twist={angle}");
        let again = lab.json(&format!("build {moved} --tree moved.bvh"));
        assert_eq!((&again["sah"], &again["refit"]), (&report["sah"], &Value::Null));
        let fresh = lab.json(&format!("build {moved} -b sweep-sah -k 4 --runs 1"));
        assert_eq!(refitted["fresh_sah"], fresh["sah"]);
        let hits = |tree: &str| lab.json(&format!("trace {moved} {tree} --size 40x40 --runs 1"))["hit_hash"].clone();
        assert_eq!(hits("--tree moved.bvh"), hits("-b sweep-sah"));
    }
    assert!(last > 1.5, "{last}");
    // Boxes of the thesis' own making become exact ones: nothing is hidden any more.
    let q8 = lab.json("build gen:spheres:300 -k 8 --candidates 9 --runs 1 -o q8.bvh");
    let refitted = lab.json("build gen:spheres:300 --tree q8.bvh --refit -o exact.bvh");
    assert!(number(&q8, "q8_hidden") > 0.0 && refitted["q8_hidden"] == 0 && refitted["empty"] == q8["empty"], "{q8}");
    for kernel in ["scalar", "first-leaf"] {
        lab.json(&format!("trace gen:spheres:300 --tree exact.bvh --kernel {kernel} --size 30x30 --runs 1"));
    }
    assert!(refit(90, "")["refit"]["fresh_sah"].is_null());
    let text =
        lab.fine("build gen:spheres:2000+twist=90 --tree still.bvh --refit --against binned-sah+leaves --runs 1");
    assert!(text.contains("refit       ") && text.contains("fresh       binned-sah+leaves: "), "{text}");
}

#[test]
fn trees_of_other_scenes_and_files_that_are_no_trees_are_refused() {
    let lab = Lab::new();
    lab.fine("build gen:soup:40 -b sweep-sah --runs 1 -o soup.bvh");
    let good = lab.read("soup.bvh");
    lab.write("cut.bvh", &good[..good.len() / 2]);
    let mut flipped = good.clone();
    flipped[100] ^= 4;
    lab.write("flipped.bvh", flipped);
    lab.fine("scene gen:soup:40 --export soup.obj");
    for (words, says) in [
        ("gen:soup:41 --tree soup.bvh", "soup.bvh: built for a scene of 40 triangles, not for this one of 41"),
        ("gen:soup:40:2 --tree soup.bvh", "name that scene, or build the tree anew, or refit it"),
        ("gen:soup:41 --tree none.bvh", "cannot read none.bvh"),
        ("gen:soup:40 --tree .", "cannot read ."),
        ("gen:soup:40 --tree soup.obj", "soup.obj: not a tree file"),
        ("gen:soup:40 --tree cut.bvh", "cut.bvh: ends after"),
        ("gen:soup:40 --tree flipped.bvh", "flipped.bvh: damaged"),
    ] {
        for command in ["build", "trace", "render"] {
            let line = lab.refuse(&format!("{command} {words}"), 1);
            assert!(line.contains(says), "{command} {words}: {line}");
        }
    }
    for (words, says) in [
        ("build gen:soup:41 --tree soup.bvh --refit", "built for a scene of 40 triangles, and this one has 41"),
        ("build gen:soup:40 --tree flipped.bvh --refit", "flipped.bvh: damaged"),
        ("build gen:soup:40 --runs 1 -o no/where.bvh", "cannot write no/where.bvh"),
        (
            "build thesis:large --engine literal --preset walter -b bottom-up --budget 0.001 -o a.bvh",
            "no tree to write",
        ),
    ] {
        let line = lab.refuse(words, 1);
        assert!(line.contains(says), "{words}: {line}");
    }
    // The file's own triangles go by the same bits from the OBJ.
    assert_eq!(lab.json("build soup.obj --tree soup.bvh")["triangles"], 40);
}

#[test]
fn a_tree_is_an_alternative_to_a_builder() {
    let lab = Lab::new();
    for words in
        ["-b top-down", "-k 2", "--preset text", "--engine exact", "--max-leaf 3", "--q8 on", "--collapse thesis"]
    {
        for command in ["build", "trace", "render"] {
            let line = lab.refuse(&format!("{command} gen:soup:40 --tree soup.bvh {words}"), 2);
            assert!(line.contains("--tree") && line.contains("cannot be used with"), "{words}: {line}");
        }
    }
    for words in [
        "--tree a.bvh --budget 3",
        "--tree a.bvh --cold",
        "--refit",
        "-b sweep-sah --refit",
        "--tree a.bvh --against sweep-sah",
        "-o tree.obj",
        "-o tree",
    ] {
        lab.refuse(&format!("build gen:soup:40 {words}"), 2);
    }
    lab.fine("build gen:soup:40 -b sweep-sah --runs 1 -o a.bvh");
    let line = lab.refuse("build gen:soup:40 --tree a.bvh --refit --against top-down+rotations", 2);
    assert!(line.contains("no step but +leaves"), "{line}");
}

#[test]
fn cold_runs_leave_one_tree() {
    let lab = Lab::new();
    for words in ["-o a.bvh --cold --runs 2", "--cold --runs 2 --output=b.bvh", "--cold -oc.bvh --runs 2"] {
        lab.fine(&format!("build gen:soup:40 -b sweep-sah {words}"));
    }
    assert!(lab.read("a.bvh") == lab.read("b.bvh") && lab.read("a.bvh") == lab.read("c.bvh"));
}

#[test]
fn trees_are_exported_for_other_programs() {
    let lab = Lab::new();
    let report = lab.json("build thesis:tiny -k 4 --runs 1 --export tree.json");
    let tree: Value = serde_json::from_slice(&lab.read("tree.json")).unwrap();
    let nodes = tree["nodes"].as_array().unwrap().len() as f64;
    assert_eq!(nodes, number(&report, "inner") + number(&report, "leaves"));
    lab.fine("build thesis:tiny -k 4 --runs 1 -o tiny.bvh");
    lab.fine("build thesis:tiny --tree tiny.bvh --export again.json");
    assert!(lab.read("again.json") == lab.read("tree.json"));
    lab.fine("build thesis:tiny -k 4 --runs 1 --export boxes.obj");
    let boxes = lab.json("scene boxes.obj");
    assert_eq!(number(&boxes, "triangles"), 12.0 * (nodes - number(&report, "empty")));
    assert_eq!(boxes["bounds"], lab.json("scene thesis:tiny")["bounds"]);
    assert!(lab.refuse("build thesis:tiny --export tree.txt", 2).contains(".json or .obj"));
    assert!(lab.refuse("build boxes.obj --export boxes.obj", 2).contains("the scene itself"));
}
