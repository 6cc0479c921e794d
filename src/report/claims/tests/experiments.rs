//! Verdicts that rest on experiments, turned round by rows made up for the purpose.

use super::Rows;
use crate::report::claims::Verdict::{self, Artefact, Corrected, Fails, Holds, Undecided};
use crate::report::claims::evidence::KINDS;
use crate::report::printed::Model;
use crate::rows::{Experiment, ExperimentRow, Lighting, Status};

fn row(experiment: Experiment, scene: &str, builder: &str, arity: usize, setting: &str) -> ExperimentRow {
    ExperimentRow {
        experiment,
        scene: scene.into(),
        triangles: 10_000,
        scene_hash: "0".into(),
        builder: builder.into(),
        preset: String::new(),
        arity,
        setting: setting.into(),
        candidates: None,
        lighting: Lighting::Primary,
        status: Status::Ok,
        budget_s: None,
        note: String::new(),
        build_ms: None,
        tree_hash: None,
        inner: None,
        leaves: None,
        avg_degree: None,
        sah: None,
        kernel: String::new(),
        us_per_pixel: None,
        us_per_pixel_min: None,
        us_per_pixel_max: None,
        wide_us_per_pixel: None,
        nodes_per_pixel: None,
        box_tests_per_pixel: None,
        triangle_tests_per_pixel: None,
        hit_fraction: None,
        rays: None,
        cut: None,
        farther: None,
        missed: None,
        extra: None,
        q8_nodes: None,
        q8_duplicated: None,
        q8_hidden: None,
        threads: 1,
        machine: String::new(),
        version: String::new(),
        commit: String::new(),
    }
}

fn verdict(id: &str, preset: usize, rows: Vec<ExperimentRow>) -> Verdict {
    let mut all = Rows::reference();
    all.study.experiments = rows;
    all.verdict(id, preset)
}

fn triangles(model: Model) -> f64 {
    [648.0, 2540.0, 11_516.0, 25_340.0, 88_748.0][model as usize]
}

/// One row a model and kind of tree.
fn of_kinds(experiment: Experiment, setting: &str, fill: impl Fn(&mut ExperimentRow, Model)) -> Vec<ExperimentRow> {
    let all = Model::ALL.into_iter().flat_map(|m| KINDS.map(|k| (m, k)));
    let one = |(model, kind): (Model, crate::report::claims::evidence::Kind)| {
        let mut row = row(experiment, &model.scene(), kind.0.id(), kind.1, setting);
        fill(&mut row, model);
        row
    };
    all.map(one).collect()
}

#[test]
fn times_with_and_without_the_lookup() {
    let with = |direct: f64, linear: f64| {
        let times = |setting, exponent: f64| {
            of_kinds(Experiment::Lookup, setting, |r, m| r.us_per_pixel = Some(triangles(m).powf(exponent)))
        };
        let rows = [times("lookup=direct", direct), times("lookup=linear", linear)].concat();
        verdict("time-grows-with-size", 0, rows)
    };
    assert_eq!([with(0.1, 0.9), with(0.9, 0.9), with(0.1, 0.1)], [Artefact, Holds, Fails]);
    assert_eq!(verdict("time-grows-with-size", 0, Vec::new()), Undecided);
}

#[test]
fn nodes_with_and_without_the_rule() {
    let with = |off: f64, on: f64, studied: f64| {
        let mut all = Rows::reference();
        all.study.experiments.clear();
        all.study.traces.iter_mut().for_each(|r| r.nodes_per_pixel = Some(if r.arity == 8 { studied } else { 5.0 }));
        for (setting, nodes) in [("rule=off", off), ("rule=on", on)] {
            all.study.experiments.extend(Model::ALL.map(|m| ExperimentRow {
                nodes_per_pixel: Some(nodes),
                q8_hidden: Some(7),
                ..row(Experiment::RuleQ8, &m.scene(), "top-down", 8, setting)
            }));
        }
        all.verdict("arity-8-visits-more", 0)
    };
    assert_eq!([with(4.0, 5.5, 5.5), with(6.0, 6.5, 6.5), with(6.0, 4.0, 4.0)], [Artefact, Holds, Fails]);
    assert_eq!(verdict("arity-8-visits-more", 0, Vec::new()), Undecided);
}

