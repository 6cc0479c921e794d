//! Claims as files and on the page: both presets, and other rows give other verdicts.

use super::{rows, written};
use bvh_lab::rows::{Construction, TraceRow};
use serde_json::Value;
use std::fs;
use std::path::Path;

fn verdict(dir: &Path, id: &str, preset: &str) -> String {
    let text = fs::read_to_string(dir.join("claims.json")).unwrap();
    let claims: Vec<Value> = serde_json::from_str(&text).unwrap();
    let claim = claims.iter().find(|c| c["id"] == id).unwrap();
    claim["findings"][preset]["verdict"].as_str().unwrap().to_owned()
}

#[test]
fn files_and_page_tell_the_same_verdicts() {
    let (dir, _) = written(rows(Some, Some));
    let page = fs::read_to_string(dir.path().join("index.html")).unwrap();
    let mut lines = csv::Reader::from_path(dir.path().join("claims.csv")).unwrap();
    let header: Vec<String> = lines.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(header.join(","), "id,statement,quote,place,preset,verdict,why,figures");
    let records: Vec<_> = lines.records().map(Result::unwrap).collect();
    assert!(records.len() >= 2 * 15);
    for record in &records {
        assert_eq!(verdict(dir.path(), &record[0], &record[4]), &record[5]);
        assert!(page.contains(&format!("id=\"claim-{}\"", &record[0])), "{} is not on the page", &record[0]);
    }
    // Before everything else.
    assert!(page.find("id=\"claims\"").unwrap() < page.find("published-table1").unwrap());
}

#[test]
fn doctored_rows_change_the_verdict() {
    let id = "wider-bottom-up-fewer-nodes";
    let (dir, _) = written(rows(Some, Some));
    assert_eq!(verdict(dir.path(), id, "published"), "holds");
    let more = |r: TraceRow| {
        let wide = r.construction == Construction::BottomUp && r.arity == 8 && r.preset == "published";
        let nodes = if wide { Some(99.0) } else { r.nodes_per_pixel };
        Some(TraceRow { nodes_per_pixel: nodes, ..r })
    };
    let (doctored, _) = written(rows(Some, more));
    assert_eq!(verdict(doctored.path(), id, "published"), "does not hold");
    assert_eq!(verdict(doctored.path(), id, "text"), verdict(dir.path(), id, "text"));
    let (partial, _) = written(rows(Some, |r| (r.triangles < 5000).then_some(r)));
    assert_eq!(verdict(partial.path(), id, "published"), "not decidable here");
}
