//! Builders side by side that nobody measured: what the page makes of their rows, and what the gate does.

use crate::synthetic::{rows, store};
use bvh_lab::report::gate::{Bound, check};
use bvh_lab::report::{self, ReportError};
use bvh_lab::rows::{CompareRow, Row, RowFile, Status};
use std::fs;
use std::path::Path;

/// A finished row of a builder that takes `ms` and traces `mrays`, with a tree of this SAH.
fn row(scene: &str, recipe: &str, preset: &str, ms: f64, sah: f64, mrays: f64) -> CompareRow {
    CompareRow {
        scene: scene.into(),
        triangles: 1000,
        scene_hash: "0".into(),
        recipe: recipe.into(),
        builder: recipe.split('+').next().unwrap().into(),
        preset: preset.into(),
        engine: if preset.is_empty() { "" } else { "exact" }.into(),
        arity: 2,
        leaf_limit: 4,
        status: Status::Ok,
        budget_s: Some(20.0),
        note: String::new(),
        build_ms: Some(ms),
        build_ms_min: Some(ms * 0.98),
        build_ms_max: Some(ms * 1.02),
        build_runs: 9,
        projected_ms: None,
        tree_hash: Some(format!("{recipe}{preset}")),
        inner: Some(499),
        leaves: Some(500),
        empty: Some(0),
        avg_degree: Some(2.0),
        max_depth: Some(20),
        max_leaf: Some(4),
        references: Some(1000),
        duplicated: Some(0),
        hidden: Some(0),
        sah: Some(sah),
        epo: Some(sah / 50.0),
        lcv: Some(1.3),
        bytes: Some(36_000),
        peak_bytes: Some(90_000),
        counters: "keys_sorted=1000 rounds=3".into(),
        kernel: "scalar".into(),
        pixels: "512x512".into(),
        primary_rays: 262_144,
        primary_nodes: Some(sah / 4.0),
        primary_box_tests: Some(sah / 2.0),
        primary_tri_tests: Some(1.5),
        primary_mrays: Some(mrays * 2.0),
        primary_mrays_min: Some(mrays * 1.98),
        primary_mrays_max: Some(mrays * 2.02),
        primary_runs: 9,
        primary_hit_hash: Some("1".into()),
        diffuse_rays: 60_000,
        diffuse_nodes: Some(sah / 2.0),
        diffuse_box_tests: Some(sah),
        diffuse_tri_tests: Some(4.0),
        diffuse_mrays: Some(mrays),
        diffuse_mrays_min: Some(mrays * 0.99),
        diffuse_mrays_max: Some(mrays * 1.01),
        diffuse_runs: 9,
        diffuse_hit_hash: Some("2".into()),
        threads: 2,
        trace_threads: 2,
        machine: "Synthetic CPU, Linux".into(),
        version: "0.1.0+rows2".into(),
        commit: "0123abcd".into(),
    }
}

/// Four builders and an original on two scenes; the second has everything four times as large.
fn all() -> Vec<CompareRow> {
    let of_scene = |scene: &str, f: f64| {
        [
            row(scene, "sweep-sah", "", 40.0 * f, 50.0 * f, 2.5 / f),
            CompareRow { peak_bytes: Some(135_000), ..row(scene, "binned-sah", "", 10.0 * f, 51.0 * f, 2.4 / f) },
            row(scene, "lbvh", "", 1.0 * f, 60.0 * f, 2.0 / f),
            row(scene, "sbvh", "", 400.0 * f, 48.0 * f, 3.0 / f),
            CompareRow { bytes: Some(20_000), ..row(scene, "bottom-up+leaves", "walter", 80.0 * f, 60.0 * f, 2.0 / f) },
        ]
    };
    [of_scene("gen:a:1000", 1.0), of_scene("models/b & c.obj", 4.0)].concat()
}

fn put(dir: &Path, rows: Vec<CompareRow>) {
    let mut file = RowFile::open(dir).unwrap();
    rows.into_iter().for_each(|row| file.put(row).unwrap());
}

fn report_of(rows: Vec<CompareRow>) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    put(&dir.path().join("rows"), rows);
    report::write(&dir.path().join("rows"), dir.path()).unwrap();
    let page = fs::read_to_string(dir.path().join("compare.html")).unwrap();
    (dir, page)
}

