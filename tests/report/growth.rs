//! Rows about growth that no machine measured: known exponents, known constants; what the report makes of them.

use crate::synthetic::{rows, store};
use bvh_lab::report::{self, ReportError};
use bvh_lab::rows::{Construction, Row, RowFile, ScalingRow, Status, WorkRow};
use std::fs;
use std::path::Path;

/// A build of `n` triangles that takes 2·10⁻³·n^`exponent` milliseconds and as many steps.
fn scaling(engine: &str, arity: usize, n: usize, exponent: f64) -> ScalingRow {
    let y = (n as f64).powf(exponent);
    ScalingRow {
        scene: format!("gen:spheres:{n}"),
        family: "gen:spheres".into(),
        triangles: n,
        scene_hash: "0".into(),
        builder: "top-down".into(),
        preset: "published".into(),
        arity,
        engine: engine.into(),
        status: Status::Ok,
        budget_s: Some(3.0),
        build_ms: Some(2e-3 * y),
        build_ms_min: Some(1e-3 * y),
        build_ms_max: Some(3e-3 * y),
        runs: 5,
        projected_ms: None,
        note: String::new(),
        tree_hash: Some("0".into()),
        combinations: if engine == "literal" { y as u64 } else { 0 },
        child_costs: 0,
        box_unions: 0,
        original_unions: 0,
        pair_distances: 0,
        nearest_searches: 0,
        merges: 0,
        dp_steps: if engine == "exact" { (10.0 * y) as u64 } else { 0 },
        search_visits: 0,
        model_steps: None,
        literal_steps: Some((n as f64).powi(2)),
        literal_unions: Some((n as f64).powf(2.5)),
        threads: 1,
        machine: "Synthetic CPU, Linux".into(),
        version: "0.1.0+rows2".into(),
        commit: "0123abcd".into(),
    }
}

/// Work of the program on a thesis scene; `work` is in its own unit.
fn work(scene: &str, n: usize, construction: Construction, arity: usize, work: Option<f64>) -> WorkRow {
    let bottom_up = construction == Construction::BottomUp;
    WorkRow {
        preset: "published".into(),
        scene: scene.into(),
        triangles: n,
        scene_hash: "0".into(),
        construction,
        arity,
        tree_hash: None,
        model_steps: 1.0,
        literal_steps: work.map(f64::sqrt),
        literal_unions: work.filter(|_| !bottom_up),
        original_every: bottom_up.then_some(1),
        original_queries: None,
        original_visits: None,
        original_list_steps: None,
        original_steps: work.filter(|_| bottom_up).map(|w| w as u64),
        budget_s: None,
        note: String::new(),
        version: "0.1.0+rows2".into(),
        commit: "0123abcd".into(),
    }
}

/// The printed seconds of a column of Table 2 times 10⁸: as if one unit of work took 10 ns.
fn all_work() -> Vec<WorkRow> {
    let mut all = Vec::new();
    for p in report::printed::cells().iter().filter(|p| p.table == 2) {
        let (Some(construction), Some(arity)) = (p.construction, p.arity) else { continue };
        if construction == Construction::BottomUp && arity > 2 {
            continue;
        }
        let seconds = match p.reference() {
            Some(figure) => Some(figure.value),
            None if construction == Construction::TopDown => Some(2_000_000.0),
            None => None,
        };
        all.push(work(&p.model.scene(), p.size, construction, arity, seconds.map(|s| s * 1e8)));
    }
    all
}

fn all_scaling() -> Vec<ScalingRow> {
    let mut all = Vec::new();
    for n in [1000, 3162, 10_000, 31_623, 100_000] {
        all.push(scaling("exact", 2, n, 1.1));
        all.push(scaling("literal", 2, n, 2.0));
        // Ten times the work at arity 4, at the same cost each.
        all.push(ScalingRow { arity: 4, ..scaling("exact", 2, n, 1.3) });
    }
    all
}

fn put<R: Row>(dir: &Path, rows: Vec<R>) {
    let mut file = RowFile::open(dir).unwrap();
    rows.into_iter().for_each(|row| file.put(row).unwrap());
}

