//! Claims about build times. Times are of the literal engines, which do the thesis' own work; exact engines build the same trees.

use super::evidence::{ByModel, Evidence, KINDS, Kind, bottom_up, span, top_down};
use super::{Claim, Finding, Source, Verdict};
use crate::report::printed::Model;

const ROWS: Source = Source::Rows("rows/builds.csv");
const WORK: Source = Source::Rows("rows/work.csv");

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "build-times-grow",
        statement: "Build times grow with the model, from the top down and from the bottom up.",
        quote: "build times for both construction techniques increased as the models increased in size",
        place: "Results and Analysis, build times (Table 2, Figure 4)",
        predicate: "For each of the six kinds of tree, seconds of the literal engine rise from model to model.",
        decide: grows,
        sources: &[Source::Table(2), Source::Section("build-times", "Figure 4"), ROWS],
    },
    Claim {
        id: "binary-top-down-quickest",
        statement: "Binary top-down trees are by far the quickest to build.",
        quote: "The top-down binary BVH had by far the quickest construction.",
        place: "Results and Analysis, build times (Table 2)",
        predicate: "The program's elementary steps (box unions, steps of its kd-tree) are fewest for binary top-down trees of every model, \
                    by at least 2 times; by exact engines these trees are still the quickest.",
        decide: binary_quickest,
        sources: &[Source::Table(2), Source::Section("growth", "counted work"), WORK],
    },
    Claim {
        id: "doubling-costs-two-orders",
        statement: "Each doubling of the branching factor makes top-down builds at least 100 times as long.",
        quote: "For each doubling of the branching factor, the top-down construction took dramatically longer, increasing the build \
                times by at least two orders of magnitude.",
        place: "Results and Analysis, build times (Table 2)",
        predicate: "The program's box unions grow at least 100-fold from arity 2 to 4 and from 4 to 8, for every model.",
        decide: two_orders,
        sources: &[Source::Table(2), Source::Section("growth", "counted work"), WORK],
    },
    Claim {
        id: "wide-top-down-is-slow",
        statement: "A higher branching factor necessarily makes top-down builds very much longer.",
        quote: "a higher branching factor would still necessitate a longer build time",
        place: "Summary and Conclusion; Results and Analysis (\"grow exponentially as the branching factor increases\")",
        predicate: "The exact engine, which returns the same tree, takes at least 10 times as long at arity 8 as at arity 2. If it does not \
                    while the literal engine does, the cost is that of trying every combination.",
        decide: wide_is_slow,
        sources: &[Source::Table(2), ROWS],
    },
    Claim {
        id: "bottom-up-slower",
        statement: "Binary bottom-up builds take longer than top-down ones, increasingly so as models grow.",
        quote: "The productions of binary bottom-up BVHs took significantly longer than those of their top-down counterparts, and \
                increasingly so as the models got larger.",
        place: "Results and Analysis, build times (Table 2)",
        predicate: "Bottom-up ÷ top-down seconds at arity 2: above 1 for the larger half of the models and rising, by the literal engines; \
                    above 1 for every model by the exact ones.",
        decide: bottom_up_slower,
        sources: &[Source::Table(2), ROWS],
    },
    Claim {
        id: "top-down-faster-at-2-and-4",
        statement: "At branching factors 2 and 4 top-down construction is the faster one.",
        quote: "Top-down construction is the faster approach when building trees with branching factors of two or four.",
        place: "Results and Analysis, build times (Table 2)",
        predicate: "Top-down takes less time than bottom-up at arity 2 and 4 for every model: printed, and by the literal engines.",
        decide: top_down_faster,
        sources: &[Source::Table(2), ROWS],
    },
    Claim {
        id: "bottom-up-faster-at-8",
        statement: "At branching factor 8 bottom-up construction is the faster one.",
        quote: "as the desired branching factor increases from four to eight, bottom-up construction becomes the faster technique",
        place: "Results and Analysis, build times (Table 2)",
        predicate: "Bottom-up takes less time than top-down at arity 8 for every model by the literal engines, and for most by the exact \
                    ones. If only by the literal ones, the cause is the enumeration.",
        decide: bottom_up_faster,
        sources: &[Source::Table(2), ROWS],
    },
];

fn ratio(ev: &Evidence, preset: &str, engine: &str, (above, below): (Kind, Kind)) -> ByModel {
    ByModel::of(|m| Some(ev.seconds(preset, engine, above.of(m))? / ev.seconds(preset, engine, below.of(m))?))
}

fn printed_ratio(ev: &Evidence, (above, below): (Kind, Kind)) -> ByModel {
    ByModel::of(|m| Some(ev.printed(2, above.of(m))? / ev.printed(2, below.of(m))?))
}