#[test]
fn pixels_that_are_wrong() {
    let with = |first: usize, closest: usize| {
        let pixels = |setting, wrong| {
            of_kinds(Experiment::FirstLeaf, setting, |r, _| {
                (r.farther, r.missed, r.extra) = (Some(wrong), Some(0), Some(0));
            })
        };
        let rows = [pixels("traversal=first-leaf", first), pixels("traversal=closest", closest)].concat();
        verdict("images-are-right", 0, rows)
    };
    assert_eq!([with(10, 0), with(1000, 0), with(1000, 1000)], [Holds, Artefact, Fails]);
    assert_eq!(verdict("images-are-right", 1, Vec::new()), Undecided);
}

#[test]
fn the_collapse_alone() {
    let with = |ms: f64| {
        let all = Model::ALL.into_iter().flat_map(|m| [4, 8].map(|k| (m, k)));
        let rows = all.map(|(m, k)| ExperimentRow {
            preset: "published".into(),
            build_ms: Some(ms),
            ..row(Experiment::Collapse, &m.scene(), "bottom-up", k, "collapse=alone")
        });
        verdict("collapse-is-cheap", 0, rows.collect())
    };
    // The printed times contradict it, whatever is measured.
    assert_eq!([with(0.001), with(1000.0)], [Corrected, Fails]);
}

#[test]
fn all_planes() {
    let with = |gain: f64, tests: fn(usize) -> f64| {
        let mut rows = Vec::new();
        for scene in ["a", "b", "c"] {
            for (arity, candidates) in [(2, 100), (4, 50), (4, 100), (8, 25), (8, 100)] {
                let full = candidates == 100 && arity > 2;
                rows.push(ExperimentRow {
                    preset: "published".into(),
                    candidates: Some(candidates),
                    sah: Some(if full { 10.0 * gain } else { 10.0 }),
                    nodes_per_pixel: Some(8.0 / arity as f64),
                    box_tests_per_pixel: Some(tests(arity)),
                    triangle_tests_per_pixel: Some(1.0),
                    ..row(Experiment::Conjecture, scene, "top-down", arity, "planes")
                });
            }
        }
        verdict("full-planes-would-win", 0, rows)
    };
    assert_eq!(with(0.9, |k| 20.0 / k as f64), Holds);
    assert_eq!(with(0.9, |k| k as f64), Fails);
    assert_eq!(with(1.0, |k| 20.0 / k as f64), Fails);
    assert_eq!(verdict("full-planes-would-win", 0, Vec::new()), Undecided);
}

#[test]
fn how_many_planes() {
    let with = |at_100: f64| {
        let mut rows = Vec::new();
        for scene in ["a", "b", "c"] {
            for (candidates, sah) in [(50, 11.0), (100, at_100), (400, 10.0)] {
                rows.push(ExperimentRow {
                    preset: "published".into(),
                    candidates: Some(candidates),
                    sah: Some(sah),
                    ..row(Experiment::Candidates, scene, "top-down", 2, "sweep")
                });
            }
        }
        verdict("hundred-planes-suffice", 0, rows)
    };
    assert_eq!([with(10.1), with(10.5)], [Holds, Fails]);
    let sweep = |ms: f64| {
        let rows = Model::ALL.map(|m| ExperimentRow {
            build_ms: Some(ms),
            sah: Some(10.0),
            ..row(Experiment::Conjecture, &m.scene(), "sweep-sah", 2, "yardstick")
        });
        verdict("best-plane-unreasonable", 0, rows.to_vec())
    };
    assert_eq!([sweep(1e9), sweep(1e-3)], [Holds, Fails]);
}

#[test]
fn readings_are_named_with_their_distance() {
    let mut all = Rows::reference();
    all.study.experiments = Vec::new();
    for (builder, setting, nodes) in
        [("one-axis", "near", 4.85), ("one-axis", "far", 48.5), ("bottom-up", "close", 5.39)]
    {
        let nodes_per_pixel = Some(nodes);
        all.study
            .experiments
            .push(ExperimentRow { nodes_per_pixel, ..row(Experiment::Readings, "thesis:tiny", builder, 2, setting) });
    }
    let claim = crate::report::claims::claims().find(|c| c.id == "words-describe-program").unwrap();
    let finding = (claim.decide)(&all.evidence(), "published");
    assert!(
        finding.why.contains("Of 3 readings tried the nearest are “near” (0 %) and “close” (0 %)"),
        "{}",
        finding.why
    );
}
