//! Rows about accuracy that no machine measured: what the page says must follow them, up and down.

use bvh_lab::report::{self, ReportError};
use bvh_lab::rows::{AccuracyRow, Row, RowFile, Status};
use std::fs;
use std::path::Path;

fn row(study: &str, scene: &str, method: &str, setting: Option<u32>, ms: f64, sah: f64, rate: f64) -> AccuracyRow {
    AccuracyRow {
        study: study.into(),
        scene: scene.into(),
        triangles: 1000,
        scene_hash: "0".into(),
        method: method.into(),
        setting,
        arity: 2,
        rays: "diffuse".into(),
        status: Status::Ok,
        budget_s: 5.0,
        note: String::new(),
        build_ms: Some(ms),
        build_ms_min: Some(ms),
        build_ms_max: Some(ms),
        runs: 3,
        tree_hash: Some("0".into()),
        sah: Some(sah),
        bytes: Some(32_000),
        traced: Some(1_000_000),
        mrays_per_s: Some(rate),
        mrays_per_s_min: Some(rate),
        mrays_per_s_max: Some(rate),
        nodes_per_ray: Some(10.0),
        box_tests_per_ray: Some(20.0),
        tri_tests_per_ray: Some(2.0),
        missed: None,
        other: None,
        off: None,
        largest_ulp: None,
        oracle_rays: None,
        compared: None,
        different: None,
        largest_excess: None,
        threads: 1,
        machine: "Synthetic CPU, Linux".into(),
        version: "0.1.0+rows2".into(),
        commit: "0123abcd".into(),
    }
}

/// Two scenes; more bins cost four times the time and change the cost by `factor`.
fn rows(factor: f64) -> Vec<AccuracyRow> {
    let of = |scene: &str, scale: f64| {
        let wrong = |method: &str, rate: f64, wrong: usize| AccuracyRow {
            rays: "edges".into(),
            build_ms: None,
            sah: None,
            missed: Some(wrong),
            other: Some(wrong),
            off: Some(0),
            ..row("intersection", scene, method, None, 1.0, 1.0, rate)
        };
        let stored = |bits: u32, bytes: usize, boxes: f64| AccuracyRow {
            bytes: Some(bytes),
            box_tests_per_ray: Some(boxes),
            arity: 8,
            ..row("storage", scene, "arity 8", Some(bits), 1.0, 20.0, 2.0)
        };
        let decided = |bits: Option<u32>, different: usize| AccuracyRow {
            compared: Some(1000),
            different: Some(different),
            largest_excess: Some(different as f64 * 1e-7 * scale),
            ..row("decisions", scene, "splits", bits, if bits.is_some() { 2.0 } else { 4.0 }, 20.0, 1.0)
        };
        vec![
            row("bins", scene, "binned-sah", Some(4), 10.0 * scale, 40.0 * scale, 1.0),
            row("bins", scene, "binned-sah", Some(16), 20.0 * scale, 40.0 * scale * factor.sqrt(), 1.1),
            row("bins", scene, "binned-sah", Some(64), 40.0 * scale, 40.0 * scale * factor, 1.2),
            row("bins", scene, "sweep-sah", None, 80.0 * scale, 30.0 * scale, 1.25),
            wrong("scalar", 1.0, 0),
            wrong("scalar-fast", 1.25, 200),
            wrong("other-kernel", 1.5, 500),
            decided(None, 0),
            decided(Some(64), 0),
            decided(Some(32), 25),
            stored(8, 16_000, 25.0),
            stored(32, 32_000, 20.0),
        ]
    };
    [of("gen:spheres:1000", 1.0), of("gen:soup:1000", 3.0)].concat()
}

fn report_of(rows: Vec<AccuracyRow>) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let mut file = RowFile::open(&dir.path().join("rows")).unwrap();
    for row in rows {
        file.put(row).unwrap();
    }
    report::write(&dir.path().join("rows"), dir.path()).unwrap();
    let page = fs::read_to_string(dir.path().join("accuracy.html")).unwrap();
    (dir, page)
}

fn table(dir: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(dir.join("tables/accuracy.csv")).unwrap();
    reader.records().map(|r| r.unwrap().iter().map(str::to_owned).collect()).collect()
}