fn grows(ev: &Evidence, preset: &str) -> Finding {
    let times = KINDS.map(|k| (k, ByModel::of(|m| ev.seconds(preset, "literal", k.of(m)))));
    if times.iter().any(|(_, t)| !t.is_enough()) {
        return Finding::undecided("literal builds of at least three models of each kind");
    }
    let falls: Vec<_> = times.iter().filter(|(_, t)| !t.rises()).map(|(k, _)| k.name()).collect();
    let projected = Model::ALL.into_iter().flat_map(|m| KINDS.map(|k| k.of(m)));
    let projected = projected
        .filter(|t| ev.build(preset, "literal", *t).is_some_and(|r| r.status == crate::rows::Status::Projected));
    let projected = projected.count();
    let (verdict, mut why) = match falls.is_empty() {
        true => (Verdict::Holds, "All six kinds take longer from model to model.".to_owned()),
        false => (Verdict::Fails, format!("Times fall somewhere for {}.", falls.join(", "))),
    };
    if projected > 0 {
        why += &format!(" {projected} of these times are projected from counted work.");
    }
    times.iter().fold(Finding::new(verdict, why), |f, (k, t)| f.with(format!("{}, seconds", k.name()), t.labelled()))
}

fn binary_quickest(ev: &Evidence, preset: &str) -> Finding {
    // Bottom-up rows of work stand for arity 2; the collapse adds next to nothing.
    let others = [top_down(4), top_down(8), bottom_up(2)];
    let least = |m: Model| {
        let all = others.map(|k| ev.work(preset, k.of(m)));
        all.into_iter().collect::<Option<Vec<_>>>().map(|all| all.into_iter().fold(f64::INFINITY, f64::min))
    };
    let by_work = ByModel::of(|m| Some(least(m)? / ev.work(preset, top_down(2).of(m))?));
    let by_exact = ByModel::of(|m| {
        let all: Option<Vec<f64>> = KINDS[1..].iter().map(|k| ev.seconds(preset, "exact", k.of(m))).collect();
        Some(all?.into_iter().fold(f64::INFINITY, f64::min) / ev.seconds(preset, "exact", top_down(2).of(m))?)
    });
    if !by_work.is_enough() || !by_exact.is_enough() {
        return Finding::undecided(
            "the program's work (run bvh-lab scaling) and exact builds of at least three models",
        );
    }
    let verdict = match (by_work.all(|r| r >= 2.0), by_exact.all(|r| r >= 1.0)) {
        (true, true) => Verdict::Holds,
        (true, false) => Verdict::Artefact,
        _ => Verdict::Fails,
    };
    let why = format!(
        "The program did {} times the steps for the next cheapest kind. Exact engines still build binary top-down trees \
         {}, but the next kind takes only {} times as long.",
        by_work.span(3),
        if by_exact.all(|r| r >= 1.0) { "quickest" } else { "quickest only sometimes" },
        by_exact.span(3)
    );
    Finding::new(verdict, why)
        .with("next cheapest ÷ binary top-down, program's steps", by_work.labelled())
        .with("next cheapest ÷ binary top-down, seconds of exact engines", by_exact.labelled())
}

fn two_orders(ev: &Evidence, preset: &str) -> Finding {
    const TWO_ORDERS: f64 = 100.0;
    let steps = [(top_down(4), top_down(2)), (top_down(8), top_down(4))];
    let [to_4, to_8] = steps.map(|(a, b)| ByModel::of(|m| Some(ev.work(preset, a.of(m))? / ev.work(preset, b.of(m))?)));
    if !to_4.is_enough() || !to_8.is_enough() {
        return Finding::undecided("the program's work on at least three models (run bvh-lab scaling)");
    }
    let verdict =
        if to_4.all(|r| r >= TWO_ORDERS) && to_8.all(|r| r >= TWO_ORDERS) { Verdict::Holds } else { Verdict::Fails };
    let [printed_4, printed_8] = steps.map(|pair| printed_ratio(ev, pair));
    let why = format!(
        "Counted work grows {}-fold from arity 2 to 4 and {}-fold from 4 to 8; the printed times themselves grow {}-fold and {}-fold.",
        to_4.span(3),
        to_8.span(3),
        printed_4.span(3),
        printed_8.span(3)
    );
    Finding::new(verdict, why)
        .with("box unions, arity 4 ÷ 2", to_4.labelled())
        .with("box unions, arity 8 ÷ 4", to_8.labelled())
        .with("printed seconds, arity 4 ÷ 2", printed_4.labelled())
        .with("printed seconds, arity 8 ÷ 4", printed_8.labelled())
}

fn wide_is_slow(ev: &Evidence, preset: &str) -> Finding {
    const MUCH: f64 = 10.0;
    let pair = (top_down(8), top_down(2));
    let (literal, exact) = (ratio(ev, preset, "literal", pair), ratio(ev, preset, "exact", pair));
    if !literal.is_enough() || !exact.is_enough() {
        return Finding::undecided("builds by both engines of at least three models");
    }
    let verdict = match (literal.all(|r| r >= MUCH), exact.all(|r| r >= MUCH)) {
        (true, true) => Verdict::Holds,
        (true, false) => Verdict::Artefact,
        _ => Verdict::Fails,
    };
    let why = format!(
        "Trying every combination, arity 8 takes {} times as long as arity 2; the exact engine, which returns the same tree, {} times.",
        literal.span(3),
        exact.span(3)
    );
    let four = ratio(ev, preset, "exact", (top_down(4), top_down(2)));
    Finding::new(verdict, why)
        .with("arity 8 ÷ 2, literal engine", literal.labelled())
        .with("arity 8 ÷ 2, exact engine", exact.labelled())
        .with("arity 4 ÷ 2, exact engine", four.labelled())
}

