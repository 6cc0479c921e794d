//! Claims about what trees cost when they are traced: nodes visited and time per pixel, primary rays.

use super::evidence::{ByModel, Evidence, KINDS, Kind, bottom_up, changes, top_down, triangles};
use super::{Claim, Finding, Source, Verdict};
use crate::report::number::padded;
use crate::rows::{Construction, Lighting};

const ROWS: Source = Source::Rows("rows/traces.csv");
const FIGURE5: Source = Source::Section("nodes", "Figure 5");

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "logarithmic-search",
        statement: "With a tree, the search for a hit grows as the logarithm of the number of triangles.",
        quote: "the reduction of the intersection search's time complexity to a logarithm of the number of total primitives (the logarithm \
                with base equal to the average tree degree)",
        place: "Introduction, Bounding Volume Hierarchies",
        predicate: "Nodes per pixel of each kind of tree follow a straight line over log n (R² at least 0.9) and grow from the smallest model \
                    to the largest by no more than 1.25 times what log n does.",
        decide: logarithmic,
        sources: &[Source::Table(5), FIGURE5, ROWS],
    },
    Claim {
        id: "wider-bottom-up-fewer-nodes",
        statement: "Bottom-up trees visit steadily fewer nodes as the branching factor grows.",
        quote: "in bottom-up BVHs, the number of nodes traversed demonstrates a steady, consistent downward trend as the branching factor \
                increases",
        place: "Note under Table 5; Results and Analysis",
        predicate: "Nodes per pixel fall from arity 2 to 4 and from 4 to 8, for every model.",
        decide: fewer_bottom_up,
        sources: &[Source::Table(5), FIGURE5, ROWS],
    },
    Claim {
        id: "wider-slower",
        statement: "A higher branching factor makes traversal slower: more boxes are tested at each node.",
        quote: "increasing the branching factor also increases the average traversal time",
        place: "Note under Table 4; Results and Analysis",
        predicate: "Microseconds per pixel at arity 8 exceed those at arity 2 for both constructions, and box tests do too: by the median over \
                    models, as single times are noisy.",
        decide: slower,
        sources: &[Source::Table(4), ROWS],
    },
    Claim {
        id: "wider-performs-better",
        statement: "Top-down trees of higher branching factor perform better, although fewer planes were tried for them.",
        quote: "Yet even with this handicap, the trees with higher branching factors yielded improved performance.",
        place: "Summary and Conclusion",
        predicate: "Top-down trees of arity 4 and 8 need fewer nodes and less time per pixel than binary ones, by the median over \
                    models.",
        decide: better,
        sources: &[Source::Table(4), Source::Table(5), ROWS],
    },
    Claim {
        id: "collapse-not-faster",
        statement: "Collapsing lowers the nodes visited but not the time: more children are tested at each node.",
        quote: "this does not translate into a reduction in traversal times as increasing the degree comes with the cost of testing more \
                child nodes for intersection per inner node",
        place: "Summary and Conclusion",
        predicate: "Bottom-up trees of arity 4 and 8: fewer nodes than the binary tree, more box tests, and at most 5 % less time by \
                    the median over models.",
        decide: collapse_not_faster,
        sources: &[Source::Table(4), Source::Table(5), ROWS],
    },
];

type Quantity<'a> = &'a dyn Fn(Kind, crate::report::printed::Model) -> Option<f64>;

fn ratio(of: Quantity, above: Kind, below: Kind) -> ByModel {
    ByModel::of(|m| Some(of(above, m)? / of(below, m)?))
}

