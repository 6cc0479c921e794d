//! The page of builders side by side: advice, means over scenes, the price of the exact originals, then scene by scene.

use super::{document, drawing};
use crate::report::comparison::advice::{Advice, Counsel, Range, many, percent};
use crate::report::comparison::means::{Means, QUANTITIES};
use crate::report::comparison::originals::{Originals, Pair};
use crate::report::comparison::{
    Class, Comparison, Kind, build_ms, front, mrays, nodes, peak_bytes_a_triangle, positive,
};
use crate::report::figures::Figures;
use crate::report::number::{grouped, padded};
use crate::rows::{CompareRow, Spread, Status};
use maud::{Markup, html};
use std::collections::BTreeSet;

/// What the page tells besides the rows.
#[derive(Clone, Copy)]
pub(crate) struct Findings<'a> {
    /// The rows.
    pub comparison: &'a Comparison,
    /// Which builder for which use.
    pub counsel: &'a Counsel,
    /// Geometric means.
    pub means: &'a [Means],
    /// Against the thesis' constructions.
    pub originals: Option<&'a Originals>,
    /// Whether the study's page stands beside this one.
    pub study: bool,
}

/// The whole page as text.
pub(crate) fn html(findings: &Findings, figures: &Figures) -> String {
    let Findings { comparison, counsel, means, originals, study } = *findings;
    let body = html! {
        h1 { "Builders side by side" }
        (introduction(comparison, study))
        (advice(counsel))
        @for of_class in means { (averages(comparison, of_class)) }
        @if let Some(originals) = originals { (price(comparison, originals)) }
        @for scene in &comparison.scenes { (scene_section(comparison, scene, figures)) }
        (footer(comparison))
    };
    document("bvh-lab: builders side by side", &body)
}

fn introduction(comparison: &Comparison, study: bool) -> Markup {
    let builders = comparison.entrants().len();
    html! {
        p .lead {
            (builders) " contestants on " (comparison.scenes.len())
            @if comparison.scenes.len() == 1 { " scene: " } @else { " scenes: " }
            @for (i, scene) in comparison.scenes.iter().enumerate() {
                @if i > 0 { ", " }
                a href=(format!("#{}", anchor(i))) { (comparison.short(scene)) }
            }
            ". What each build takes, what its tree is worth by three measures, and what rays through it take."
        }
        p .soft {
            "Every contestant was verified before anything was timed: a valid tree, and every ray's hit that of the reference set. Times were taken in \
             turn, round by round, so that what disturbs the machine disturbs all alike; figures are medians. Everything here is drawn from "
            a href="rows/compare.csv" { "the rows" } "; the advice, too, is computed from them."
            @if study { " The study of the thesis has " a href="index.html" { "a page of its own" } "." }
        }
    }
}

fn advice(counsel: &Counsel) -> Markup {
    html! {
        h2 id="advice" { "Which builder for which use" }
        @if counsel.uses.is_empty() {
            p { "Fewer than two contestants have a build time and a ray rate on every scene: there is nothing to advise." }
        } @else {
            div .scroll { table .advice {
                thead { tr { th .name { "Use" } th .name { "Take" } th .name { "Because" } } }
                tbody { @for Advice { purpose, pick, why } in &counsel.uses {
                    tr { td .name .wrap { (purpose) } td .name { b { (pick) } } td .name .wrap { (why) "." } }
                } }
            } }
            (bills(&counsel.ranges))
        }
        p .soft {
            @if let Some(noise) = counsel.noise {
                "Half the span of the runs of one contestant is typically " (percent(noise.builds)) " of their median (builds) and "
                (percent(noise.rays)) " (rays). From that, two medians over these scenes are clearly apart from " (percent(noise.builds_apart))
                " (builds) and " (percent(noise.rays_apart)) " (rays) on. "
            }
            @if !counsel.left_out.is_empty() {
                "Left out, as they have no build time or were not traced on every scene: " (counsel.left_out.join(", ")) "."
            }
        }
    }
}

