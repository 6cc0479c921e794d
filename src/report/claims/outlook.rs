//! What the thesis believes beyond its measurements: that more planes would make wide trees win, that 100 are enough, that all are too many.

use super::evidence::{ByModel, Evidence, changes, median, range, top_down};
use super::{Claim, Finding, Source, Verdict};
use crate::report::PRESETS;
use crate::report::experiments::{Figure, tests};
use crate::report::number::percent;
use crate::rows::{Experiment, ExperimentRow};

const ROWS: Source = Source::Rows("rows/experiments.csv");
/// So few scenes decide nothing.
const ENOUGH: usize = 3;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "full-planes-would-win",
        statement: "Wide top-down trees built with all 100 planes would clearly beat binary ones.",
        quote: "If these top-down BVHs were built without a sacrificial reduction in quality (or at least to a lesser extent), I am confident \
                that a top-down tree of a higher branching factor would significantly out-perform its counterpart beyond the performance gaps \
                demonstrated by my BVHs.",
        place: "Summary and Conclusion",
        predicate: "With 100 candidates an axis at every arity and rule Q8 off, by the median over scenes: trees of arity 4 and 8 have at least \
                    5 % less SAH than with 50 and 25 candidates, and need at least 10 % fewer box and triangle tests than binary ones.",
        decide: full_planes,
        sources: &[Source::Section("conjecture", "the conjecture"), ROWS],
    },
    Claim {
        id: "hundred-planes-suffice",
        statement: "100 evenly spaced planes per axis are enough for a good binary tree.",
        quote: "selecting the best plane of an evenly-spaced set of 100 sufficiently balances time consumption and tree quality",
        place: "Construction Algorithms",
        predicate: "SAH at 100 candidates, arity 2: by the median over scenes within 2 % of the least over all numbers tried.",
        decide: hundred,
        sources: &[Source::Section("candidates", "how many candidates are enough"), ROWS],
    },
    Claim {
        id: "best-plane-unreasonable",
        statement: "Looking for the best of all splitting planes would take an unreasonable time.",
        quote: "It is not necessary to find the absolute best splitting-plane; doing so would take an unreasonable amount of time.",
        place: "Construction Algorithms",
        predicate: "sweep-sah, which costs every position between sorted centres, takes longer than the literal search among 100 candidates \
                    an axis, by the median over models.",
        decide: best_plane,
        sources: &[Source::Table(2), Source::Section("conjecture", "sweep-sah among the yardsticks"), ROWS],
    },
];