/// Who is advised for a use, and why.
fn advised(rows: &[CompareRow], purpose: &str) -> String {
    let lines = report::advice(rows);
    lines.iter().find(|l| l.starts_with(purpose)).unwrap_or_else(|| panic!("{purpose}: {lines:?}")).clone()
}

#[test]
fn advice_follows_from_the_rows() {
    let rows = all();
    // 4.147 million rays at 300 ns (half 5, half 2.5 MRays/s) and 40 ms of build: 1,284 ms; four times that on the other scene.
    let frame = advised(&rows, "Built for every frame");
    assert!(frame.contains(": sweep-sah: build and rays together take 2.57 s, of which the build is 3.1 %"), "{frame}");
    assert!(frame.contains("next is binned-sah, 1.7 % more"), "{frame}");
    let fast = advised(&rows, "Built as fast as can be");
    assert!(fast.contains(": lbvh: 2.00 ms; next is binned-sah, which takes 10.0 times as long;"), "{fast}");
    assert!(fast.ends_with("rays through its tree are 33 % slower than through the fastest"), "{fast}");
    let much = advised(&rows, "Built once");
    // 360 ms more to build, 50 ns less a ray: 7.2 million rays.
    assert!(
        much.contains(": sbvh: 2.00 million rays/s; next is sweep-sah, 17 % slower; its build takes 800 ms"),
        "{much}"
    );
    assert!(much.ends_with("it pays for itself over sweep-sah from 7.2 million rays a build on"), "{much}");
    let cost = advised(&rows, "The least SAH (arity 2, leaves of 4)");
    assert!(
        cost.contains(": sbvh: SAH 96.00; next is sweep-sah, 4.2 % more; rays are fastest through it, too"),
        "{cost}"
    );
    let small = advised(&rows, "Memory is tight");
    assert!(
        small.contains("sbvh: 36.0 bytes a triangle") && small.contains("bottom-up+leaves walter, 20.0 bytes"),
        "{small}"
    );
}

#[test]
fn doctored_rows_change_the_advice() {
    let change = |recipe: &str, f: &dyn Fn(&mut CompareRow)| {
        let mut rows = all();
        rows.iter_mut().filter(|r| r.recipe == recipe).for_each(f);
        rows
    };
    let slow = change("lbvh", &|r| r.build_ms = r.build_ms.map(|ms| ms * 100.0));
    assert!(advised(&slow, "Built as fast as can be").contains(": binned-sah: 20.0 ms"));
    let swift = change("lbvh", &|r| (r.primary_mrays, r.diffuse_mrays) = (Some(9.0), Some(9.0)));
    for purpose in ["Built for every frame", "Built once", "Memory is tight"] {
        assert!(advised(&swift, purpose).contains(": lbvh: "), "{purpose}");
    }
    let cheap = change("binned-sah", &|r| r.sah = r.sah.map(|sah| sah * 0.5));
    let line = advised(&cheap, "The least SAH");
    assert!(
        line.contains(": binned-sah: SAH 51.00")
            && line.contains("yet rays are 20 % slower through it than through sbvh"),
        "{line}"
    );
    let close = change("sweep-sah", &|r| {
        (r.primary_mrays, r.diffuse_mrays) = (r.primary_mrays.map(|m| m * 1.1995), r.diffuse_mrays.map(|m| m * 1.1995));
    });
    assert!(advised(&close, "Built once").contains("next is sweep-sah, 0.0 % slower (not clearly apart)"));
    // Who is not there on every scene is no candidate, and it is said.
    let mut gone = all();
    gone.retain(|r| r.recipe != "lbvh" || r.scene == "gen:a:1000");
    assert!(advised(&gone, "Built as fast as can be").contains(": binned-sah: "));
    let (_dir, page) = report_of(gone);
    assert!(page.contains("traced on every scene: lbvh."), "{page}");
    let failed = change("lbvh", &|r| r.status = Status::Error);
    assert!(advised(&failed, "Built as fast as can be").contains(": binned-sah: "));
    assert!(report::advice(&all()[..1]).is_empty() && report::advice(&[]).is_empty());
}

