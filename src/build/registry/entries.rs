//! One entry a builder, in the order of `list builders`.

use super::pipeline::{refined, widened};
use super::{Builder, Engine, Parameter, Preset};
use crate::build::binned_sah::{self, BinnedSah};
use crate::build::bottom_up::{all_pairs_literal, centres_exact, chain_exact, chain_literal, union_area};
use crate::build::top_down::{Published, Text, published_exact, published_literal, text_exact, text_literal};
use crate::build::{Brake, BuildError, BuildOptions, Counters, Input, Probe, sweep_sah};
use crate::bvh::Bvh;
use crate::refine::{Collapse, open_leaves};

/// What every builder of binary trees understands.
const BINARY: &[Parameter] = &[Parameter::MaxLeaf, Parameter::Refine, Parameter::Collapse];

/// All builders, in the order of `list builders`.
pub const BUILDERS: &[Builder] = &[
    Builder {
        id: "top-down",
        paper: "Beick 2014",
        summary: "exhaustive search over arity - 1 splits at once, on one axis (published) or mixed planes (text)",
        presets: &[Preset::Published, Preset::Text],
        engines: &Engine::ALL,
        parameters: &[Parameter::Candidates, Parameter::Q8, Parameter::Costs],
        parallel: |_| false,
        spatial: false,
        arities: &[2, 4, 8],
        timed: top_down::<Brake>,
        counted: top_down::<Counters>,
    },
    Builder {
        id: "bottom-up",
        paper: "Beick 2014, after Walter et al. 2008",
        summary: "agglomerative clustering, by a chain (published), the closest centres (text) or the least union (walter)",
        presets: &[Preset::Published, Preset::Text, Preset::Walter],
        engines: &Engine::ALL,
        parameters: &[],
        parallel: |o| (o.preset, o.engine) == (Preset::Walter, Engine::Exact),
        spatial: false,
        arities: &[2, 4, 8],
        timed: bottom_up::<Brake>,
        counted: bottom_up::<Counters>,
    },
    Builder {
        id: "agglo-local",
        paper: "Walter et al. 2008; Benzécri 1982",
        summary: "the exact clustering of bottom-up walter with leaves where the cost wants them",
        presets: &[],
        engines: &[],
        parameters: BINARY,
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: agglo_local::<Brake>,
        counted: agglo_local::<Counters>,
    },
    Builder {
        id: "sweep-sah",
        paper: "MacDonald and Booth 1990",
        summary: "every split of the sorted centres of each axis by its cost: what others are measured by",
        presets: &[],
        engines: &[],
        parameters: BINARY,
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: sweep_sah::<Brake>,
        counted: sweep_sah::<Counters>,
    },
    Builder {
        id: "binned-sah",
        paper: "Wald 2007",
        summary: "planes between equal bins of centres by their cost, one pass a level",
        presets: &[],
        engines: &[],
        parameters: &[Parameter::MaxLeaf, Parameter::Refine, Parameter::Collapse, Parameter::Bins],
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: binned_sah::<Brake>,
        counted: binned_sah::<Counters>,
    },
];

/// The arities of modern builders: binary, or collapsed.
const MODERN_ARITIES: &[usize] = &[2, 4, 8, 16];

fn top_down<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    let (boxes, arity) = (input.boxes, options.arity);
    let candidates = options.candidates.unwrap_or(200 / arity.max(1));
    let published = Published { arity, candidates, q8: options.q8 };
    let text = Text { arity, planes: candidates };
    match (options.preset, options.engine) {
        (Preset::Published, Engine::Exact) => published_exact::build(boxes, &published, probe),
        (Preset::Published, Engine::Literal) => published_literal::build_by(boxes, &published, options.costs, probe),
        (Preset::Text, Engine::Exact) => text_exact::build(boxes, &text, probe),
        (Preset::Text, Engine::Literal) => text_literal::build(boxes, &text, probe),
        (Preset::Walter, _) => Err(BuildError::Parameter("top-down has no preset walter".into())),
    }
}

fn bottom_up<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    use all_pairs_literal::Distance;
    let boxes = input.boxes;
    let binary = match (options.preset, options.engine) {
        (Preset::Published, Engine::Exact) => chain_exact::build(boxes, probe),
        (Preset::Text, Engine::Exact) => centres_exact::build(boxes, probe),
        (Preset::Walter, Engine::Exact) => union_area::build(boxes, probe),
        (Preset::Published, Engine::Literal) => chain_literal::build(boxes, probe, &mut ()),
        (Preset::Text, Engine::Literal) => all_pairs_literal::build(boxes, Distance::Centres, probe),
        (Preset::Walter, Engine::Literal) => all_pairs_literal::build(boxes, Distance::UnionArea, probe),
    }?;
    Ok(widened(binary, options.arity, Collapse::Thesis))
}

fn agglo_local<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, |max_leaf| {
        let triangles = union_area::build_with_leaves(input.boxes, 1, probe)?;
        Ok(open_leaves(&triangles, max_leaf))
    })
}

fn sweep_sah<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, |max_leaf| sweep_sah::build(input.boxes, &sweep_sah::SweepSah { max_leaf }, probe))
}

fn binned_sah<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, |max_leaf| {
        let bins = options.bins.unwrap_or(BinnedSah::default().bins);
        binned_sah::build(input.boxes, &BinnedSah { max_leaf, bins }, probe)
    })
}
