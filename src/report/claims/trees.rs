//! Claims about the trees: how full their nodes are, whether one way of building is as good as the other, whether they are what the
//! words describe.

use super::evidence::{ByModel, Evidence, KINDS, bottom_up, changes, distance, printed_cell, top_down};
use super::{Claim, Finding, Source, Verdict};
use crate::report::PRESETS;
use crate::report::experiments::Reading;
use crate::report::number::padded;
use crate::report::printed::Model;
use crate::report::summary::DEGREES_CLOSE;
use crate::rows::{Construction, Lighting};

const BUILDS: Source = Source::Rows("rows/builds.csv");
const TRACES: Source = Source::Rows("rows/traces.csv");

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "degree-after-collapse",
        statement: "Collapsed bottom-up trees have fewer children per node than the branching factor allows: 2.6 of 4, 6.6 of 8.",
        quote: "The maximum number of children each node can have is determined by the branching factor, although this number is rarely \
                exactly met.",
        place: "Data Tables, Table 3 and the note under it",
        predicate: "Measured average degrees lie below the arity. They are the printed ones, or only the corrected ones, within 0.2 in \
                    three of four cells.",
        decide: degrees,
        sources: &[Source::Table(3), BUILDS],
    },
    Claim {
        id: "bottom-up-comparable",
        statement: "Bottom-up trees perform about as well as top-down ones.",
        quote: "the bottom-up trees' performances were comparable to those of the top-down versions",
        place: "Summary and Conclusion",
        predicate: "Nodes per pixel, bottom-up ÷ top-down at the same arity: within 25 % of 1 in four of five cells, at arity 2, 4 and 8.",
        decide: comparable,
        sources: &[Source::Table(5), Source::Section("nodes", "Figure 5"), TRACES],
    },
    Claim {
        id: "words-describe-program",
        statement: "The printed numbers come from the algorithms that the thesis describes.",
        quote: "the best combination of three planes from 50 candidate planes per dimension and of seven from 25 candidate planes per \
                dimension, respectively, are selected to split an interior node",
        place: "Construction Algorithms",
        predicate: "Mean distance (exp mean |ln ratio|) of nodes per pixel to the printed ones, Tiny to Large: for the algorithms as worded \
                    no greater than twice that for the program as it was.",
        decide: words,
        sources: &[Source::Table(5), Source::Section("readings", "the grid of readings"), TRACES],
    },
];

fn degrees(ev: &Evidence, preset: &str) -> Finding {
    let mut cells = Vec::new();
    for arity in [4, 8] {
        for model in Model::ALL {
            let tree = bottom_up(arity).of(model);
            let built = ev.study.builds_of(preset, model, tree.construction, arity);
            let ours = built.iter().find_map(|r| r.avg_degree.filter(|_| r.status == crate::rows::Status::Ok));
            let printed = printed_cell(3, tree).and_then(|c| Some((c.printed.as_ref()?.value, c.reference()?.value)));
            if let Some((ours, (printed, meant))) = ours.zip(printed) {
                cells.push((model, arity, ours, printed, meant));
            }
        }
    }
    if cells.len() < 4 {
        return Finding::undecided("collapsed trees of at least two models");
    }
    let near = |of: fn(&(Model, usize, f64, f64, f64)) -> f64| {
        cells.iter().filter(|c| (c.2 - of(c)).abs() <= DEGREES_CLOSE).count()
    };
    let (as_printed, as_meant) = (near(|c| c.3), near(|c| c.4));
    let enough = |n: usize| 4 * n >= 3 * cells.len();
    let below = cells.iter().all(|c| c.2 < c.1 as f64);
    let verdict = match (below, enough(as_printed), enough(as_meant)) {
        (true, true, _) => Verdict::Holds,
        (true, false, true) => Verdict::Corrected,
        _ => Verdict::Fails,
    };
    let of = |k: usize| super::evidence::range(cells.iter().filter(|c| c.1 == k).map(|c| c.2));
    let why = format!(
        "Measured {} children of 4 and {} of 8. {as_printed} of {} cells lie within {DEGREES_CLOSE} of the printed figure, {as_meant} of the \
         corrected one: at arity 4, 2.60 misreads 3.60.",
        super::evidence::span(of(4), 3),
        super::evidence::span(of(8), 3),
        cells.len()
    );
    let label = |c: &(Model, usize, f64, f64, f64)| format!("{} {}", c.0.id(), c.1);
    Finding::new(verdict, why)
        .with("measured", cells.iter().map(|c| (label(c), c.2)))
        .with("printed", cells.iter().map(|c| (label(c), c.3)))
        .with("corrected", cells.iter().map(|c| (label(c), c.4)))
}

