//! The report on rows made up for the purpose: tables, figures, page, refusals, and what it may import.

mod accuracy;
mod claims;
mod compare;
mod decisions;
mod growth;
mod imports;
mod synthetic;

use bvh_lab::report::{self, ReportError, Summary};
use bvh_lab::rows::{BuildRow, Construction, Lighting, Row, RowFile, Status, TraceRow};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use synthetic::{rows, store};

fn written(rows: (Vec<BuildRow>, Vec<TraceRow>)) -> (tempfile::TempDir, Summary) {
    let dir = tempfile::tempdir().unwrap();
    store(&dir.path().join("rows"), rows);
    let summary = report::write(&dir.path().join("rows"), dir.path()).unwrap();
    (dir, summary)
}

fn bytes_under(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![dir.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(dir).unwrap().to_str().unwrap().to_owned();
                files.insert(name, fs::read(path).unwrap());
            }
        }
    }
    files
}

/// The lines of a table, each as its fields.
fn table(dir: &Path, name: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(dir.join("tables").join(name)).unwrap();
    let mut lines = text.lines();
    let header = "model,size,construction,arity,printed,corrected,ours,ratio,status";
    assert_eq!(lines.next(), Some(header));
    lines.map(|l| l.split(',').map(str::to_owned).collect()).collect()
}

fn line<'a>(table: &'a [Vec<String>], key: [&str; 3]) -> &'a [String] {
    table.iter().find(|l| [&l[0], &l[2], &l[3]] == key).unwrap()
}

#[test]
fn everything_is_written_and_listed_and_the_same_twice() {
    let (dir, summary) = written(rows(Some, Some));
    let first = bytes_under(dir.path());
    let mut expected: Vec<String> =
        ["index.html", "paper.html", "claims.csv", "claims.json"].map(String::from).to_vec();
    for number in 1..=9 {
        expected.push(format!("tables/table{number}.csv"));
        expected.push(format!("tables/text/table{number}.csv"));
    }
    expected.extend(["tables/table2-exact.csv", "tables/text/table2-exact.csv"].map(str::to_owned));
    let extended = ["figure4-extended", "figure4-extended_text"];
    for figure in
        ["figure3", "figure3-lit", "figure4", "figure5", "figure4_text", "figure5_text"].into_iter().chain(extended)
    {
        expected.push(format!("figures/{figure}.svg"));
        expected.push(format!("figures/{figure}.png"));
    }
    expected.sort();
    let mut listed: Vec<String> =
        summary.files.iter().map(|f| f.strip_prefix(dir.path()).unwrap().to_str().unwrap().to_owned()).collect();
    listed.sort();
    assert_eq!(listed, expected);
    for file in &expected {
        assert!(!first[file].is_empty(), "{file}");
    }
    assert_eq!(first.len(), expected.len() + 4, "nothing else is left beside the rows and two pictures");

    let again = report::write(&dir.path().join("rows"), dir.path()).unwrap();
    assert_eq!(again, summary);
    assert!(bytes_under(dir.path()) == first, "a second run changes bytes");
}

#[test]
fn tables_hold_printed_corrected_ours_and_ratio() {
    let (dir, _) = written(rows(Some, Some));
    let counts: Vec<usize> = (1..=9).map(|n| table(dir.path(), &format!("table{n}.csv")).len()).collect();
    assert_eq!(counts, [5, 30, 10, 30, 30, 30, 30, 30, 30]);

    let sizes = table(dir.path(), "table1.csv");
    assert_eq!(line(&sizes, ["med", "", ""]).join(","), "med,11516,,,11516,,11516,1,ok");

    let times = table(dir.path(), "table2.csv");
    // Corrected by the thesis' own text; the ratio is against the corrected figure.
    let huge = line(&times, ["huge", "top-down", "2"]);
    assert_eq!(huge[4..6], ["01.44", "91.44"]);
    let (ours, ratio): (f64, f64) = (huge[6].parse().unwrap(), huge[7].parse().unwrap());
    assert!((ours / 91.44 - ratio).abs() < 1e-4);
    // The literal engine's projection, though the exact engine finished.
    let projected = line(&times, ["large", "top-down", "8"]);
    assert_eq!(projected[8], "projected");
    assert!(projected[6].parse::<f64>().unwrap() > 1000.0);
    assert_eq!(line(&times, ["huge", "bottom-up", "2"])[4..], ["", "", "", "", "capped"]);

    // Statistics of the tree come from the engine that finished.
    let degrees = table(dir.path(), "table3.csv");
    assert_eq!(line(&degrees, ["large", "bottom-up", "8"])[6..].join(","), "7.2,1.073,ok");
    let nodes = table(dir.path(), "table5.csv");
    assert_eq!(line(&nodes, ["huge", "bottom-up", "2"])[4..8].join(","), ",,11.918,");
}