#[test]
fn factors_are_means_over_scenes_and_the_sentence_follows_them() {
    let (dir, page) = report_of(rows(0.8));
    assert!(page.contains(
        "from 4 to 64 bins an axis, a factor of 4 in build time buys 20 % less cost and 20 % more rays per second"
    ));
    assert!(page.contains("Against sweep-sah"));
    let table = table(dir.path());
    let line = table.iter().find(|l| l[1] == "binned-sah" && l[4] == "64").unwrap();
    assert_eq!((&line[5][..], &line[6][..], &line[7][..]), ("2", "0.5", "1.0667"));
    assert!(page.contains(
        "other-kernel, rays at corners and edges: 50 % more rays per second than scalar, 1,000 wrong hits in a million"
    ));
    assert!(page.contains("8 bits a coordinate take 50 % of the bytes for 25 % more box tests and no change"));
    assert!(page.contains(
        "f32 decides 50 of 2,000 otherwise than costs without rounding, at most 0.00075 % above the least cost"
    ));
    assert!(page.contains("f64 decides 0 of 2,000 otherwise") && page.contains("no change in 50 % of the time"));
    let mut prices = csv::Reader::from_path(dir.path().join("tables/accuracy-robust.csv")).unwrap();
    let prices: Vec<_> = prices.records().map(|r| r.unwrap().iter().collect::<Vec<_>>().join(" ")).collect();
    // 1 µs a ray for 0.8: 25 % more; a kernel without a twin has no price.
    assert_eq!(prices, ["scalar edges 2 1000 800 1.25 0 200 200 0"]);
    for figure in ["accuracy-cost-1", "accuracy-speed-2", "accuracy-decisions", "accuracy-hits", "accuracy-storage"] {
        for ending in ["svg", "png"] {
            assert!(dir.path().join(format!("figures/{figure}.{ending}")).is_file(), "{figure}");
        }
    }
    assert!(!dir.path().join("figures/accuracy-cost-3.svg").exists());
    // By f32, 25 of 1,000 on both scenes, far above none by f64, and nothing of the decision that has no rows.
    let flips = fs::read_to_string(dir.path().join("figures/accuracy-decisions.svg")).unwrap();
    assert!(page.contains("figures/accuracy-decisions.svg") && flips.contains("Where to split"));
    let height_of = |name: &str| {
        let lines: Vec<&str> = flips.lines().collect();
        let place = lines.iter().position(|line| *line == name).unwrap_or_else(|| panic!("no {name} in {flips}"));
        let y = lines[place - 1].split("y=\"").nth(1).and_then(|rest| rest.split('"').next());
        y.unwrap().parse::<f64>().unwrap()
    };
    assert!(height_of("f32") + 100.0 < height_of("f64"));
    assert!(!flips.contains("nearest"));
    // Without a study there is no page of it; beside one, it names this page.
    let index = dir.path().join("index.html");
    assert!(!index.exists());
    crate::synthetic::store(&dir.path().join("rows"), crate::synthetic::rows(Some, Some));
    report::write(&dir.path().join("rows"), dir.path()).unwrap();
    let index = fs::read_to_string(index).unwrap();
    assert!(index.contains("accuracy.html"));
}

#[test]
fn doctored_rows_turn_the_sentence_round() {
    let (_dir, page) = report_of(rows(1.5));
    assert!(page.contains("a factor of 4 in build time makes things worse: 50 % more cost"));
    assert!(page.contains("4 give the cheapest tree of these"));
}

#[test]
fn failed_and_capped_settings_carry_no_figure() {
    let mut rows = rows(0.8);
    for row in rows.iter_mut().filter(|r| r.study == "bins" && r.setting == Some(64)) {
        (row.status, row.note) = (Status::Error, "a wrong <tree>".into());
    }
    let (dir, page) = report_of(rows);
    assert!(page.contains("from 4 to 16 bins an axis"));
    assert!(page.contains("error: a wrong &lt;tree&gt;"));
    assert!(table(dir.path()).iter().all(|l| l[0] != "bins" || l[4] != "64"));
    let summary = report::write(&dir.path().join("rows"), dir.path()).unwrap();
    assert_eq!(summary.error_rows, 2);
}

#[test]
fn rows_of_another_program_are_refused_and_a_page_without_rows_goes() {
    let (dir, _) = report_of(rows(0.8));
    let study = crate::synthetic::rows(Some, Some);
    let (mut builds, traces) = study;
    builds.iter_mut().for_each(|b| b.commit = "other".into());
    crate::synthetic::store(&dir.path().join("rows"), (builds, traces));
    let refused = report::write(&dir.path().join("rows"), dir.path());
    assert!(matches!(refused, Err(ReportError::Mixed { .. } | ReportError::Rows(_))), "{refused:?}");
    fs::remove_file(dir.path().join("rows").join(AccuracyRow::FILE)).unwrap();
    let fresh = tempfile::tempdir().unwrap();
    crate::synthetic::store(&fresh.path().join("rows"), crate::synthetic::rows(Some, Some));
    report::write(&fresh.path().join("rows"), dir.path()).unwrap();
    assert!(!dir.path().join("accuracy.html").exists() && !dir.path().join("tables/accuracy.csv").exists());
    assert!(!dir.path().join("tables/accuracy-robust.csv").exists());
}
