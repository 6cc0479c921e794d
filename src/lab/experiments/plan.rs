//! What each experiment measures, cell by cell.

use crate::build::top_down::one_axis::{OneAxis, Placement, Weighing};
use crate::build::{BuildOptions, Preset};
use crate::refine::Collapse;
use crate::rows::{Construction, Experiment, Lighting};
use crate::trace::{FirstLeafOptions, Reading};

/// How a cell's tree is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Make {
    /// By a registered builder.
    Builder(&'static str, BuildOptions),
    /// By a reading of the thesis' top-down search that is no builder.
    OneAxis(OneAxis),
    /// By collapsing a registered builder's binary tree.
    Collapsed(&'static str, BuildOptions, Collapse),
}

/// What is done with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// The collapse is timed, nothing traced.
    TimeCollapse,
    /// A picture is counted.
    Count(Reading),
    /// Counted, and timed: by the scalar kernel, and by the wide one where `wide`.
    Time {
        /// How it is traced.
        reading: Reading,
        /// Whether the wide kernel is timed besides.
        wide: bool,
    },
    /// Counted, and its hits held against the closest ones.
    Compare(Reading),
}

/// One cell.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub experiment: Experiment,
    pub make: Make,
    pub setting: String,
    pub lighting: Lighting,
    pub action: Use,
}

const FIRST_LEAF: Reading = Reading::Published(FirstLeafOptions { tie_slip: true, linear_lookup: false });
const ARITIES: [usize; 3] = [2, 4, 8];
/// Beyond so many triangles `text` at arity 8 is not asked for 100 planes an axis: some 10¹⁰ steps at 10,000.
const TEXT_WIDE: usize = 12_000;

/// The cells of an experiment on a scene of `triangles`; none where it does not ask for such scenes.
pub(super) fn cells(experiment: Experiment, scene: &str, triangles: usize) -> Vec<Cell> {
    let of_thesis = scene.starts_with("thesis:");
    match experiment {
        Experiment::Conjecture => conjecture(triangles),
        Experiment::Candidates if scene == "thesis:med" || !of_thesis => candidates(triangles),
        Experiment::Candidates => Vec::new(),
        _ if !of_thesis => Vec::new(),
        Experiment::Lookup => lookup(),
        Experiment::RuleQ8 => rule_q8(),
        Experiment::FirstLeaf => first_leaf(),
        Experiment::Collapse => collapse(),
        Experiment::Origins => origins(),
        Experiment::Readings if scene != "thesis:huge" => readings(),
        Experiment::Readings => Vec::new(),
    }
}

fn cell(experiment: Experiment, make: Make, setting: impl Into<String>, action: Use) -> Cell {
    Cell { experiment, make, setting: setting.into(), lighting: Lighting::Primary, action }
}

fn thesis(construction: Construction, preset: Preset, arity: usize) -> (&'static str, BuildOptions) {
    (construction.id(), BuildOptions { preset, arity, ..BuildOptions::default() })
}

/// The six trees of the thesis' program.
fn published() -> impl Iterator<Item = Make> {
    let both = [Construction::TopDown, Construction::BottomUp];
    both.into_iter().flat_map(|c| ARITIES.map(|k| thesis(c, Preset::Published, k))).map(|(id, o)| Make::Builder(id, o))
}

/// The same, each with the traversal of the program.
pub(super) fn as_published() -> impl Iterator<Item = (Make, Reading)> {
    published().map(|make| (make, FIRST_LEAF))
}

fn lookup() -> Vec<Cell> {
    let reading = |linear_lookup| Reading::Published(FirstLeafOptions { linear_lookup, ..FirstLeafOptions::default() });
    let settings = [("lookup=direct", reading(false)), ("lookup=linear", reading(true))];
    let one =
        |make| settings.map(|(name, reading)| cell(Experiment::Lookup, make, name, Use::Time { reading, wide: false }));
    published().flat_map(one).collect()
}

fn rule_q8() -> Vec<Cell> {
    let (id, options) = thesis(Construction::TopDown, Preset::Published, 8);
    let one = |(name, q8)| {
        cell(Experiment::RuleQ8, Make::Builder(id, BuildOptions { q8, ..options }), name, Use::Compare(FIRST_LEAF))
    };
    [("rule=on", true), ("rule=off", false)].map(one).to_vec()
}

fn first_leaf() -> Vec<Cell> {
    let settings = [("traversal=first-leaf", FIRST_LEAF), ("traversal=closest", Reading::Text)];
    let one = |make| settings.map(|(name, reading)| cell(Experiment::FirstLeaf, make, name, Use::Compare(reading)));
    published().flat_map(one).collect()
}