fn comparable(ev: &Evidence, preset: &str) -> Finding {
    const NEAR: f64 = 0.25;
    let nodes = |k, m, bottom: bool| {
        let kind = if bottom { bottom_up(k) } else { top_down(k) };
        ev.nodes(preset, kind.of(m), Lighting::Primary)
    };
    let ratios = [2, 4, 8].map(|k| (k, ByModel::of(|m| Some(nodes(k, m, true)? / nodes(k, m, false)?))));
    if ratios.iter().any(|(_, r)| !r.is_enough()) {
        return Finding::undecided("traversals of both constructions over at least three models");
    }
    let all = || ratios.iter().flat_map(|(_, r)| r.values());
    let near = all().filter(|r| (1.0 - NEAR..=1.0 + NEAR).contains(r)).count();
    let verdict = if 5 * near >= 4 * all().count() { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "Against top-down trees of the same arity, bottom-up ones visit {} nodes; {near} of {} pairs are within 25 %.",
        changes(super::evidence::range(all())),
        all().count()
    );
    ratios.iter().fold(Finding::new(verdict, why), |f, (k, r)| {
        f.with(format!("nodes per pixel, bottom-up ÷ top-down, arity {k}"), r.labelled())
    })
}

/// Distance of a preset's nodes per pixel from the printed ones, over the models whose scene is known.
fn from_print(ev: &Evidence, preset: &str) -> Option<f64> {
    let trees = Model::ALL.into_iter().filter(|m| *m != Model::Huge).flat_map(|m| KINDS.map(|k| k.of(m)));
    let ratios: Option<Vec<f64>> =
        trees.map(|t| Some(ev.nodes(preset, t, Lighting::Primary)? / ev.printed(5, t)?)).collect();
    distance(ratios?.into_iter())
}

fn words(ev: &Evidence, _preset: &str) -> Finding {
    let [Some(program), Some(words)] = PRESETS.map(|p| from_print(ev, p)) else {
        return Finding::undecided("traversals of both presets, Tiny to Large");
    };
    let verdict = if words <= 2.0 * program { Verdict::Holds } else { Verdict::Fails };
    let readings = ev.experiments().readings();
    let nearest = |c: Construction| readings.iter().find(|r| r.construction == c);
    let mut why = format!(
        "Nodes per pixel by the words are off the printed ones by {} % on average, by what the program did {} %: the program tries ranks \
         on one axis, not planes on three, and weighs areas by triangles.",
        padded(100.0 * words, 2),
        padded(100.0 * program, 2)
    );
    if let Some((down, up)) = nearest(Construction::TopDown).zip(nearest(Construction::BottomUp)) {
        why += &format!(
            " Of {} readings tried the nearest are “{}” ({} %) and “{}” ({} %).",
            readings.len(),
            down.name,
            padded(100.0 * down.distance(), 2),
            up.name,
            padded(100.0 * up.distance(), 2)
        );
    }
    let found =
        Finding::new(verdict, why).with("mean distance from Table 5", PRESETS.into_iter().zip([program, words]));
    match readings.is_empty() {
        true => found,
        false => {
            let named = |r: &Reading| (format!("{}: {}", r.construction.id(), r.name), r.distance());
            found.with("mean distance of each reading", readings.iter().map(named))
        }
    }
}
