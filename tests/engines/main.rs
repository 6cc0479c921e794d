//! Two engines under every name: `literal` does the thesis' work, `exact` must return the very same tree.
//!
//! Equal means: the same nodes, the same children in the same order, the same triangles in every leaf, the same boxes,
//! and so the same `tree_hash`. `cargo test --release --test engines -- --nocapture` prints how many trees were compared;
//! with `--ignored` the larger scenes of the thesis are, in about a quarter of an hour.

mod slow;
mod ties;
mod twins;

use bvh_lab::build::Preset;
use bvh_lab::scene::families::FAMILIES;
use proptest::test_runner::{Config, TestCaseError, TestRunner};
use std::cell::RefCell;
use twins::{Tally, boxes, only, variants};

/// So few candidates that a literal search over mixed planes ends soon.
fn few(preset: Preset, arity: usize) -> Option<usize> {
    match (preset, arity) {
        (Preset::Text, 8) => Some(5),
        (Preset::Text, 4) => Some(9),
        _ => None,
    }
}

#[test]
fn every_family_at_every_small_size() {
    let mut tally = Tally::new("families");
    for family in FAMILIES {
        for n in (1..=17).chain([33, 65, 150]) {
            let name = format!("gen:{}:{n}", family.name);
            tally.compare_all(&variants(few), &boxes(&name), &name);
        }
    }
}

#[test]
fn odd_numbers_of_candidates() {
    let mut tally = Tally::new("candidates");
    for candidates in [8, 9, 11] {
        for name in ["gen:spheres:90", "gen:slivers:90", "gen:coincident:40", "gen:nested:60"] {
            let all = variants(|_, _| Some(candidates));
            let all: Vec<_> = all.into_iter().filter(|(b, _)| b.id == "top-down").collect();
            tally.compare_all(&all, &boxes(name), name);
        }
    }
}

#[test]
fn the_smallest_scene_of_the_thesis() {
    let mut tally = Tally::new("thesis:tiny");
    // All of it with the thesis' own parameters, but for the 1.3·10¹¹ choices of eight children among 75 planes.
    let own = |preset, arity| (preset == Preset::Text && arity == 8).then_some(9);
    tally.compare_all(&variants(own), &boxes("thesis:tiny"), "thesis:tiny");
}

#[test]
fn the_second_scene_of_the_thesis() {
    let mut tally = Tally::new("thesis:small");
    let name = "thesis:small";
    let boxes = boxes(name);
    let own = |preset, arity| (preset == Preset::Text && arity == 8).then_some(6);
    let slow = |preset| matches!(preset, Preset::Text | Preset::Walter);
    // All pairs take seconds, and all arities are collapsed from the same binary tree: one will do.
    let quick = |id: &str, preset, arity| id == "top-down" || !slow(preset) || arity == 4;
    let all: Vec<_> = variants(own).into_iter().filter(|(b, o)| quick(b.id, o.preset, o.arity)).collect();
    tally.compare_all(&all, &boxes, name);
}

#[test]
fn boxes_that_provoke_ties() {
    let tally = RefCell::new(Tally::new("ties"));
    let all =
        variants(|preset, arity| if (preset, arity) == (Preset::Published, 8) { Some(12) } else { few(preset, arity) });
    for (name, strategy) in ties::families(1..=48) {
        let mut runner = TestRunner::new(Config { cases: 48, failure_persistence: None, ..Config::default() });
        let outcome = runner.run(&strategy, |boxes| {
            let mut tally = tally.borrow_mut();
            all.iter().try_for_each(|v| tally.compare(v, &boxes)).map_err(TestCaseError::fail)
        });
        outcome.unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn few_boxes_that_provoke_ties_in_many_ways() {
    let tally = RefCell::new(Tally::new("ties among few"));
    // At arity 8 the published search wants eight candidates or more.
    let all = variants(|preset, arity| (preset == Preset::Text || arity < 8).then_some(4));
    for (name, strategy) in ties::families(4..=14) {
        let mut runner = TestRunner::new(Config { cases: 256, failure_persistence: None, ..Config::default() });
        let outcome = runner.run(&strategy, |boxes| {
            let mut tally = tally.borrow_mut();
            all.iter().try_for_each(|v| tally.compare(v, &boxes)).map_err(TestCaseError::fail)
        });
        outcome.unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}

#[test]
fn any_number_of_threads() {
    let mut tally = Tally::new("threads");
    for name in ["gen:spheres:6000", "gen:hairball:4000", "gen:coincident:1500", "gen:nested:1500", "thesis:med"] {
        let boxes = boxes(name);
        for variant in variants(few) {
            tally.compare_threads(&variant, &boxes, name);
        }
    }
}

#[test]
fn every_reading_is_compared() {
    let readings: Vec<_> = variants(few).iter().map(|(b, o)| (b.id, o.preset.id(), o.arity, o.q8)).collect();
    assert_eq!(readings.len(), 5 * 3 + 1, "{readings:?}");
    assert_eq!(only("bottom-up", Preset::Walter, variants(few)).len(), 3);
}
