//! One entry a builder, in the order of `list builders`.

use super::pipeline::refined;
use super::{Builder, Engine, Parameter, Preset};
use crate::build::binned_sah::{self, BinnedSah};
use crate::build::bottom_up::agglo_kd::{self, AggloKd};
use crate::build::bottom_up::{all_pairs_literal, centres_exact, chain_exact, chain_literal, union_area};
use crate::build::hlbvh::{self, Hlbvh};
use crate::build::kway_sah::{self, Cuts, KwaySah, Nodes};
use crate::build::lbvh::{self, Lbvh};
use crate::build::ploc::{self, Ploc};
use crate::build::sbvh::{self, Sbvh};
use crate::build::top_down::{Published, Text, published_exact, published_literal, text_exact, text_literal};
use crate::build::{Brake, BuildError, BuildOptions, Counters, Input, MAX_LEAF, Probe, sweep_sah};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use crate::refine::{collapse, equal_leaves, open_leaves};

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
        parameters: &[Parameter::Candidates, Parameter::Q8, Parameter::Costs, Parameter::MaxLeaf, Parameter::Refine],
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
        parameters: &[Parameter::MaxLeaf, Parameter::Refine],
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
        id: "agglo-kd",
        paper: "Walter et al. 2008; Gu et al. 2013",
        summary: "clustering among the nearest centres only, found by kiddo's k-d tree (--radius: how many)",
        presets: &[],
        engines: &[],
        parameters: &[Parameter::MaxLeaf, Parameter::Refine, Parameter::Collapse, Parameter::Radius],
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: agglo_kd::<Brake>,
        counted: agglo_kd::<Counters>,
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
    Builder {
        id: "sbvh",
        paper: "Stich, Friedrich and Dietrich 2009",
        summary: "object splits as sweep-sah, and spatial splits that cut triangles in two within a budget",
        presets: &[],
        engines: &[],
        parameters: &[
            Parameter::MaxLeaf,
            Parameter::Refine,
            Parameter::Collapse,
            Parameter::Bins,
            Parameter::SplitBudget,
        ],
        parallel: |_| true,
        spatial: true,
        arities: MODERN_ARITIES,
        timed: sbvh::<Brake>,
        counted: sbvh::<Counters>,
    },
    Builder {
        id: "kway-sah",
        paper: "after Beick 2014; Gilmore and Gomory 1965 for the cuts",
        summary: "the best division of a grid into k parts by cuts from side to side; binary: by the best tree over the grid",
        presets: &[],
        engines: &[],
        parameters: &[Parameter::MaxLeaf, Parameter::Refine, Parameter::Collapse, Parameter::Bins],
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: kway_sah::<Brake>,
        counted: kway_sah::<Counters>,
    },
    Builder {
        id: "kway-slab",
        paper: "after Beick 2014",
        summary: "the best k slabs between equal bins of one axis: what kway-sah is measured by",
        presets: &[],
        engines: &[],
        parameters: &[Parameter::MaxLeaf, Parameter::Bins],
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: kway_slab::<Brake>,
        counted: kway_slab::<Counters>,
    },
    Builder {
        id: "lbvh",
        paper: "Lauterbach et al. 2009; Karras 2012; Apetrei 2014",
        summary: "triangles along the Morton curve, split where the highest bit changes",
        presets: &[],
        engines: &[],
        parameters: BINARY,
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: lbvh::<Brake>,
        counted: lbvh::<Counters>,
    },
    Builder {
        id: "hlbvh",
        paper: "Pantaleoni and Luebke 2010; Garanzha et al. 2011",
        summary: "small subtrees of lbvh (--cluster: how many triangles), above them binned-sah",
        presets: &[],
        engines: &[],
        parameters: &[Parameter::MaxLeaf, Parameter::Refine, Parameter::Collapse, Parameter::Bins, Parameter::Cluster],
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: hlbvh::<Brake>,
        counted: hlbvh::<Counters>,
    },
    Builder {
        id: "ploc",
        paper: "Meister and Bittner 2018",
        summary: "clusters in Morton order merge with the nearest within a radius, all at once, round by round",
        presets: &[],
        engines: &[],
        parameters: &[Parameter::MaxLeaf, Parameter::Refine, Parameter::Collapse, Parameter::Radius],
        parallel: |_| true,
        spatial: false,
        arities: MODERN_ARITIES,
        timed: ploc::<Brake>,
        counted: ploc::<Counters>,
    },
];

/// The arities of modern builders: binary, or collapsed.
const MODERN_ARITIES: &[usize] = &[2, 4, 8, 16];

