//! Experiments on the smallest scene: what they vary changes what it should and nothing else, and nothing is measured twice.

use crate::support::{STUDY, builds, lines, reproduce, text, traces};
use bvh_lab::rows::{Construction, Experiment, ExperimentRow, Lighting, Status, read};
use std::path::Path;
use std::sync::LazyLock;

const CELLS: [&str; 4] = ["--scenes", "thesis:tiny", "--only", "experiments"];

static ROWS: LazyLock<(tempfile::TempDir, Vec<ExperimentRow>)> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path());
    let rows = read(&dir.path().join("rows")).unwrap();
    (dir, rows)
});

fn run(out: &Path) {
    let output = reproduce(out, &CELLS, "600");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn of(experiment: Experiment) -> impl Iterator<Item = &'static ExperimentRow> {
    ROWS.1.iter().filter(move |r| r.experiment == experiment)
}

#[test]
fn every_row_is_verified_and_none_is_measured_twice() {
    assert!(ROWS.1.iter().all(|r| r.status == Status::Ok), "{:?}", ROWS.1.iter().find(|r| r.status != Status::Ok));
    // Candidates are swept on another scene.
    for experiment in Experiment::ALL.into_iter().filter(|e| *e != Experiment::Candidates) {
        assert!(of(experiment).next().is_some(), "{experiment:?}");
    }
    let before = lines::<ExperimentRow>(ROWS.0.path());
    run(ROWS.0.path());
    assert_eq!(lines::<ExperimentRow>(ROWS.0.path()), before);
}

#[test]
fn the_trees_are_those_of_the_study() {
    for row in of(Experiment::Lookup) {
        let built = builds(&STUDY).into_iter().find(|b| (b.construction.id(), b.arity) == (&row.builder, row.arity));
        assert_eq!(row.tree_hash, built.unwrap().tree_hash, "{row:?}");
        let traced = traces(&STUDY)
            .into_iter()
            .find(|t| (t.construction.id(), t.arity, t.lighting) == (&*row.builder, row.arity, Lighting::Primary));
        assert_eq!(row.nodes_per_pixel, traced.unwrap().nodes_per_pixel);
        assert!(row.us_per_pixel > Some(0.0));
    }
}

#[test]
fn the_rule_hides_triangles_and_the_closest_hit_is_right() {
    let q8 = |setting: &str| of(Experiment::RuleQ8).find(|r| r.setting == setting).unwrap();
    assert!(q8("rule=on").q8_hidden > Some(0) && q8("rule=off").q8_hidden == Some(0));
    assert!(q8("rule=on").nodes_per_pixel > q8("rule=off").nodes_per_pixel);
    for row in of(Experiment::FirstLeaf) {
        let hidden = row.builder == Construction::TopDown.id() && row.arity == 8;
        let wrong = row.farther.unwrap() + row.missed.unwrap() + row.extra.unwrap();
        match row.setting.as_str() {
            "traversal=closest" => assert!(hidden || wrong == 0, "{row:?}"),
            _ => assert!(wrong > 0, "{row:?}"),
        }
    }
}

#[test]
fn readings_that_are_presets_have_their_figures() {
    let find = |arity: usize, setting: &str| {
        of(Experiment::Readings).find(|r| r.arity == arity && r.setting == setting).unwrap().nodes_per_pixel
    };
    let traced = |construction: Construction, arity: usize| {
        let mut all = traces(&STUDY).into_iter();
        let is = |t: &bvh_lab::rows::TraceRow| {
            (t.construction, t.arity, t.lighting) == (construction, arity, Lighting::Primary)
        };
        all.find(is).unwrap().nodes_per_pixel
    };
    for arity in [2, 4] {
        assert_eq!(find(arity, "ranks, one axis, weighted; first leaf"), traced(Construction::TopDown, arity));
    }
    for arity in [2, 4, 8] {
        let chain = find(arity, "chain of nearest centres, thesis collapse; first leaf");
        assert_eq!(chain, traced(Construction::BottomUp, arity));
    }
}