fn logarithmic(ev: &Evidence, preset: &str) -> Finding {
    const STRAIGHT: f64 = 0.9;
    const MUCH: f64 = 1.25;
    let nodes = KINDS.map(|k| (k, ByModel::of(|m| ev.nodes(preset, k.of(m), Lighting::Primary))));
    if nodes.iter().any(|(_, n)| !n.is_enough()) {
        return Finding::undecided("traversals of every kind over at least three models");
    }
    let fits = nodes.each_ref().map(|(k, n)| {
        let points: Vec<_> = n.0.iter().map(|(m, y)| (triangles(*m).log2(), *y)).collect();
        (*k, line(&points))
    });
    let excess = nodes.each_ref().map(|(k, n)| (k.name(), beyond_logarithm(n)));
    let r2 = super::evidence::range(fits.iter().map(|(_, (_, r2))| *r2));
    let beyond = super::evidence::range(excess.iter().map(|(_, x)| *x));
    let verdict = if r2.0 >= STRAIGHT && beyond.1 <= MUCH { Verdict::Holds } else { Verdict::Fails };
    let slope = |kind: Kind| fits.iter().find(|(k, _)| *k == kind).map_or(f64::NAN, |(_, (slope, _))| *slope);
    let why = format!(
        "Nodes grow {} times as much as log n, with R² of {} over it. The base is not the degree: each doubling of the triangles adds {} nodes \
         at arity 2, {} at 4 and {} at 8 to a top-down tree, where logarithms to these bases would add them as 1 : ½ : ⅓.",
        super::evidence::span(beyond, 3),
        super::evidence::span(r2, 3),
        padded(slope(top_down(2)), 2),
        padded(slope(top_down(4)), 2),
        padded(slope(top_down(8)), 2)
    );
    let found = Finding::new(verdict, why)
        .with("growth ÷ growth of log n", excess)
        .with("R² over log n", fits.iter().map(|(k, (_, r2))| (k.name(), *r2)))
        .with("nodes per doubling", fits.iter().map(|(k, (slope, _))| (k.name(), *slope)));
    nodes.iter().fold(found, |f, (k, n)| f.with(format!("nodes per pixel, {}", k.name()), n.labelled()))
}

/// Growth from the first model to the last, divided by that of log n.
fn beyond_logarithm(nodes: &ByModel) -> f64 {
    match (nodes.0.first(), nodes.0.last()) {
        (Some((small, few)), Some((large, many))) => many / few / (triangles(*large).ln() / triangles(*small).ln()),
        _ => f64::NAN,
    }
}

/// Slope and R² of the least-squares line.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |of: fn(f64, f64) -> f64| points.iter().map(|(x, y)| of(x - mx, y - my)).sum::<f64>();
    let (sxx, sxy, syy) = (sum(|x, _| x * x), sum(|x, y| x * y), sum(|_, y| y * y));
    (sxy / sxx, if syy > 0.0 { sxy * sxy / (sxx * syy) } else { 0.0 })
}

fn fewer_bottom_up(ev: &Evidence, preset: &str) -> Finding {
    let nodes = |k: Kind, m| ev.nodes(preset, k.of(m), Lighting::Primary);
    let steps = [(bottom_up(4), bottom_up(2)), (bottom_up(8), bottom_up(4))].map(|(a, b)| ratio(&nodes, a, b));
    if steps.iter().any(|r| !r.is_enough()) {
        return Finding::undecided("bottom-up traversals of at least three models");
    }
    let verdict = if steps.iter().all(|r| r.all(|x| x < 1.0)) { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "From arity 2 to 4 nodes change by {}, from 4 to 8 by {}.",
        changes(steps[0].range()),
        changes(steps[1].range())
    );
    Finding::new(verdict, why)
        .with("nodes per pixel, arity 4 ÷ 2", steps[0].labelled())
        .with("nodes per pixel, arity 8 ÷ 4", steps[1].labelled())
}