fn bills(ranges: &[Range]) -> Markup {
    html! {
        h3 id="bills" { "By the number of rays" }
        p .soft {
            "A build and the rays that go through its tree are one bill. The least one, averaged geometrically over the scenes, is that of:"
        }
        div .scroll { table .narrow {
            thead { tr { th .name { "Rays a build" } th .name { "Least bill" } th { "Build, ms" } th { "MRays/s" } } }
            tbody { @for range in ranges {
                tr {
                    td .name { (span(range)) }
                    td .name { (range.pick) }
                    td { (grouped(&padded(range.build_ms, 3))) }
                    td { (padded(range.mrays, 3)) }
                }
            } }
        } }
    }
}

fn span(range: &Range) -> String {
    match (range.from, range.to) {
        (None, None) => "any number".into(),
        (None, Some(to)) => format!("up to {}", many(to)),
        (Some(from), None) => format!("{} and more", many(from)),
        (Some(from), Some(to)) => format!("{} to {}", many(from), many(to)),
    }
}

fn averages(comparison: &Comparison, means: &Means) -> Markup {
    let Class { arity, leaf_limit } = means.class;
    let scenes = comparison.scenes.len();
    let id = format!("means-{arity}-{leaf_limit}");
    html! {
        h2 id=(id) { "Means over the scenes, arity " (arity) ", leaves of at most " (leaf_limit) " " a .soft href="tables/compare.csv" { "CSV" } }
        p .soft {
            "Geometric means of ratios to " code { (means.reference) } ": below 1 is less, which is better everywhere but at rays per second. Bold is \
             the best of a column."
        }
        div .scroll { table .dense {
            thead {
                tr {
                    th .name rowspan="2" { "Contestant" }
                    th .over colspan="2" { "Build" } th .over colspan="5" { "Tree" } th .over colspan="3" { "Primary rays" } th .over colspan="3" { "Diffuse rays" }
                }
                tr { @for q in QUANTITIES { th { (q.head) } } }
            }
            tbody { @for line in &means.lines {
                tr {
                    td .name { (line.label) @if line.scenes < scenes { span .mark { (line.scenes) " of " (scenes) " scenes" } } }
                    @for (i, ratio) in line.ratios.iter().enumerate() {
                        @let best = is_best(*ratio, means.lines.iter().filter_map(|l| l.ratios[i]), QUANTITIES[i].more_is_better);
                        td .best[best] { (ratio.map_or("—".into(), |r| padded(r, 3))) }
                    }
                }
            } }
        } }
    }
}

/// Whether a figure, as it is shown, is the best of its column.
fn is_best(value: Option<f64>, all: impl Iterator<Item = f64>, more_is_better: bool) -> bool {
    let best = if more_is_better { all.fold(f64::MIN, f64::max) } else { all.fold(f64::MAX, f64::min) };
    value.is_some_and(|v| padded(v, 3) == padded(best, 3))
}

fn price(comparison: &Comparison, originals: &Originals) -> Markup {
    let pair = |p: &Option<Pair>| match p {
        Some(Pair { cost, time }) => html! { td { (padded(*cost, 3)) } td { (padded(*time, 3)) } },
        None => html! { td { "—" } td { "—" } },
    };
    let class = comparison.main_class().unwrap_or(Class { arity: 2, leaf_limit: 4 });
    html! {
        h2 id="originals" { "What each pays over the exact originals" }
        p {
            "SAH and build time over those of the thesis' constructions (below 1: cheaper, faster); arity " (class.arity)
            ", leaves of at most " (class.leaf_limit) ", geometric means. " (verdict(originals))
            @if originals.equal_leaves {
                " The thesis' leaves hold up to four triangles whatever they cost; for this table they were made anew by cost (" code { "+leaves" } "), as \
                 modern builders' are."
            } @else {
                " The thesis' leaves are as they are: its constructions with " code { "+leaves" } " did not take part."
            }
        }
        div .scroll { table .dense {
            thead {
                tr {
                    th .name rowspan="2" { "Builder" }
                    th .over colspan="2" { "the best original of each scene" }
                    @for name in &originals.names { th .over colspan="2" { (name) } }
                }
                tr { @for _ in 0..=originals.names.len() { th { "SAH" } th { "time" } } }
            }
            tbody { @for line in &originals.lines {
                tr { td .name { (line.label) } (pair(&line.best)) @for p in &line.against { (pair(p)) } }
            } }
        } }
    }
}