fn top_down<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    let (boxes, arity) = (input.boxes, options.arity);
    let candidates = options.candidates.unwrap_or(200 / arity.max(1));
    let published = Published { arity, candidates, q8: options.q8 };
    let text = Text { arity, planes: candidates };
    let bvh = match (options.preset, options.engine) {
        (Preset::Published, Engine::Exact) => published_exact::build(boxes, &published, probe),
        (Preset::Published, Engine::Literal) => published_literal::build_by(boxes, &published, options.costs, probe),
        (Preset::Text, Engine::Exact) => text_exact::build(boxes, &text, probe),
        (Preset::Text, Engine::Literal) => text_literal::build(boxes, &text, probe),
        (Preset::Walter, _) => Err(BuildError::Parameter("top-down has no preset walter".into())),
    }?;
    Ok(with_leaves(bvh, boxes, options))
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
    let binary = with_leaves(binary, boxes, options);
    Ok(if options.arity == 2 { binary } else { collapse(&binary, options.arity) })
}

/// The thesis' leaves hold up to four triangles whatever they cost. With `+leaves`, the one step that its builders take
/// ([`Builder::check`]), they are what they are in modern trees, so that costs compare.
fn with_leaves(bvh: Bvh, boxes: &[Aabb], options: &BuildOptions) -> Bvh {
    if options.refine.is_empty() {
        return bvh;
    }
    equal_leaves(&bvh, boxes, options.max_leaf.unwrap_or(MAX_LEAF))
}

fn agglo_local<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| {
        let triangles = union_area::build_with_leaves(input.boxes, 1, probe)?;
        Ok(open_leaves(&triangles, max_leaf))
    })
}

fn agglo_kd<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| {
        let neighbours = options.radius.unwrap_or(AggloKd::default().neighbours);
        let triangles = agglo_kd::build(input.boxes, &AggloKd { neighbours }, probe)?;
        Ok(open_leaves(&triangles, max_leaf))
    })
}

fn sweep_sah<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| sweep_sah::build(input.boxes, &sweep_sah::SweepSah { max_leaf }, probe))
}

fn binned_sah<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| {
        let bins = options.bins.unwrap_or(BinnedSah::default().bins);
        binned_sah::build(input.boxes, &BinnedSah { max_leaf, bins }, probe)
    })
}

fn sbvh<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| {
        let default = Sbvh::default();
        let bins = options.bins.unwrap_or(default.bins);
        let budget = options.split_budget.unwrap_or(default.budget);
        sbvh::build(input, &Sbvh { max_leaf, bins, budget, ..default }, probe)
    })
}

/// Refined or collapsed is its binary tree; without either, wide nodes are built as they are.
fn kway_sah<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    let params = |arity, max_leaf| {
        let params = KwaySah::at_arity(arity);
        KwaySah { max_leaf, bins: options.bins.unwrap_or(params.bins), ..params }
    };
    if options.arity > 2 && options.refine.is_empty() && options.collapse.is_none() {
        let max_leaf = options.max_leaf.unwrap_or(MAX_LEAF);
        return kway_sah::build(input.boxes, &params(options.arity, max_leaf), probe);
    }
    refined(options, probe, |max_leaf, probe| kway_sah::build(input.boxes, &params(2, max_leaf), probe))
}

fn kway_slab<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    let (params, max_leaf) = (KwaySah::default(), options.max_leaf.unwrap_or(MAX_LEAF));
    let runs = options.bins.unwrap_or(params.runs);
    let slabs = KwaySah { parts: options.arity, nodes: Nodes::Parts, cuts: Cuts::Slabs, max_leaf, runs, ..params };
    kway_sah::build(input.boxes, &slabs, probe)
}

fn lbvh<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| lbvh::build(input.boxes, &Lbvh { max_leaf }, probe))
}

fn hlbvh<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| {
        let default = Hlbvh::default();
        let cluster = options.cluster.unwrap_or(default.cluster);
        let bins = options.bins.unwrap_or(default.bins);
        hlbvh::build(input.boxes, &Hlbvh { max_leaf, cluster, bins }, probe)
    })
}

fn ploc<P: Probe>(input: Input, options: &BuildOptions, probe: &mut P) -> Result<Bvh, BuildError> {
    refined(options, probe, |max_leaf, probe| {
        let radius = options.radius.unwrap_or(Ploc::default().radius);
        ploc::build(input.boxes, &Ploc { radius, max_leaf }, probe)
    })
}
