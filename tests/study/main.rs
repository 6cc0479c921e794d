//! The study from outside: what a run leaves, what a second run touches, and the figures that must never move.

mod decisions;
mod engines;
mod experiments;
mod pinned;
mod resume;
mod support;

use bvh_lab::rows::Status;
use std::fs;
use std::path::Path;
use support::{STUDY, builds, copy_of_rows, lines, refused, report, reproduce, text, traces, write_lines};

/// Every file under `dir` that is no row, as path and bytes.
fn report_files(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![dir.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(dir).unwrap().to_str().unwrap().to_owned();
            match path.is_dir() {
                true if name != "rows" => folders.push(path),
                true => {}
                false => files.push((name, fs::read(path).unwrap())),
            }
        }
    }
    files.sort();
    files
}

#[test]
fn a_study_leaves_rows_tables_figures_and_a_page() {
    let (builds, traces) = (builds(&STUDY), traces(&STUDY));
    assert_eq!((builds.len(), traces.len()), (6, 18));
    assert!(
        builds.iter().all(|r| r.status == Status::Ok && r.build_ms > Some(0.0) && r.commit == bvh_lab::lab::commit())
    );
    assert!(traces.iter().all(|r| r.status == Status::Ok && r.us_per_pixel > Some(0.0) && r.runs > 0));
    for trace in &traces {
        let built = builds.iter().find(|b| (b.construction, b.arity) == (trace.construction, trace.arity)).unwrap();
        assert_eq!(trace.tree_hash, built.tree_hash, "traced is what was built");
    }
    let names: Vec<_> = report_files(&STUDY).into_iter().map(|(name, _)| name).collect();
    for table in 1..=9 {
        assert!(names.contains(&format!("tables/table{table}.csv")), "{names:?}");
    }
    for file in
        ["index.html", "figures/figure4.svg", "figures/figure4.png", "figures/figure5.svg", "figures/figure5.png"]
    {
        assert!(names.contains(&file.to_owned()), "{file} in {names:?}");
    }
    // Table 5 shows the rows' figures, and only where there are rows.
    let table5 = fs::read_to_string(STUDY.join("tables/table5.csv")).unwrap();
    for line in table5.lines().skip(1) {
        let fields: Vec<_> = line.split(',').collect();
        let row = traces.iter().find(|t| {
            (t.construction.id(), t.arity.to_string().as_str(), t.lighting.id()) == (fields[2], fields[3], "primary")
        });
        match (fields[0], row.and_then(|r| r.nodes_per_pixel)) {
            ("Tiny" | "tiny", Some(nodes)) => {
                let ours: f64 = fields[6].parse().unwrap();
                assert!((ours / nodes - 1.0).abs() < 1e-5 && fields[8] == "ok", "{line}");
            }
            _ => assert_eq!((fields[6], fields[8]), ("", "missing"), "{line}"),
        }
    }
    assert_eq!(table5.matches(",ok").count(), 6, "{table5}");
}

#[test]
fn a_report_comes_from_rows_alone_and_out_the_same() {
    let dir = copy_of_rows();
    let elsewhere = dir.path().join("elsewhere");
    let output = report(&dir.path().join("rows"), &elsewhere);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (first, again) = (report_files(&STUDY), report_files(&elsewhere));
    assert_eq!(first.iter().map(|f| &f.0).collect::<Vec<_>>(), again.iter().map(|f| &f.0).collect::<Vec<_>>());
    for ((name, ours), (_, theirs)) in first.iter().zip(&again) {
        assert!(ours == theirs, "{name} differs");
    }
}

#[test]
fn two_rows_about_one_cell_are_refused_and_left_alone() {
    fn check<R: bvh_lab::rows::Row>() {
        let dir = copy_of_rows();
        let mut twice = lines::<R>(dir.path());
        twice.push(twice[1].clone());
        write_lines::<R>(dir.path(), &twice);
        let outputs = [
            reproduce(dir.path(), &support::CELLS, "600"),
            report(&dir.path().join("rows"), &dir.path().join("elsewhere")),
        ];
        for output in outputs {
            let line = refused(&output);
            assert!(line.contains(R::FILE) && line.contains("two rows are about the same cell"), "{line}");
            assert_eq!(lines::<R>(dir.path()), twice);
        }
        assert!(!dir.path().join("elsewhere").exists() && !dir.path().join("index.html").exists());
    }
    check::<bvh_lab::rows::BuildRow>();
    check::<bvh_lab::rows::TraceRow>();
}

#[test]
fn rows_of_two_commits_in_one_file_are_refused_and_left_alone() {
    let dir = copy_of_rows();
    let mut mixed = lines::<bvh_lab::rows::TraceRow>(dir.path());
    mixed[3] = mixed[3].replace(bvh_lab::lab::commit(), "0123456789ab");
    write_lines::<bvh_lab::rows::TraceRow>(dir.path(), &mixed);
    for output in
        [report(&dir.path().join("rows"), &dir.path().join("elsewhere")), reproduce(dir.path(), &support::CELLS, "600")]
    {
        let line = refused(&output);
        assert!(line.contains("traces.csv") && line.contains("0123456789ab") && line.contains("mixed"), "{line}");
        assert_eq!(lines::<bvh_lab::rows::TraceRow>(dir.path()), mixed);
    }
}

#[test]
fn a_row_that_is_none_is_refused_with_its_line() {
    let dir = copy_of_rows();
    let mut bent = lines::<bvh_lab::rows::BuildRow>(dir.path());
    bent[2] = bent[2].replacen("648", "many", 1);
    write_lines::<bvh_lab::rows::BuildRow>(dir.path(), &bent);
    for output in
        [report(&dir.path().join("rows"), &dir.path().join("elsewhere")), reproduce(dir.path(), &support::CELLS, "600")]
    {
        let line = refused(&output);
        assert!(line.contains("builds.csv:3: not a row of this version"), "{line}");
        assert_eq!(lines::<bvh_lab::rows::BuildRow>(dir.path()), bent);
    }
}