fn slower(ev: &Evidence, preset: &str) -> Finding {
    let time = |k: Kind, m| ev.time(preset, k.of(m));
    let boxes = |k: Kind, m| ev.trace(preset, k.of(m), Lighting::Primary)?.box_tests_per_pixel;
    let both = [Construction::TopDown, Construction::BottomUp];
    let of = |what: Quantity, k| both.map(|c| ratio(what, Kind(c, k), Kind(c, 2)));
    let (times, tests, four) = (of(&time, 8), of(&boxes, 8), of(&time, 4));
    if times.iter().chain(&tests).any(|r| !r.is_enough()) {
        return Finding::undecided("timed traversals of at least three models");
    }
    let all = |rs: &[ByModel; 2]| super::evidence::range(rs.iter().flat_map(ByModel::values));
    let more = |r: &ByModel| r.median() > 1.0;
    let verdict = if times.iter().chain(&tests).all(more) { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "At arity 8 time changes by {} against arity 2, box tests by {}; at arity 4 time changes by {}.",
        changes(all(&times)),
        changes(all(&tests)),
        changes(all(&four))
    );
    let mut found = Finding::new(verdict, why);
    for (i, construction) in both.iter().enumerate() {
        found = found
            .with(format!("time, arity 8 ÷ 2, {}", construction.id()), times[i].labelled())
            .with(format!("box tests, arity 8 ÷ 2, {}", construction.id()), tests[i].labelled())
            .with(format!("time, arity 4 ÷ 2, {}", construction.id()), four[i].labelled());
    }
    found
}

fn better(ev: &Evidence, preset: &str) -> Finding {
    let time = |k: Kind, m| ev.time(preset, k.of(m));
    let nodes = |k: Kind, m| ev.nodes(preset, k.of(m), Lighting::Primary);
    let of = |what: Quantity| [4, 8].map(|k| ratio(what, top_down(k), top_down(2)));
    let (times, visits) = (of(&time), of(&nodes));
    if times.iter().chain(&visits).any(|r| !r.is_enough()) {
        return Finding::undecided("timed top-down traversals of at least three models");
    }
    let verdict = if times.iter().chain(&visits).all(|r| r.median() < 1.0) { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "They visit fewer nodes ({} at arity 4, {} at 8), but time changes by {} and {}. The thesis' own Results say that \
         traversal became less efficient.",
        changes(visits[0].range()),
        changes(visits[1].range()),
        changes(times[0].range()),
        changes(times[1].range())
    );
    Finding::new(verdict, why)
        .with("nodes, top-down 4 ÷ 2", visits[0].labelled())
        .with("nodes, top-down 8 ÷ 2", visits[1].labelled())
        .with("time, top-down 4 ÷ 2", times[0].labelled())
        .with("time, top-down 8 ÷ 2", times[1].labelled())
}

fn collapse_not_faster(ev: &Evidence, preset: &str) -> Finding {
    const LESS: f64 = 0.95;
    let time = |k: Kind, m| ev.time(preset, k.of(m));
    let nodes = |k: Kind, m| ev.nodes(preset, k.of(m), Lighting::Primary);
    let boxes = |k: Kind, m| ev.trace(preset, k.of(m), Lighting::Primary)?.box_tests_per_pixel;
    let of = |what: Quantity| [4, 8].map(|k| ratio(what, bottom_up(k), bottom_up(2)));
    let (times, visits, tests) = (of(&time), of(&nodes), of(&boxes));
    if times.iter().chain(&visits).chain(&tests).any(|r| !r.is_enough()) {
        return Finding::undecided("timed bottom-up traversals of at least three models");
    }
    let range = |rs: &[ByModel; 2]| super::evidence::range(rs.iter().flat_map(ByModel::values));
    let holds =
        range(&visits).1 < 1.0 && tests.iter().all(|r| r.median() > 1.0) && times.iter().all(|r| r.median() >= LESS);
    let verdict = if holds { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "Against the binary tree nodes change by {}, box tests by {} and time by {}.",
        changes(range(&visits)),
        changes(range(&tests)),
        changes(range(&times))
    );
    let mut found = Finding::new(verdict, why);
    for (i, k) in [4, 8].into_iter().enumerate() {
        found = found
            .with(format!("nodes, arity {k} ÷ 2"), visits[i].labelled())
            .with(format!("box tests, arity {k} ÷ 2"), tests[i].labelled())
            .with(format!("time, arity {k} ÷ 2"), times[i].labelled());
    }
    found
}
