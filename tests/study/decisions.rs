//! Decisions by f32 costs: measured once, beside the trees of the study.

use crate::support::{STUDY, builds, copy_of_rows, lines, reproduce, text, traces, write_lines};
use bvh_lab::rows::{BuildRow, Construction, DecisionRow, Lighting, Status, read};
use std::path::Path;

const CELLS: [&str; 6] = ["--scenes", "thesis:tiny", "--preset", "published", "--only", "decisions"];

fn decisions(out: &Path) -> Vec<DecisionRow> {
    read(&out.join("rows")).unwrap()
}

fn run(out: &Path, budget: &str) -> String {
    let output = reproduce(out, &CELLS, budget);
    let err = text(&output.stderr);
    assert!(output.status.success(), "{err}");
    err
}

#[test]
fn exact_trees_are_those_of_the_study_and_nothing_is_measured_twice() {
    // Beside the study's rows, whose trees they are held against, and alone.
    let beside = copy_of_rows();
    let alone = tempfile::tempdir().unwrap();
    for out in [beside.path(), alone.path()] {
        run(out, "600");
        let rows = decisions(out);
        assert_eq!(rows.iter().map(|r| r.arity).collect::<Vec<_>>(), [2, 4, 8]);
        for row in &rows {
            assert_eq!((row.status, row.threads), (Status::Ok, 1), "{row:?}");
            let built =
                builds(&STUDY).into_iter().find(|b| (b.construction, b.arity) == (Construction::TopDown, row.arity));
            let built = built.unwrap();
            assert_eq!(row.exact_tree_hash, built.tree_hash);
            assert_eq!((row.exact_sah, row.exact_epo, &row.scene_hash), (built.sah, built.epo, &built.scene_hash));
            let traced = traces(&STUDY).into_iter().find(|t| {
                (t.construction, t.arity, t.lighting) == (Construction::TopDown, row.arity, Lighting::Primary)
            });
            assert_eq!(row.exact_nodes_per_pixel, traced.unwrap().nodes_per_pixel);
            assert!(row.different > Some(0) && row.f32_tree_hash != row.exact_tree_hash, "{row:?}");
            // Nodes of rule Q8 have no choice to compare.
            assert_eq!(row.compared.unwrap() + built.q8_nodes as usize, built.inner.unwrap());
        }
        let before = lines::<DecisionRow>(out);
        run(out, "600");
        run(out, "0.000001");
        assert_eq!(lines::<DecisionRow>(out), before);
    }
}

#[test]
fn a_capped_cell_is_measured_when_there_is_more_time() {
    let dir = tempfile::tempdir().unwrap();
    let said = run(dir.path(), "0.000001");
    // The smallest trees are done before a budget is looked at.
    let first = decisions(dir.path());
    let capped = first.iter().filter(|r| r.status == Status::Capped).count();
    assert!(capped > 0 && said.contains("stopped by its budget"), "{said}");
    assert!(first.iter().all(|r| r.status == Status::Ok || r.exact_tree_hash.is_none()));
    run(dir.path(), "600");
    assert!(decisions(dir.path()).iter().all(|r| r.status == Status::Ok));
}

#[test]
fn a_tree_that_is_not_the_builds_is_an_error() {
    let dir = copy_of_rows();
    let hash = builds(dir.path()).into_iter().find(|b| b.construction == Construction::TopDown && b.arity == 4);
    let hash = hash.unwrap().tree_hash.unwrap();
    let bent: Vec<_> = lines::<BuildRow>(dir.path()).iter().map(|l| l.replace(&hash, &"0".repeat(32))).collect();
    write_lines::<BuildRow>(dir.path(), &bent);
    let output = reproduce(dir.path(), &CELLS, "600");
    assert_eq!(output.status.code(), Some(1), "a result that is wrong ends with status 1");
    let rows = decisions(dir.path());
    assert_eq!(rows.iter().map(|r| r.status).collect::<Vec<_>>(), [Status::Ok, Status::Error, Status::Ok]);
    assert!(rows[1].exact_sah.is_none() && rows[1].note.contains("exact tree"), "{:?}", rows[1]);
}