fn report_of(scaling: Vec<ScalingRow>, work: Vec<WorkRow>) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let rows = dir.path().join("rows");
    put(&rows, scaling);
    put(&rows, work);
    report::write(&rows, dir.path()).unwrap();
    dir
}

fn lines(dir: &Path, name: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(dir.join("tables").join(name)).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(str::to_owned).collect()).collect()
}

fn number(field: &str) -> f64 {
    field.parse().unwrap_or_else(|_| panic!("{field} is no number"))
}

#[test]
fn exponents_are_found_with_their_intervals() {
    let mut rows = all_scaling();
    // A factor of two up and down, so that the interval has a width and holds the exponent.
    for (i, row) in rows.iter_mut().filter(|r| r.engine == "literal").enumerate() {
        row.build_ms = row.build_ms.map(|ms| ms * [2.0, 0.5, 1.0, 0.5, 2.0][i]);
    }
    // What did not finish takes no part, whatever figure it carries.
    rows.push(ScalingRow { status: Status::Projected, ..scaling("literal", 2, 1_000_000, 9.0) });
    rows.push(ScalingRow { status: Status::Error, ..scaling("exact", 2, 1_000_000, 9.0) });
    let dir = report_of(rows, Vec::new());
    let table = lines(dir.path(), "scaling.csv");
    let line = |engine: &str, arity: &str, quantity: &str| {
        table.iter().find(|l| [&l[3], &l[4], &l[5]] == [arity, engine, quantity]).unwrap()
    };
    for (arity, exponent) in [("2", 1.1), ("4", 1.3)] {
        let time = line("exact", arity, "time");
        assert_eq!(time[..3].join(" "), "gen:spheres top-down published");
        assert_eq!(time[6..9].join(" "), "5 1000 100000");
        assert!((number(&time[9]) - exponent).abs() < 1e-3, "{time:?}");
        assert!(number(&time[11]) - number(&time[10]) < 1e-3);
    }
    let literal = line("literal", "2", "time");
    assert!((number(&literal[9]) - 2.0).abs() < 1e-3, "the noise is even in log n: {literal:?}");
    let width = number(&literal[11]) - number(&literal[10]);
    assert!((0.8..1.8).contains(&width), "{width}");
    assert!((number(&line("exact", "2", "dp_steps")[9]) - 1.1).abs() < 1e-2);
    assert!((number(&line("literal", "2", "combinations")[9]) - 2.0).abs() < 1e-2);
    assert!((number(&line("exact", "2", "literal_unions")[9]) - 2.5).abs() < 1e-3);
    let page = fs::read_to_string(dir.path().join("index.html")).unwrap();
    assert!(page.contains("1.10 ± 0.00") && page.contains("id=\"scaling\"") && !page.contains("id=\"why\""));
}

#[test]
fn one_constant_is_found_and_doctored_rows_show() {
    let dir = report_of(Vec::new(), all_work());
    let find = |dir: &Path, construction: &str| {
        let all = lines(dir, "why.csv");
        all.into_iter().find(|l| [&l[0], &l[1], &l[5]] == ["printed", construction, "true"]).unwrap()
    };
    let law = find(dir.path(), "top-down");
    assert!((number(&law[8]) - 10.0).abs() < 1e-3 && number(&law[9]) > 0.9999, "{law:?}");
    // All but the capped cell and the two doubtful ones.
    assert_eq!(law[6], "12");
    let bottom_up = find(dir.path(), "bottom-up");
    assert!((9.0..11.0).contains(&number(&bottom_up[8])), "{bottom_up:?}");
    assert_eq!(bottom_up[6], "11");

    let cells = lines(dir.path(), "why-cells.csv");
    let cell = |scene: &str, construction: &str, arity: &str| {
        cells.iter().find(|l| [&l[1], &l[3], &l[4]] == [construction, scene, arity]).unwrap()
    };
    assert!((number(&cell("thesis:med", "top-down", "4")[9]) - 1.0).abs() < 1e-3);
    let huge = cell("thesis:huge", "top-down", "8");
    assert!(number(&huge[8]) > 1.9e6 && huge[10].starts_with("capped"), "{huge:?}");
    // Not replayed: continued from the four scenes that were.
    let continued = cell("thesis:huge", "bottom-up", "2");
    assert!(number(&continued[8]) > 1e5 && continued[10].starts_with("capped"), "{continued:?}");
    assert!(cell("thesis:small", "top-down", "4")[10].starts_with("doubtful"));

    let page = fs::read_to_string(dir.path().join("index.html")).unwrap();
    assert!(page.contains("at 10.0 ns each") && page.contains("23.1 days"));
    for figure in ["why.svg", "why.png"] {
        assert!(dir.path().join("figures").join(figure).exists());
    }

    let mut doctored = all_work();
    let row = doctored.iter_mut().find(|r| r.key() == "published thesis:med top-down k=4").unwrap();
    row.literal_unions = row.literal_unions.map(|u| u * 1000.0);
    let other = report_of(Vec::new(), doctored);
    let law = find(other.path(), "top-down");
    assert!(number(&law[9]) < 0.95 && number(&law[11]) < 0.01, "{law:?}");
    assert!(fs::read_to_string(other.path().join("index.html")).unwrap() != page);
}