#[test]
fn the_page_has_tables_figures_means_and_the_price_of_the_originals() {
    let (dir, page) = report_of(all());
    for part in [
        "gen:a:1000",
        "b &amp; c.obj",
        "up to ",
        "<code>sweep-sah</code>",
        "bottom-up+leaves walter",
        "Of 4 builders 3 have cheaper trees than the best original of each scene, 2 of them in less time; the cheapest, sbvh, is 20 % below it \
         and takes 5.00 times as long",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert_eq!(page.matches("<svg").count(), 2);
    for name in ["compare-1-arity2-leaf4", "compare-2-arity2-leaf4"] {
        let svg = fs::read_to_string(dir.path().join(format!("figures/{name}.svg"))).unwrap();
        // A label in either panel.
        for label in ["lbvh", "sbvh", "bottom-up+leaves walter"] {
            assert_eq!(svg.lines().filter(|l| l.trim() == label).count(), 2, "{name}: {label}");
        }
    }
    let means = fs::read_to_string(dir.path().join("tables/compare.csv")).unwrap();
    let line = |recipe: &str| {
        let line = means.lines().find(|l| l.starts_with(&format!("\"{recipe}\""))).unwrap();
        line.split(',').map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(line("binned-sah")[1..8], ["2", "4", "\"sweep-sah\"", "2", "0.25", "1.5", "1.02"]);
    assert_eq!(line("sweep-sah")[5..], ["1"; 13]);
    // Where nobody sweeps, the binned builder is the measure.
    let mut without = all();
    without.retain(|r| r.recipe != "sweep-sah");
    assert!(report_of(without).1.contains("<code>binned-sah</code>"));
}

#[test]
fn both_pages_link_each_other_and_go_with_their_rows() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("rows");
    store(&folder, rows(Some, Some));
    put(&folder, all());
    let summary = report::write(&folder, dir.path()).unwrap();
    assert_eq!((summary.comparison_rows, summary.error_rows), (10, 0));
    let read = |name: &str| fs::read_to_string(dir.path().join(name)).unwrap();
    assert!(
        read("index.html").contains("href=\"compare.html\"") && read("compare.html").contains("href=\"index.html\"")
    );
    // Fewer scenes, fewer figures; no rows, no page.
    fs::remove_file(folder.join(CompareRow::FILE)).unwrap();
    put(&folder, all()[..5].to_vec());
    report::write(&folder, dir.path()).unwrap();
    assert!(dir.path().join("figures/compare-1-arity2-leaf4.svg").exists());
    assert!(!dir.path().join("figures/compare-2-arity2-leaf4.svg").exists());
    fs::remove_file(folder.join(CompareRow::FILE)).unwrap();
    report::write(&folder, dir.path()).unwrap();
    for gone in ["compare.html", "tables/compare.csv", "figures/compare-1-arity2-leaf4.png"] {
        assert!(!dir.path().join(gone).exists(), "{gone}");
    }
    assert!(!read("index.html").contains("compare.html"));
    put(&folder, vec![CompareRow { commit: "ffff".into(), ..all().remove(0) }]);
    assert!(matches!(report::write(&folder, dir.path()), Err(ReportError::Mixed { .. })));
}

#[test]
fn odd_rows_draw_without_a_panic() {
    for odd in [0.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY] {
        let bend = |r: CompareRow| CompareRow {
            build_ms: Some(odd),
            sah: Some(odd),
            epo: Some(odd),
            primary_mrays: Some(odd),
            diffuse_mrays: Some(odd),
            ..r
        };
        report_of(all().into_iter().map(bend).collect());
        report_of(all().into_iter().enumerate().map(|(i, r)| if i == 2 { bend(r) } else { r }).collect());
    }
    let capped = |r: CompareRow| CompareRow {
        status: Status::Capped,
        build_ms: None,
        note: "stopped by its budget".into(),
        ..r
    };
    let (_dir, page) = report_of(all().into_iter().map(capped).collect());
    assert!(page.contains("capped: stopped by its budget") && page.contains("nothing to advise"));
    let wide = |r: CompareRow| [CompareRow { arity: 4, ..r.clone() }, CompareRow { leaf_limit: 8, ..r.clone() }, r];
    let (dir, page) = report_of(all().into_iter().flat_map(wide).collect());
    assert!(page.contains("lbvh, arity 4, leaves of 4") && page.contains("lbvh, arity 2, leaves of 8"));
    assert!(dir.path().join("figures/compare-2-arity2-leaf8.svg").exists());
    let (_dir, page) = report_of(vec![all().remove(0)]);
    assert!(page.contains("sweep-sah") && !page.contains("<svg"));
}

fn bounds(words: &str) -> Vec<Bound> {
    words.split(',').map(|w| w.parse().unwrap()).collect()
}

#[test]
fn bounds_are_read_and_written_alike() {
    for word in ["sah>1%", "build_ms>20%", "diffuse_mrays<10.5%", "work>0%", "tree"] {
        assert_eq!(word.parse::<Bound>().unwrap().to_string(), word);
    }
    assert_eq!(" sah > 1 % ".parse::<Bound>().unwrap().to_string(), "sah>1%");
    for word in
        ["", "sah", "sah>", "sah>%", "sah>1", ">1%", "sah=1%", "sah>1%%", "sah>-1%", "sah>inf%", "tree>1%", "sah<101%"]
    {
        assert!(word.parse::<Bound>().is_err(), "{word}");
    }
    for subject in Bound::subjects().filter(|s| *s != "tree") {
        assert!(format!("{subject}>5%").parse::<Bound>().is_ok(), "{subject}");
    }
}

#[test]
fn the_gate_says_what_where_and_by_how_much() {
    let base = all();
    let gate = |rows: &[CompareRow], words: &str| check(rows, &base, &bounds(words), false).violations;
    let all_subjects: Vec<_> =
        Bound::subjects().map(|s| if s == "tree" { s.to_owned() } else { format!("{s}>0%,{s}<0%") }).collect();
    let verdict = check(&base, &base, &bounds(&all_subjects.join(",")), false);
    // Seventeen figures and two kinds of work, above and below, and the tree.
    assert_eq!((verdict.violations.len(), verdict.compared, verdict.unknown), (0, 10 * (2 * 19 + 1), 0));

    let mut rows = all();
    rows[2].build_ms = Some(1.3);
    rows[3].diffuse_mrays = Some(2.4);
    let key = "gen:a:1000, lbvh, arity 2, leaves of 4";
    assert_eq!(
        gate(&rows, "build_ms>20%,sah>0%"),
        [format!("{key}: build_ms 1.3 is 30 % above 1 of the baseline, 20 % is allowed")]
    );
    let slower = gate(&rows, "diffuse_mrays<10%");
    assert!(
        slower.len() == 1 && slower[0].ends_with("diffuse_mrays 2.4 is 20 % below 3 of the baseline, 10 % is allowed"),
        "{slower:?}"
    );
    assert!(gate(&rows, "build_ms>30%,diffuse_mrays<20%,diffuse_mrays>0%").is_empty());

    // Times of other threads do not compare, costs do; rays of another kernel do not.
    let mut rows = all();
    rows[0].threads = 1;
    rows[1].kernel = "scalar-fast".into();
    assert!(gate(&rows, "sah>0%,bytes>0%").is_empty());
    let lines = gate(&rows, "build_ms>99%,primary_nodes>99%");
    assert!(
        lines.len() == 2 && lines[0].contains("build_ms does not compare: threads 1 now, 2 in the baseline"),
        "{lines:?}"
    );
    assert!(
        lines[1].contains("primary_nodes does not compare: kernel scalar-fast now, scalar in the baseline"),
        "{lines:?}"
    );

    // What has no figure any more, or failed, is told; what the baseline never had is not looked at.
    let mut rows = all();
    rows[0].epo = None;
    (rows[1].status, rows[1].note) = (Status::Error, "a wrong tree".into());
    let lines = gate(&rows, "epo>5%");
    assert!(lines.len() == 2 && lines[0].ends_with("epo has no figure now, 1 in the baseline"), "{lines:?}");
    assert!(lines[1].ends_with("error now (a wrong tree), fine in the baseline"), "{lines:?}");
    let mut blank = all();
    blank.iter_mut().for_each(|r| r.epo = None);
    assert!(check(&all(), &blank, &bounds("epo>0%,sah>0%"), false).violations.is_empty());

    let mut rows = all();
    rows[2].counters = "keys_sorted=1000 rounds=4 moves=1".into();
    let lines = gate(&rows, "work>10%");
    assert!(lines.len() == 2 && lines[0].contains("rounds 4 is 33.3 % above 3"), "{lines:?}");
    assert!(lines[1].contains("moves 1 is above 0 of the baseline"), "{lines:?}");
}