fn bottom_up_slower(ev: &Evidence, preset: &str) -> Finding {
    let pair = (bottom_up(2), top_down(2));
    let (literal, exact) = (ratio(ev, preset, "literal", pair), ratio(ev, preset, "exact", pair));
    if !literal.is_enough() || !exact.is_enough() {
        return Finding::undecided("binary builds by both engines of at least three models");
    }
    let larger: Vec<f64> = literal.values().rev().take(literal.0.len().div_ceil(2)).collect();
    let holds = larger.iter().all(|r| *r > 1.0) && literal.rises();
    let verdict = match (holds, exact.all(|r| r > 1.0)) {
        (true, true) => Verdict::Holds,
        (true, false) => Verdict::Artefact,
        _ => Verdict::Fails,
    };
    let why = format!(
        "Bottom-up takes {} times as long as top-down by the literal engines and {} times by the exact ones; printed {} times.",
        literal.span(3),
        exact.span(3),
        printed_ratio(ev, pair).span(3)
    );
    Finding::new(verdict, why)
        .with("bottom-up ÷ top-down, arity 2, literal engines", literal.labelled())
        .with("bottom-up ÷ top-down, arity 2, exact engines", exact.labelled())
        .with("bottom-up ÷ top-down, arity 2, printed", printed_ratio(ev, pair).labelled())
}

fn top_down_faster(ev: &Evidence, preset: &str) -> Finding {
    let pairs = [2, 4].map(|k| (bottom_up(k), top_down(k)));
    let literal = pairs.map(|p| ratio(ev, preset, "literal", p));
    let exact = pairs.map(|p| ratio(ev, preset, "exact", p));
    if literal.iter().chain(&exact).any(|r| !r.is_enough()) {
        return Finding::undecided("builds by both engines of at least three models at arity 2 and 4");
    }
    let printed = pairs.map(|p| printed_ratio(ev, p));
    let slower = |all: &[ByModel; 2]| {
        let of = |(r, k): (&ByModel, usize)| {
            r.0.iter().filter(|x| x.1 <= 1.0).map(|x| format!("{} {k}", x.0.id())).collect::<Vec<_>>()
        };
        all.iter().zip([2, 4]).flat_map(of).collect::<Vec<_>>()
    };
    let told = |all| match &slower(all)[..] {
        [] => "nowhere".to_owned(),
        names => names.join(", "),
    };
    let thesis = slower(&printed).len() + slower(&literal).len();
    let verdict = match (thesis, slower(&exact).len()) {
        (0, 0) => Verdict::Holds,
        (0, _) => Verdict::Artefact,
        _ => Verdict::Fails,
    };
    let why = format!(
        "Top-down is the slower one, as printed: {}; by the literal engines: {}; by the exact ones: {}.",
        told(&printed),
        told(&literal),
        told(&exact)
    );
    let all = [("printed", &printed), ("literal engines", &literal), ("exact engines", &exact)];
    all.into_iter().fold(Finding::new(verdict, why), |f, (name, [two, four])| {
        f.with(format!("bottom-up ÷ top-down, arity 2, {name}"), two.labelled())
            .with(format!("bottom-up ÷ top-down, arity 4, {name}"), four.labelled())
    })
}

fn bottom_up_faster(ev: &Evidence, preset: &str) -> Finding {
    let pair = (top_down(8), bottom_up(8));
    let (literal, exact) = (ratio(ev, preset, "literal", pair), ratio(ev, preset, "exact", pair));
    if !literal.is_enough() || !exact.is_enough() {
        return Finding::undecided("builds of arity 8 by both engines of at least three models");
    }
    let quicker = exact.values().filter(|r| *r > 1.0).count();
    let verdict = match (literal.all(|r| r > 1.0), 2 * quicker > exact.0.len()) {
        (true, true) => Verdict::Holds,
        (true, false) => Verdict::Artefact,
        _ => Verdict::Fails,
    };
    let why = format!(
        "Top-down takes {} times as long as bottom-up by the literal engines, but {} times by the exact ones, which make the same \
         trees: bottom-up is quicker there for {quicker} of {} models.",
        span(literal.range(), 3),
        span(exact.range(), 2),
        exact.0.len()
    );
    Finding::new(verdict, why)
        .with("top-down ÷ bottom-up, arity 8, literal engines", literal.labelled())
        .with("top-down ÷ bottom-up, arity 8, exact engines", exact.labelled())
        .with("top-down ÷ bottom-up, arity 8, printed", printed_ratio(ev, pair).labelled())
}