fn collapse() -> Vec<Cell> {
    let one = |(preset, arity)| {
        let (id, options) = thesis(Construction::BottomUp, preset, 2);
        let make = Make::Collapsed(id, BuildOptions { arity, ..options }, Collapse::Thesis);
        cell(Experiment::Collapse, make, "collapse=alone", Use::TimeCollapse)
    };
    [Preset::Published, Preset::Text].into_iter().flat_map(|p| [(p, 4), (p, 8)]).map(one).collect()
}

fn origins() -> Vec<Cell> {
    let one = |make| {
        Lighting::ALL.map(|lighting| {
            let action = Use::Count(Reading::Text);
            Cell { lighting, ..cell(Experiment::Origins, make, "origins=hit points", action) }
        })
    };
    published().flat_map(one).collect()
}

/// A top-down search with so many candidates, the program's memory fault left out.
fn top_down(preset: Preset, arity: usize, candidates: usize) -> Make {
    let (id, options) = thesis(Construction::TopDown, preset, arity);
    let q8 = preset != Preset::Published;
    Make::Builder(id, BuildOptions { candidates: Some(candidates), q8, ..options })
}

fn conjecture(triangles: usize) -> Vec<Cell> {
    let action = Use::Time { reading: Reading::Text, wide: true };
    let mut all = Vec::new();
    for preset in [Preset::Published, Preset::Text] {
        for (arity, candidates) in [(2, 100), (4, 50), (4, 100), (8, 25), (8, 100)] {
            if preset == Preset::Text && (arity, candidates) == (8, 100) && triangles > TEXT_WIDE {
                continue;
            }
            let setting = if candidates == 100 { "planes=full" } else { "planes=reduced" };
            all.push(cell(Experiment::Conjecture, top_down(preset, arity, candidates), setting, action));
        }
    }
    for id in ["kway-slab", "kway-sah", "sweep-sah"] {
        for arity in ARITIES {
            let make = Make::Builder(id, BuildOptions { arity, ..BuildOptions::default() });
            all.push(cell(Experiment::Conjecture, make, "yardstick", action));
        }
    }
    all
}

fn candidates(triangles: usize) -> Vec<Cell> {
    const PUBLISHED: [usize; 9] = [4, 8, 16, 25, 50, 100, 200, 300, 400];
    const TEXT: [usize; 6] = [4, 8, 16, 25, 50, 100];
    let mut all = Vec::new();
    for (preset, numbers) in [(Preset::Published, &PUBLISHED[..]), (Preset::Text, &TEXT[..])] {
        for arity in ARITIES {
            for &n in numbers {
                let too_few = preset == Preset::Published && n < arity;
                let too_long = preset == Preset::Text && arity == 8 && n > 50 && triangles > TEXT_WIDE;
                if !too_few && !too_long {
                    let action = Use::Count(Reading::Text);
                    all.push(cell(Experiment::Candidates, top_down(preset, arity, n), "sweep", action));
                }
            }
        }
    }
    all
}

/// Each tree under both traversals.
fn readings() -> Vec<Cell> {
    let mut trees: Vec<(Make, String)> = Vec::new();
    for arity in ARITIES {
        for (placement, where_) in [(Placement::Ranks, "ranks"), (Placement::Planes, "planes")] {
            for (weighing, what) in [(Weighing::Weighted, "weighted"), (Weighing::Area, "area")] {
                let reading = OneAxis { arity, candidates: 200 / arity, placement, weighing };
                trees.push((Make::OneAxis(reading), format!("{where_}, one axis, {what}")));
            }
        }
        let (id, options) = thesis(Construction::TopDown, Preset::Text, arity);
        trees.push((Make::Builder(id, options), "planes, mixed axes, area".into()));
        for preset in Preset::ALL {
            let name = match preset {
                Preset::Published => "chain of nearest centres",
                Preset::Text => "nearest centres",
                Preset::Walter => "least union area",
            };
            let (id, options) = thesis(Construction::BottomUp, preset, 2);
            for rule in Collapse::ALL {
                if arity > 2 {
                    let make = Make::Collapsed(id, BuildOptions { arity, ..options }, rule);
                    trees.push((make, format!("{name}, {} collapse", rule.id())));
                } else {
                    // The same binary tree stands for every rule.
                    trees.push((Make::Builder(id, options), format!("{name}, {} collapse", rule.id())));
                }
            }
        }
    }
    let traversals = [("first leaf", FIRST_LEAF), ("closest hit", Reading::Text)];
    let both = |(make, name): (Make, String)| {
        traversals
            .map(|(kind, reading)| cell(Experiment::Readings, make, format!("{name}; {kind}"), Use::Count(reading)))
    };
    trees.into_iter().flat_map(both).collect()
}