#[test]
fn each_table_reads_its_own_lighting_preset_and_quantity() {
    let value = |r: &TraceRow| {
        let preset = if r.preset == "text" { 100.0 } else { 0.0 };
        preset + (1 + r.lighting as usize * 3) as f64
    };
    let (dir, _) = written(rows(Some, |r| {
        let nodes = value(&r);
        Some(TraceRow { nodes_per_pixel: Some(nodes), us_per_pixel: Some(nodes + 0.5), ..r })
    }));
    for (number, ours) in [(4, 1.5), (5, 1.0), (6, 4.5), (7, 4.0), (8, 7.5), (9, 7.0)] {
        for (folder, offset) in [("", 0.0), ("text/", 100.0)] {
            let table = table(dir.path(), &format!("{folder}table{number}.csv"));
            assert!(table.iter().all(|l| l[6].parse::<f64>().unwrap() == ours + offset), "{folder}{number}");
        }
    }
}

#[test]
fn the_headline_counts_what_is_close() {
    let (_dir, summary) = written(rows(Some, Some));
    assert_eq!((summary.table5.within, summary.table5.compared, summary.table5.printed), (16, 16, 16));
    assert_eq!((summary.table5_all.within, summary.table5_all.printed), (26, 26));
    assert_eq!(summary.error_rows, 0);
    assert_eq!(summary.engines_agree.0, summary.engines_agree.1);
    assert!(summary.engines_agree.1 > 0);
    let cells = summary.cells;
    assert_eq!(cells.ok + cells.capped + cells.projected + cells.error + cells.missing, 220);

    // One cell far off, one wrong, one not there, one tree that differs between the engines.
    let (_dir, worse) = written(rows(
        |r| {
            let differs = r.key() == "published thesis:tiny top-down k=2 exact";
            let tree_hash = if differs { Some("bad".into()) } else { r.tree_hash.clone() };
            Some(BuildRow { tree_hash, ..r })
        },
        |mut r| match &r.key()[..] {
            "published thesis:tiny top-down k=2 primary" => {
                r.nodes_per_pixel = r.nodes_per_pixel.map(|n| n * 1.2);
                Some(r)
            }
            "published thesis:tiny top-down k=4 primary" => {
                r.status = Status::Error;
                Some(r)
            }
            "published thesis:med bottom-up k=2 primary" => None,
            _ => Some(r),
        },
    ));
    assert_eq!((worse.table5.within, worse.table5.compared, worse.table5.printed), (13, 14, 16));
    assert_eq!((worse.error_rows, worse.cells.error, worse.cells.missing), (1, 2, 2));
    assert_eq!(worse.engines_agree.0 + 1, worse.engines_agree.1);
}

#[test]
fn a_wrong_answer_never_becomes_a_number() {
    let (dir, _) = written(rows(
        |r| Some(BuildRow { status: Status::Error, ..r }),
        |r| Some(TraceRow { status: Status::Error, ..r }),
    ));
    for number in 2..=9 {
        for l in table(dir.path(), &format!("table{number}.csv")) {
            assert_eq!(l[6..], ["", "", "error"], "table {number}");
        }
    }
}

#[test]
fn a_study_in_parts_is_reported_as_far_as_it_goes() {
    let few = |r: &str| r.starts_with("published thesis:tiny top-down k=2");
    let dir = tempfile::tempdir().unwrap();
    let (all, part) = (dir.path().join("all"), dir.path().join("part"));
    store(&all, rows(Some, Some));
    store(&part, rows(|r| few(&r.key()).then_some(r), |r| few(&r.key()).then_some(r)));
    fs::remove_file(part.join("figure3.png")).unwrap();
    let out = dir.path().join("out");
    report::write(&all, &out).unwrap();
    assert!(out.join("figures/figure4_text.svg").exists());

    let summary = report::write(&part, &out).unwrap();
    assert!(summary.cells.missing > 200);
    assert!(!out.join("figures/figure4_text.svg").exists(), "a figure of other rows is left behind");
    assert!(!out.join("figures/figure3.png").exists() && out.join("figures/figure3-lit.png").exists());
    assert!(summary.files.iter().all(|f| f.exists()));
    assert_eq!(line(&table(&out, "table5.csv"), ["med", "top-down", "2"])[8], "missing");
}

