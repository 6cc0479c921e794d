//! Contestants that are wrong on purpose.

use super::*;
use crate::build::{BuildError, find};
use crate::lab::Comparison;
use crate::lab::study::Watch;
use crate::trace::Kernel;
use std::time::Duration;

struct Silent;

impl Watch for Silent {
    fn begin(&mut self, _: &str, _: f64) {}
    fn say(&mut self, _: &str) {}
}

fn comparison(contestants: Vec<Contestant>) -> Comparison {
    Comparison {
        contestants,
        rows: None,
        budget: Duration::from_secs(20),
        repeats: Repeats { runs: 2, ..Repeats::default() },
        kernel: Kernel::Scalar,
        kernel_id: "scalar".into(),
        size: (16, 16),
    }
}

fn good<P: crate::build::Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    let params = crate::build::binned_sah::BinnedSah { max_leaf: options.max_leaf.unwrap_or(4), ..Default::default() };
    crate::build::binned_sah::build(input.boxes, &params, probe)
}

/// Has lost a triangle.
fn lossy(input: Input, options: &BuildOptions, probe: &mut Brake) -> Result<Bvh, BuildError> {
    let mut bvh = good(input, options, probe)?;
    bvh.triangle_ids[0] = bvh.triangle_ids[1];
    Ok(bvh)
}

/// Builds another tree when it is counted.
fn fickle(input: Input, options: &BuildOptions, probe: &mut Counters) -> Result<Bvh, BuildError> {
    good(input, &BuildOptions { max_leaf: Some(1), ..*options }, probe)
}

static GOOD: Builder = Builder { id: "good", timed: good::<Brake>, counted: good::<Counters>, ..BASE };
static LOSSY: Builder = Builder { id: "lossy", timed: lossy, ..GOOD };
static FICKLE: Builder = Builder { id: "fickle", counted: fickle, ..GOOD };
const BASE: Builder = Builder {
    id: "",
    paper: "",
    summary: "",
    presets: &[],
    engines: &[],
    parameters: &[],
    parallel: |_| false,
    spatial: false,
    arities: &[2],
    timed: good::<Brake>,
    counted: good::<Counters>,
};

fn recipe(builder: &'static Builder) -> Contestant {
    Contestant::Recipe { builder, options: BuildOptions::default() }
}

#[test]
fn wrong_trees_become_errors_without_figures_and_stop_nobody() {
    let scene = Scene::load("gen:spheres:200").unwrap();
    let all = comparison([&LOSSY, &GOOD, &FICKLE].map(recipe).to_vec());
    let rows = all.run(&[scene], &mut Silent).unwrap().remove(0);
    assert_eq!([0, 1, 2].map(|i| rows[i].status), [Status::Error, Status::Ok, Status::Error]);
    assert!(rows[0].note.contains("stands in"), "{}", rows[0].note);
    assert!(rows[2].note.contains("different trees"), "{}", rows[2].note);
    for row in [&rows[0], &rows[2]] {
        assert_eq!((row.build_ms, row.sah, row.primary_nodes, row.primary_mrays), (None, None, None, None));
        assert_eq!((row.counters.as_str(), row.bytes), ("", None));
    }
    assert!(rows[1].build_runs == 2 && rows[1].primary_runs == 2 && rows[1].diffuse_mrays > Some(0.0));
}

#[test]
fn wrong_hits_become_an_error_without_figures() {
    let scene = Scene::load("gen:spheres:200").unwrap();
    let all = comparison(vec![recipe(&GOOD)]);
    let mut reference = Reference::new(&scene, Kernel::Scalar, (16, 16)).unwrap();
    let look = |reference: &Reference| {
        let empty = all.empty_row(&all.contestants[0], &scene);
        let mut contest = Contest::new(&all, &scene, vec![empty]);
        let mut runner = contest.runners.remove(0);
        runner.prepare(&all, &scene, reference);
        runner.build(&scene.triangles, &all.repeats);
        runner.trace(&all, &scene, reference, &mut Vec::new());
        runner.finish(reference)
    };
    assert_eq!(look(&reference).status, Status::Ok);
    reference.diffuse.expected[0].triangle ^= 1;
    let row = look(&reference);
    assert_eq!((row.status, row.note.as_str()), (Status::Error, "1 rays hit something else than they should"));
    assert_eq!((row.build_ms, row.sah, row.primary_mrays, row.tree_hash), (None, None, None, None));
}

#[test]
fn triangles_hidden_by_rule_q8_are_told_and_not_traced() {
    let scene = Scene::load("thesis:small").unwrap();
    let options = BuildOptions { arity: 8, ..BuildOptions::default() };
    let all = comparison(vec![Contestant::Recipe { builder: find("top-down").unwrap(), options }]);
    let rows = Comparison { size: (200, 200), ..all }.run(&[scene], &mut Silent).unwrap().remove(0);
    assert!(rows[0].hidden > Some(0) && rows[0].status == Status::Ok);
    assert!(rows[0].note.contains("hidden by rule Q8"), "{}", rows[0].note);
    assert_eq!((rows[0].primary_mrays, rows[0].primary_nodes), (None, None));
    assert!(rows[0].build_ms > Some(0.0) && rows[0].sah > Some(0.0));
}