/// How many beat the best originals, and who does by most.
fn verdict(originals: &Originals) -> String {
    let best: Vec<(&str, Pair)> = originals.lines.iter().filter_map(|l| Some((&*l.label, l.best?))).collect();
    let cheaper = best.iter().filter(|(_, p)| p.cost < 1.0).count();
    let both = best.iter().filter(|(_, p)| p.cost < 1.0 && p.time < 1.0).count();
    let Some((name, least)) = best.iter().min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) else { return String::new() };
    let change = match least.cost - 1.0 {
        less if less < 0.0 => format!("{} below", percent(-less)),
        more => format!("{} above", percent(more)),
    };
    format!(
        "Of {} builders {cheaper} have cheaper trees than the best original of each scene, {both} of them in less time; the cheapest, {name}, is {change} \
         it and takes {} times as long.",
        best.len(),
        padded(least.time, 3)
    )
}

/// The id of a scene's section.
fn anchor(i: usize) -> String {
    format!("scene-{}", i + 1)
}

/// The figure's name of a scene and class.
pub(crate) fn figure_name(i: usize, class: Class) -> String {
    format!("compare-{}-arity{}-leaf{}", i + 1, class.arity, class.leaf_limit)
}

fn scene_section(comparison: &Comparison, scene: &str, figures: &Figures) -> Markup {
    let i = comparison.scenes.iter().position(|s| s == scene).unwrap_or(0);
    let rows: Vec<&CompareRow> = comparison.of_scene(scene).collect();
    let triangles = rows.first().map_or(0, |r| r.triangles);
    html! {
        h2 id=(anchor(i)) title=(scene) { (comparison.short(scene)) ", " (grouped(&triangles.to_string())) " triangles" }
        @for class in comparison.classes() {
            (drawing(figures, &figure_name(i, class), "Build time against SAH and against rays per second.", html! {
                "Build time, on a logarithmic axis, against SAH and against measured rays per second. Contestants far worse than most stand at the edge with \
                 their figure."
            }))
        }
        (scene_table(comparison, &rows))
    }
}

/// A figure of a row.
type Figure = fn(&CompareRow) -> Option<f64>;

/// Head, whether more is better, and the figure.
const COLUMNS: &[(&str, bool, Figure)] = &[
    ("B/tri", false, peak_bytes_a_triangle),
    ("SAH", false, |r| r.sah),
    ("EPO", false, |r| r.epo),
    ("LCV", false, |r| r.lcv),
    ("nodes", false, nodes),
    ("kB", false, |r| r.bytes.map(|b| b as f64 / 1e3)),
    ("nodes", false, |r| r.primary_nodes),
    ("boxes", false, |r| r.primary_box_tests),
    ("tris", false, |r| r.primary_tri_tests),
    ("MRays/s", true, |r| r.primary_mrays),
    ("nodes", false, |r| r.diffuse_nodes),
    ("boxes", false, |r| r.diffuse_box_tests),
    ("tris", false, |r| r.diffuse_tri_tests),
    ("MRays/s", true, |r| r.diffuse_mrays),
];