#[test]
fn figures_say_the_same_in_both_formats() {
    let (dir, _) = written(rows(Some, Some));
    for figure in ["figure4", "figure5", "figure4_text", "figure5_text"] {
        let svg = fs::read_to_string(dir.path().join(format!("figures/{figure}.svg"))).unwrap();
        for words in ["Branching factor", "Tiny (648)", "Huge (88,748)"] {
            assert!(svg.contains(words), "{figure} lacks {words}");
        }
        let png = image::open(dir.path().join(format!("figures/{figure}.png"))).unwrap().to_rgb8();
        assert_eq!(png.width(), 1600);
        assert!(svg.contains(&format!("width=\"1600\" height=\"{}\"", png.height())));
        // Not blank: all five colours of the models are there.
        for colour in [[86, 180, 233], [230, 159, 0], [0, 158, 115], [0, 90, 178], [204, 61, 110]] {
            let pixels = png.pixels().filter(|p| p.0 == colour).count();
            assert!(pixels > 100, "{figure}: {pixels} pixels of {colour:?}");
        }
    }
    for picture in ["figure3", "figure3-lit"] {
        let rows_picture = fs::read(dir.path().join(format!("rows/{picture}.png"))).unwrap();
        assert_eq!(fs::read(dir.path().join(format!("figures/{picture}.png"))).unwrap(), rows_picture);
        let svg = fs::read_to_string(dir.path().join(format!("figures/{picture}.svg"))).unwrap();
        assert!(svg.contains("data:image/png;base64,iVBOR"));
    }
}

#[test]
fn the_page_stands_alone() {
    let (dir, _) = written(rows(|r| Some(BuildRow { note: "<b>&\"quoted\"".into(), ..r }), Some));
    let page = fs::read_to_string(dir.path().join("index.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>"));
    for words in [
        "16 of 16",
        "Figure 3.",
        "materials and lamps of ours",
        "Figure 4.",
        "Figure 5.",
        "0123abcd",
        "Synthetic CPU, Linux",
        "probably 1,610",
    ] {
        assert!(page.contains(words), "the page lacks {words}");
    }
    for number in 1..=9 {
        assert!(page.contains(&format!("published-table{number}\"")));
    }
    for fetched in ["<script", "<link", "src=\"http", "@import", "url("] {
        assert!(!page.contains(fetched), "the page fetches: {fetched}");
    }
    assert!(!page.contains("<b>&\""), "a note is not escaped");
}

#[test]
fn rows_that_do_not_belong_together_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let empty = dir.path().join("empty");
    fs::create_dir(&empty).unwrap();
    assert!(matches!(report::write(&empty, &out), Err(ReportError::NoRows(_))));

    let mixed = dir.path().join("mixed");
    let other = |r| Some(TraceRow { commit: "ffff".into(), ..r });
    store(&mixed, rows(Some, other));
    let error = report::write(&mixed, &out).unwrap_err();
    assert!(matches!(error, ReportError::Mixed { .. }));
    assert_eq!(error.to_string().lines().count(), 1);

    let double = dir.path().join("double");
    store(&double, rows(Some, Some));
    let path = double.join(BuildRow::FILE);
    let text = fs::read_to_string(&path).unwrap();
    let last = text.lines().last().unwrap();
    fs::write(&path, format!("{text}{last}\n")).unwrap();
    assert!(matches!(report::write(&double, &out), Err(ReportError::Rows(_))));

    let torn = dir.path().join("torn");
    store(&torn, rows(Some, Some));
    fs::write(torn.join("figure3.png"), "no picture").unwrap();
    assert!(matches!(report::write(&torn, &out), Err(ReportError::Picture { .. })));
    assert!(!out.exists() || fs::read_dir(&out).unwrap().all(|e| e.unwrap().file_name() == "tables"));
}

#[test]
fn odd_figures_draw_without_a_panic() {
    for odd in [0.0, -1.0, 1e-12, 1e15, f64::NAN, f64::INFINITY] {
        let (dir, _) = written(rows(
            |r| {
                let ms = r.build_ms.map(|_| odd);
                Some(BuildRow { build_ms: ms, avg_degree: Some(odd), ..r })
            },
            |r| Some(TraceRow { nodes_per_pixel: Some(odd), us_per_pixel: Some(odd), ..r }),
        ));
        assert!(dir.path().join("index.html").exists());
    }
}

#[test]
fn scenes_and_presets_of_other_studies_do_not_leak_in() {
    let (dir, _) = written(rows(Some, Some));
    let stranger =
        synthetic::trace("published", report::printed::Model::Tiny, Construction::TopDown, 2, Lighting::Primary);
    let stranger = TraceRow { scene: "thesis:small2940".into(), nodes_per_pixel: Some(999.0), ..stranger };
    let walter = synthetic::build("walter", report::printed::Model::Tiny, Construction::BottomUp, 2);
    let before = bytes_under(&dir.path().join("tables"));
    RowFile::open(&dir.path().join("rows")).unwrap().put(stranger).unwrap();
    RowFile::open(&dir.path().join("rows")).unwrap().put(walter).unwrap();
    report::write(&dir.path().join("rows"), dir.path()).unwrap();
    assert!(bytes_under(&dir.path().join("tables")) == before);
}