/// A quantity of one row over another's, scene by scene.
fn ratios<'a>(
    scenes: &[&'a str],
    of: Figure,
    above: impl Fn(&'a str) -> Option<&'a ExperimentRow>,
    below: impl Fn(&'a str) -> Option<&'a ExperimentRow>,
) -> Vec<(&'a str, f64)> {
    let one = |&scene: &&'a str| {
        let (a, b) = (of(above(scene)?)?, of(below(scene)?)?);
        (b > 0.0).then_some((scene, a / b))
    };
    scenes.iter().filter_map(one).collect()
}

fn middle(ratios: &[(&str, f64)]) -> f64 {
    median(ratios.iter().map(|r| r.1))
}

fn full_planes(ev: &Evidence, preset: &str) -> Finding {
    let rows = ev.experiments();
    let scenes = rows.scenes(Experiment::Conjecture);
    let tree = |key| move |scene| rows.search(Experiment::Conjecture, scene, preset, key);
    let gain = [(4, 50), (8, 25)].map(|reduced| ratios(&scenes, |r| r.sah, tree((reduced.0, 100)), tree(reduced)));
    let against = |of: Figure| [4, 8].map(|k| ratios(&scenes, of, tree((k, 100)), tree((2, 100))));
    let (work, nodes) = (against(tests), against(|r| r.nodes_per_pixel));
    if gain.iter().chain(&work).any(|r| r.len() < ENOUGH) {
        return Finding::undecided("top-down trees with all planes over at least three scenes");
    }
    let holds = gain.iter().all(|r| middle(r) <= 0.95) && work.iter().all(|r| middle(r) <= 0.9);
    let verdict = if holds { Verdict::Holds } else { Verdict::Fails };
    let scalar = against(|r| r.us_per_pixel);
    // Binary trees have no wide kernel: theirs is the scalar one.
    let wide =
        [4, 8].map(|k| ratios(&scenes, |r| r.wide_us_per_pixel.or(r.us_per_pixel), tree((k, 100)), tree((2, 100))));
    let other = |id: &'static str, k| move |scene| rows.yardstick(scene, id, k);
    let grid = [4, 8].map(|k| ratios(&scenes, |r| r.sah, other("kway-slab", k), other("kway-sah", k)));
    let parts = [4, 8].map(|k| ratios(&scenes, |r| r.sah, tree((k, 100)), other("kway-sah", k)));
    let mut why = format!(
        "All planes change SAH by {} at arity 4 and {} at 8. Against binary trees nodes change by {} and {}, but box and triangle tests by \
         {} and {} (medians of {} scenes).",
        percent(middle(&gain[0])),
        percent(middle(&gain[1])),
        percent(middle(&nodes[0])),
        percent(middle(&nodes[1])),
        percent(middle(&work[0])),
        percent(middle(&work[1])),
        gain[0].len()
    );
    // Only the program cuts one axis.
    if preset == PRESETS[0] && middle(&grid[1]) > 1.05 {
        why += &format!(
            " Slabs are the reason: on a grid the best 8 slabs of one axis cost {} more SAH than the best 8 parts.",
            percent(middle(&grid[1])).trim_start_matches('+')
        );
    }
    if !wide[1].is_empty() {
        why += &format!(
            " A kernel that tests as many boxes at once as a node has changes time by {} and {}.",
            percent(middle(&wide[0])),
            percent(middle(&wide[1]))
        );
    }
    let named = [
        ("SAH, arity 4, 100 ÷ 50 candidates", &gain[0]),
        ("SAH, arity 8, 100 ÷ 25 candidates", &gain[1]),
        ("nodes per pixel, arity 4 ÷ 2", &nodes[0]),
        ("nodes per pixel, arity 8 ÷ 2", &nodes[1]),
        ("box and triangle tests, arity 4 ÷ 2", &work[0]),
        ("box and triangle tests, arity 8 ÷ 2", &work[1]),
        ("time, scalar kernel, arity 4 ÷ 2", &scalar[0]),
        ("time, scalar kernel, arity 8 ÷ 2", &scalar[1]),
        ("time, wide kernel, arity 4 ÷ scalar 2", &wide[0]),
        ("time, wide kernel, arity 8 ÷ scalar 2", &wide[1]),
        ("SAH, this tree ÷ best 4 parts of a grid", &parts[0]),
        ("SAH, this tree ÷ best 8 parts of a grid", &parts[1]),
        ("SAH, best 4 slabs ÷ best 4 parts", &grid[0]),
        ("SAH, best 8 slabs ÷ best 8 parts", &grid[1]),
    ];
    let shown = named.into_iter().filter(|(_, r)| !r.is_empty());
    shown.fold(Finding::new(verdict, why), |f, (name, r)| f.with(name, r.iter().copied()))
}

fn hundred(ev: &Evidence, preset: &str) -> Finding {
    let rows = ev.experiments();
    let mut excess = Vec::new();
    let mut best = Vec::new();
    for scene in rows.scenes(Experiment::Candidates) {
        let sweep = rows.sweep(scene, preset, 2);
        let least = sweep.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let at_100 = sweep.iter().find(|p| p.0 == 100);
        if let Some((least, at_100)) = least.zip(at_100).filter(|_| sweep.len() > 2) {
            excess.push((scene, at_100.1 / least.1));
            best.push((scene, least.0 as f64));
        }
    }
    if excess.len() < ENOUGH {
        return Finding::undecided("sweeps of candidates over at least three scenes");
    }
    let verdict = if middle(&excess) <= 1.02 { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "SAH at 100 candidates differs from the least that any number gives by {} ({} by the median over {} scenes); the least comes with {} candidates.",
        changes(range(excess.iter().map(|e| e.1))),
        percent(middle(&excess)),
        excess.len(),
        whole(range(best.iter().map(|b| b.1)))
    );
    Finding::new(verdict, why)
        .with("SAH at 100 candidates ÷ the least", excess)
        .with("candidates of the least SAH", best)
}

/// A range of whole numbers.
fn whole((low, high): (f64, f64)) -> String {
    if low == high { low.to_string() } else { format!("{low} to {high}") }
}

fn best_plane(ev: &Evidence, preset: &str) -> Finding {
    let rows = ev.experiments();
    let sweep = |m: crate::report::printed::Model| rows.yardstick(&m.scene(), "sweep-sah", 2);
    let time = ByModel::of(|m| Some(sweep(m)?.build_ms? / 1e3 / ev.seconds(preset, "literal", top_down(2).of(m))?));
    let cost = ByModel::of(|m| Some(sweep(m)?.sah? / ev.build(preset, "exact", top_down(2).of(m))?.sah?));
    if !time.is_enough() {
        return Finding::undecided("sweep-sah beside literal binary builds of at least three models");
    }
    let verdict = if time.median() > 1.0 { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "Trying every position takes {} times as long as the literal search among 100 candidates, and its trees differ in SAH by {}.",
        time.span(2),
        changes(cost.range())
    );
    Finding::new(verdict, why)
        .with("seconds, every position ÷ 100 candidates", time.labelled())
        .with("SAH, every position ÷ 100 candidates", cost.labelled())
}
