//! Both engines in one study: every cell twice, one tree, and what happens where they do not agree.

use crate::support::{builds, lines, reproduce, text, traces, write_lines};
use bvh_lab::rows::{BuildRow, Row, Status};
use std::fs;
use std::path::Path;

const BOTH: [&str; 6] = ["--scenes", "thesis:tiny", "--preset", "published", "--only", "table2,table5"];

fn run(out: &Path, cells: &[&str], budget: &str) -> String {
    let output = reproduce(out, cells, budget);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn fields(out: &Path, table: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(out.join("tables").join(table)).unwrap();
    text.lines().map(|l| l.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn both_engines_build_the_same_trees_and_a_tree_that_differs_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let said = run(dir.path(), &BOTH, "600");
    assert!(said.contains("6 of 6 trees that two engines built are the same"), "{said}");
    let (rows, pictures) = (builds(dir.path()), traces(dir.path()));
    assert_eq!((rows.len(), pictures.len()), (12, 6));
    for (exact, literal) in rows[..6].iter().zip(&rows[6..]) {
        assert_eq!((&exact.engine[..], &literal.engine[..]), ("exact", "literal"), "exact ones come first");
        assert_eq!((exact.construction, exact.arity), (literal.construction, literal.arity));
        assert_eq!((exact.status, &exact.tree_hash), (Status::Ok, &literal.tree_hash));
        assert_eq!((exact.sah, exact.epo, exact.inner), (literal.sah, literal.epo, literal.inner));
        let work = |r: &BuildRow| (r.combinations + r.pair_distances, r.dp_steps + r.search_visits);
        assert!(work(literal).0 > 0 && work(literal).1 == 0 && work(exact).1 > 0, "{exact:?} {literal:?}");
    }
    // All bottom-up arities are collapsed from one binary tree: one count.
    assert!(rows[9].pair_distances > 0 && rows[9..].iter().all(|r| r.pair_distances == rows[9].pair_distances));
    assert!(rows[9].original_visits > Some(0) && rows[3].original_visits.is_none(), "the replay is the literal row's");
    // Table 2 has the literal times, and the file beside it both.
    let (times, engines) = (fields(dir.path(), "table2.csv"), fields(dir.path(), "table2-exact.csv"));
    assert_eq!(engines[0].join(","), "model,size,construction,arity,literal,literal_status,exact,exact_status,ratio");
    for (i, (exact, literal)) in rows[..6].iter().zip(&rows[6..]).enumerate() {
        let near = |text: &str, ms: Option<f64>| (text.parse::<f64>().unwrap() * 1e3 / ms.unwrap() - 1.0).abs() < 1e-5;
        assert!(near(&times[i + 1][6], literal.build_ms) && near(&engines[i + 1][4], literal.build_ms));
        assert!(near(&engines[i + 1][6], exact.build_ms), "{:?}", engines[i + 1]);
        assert_eq!([&engines[i + 1][5], &engines[i + 1][7]], ["ok", "ok"]);
    }
    assert_eq!(times[7][6..], ["", "", "missing"]);

    // An exact row that claims another tree: the literal build finds out, and is an error row that names both.
    let right = rows[0].tree_hash.clone().unwrap();
    let wrong = "00000000000000000000000000000000";
    let mut bent = lines::<BuildRow>(dir.path());
    bent[1] = bent[1].replace(&right, wrong);
    let literal = bent.remove(7);
    assert!(literal.contains("literal") && literal.contains(&right));
    write_lines::<BuildRow>(dir.path(), &bent);
    let output =
        reproduce(dir.path(), &["--scenes", "thesis:tiny", "--preset", "published", "--only", "table2"], "600");
    assert_eq!(output.status.code(), Some(1), "a result that is wrong ends with status 1");
    assert!(text(&output.stdout).contains("5 of 6 trees that two engines built are the same"));
    let after = builds(dir.path());
    let errors: Vec<_> = after.iter().filter(|r| r.status == Status::Error).collect();
    assert_eq!(errors.len(), 1);
    assert_eq!(errors[0].key(), "published thesis:tiny top-down k=2 literal");
    assert!(errors[0].note.contains(&right) && errors[0].note.contains(wrong), "{}", errors[0].note);
    assert!(errors[0].build_ms.is_none() && errors[0].sah.is_none() && errors[0].runs == 0);
}

#[test]
fn only_the_table_of_times_needs_the_literal_engine() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), &["--scenes", "gen:soup:40", "--preset", "text,walter", "--only", "table3,table5"], "600");
    assert!(builds(dir.path()).iter().all(|r| r.engine == "exact" && r.status == Status::Ok));
    assert_eq!((builds(dir.path()).len(), traces(dir.path()).len()), (9, 9));
}

#[test]
fn an_exact_build_without_time_has_no_picture_and_no_projection() {
    let dir = tempfile::tempdir().unwrap();
    const CELLS: [&str; 6] = ["--scenes", "thesis:med", "--preset", "text", "--only", "table5"];
    run(dir.path(), &CELLS, "0.001");
    let octonary = builds(dir.path()).into_iter().find(|r| r.key().contains("top-down k=8")).unwrap();
    assert_eq!((octonary.status, octonary.projected_ms, octonary.tree_hash), (Status::Capped, None, None));
    let picture = traces(dir.path()).into_iter().find(|t| t.key().contains("top-down k=8")).unwrap();
    assert!(picture.status == Status::Capped && picture.nodes_per_pixel.is_none());
    run(dir.path(), &CELLS, "600");
    assert!(builds(dir.path()).iter().all(|r| r.status == Status::Ok));
    assert!(traces(dir.path()).iter().all(|t| t.status == Status::Ok && t.tree_hash.is_some()));
}
