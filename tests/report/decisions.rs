//! The table of decisions: what its rows say is what it shows.

use crate::synthetic::{ARITIES, decision, rows, store};
use bvh_lab::report::{self, ReportError, printed::Model};
use bvh_lab::rows::{DecisionRow, RowFile, Status, read};
use std::fs;
use std::path::Path;

/// Rows of every scene and arity, doctored, and the report of them.
fn reported(dir: &Path, doctor: impl Fn(DecisionRow) -> Option<DecisionRow>) -> (String, String) {
    let rows_dir = dir.join("rows");
    fs::create_dir_all(&rows_dir).unwrap();
    let mut file = RowFile::open(&rows_dir).unwrap();
    // Not in the order in which they are shown.
    for model in Model::ALL.into_iter().rev() {
        for arity in ARITIES {
            doctor(decision(model, arity)).into_iter().for_each(|row| file.put(row).unwrap());
        }
    }
    report::write(&rows_dir, dir).unwrap();
    let text = |name: &str| fs::read_to_string(dir.join(name)).unwrap();
    (text("tables/decisions.csv"), text("index.html"))
}

#[test]
fn rows_come_back_as_they_were_written() {
    let dir = tempfile::tempdir().unwrap();
    let written = [
        decision(Model::Tiny, 2),
        DecisionRow {
            status: Status::Capped,
            budget_s: None,
            note: "a, \"b\"".into(),
            compared: None,
            largest_excess: None,
            f32_tree_hash: None,
            exact_sah: Some(0.1 + 0.2),
            ..decision(Model::Tiny, 4)
        },
    ];
    let mut file = RowFile::open(dir.path()).unwrap();
    written.iter().for_each(|row| file.put(row.clone()).unwrap());
    assert_eq!(read::<DecisionRow>(dir.path()).unwrap(), written);
}

#[test]
fn the_table_shows_the_rows_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let (csv, page) = reported(dir.path(), Some);
    let lines: Vec<_> = csv.lines().collect();
    assert_eq!(lines.len(), 1 + 15);
    assert_eq!(lines[1], "thesis:tiny,648,2,324,32,16,8,3.500e-7,false,12.5,12.625,2,1.9,5,5.1,ok");
    assert!(lines[15].starts_with("thesis:huge,88748,8,11093,1109,554,277,"), "{}", lines[15]);
    for words in ["Costs in f32", "9.9 %", "+1.000 %", "−5.000 %", "+2.000 % to +2.000 %", "3.5e-7", "Synthetic CPU"]
    {
        assert!(page.contains(words), "the page lacks {words}");
    }
}

#[test]
fn doctored_rows_change_the_table_and_the_page() {
    let (before, after) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let plain = reported(before.path(), Some);
    let (csv, page) = reported(after.path(), |row| {
        Some(match (&row.scene[..], row.arity) {
            ("thesis:tiny", 2) => DecisionRow { different: Some(300), f32_sah: Some(25.0), ..row },
            ("thesis:tiny", 4) => DecisionRow { f32_tree_hash: row.exact_tree_hash.clone(), ..row },
            ("thesis:small", 2) => DecisionRow { status: Status::Error, note: "<wrong>".into(), ..row },
            ("thesis:small", 4) => DecisionRow { status: Status::Capped, compared: None, ..row },
            ("thesis:med", 8) => return None,
            _ => row,
        })
    });
    let line = |start: &str| csv.lines().find(|l| l.starts_with(start)).unwrap_or_default().to_owned();
    assert!(line("thesis:tiny,648,2").contains(",324,300,16,8,3.500e-7,false,12.5,25,"));
    assert!(line("thesis:tiny,648,4").contains(",true,"));
    assert_eq!(line("thesis:small,2540,2"), format!("thesis:small,2540,2{},error", ",".repeat(12)));
    assert_eq!(line("thesis:small,2540,4"), format!("thesis:small,2540,4{},capped", ",".repeat(12)));
    assert_eq!(line("thesis:med,11516,8"), "");
    assert_ne!(plain, (csv, page.clone()));
    // The sentence sums over what was measured, and no figure of a wrong row is shown.
    assert!(page.contains("+100.000 %") && page.contains("&lt;wrong&gt;") && !page.contains("<wrong>"));
    let compared: usize = [648, 2540, 11_516, 25_340, 88_748].map(|n| n / 2 + n / 4 + n / 8).iter().sum();
    let compared = compared - 2540 / 2 - 2540 / 4 - 11_516 / 8;
    let words = format!("of {},{:03} nodes", compared / 1000, compared % 1000);
    assert!(page.contains(&words), "{words}");
}

#[test]
fn a_table_of_other_rows_is_not_left_behind() {
    let dir = tempfile::tempdir().unwrap();
    reported(dir.path(), Some);
    let rows_dir = dir.path().join("rows");
    store(&rows_dir, rows(Some, Some));
    report::write(&rows_dir, dir.path()).unwrap();
    assert!(dir.path().join("tables/decisions.csv").exists());
    fs::remove_file(rows_dir.join("decisions.csv")).unwrap();
    report::write(&rows_dir, dir.path()).unwrap();
    assert!(!dir.path().join("tables/decisions.csv").exists());
    assert!(!fs::read_to_string(dir.path().join("index.html")).unwrap().contains("Costs in f32"));
}

#[test]
fn decisions_of_another_program_are_refused_and_errors_are_counted() {
    let dir = tempfile::tempdir().unwrap();
    store(dir.path(), rows(Some, Some));
    let mut file = RowFile::open(dir.path()).unwrap();
    file.put(DecisionRow { status: Status::Error, ..decision(Model::Tiny, 2) }).unwrap();
    let out = dir.path().join("out");
    assert_eq!(report::write(dir.path(), &out).unwrap().error_rows, 1);
    file.put(decision(Model::Tiny, 2)).unwrap();
    assert_eq!(report::write(dir.path(), &out).unwrap().error_rows, 0);
    let text = fs::read_to_string(dir.path().join("decisions.csv")).unwrap();
    fs::write(dir.path().join("decisions.csv"), text.replace("0123abcd", "ffff")).unwrap();
    let error = report::write(dir.path(), &out).unwrap_err();
    assert!(matches!(error, ReportError::Mixed { .. }) && error.to_string().contains("decisions.csv"), "{error}");
}
