//! `scaling`: rows of every series, what is drawn from them, and a second run that measures nothing.

use crate::support::Lab;
use bvh_lab::rows::{ScalingRow, Status, WorkRow, read};

const WORDS: &str = "scaling --sizes 300,100 --budget 0.2 --scenes gen:soup:60 --out out";

#[test]
fn every_series_has_its_rows_and_a_second_run_adds_none() {
    let lab = Lab::new();
    assert!(lab.fine(WORDS).contains("index.html"));
    let rows: Vec<ScalingRow> = read(&lab.path("out/rows")).unwrap();
    // Two constructions, five readings of them, all engines; two collapses for each bottom-up reading.
    let mut series: Vec<_> = rows.iter().map(|r| r.series()).collect();
    series.sort();
    series.dedup();
    assert_eq!((series.len(), rows.len()), (9 * 2 + 6, 2 * (9 * 2 + 6)));
    for row in &rows {
        assert!(row.status != Status::Error, "{row:?}");
        assert_eq!(row.build_ms.is_some(), row.status == Status::Ok, "{row:?}");
    }
    let find = |n: usize, preset: &str, builder: &str, arity: usize, engine: &str| {
        let key = |r: &&ScalingRow| {
            (r.triangles, &*r.preset, &*r.builder, r.arity, &*r.engine) == (n, preset, builder, arity, engine)
        };
        rows.iter().find(key).unwrap()
    };
    let literal = find(300, "published", "top-down", 4, "literal");
    let exact = find(300, "published", "top-down", 4, "exact");
    assert_eq!(literal.tree_hash, exact.tree_hash);
    assert_eq!(
        (literal.literal_steps, exact.literal_steps),
        (Some(literal.combinations as f64), literal.literal_steps)
    );
    assert_eq!(exact.literal_unions, Some(literal.original_unions as f64));
    // A trillion combinations do not fit in a fifth of a second; their time is projected.
    let capped = find(300, "text", "top-down", 8, "literal");
    assert_eq!(capped.status, Status::Projected);
    assert!(capped.projected_ms.is_some_and(|ms| ms > 1000.0), "{capped:?}");
    assert!(find(300, "walter", "collapse", 8, "").build_ms.is_some());

    let work: Vec<WorkRow> = read(&lab.path("out/rows")).unwrap();
    assert_eq!(work.len(), 3 + 3 + 3);
    assert!(work.iter().all(|r| r.note.is_empty()), "{work:?}");
    assert_eq!(work.iter().filter(|r| r.original_steps.is_some()).count(), 1);

    for file in ["index.html", "tables/scaling.csv", "figures/scaling-time.svg", "figures/scaling-work.png"] {
        assert!(lab.path("out").join(file).exists(), "{file}");
    }
    let before = (lab.read("out/rows/scaling.csv"), lab.read("out/rows/work.csv"));
    lab.fine(WORDS);
    assert!(before == (lab.read("out/rows/scaling.csv"), lab.read("out/rows/work.csv")));

    // Killed while it wrote: what is missing is measured, the rest stays.
    let text = String::from_utf8(before.0.clone()).unwrap();
    let keep = text.len() - 40;
    lab.write("out/rows/scaling.csv", &text[..keep]);
    lab.fine(WORDS);
    let after = String::from_utf8(lab.read("out/rows/scaling.csv")).unwrap();
    assert_eq!(after.lines().count(), text.lines().count());
    let whole = text[..keep].rfind('\n').unwrap();
    assert!(after.starts_with(&text[..whole]));
}
