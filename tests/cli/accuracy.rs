//! `accuracy` from outside.

use crate::support::Lab;
use std::fs;

fn rows(lab: &Lab, out: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(lab.path(out).join("rows/accuracy.csv")).unwrap();
    reader.records().map(|r| r.unwrap().iter().map(str::to_owned).collect()).collect()
}

#[test]
fn every_part_leaves_rows_a_table_and_a_page_and_a_second_run_measures_nothing() {
    let lab = Lab::new();
    let call = "accuracy gen:spheres:300 --runs 1 --size 16x16 --out out";
    let text = lab.fine(call);
    assert!(text.contains("accuracy.html"), "{text}");
    let first = rows(&lab, "out");
    for part in ["planes", "bins", "clustering", "decisions", "intersection", "storage"] {
        assert!(first.iter().any(|r| r[0] == part), "{part}");
    }
    assert!(first.iter().all(|r| r.contains(&"ok".to_owned())), "{first:?}");
    let page = fs::read_to_string(lab.path("out").join("accuracy.html")).unwrap();
    assert!(page.contains("gen:spheres:300") && page.contains("planes an axis"));
    lab.fine(call);
    assert_eq!(rows(&lab, "out"), first);
}

#[test]
fn parts_can_be_named_and_odd_words_are_refused() {
    let lab = Lab::new();
    lab.fine("accuracy gen:spheres:200 --only storage,bins --runs 1 --size 8x8 --out out");
    let studies: std::collections::BTreeSet<String> = rows(&lab, "out").into_iter().map(|r| r[0].clone()).collect();
    assert_eq!(studies.into_iter().collect::<Vec<_>>(), ["bins", "storage"]);
    for odd in ["accuracy --only colour", "accuracy gen:nothing:5 --out out", "accuracy --runs 0"] {
        let refused = lab.run(odd);
        assert_eq!(refused.status, 2, "{odd}: {}", refused.err);
    }
}
