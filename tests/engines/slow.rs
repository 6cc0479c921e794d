//! The larger scenes of the thesis, and generated ones for the engines over all pairs: a quarter of an hour of literal work.

use crate::twins::{Tally, Variant, boxes, build, only, variants};
use bvh_lab::build::{Engine, Preset};
use bvh_lab::refine::collapse;
use bvh_lab::scene::families::FAMILIES;

/// The thesis' own parameters, but `planes` for the text's search at arity 8.
fn thesis(planes: usize) -> Vec<Variant> {
    variants(|preset, arity| (preset == Preset::Text && arity == 8).then_some(planes))
}

/// All arities of a bottom-up reading for the price of one literal build: the binary tree, collapsed.
fn compare_collapsed(tally: &mut Tally, preset: Preset, scene: &str) {
    let boxes = boxes(scene);
    let readings = only("bottom-up", preset, thesis(1));
    let binary = build(&readings[0], Engine::Literal, &boxes).unwrap();
    for variant in &readings {
        let literal = if variant.1.arity == 2 { binary.clone() } else { collapse(&binary, variant.1.arity) };
        tally.compare_with(&literal, variant, &boxes).unwrap_or_else(|e| panic!("{scene}: {e}"));
    }
}

fn top_down(of: &'static str, scene: &str, planes: usize) {
    let mut tally = Tally::new(of);
    let boxes = boxes(scene);
    for preset in [Preset::Published, Preset::Text] {
        tally.compare_all(&only("top-down", preset, thesis(planes)), &boxes, scene);
    }
}

#[test]
#[ignore = "minutes of literal work"]
fn top_down_med() {
    top_down("top-down thesis:med", "thesis:med", 12);
}

#[test]
#[ignore = "minutes of literal work"]
fn top_down_large() {
    top_down("top-down thesis:large", "thesis:large", 10);
}

#[test]
#[ignore = "minutes of literal work"]
fn top_down_huge() {
    top_down("top-down thesis:huge", "thesis:huge", 8);
}

#[test]
#[ignore = "minutes of literal work"]
fn bottom_up_published() {
    let mut tally = Tally::new("bottom-up published");
    for scene in ["thesis:med", "thesis:large", "thesis:huge"] {
        compare_collapsed(&mut tally, Preset::Published, scene);
    }
    for family in FAMILIES {
        compare_collapsed(&mut tally, Preset::Published, &format!("gen:{}:20000", family.name));
    }
}

#[test]
#[ignore = "minutes of literal work"]
fn bottom_up_text_med() {
    compare_collapsed(&mut Tally::new("bottom-up text thesis:med"), Preset::Text, "thesis:med");
}

#[test]
#[ignore = "minutes of literal work"]
fn bottom_up_walter_med() {
    compare_collapsed(&mut Tally::new("bottom-up walter thesis:med"), Preset::Walter, "thesis:med");
}

#[test]
#[ignore = "minutes of literal work"]
fn all_pairs_of_every_family() {
    let mut tally = Tally::new("all pairs of families");
    for family in FAMILIES {
        for preset in [Preset::Text, Preset::Walter] {
            compare_collapsed(&mut tally, preset, &format!("gen:{}:3000", family.name));
        }
    }
}