fn scene_table(comparison: &Comparison, rows: &[&CompareRow]) -> Markup {
    let finished: Vec<&CompareRow> = rows.iter().copied().filter(|r| r.status == Status::Ok).collect();
    let best = |row: &CompareRow, of: Figure, more: bool| {
        let here = finished.iter().filter(|r| Class::of(r) == Class::of(row)).filter_map(|r| of(r));
        is_best(of(row), here, more)
    };
    let fronts = on_a_front(&finished);
    html! {
        div .scroll { table .dense {
            thead {
                tr {
                    th .name rowspan="2" { "Contestant" } th .over colspan="2" { "Build" }
                    th .over colspan="5" { "Tree" } th .over colspan="4" { "Primary, per ray" } th .over colspan="4" { "Diffuse, per ray" }
                }
                tr { th { "ms" } @for (head, ..) in COLUMNS { th { (head) } } }
            }
            tbody { @for row in rows {
                tr title=[(!row.note.is_empty()).then_some(&row.note)] {
                    td .name { (comparison.label(row)) @if fronts.contains(&row.name()) { " ●" } }
                    @if row.status == Status::Ok {
                        td .best[best(row, |r| r.build_ms, false)] title=(runs(row.build(), "ms")) { (figure(row.build_ms)) }
                        @for (head, more, of) in COLUMNS {
                            @let hint = if *head == "MRays/s" { speeds(row, *of) } else { None };
                            td .best[best(row, *of, *more)] title=[hint] { (figure(of(row))) }
                        }
                    } @else {
                        td colspan=(COLUMNS.len() + 1) { span .mark { (outcome(row)) } }
                    }
                }
            } }
        } }
        p .soft {
            "● on the front of either figure. B/tri: the most bytes a triangle that a build holds beyond the triangles, boxes and tree included. Point at a \
             time or a rate for the span of its runs."
        }
        @for row in rows.iter().filter(|r| r.status == Status::Ok && !r.note.is_empty()) {
            p .soft { (comparison.label(row)) ": " (row.note) "." }
        }
    }
}

/// Names of contestants on the front of one of the figures, class by class.
fn on_a_front(rows: &[&CompareRow]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut classes: Vec<Class> = rows.iter().map(|r| Class::of(r)).collect();
    classes.dedup();
    for class in classes {
        let here: Vec<&&CompareRow> =
            rows.iter().filter(|r| Class::of(r) == class && Kind::of(r) != Kind::File).collect();
        let of: [Figure; 2] = [|r| positive(r.sah), |r| mrays(r).map(|m| -m)];
        for value in of {
            let known: Vec<_> = here.iter().filter_map(|r| Some(((build_ms(r)?, value(r)?), r.name()))).collect();
            let points: Vec<_> = known.iter().map(|k| k.0).collect();
            names.extend(front(&points).into_iter().map(|i| known[i].1.clone()));
        }
    }
    names
}

fn figure(x: Option<f64>) -> String {
    x.map_or("—".into(), |x| grouped(&padded(x, 3)))
}

fn runs(spread: Option<Spread>, unit: &str) -> String {
    spread.map_or(String::new(), |s| format!("{} … {} {unit}, {} runs", padded(s.min, 3), padded(s.max, 3), s.runs))
}

fn speeds(row: &CompareRow, of: Figure) -> Option<String> {
    let primary = of(row) == row.primary_mrays;
    Some(runs(if primary { row.primary() } else { row.diffuse() }, "MRays/s"))
}

fn outcome(row: &CompareRow) -> String {
    match (row.status, row.projected_ms) {
        (Status::Projected, Some(ms)) => format!("capped, projected to {} ms", grouped(&padded(ms, 3))),
        (status, _) if row.note.is_empty() => status.id().into(),
        (status, _) => format!("{}: {}", status.id(), row.note),
    }
}

fn footer(comparison: &Comparison) -> Markup {
    let distinct = |of: &dyn Fn(&CompareRow) -> String| {
        comparison.rows.iter().map(of).collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(", ")
    };
    html! {
        footer { dl {
            dt { "Program and rows" } dd { "bvh-lab " (distinct(&|r| r.version.clone())) }
            dt { "Commit" } dd { code { (distinct(&|r| r.commit.clone())) } }
            dt { "Machine" } dd { (distinct(&|r| r.machine.clone())) }
            dt { "Threads" } dd { "builds " (distinct(&|r| r.threads.to_string())) "; rays " (distinct(&|r| r.trace_threads.to_string())) }
            dt { "Rays" } dd {
                "kernel " (distinct(&|r| r.kernel.clone())) "; " (distinct(&|r| r.pixels.clone()))
                " pixels, one primary ray each, one diffuse ray from each hit"
            }
            dt { "Rows" } dd { (comparison.rows.len()) ", of which " (comparison.errors()) " failed their verification" }
            dt { "Measure again" } dd { code { "bvh-lab compare SCENE… --out DIR" } }
            dt { "Draw again" } dd { code { "bvh-lab report --rows DIR/rows --out DIR" } }
        } }
    }
}