#[test]
fn growth_stands_beside_the_study_and_goes_with_its_rows() {
    let dir = tempfile::tempdir().unwrap();
    let all = dir.path().join("rows");
    store(&all, rows(Some, Some));
    let before = report::write(&all, dir.path()).unwrap();
    put(&all, all_scaling());
    put(&all, all_work());
    let after = report::write(&all, dir.path()).unwrap();
    let more = ["tables/scaling.csv", "tables/why.csv", "tables/why-cells.csv"].map(str::to_owned).into_iter();
    let figures = ["scaling-time", "scaling-work", "why"].into_iter();
    let more = more.chain(figures.flat_map(|f| ["svg", "png"].map(|e| format!("figures/{f}.{e}"))));
    for name in more {
        let path = dir.path().join(name);
        assert!(path.exists() && after.files.contains(&path) && !before.files.contains(&path), "{}", path.display());
    }
    // Our literal builds have laws of their own: 2 ns a combination, as made.
    let ours = lines(dir.path(), "why.csv").into_iter().find(|l| [&l[0], &l[3]] == ["ours", "2"]).unwrap();
    assert_eq!(ours[..3].join(" "), "ours top-down published");
    let page = fs::read_to_string(dir.path().join("index.html")).unwrap();
    for id in ["why", "constants", "columns", "residuals", "scaling", "exponents"] {
        assert!(page.contains(&format!("id=\"{id}\"")), "{id}");
    }

    fs::remove_file(all.join(ScalingRow::FILE)).unwrap();
    fs::remove_file(all.join(WorkRow::FILE)).unwrap();
    report::write(&all, dir.path()).unwrap();
    assert!(!dir.path().join("figures/why.svg").exists() && !dir.path().join("tables/why.csv").exists());

    let stranger = ScalingRow { commit: "ffff".into(), ..scaling("exact", 2, 1000, 1.0) };
    put(&all, vec![stranger]);
    assert!(matches!(report::write(&all, dir.path()), Err(ReportError::Mixed { .. })));
}

#[test]
fn a_failed_row_is_told() {
    let mut rows = all_scaling();
    rows[0].status = Status::Error;
    let dir = tempfile::tempdir().unwrap();
    put(&dir.path().join("rows"), rows);
    let summary = report::write(&dir.path().join("rows"), dir.path()).unwrap();
    assert_eq!(summary.error_rows, 1);
}

#[test]
fn odd_figures_draw_without_a_panic() {
    for odd in [0.0, -1.0, 1e-300, 1e300, f64::NAN, f64::INFINITY] {
        let scaling = all_scaling().into_iter().map(|r| ScalingRow {
            build_ms: Some(odd),
            literal_steps: Some(odd),
            literal_unions: Some(odd),
            ..r
        });
        let work = all_work().into_iter().map(|r| WorkRow { literal_unions: Some(odd), literal_steps: Some(odd), ..r });
        let dir = report_of(scaling.collect(), work.collect());
        assert!(dir.path().join("index.html").exists());
    }
}
