//! The page about accuracy: one self-contained HTML file.

use super::Accuracy;
use super::price::all as all_prices;
use super::series::{Series, all};
use super::words::{percent, sentences, unit};
use crate::report::figures::canvas::Rendered;
use crate::report::number::{grouped, padded, significant};
use crate::rows::{AccuracyRow, Status};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeSet;

/// Study, its heading, and what it asks.
const STUDIES: [(&str, &str, &str); 6] = [
    (
        "planes",
        "Candidate planes",
        "The thesis' searches with more or fewer candidates an axis, by their exact engines: published puts them at ranks of one axis, text \
         at even distances on all three. Factors are over the series' greatest setting.",
    ),
    ("bins", "Bins", "Binned SAH against sweep-sah, which looks at every split. Factors are over sweep-sah."),
    (
        "clustering",
        "Neighbours",
        "Clustering that looks near along a Morton curve (ploc) or among the nearest centres (agglo-kd), against agglo-local, which always \
         merges the pair of least union. Factors are over agglo-local.",
    ),
    (
        "decisions",
        "Rounded costs",
        "The same choices by costs in f32, in f64 and without rounding: where to split (every split along three sorted orders) and which cluster is the \
         nearest (16 places to either side on a Morton curve). Decisions are those of the exact tree, each asked of all three. Times are those \
         of plain builders made for the comparison. Factors are over costs without rounding. What f32 did to the thesis' own searches: reproduce \
         --only decisions.",
    ),
    (
        "intersection",
        "Triangle tests",
        "Every kernel on the same tree and rays. Wrong: nothing where the reference has a hit, something else at another place, or a t more \
         than 4 units in the last place off. Rays at corners and edges are aimed at the places where a ray may slip between two triangles. \
         Factors are over scalar, the watertight kernel, part of whose answers are held against all triangles in f64.",
    ),
    (
        "storage",
        "Bits of stored boxes",
        "The same trees with children's boxes on a grid of their node, rounded outwards (after Ylitie, Karras and Laine 2017). Rows by arity: bytes \
         are those of such nodes and of triangle ids, tests are counted, and timed, by kernel scalar over decoded boxes, so that what less memory \
         saves is not in the rate. Rows of bvh8 are kernels bvh8, bvh8-q16 and bvh8-q8, decoding and memory included; their bytes are those of \
         nodes and of triangles in blocks, which stay the same. Factors are over f32; every setting hits the same, bit for bit.",
    ),
];

/// The whole page.
pub(crate) fn html(accuracy: &Accuracy, scenes: &[&str], drawn: &[(String, Rendered)]) -> String {
    let series = all(accuracy);
    let said = sentences(accuracy);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "bvh-lab: what accuracy costs" }
                style { (PreEscaped(include_str!("../page/style.css"))) }
            }
            body {
                h1 { "What accuracy costs in time" }
                p .lead {
                    "A better tree, a truer hit, a tighter box: each can be had to a degree, and each takes time. Everything that is compared \
                     was measured in turns in one run; factors are geometric means over " (scenes.len()) " scenes."
                }
                @for (study, heading, question) in STUDIES {
                    @if series.iter().any(|s| s.study == study && !s.points.is_empty()) {
                        h2 id=(study) { (heading) }
                        p { (question) }
                        ul { @for (_, text) in said.iter().filter(|(s, _)| s == study) { li { (text) } } }
                        (means(series.iter().filter(|s| s.study == study)))
                        @if study == "decisions" { (picture(drawn, "accuracy-decisions", "Decisions that flip against build time.")) }
                        @if study == "intersection" { (prices(accuracy)) }
                        @if study == "intersection" { (picture(drawn, "accuracy-hits", "Wrong hits against time a ray.")) }
                        @if study == "storage" { (picture(drawn, "accuracy-storage", "Box tests against memory.")) }
                    }
                }
                @for (i, scene) in scenes.iter().enumerate() {
                    h2 id=(format!("scene-{}", i + 1)) { (scene) }
                    (picture(drawn, &format!("accuracy-cost-{}", i + 1), "Cost against build time."))
                    (picture(drawn, &format!("accuracy-speed-{}", i + 1), "Diffuse rays per second against build time."))
                    details {
                        summary { "Every measurement on this scene" }
                        (every(accuracy.rows.iter().filter(|r| r.scene == *scene)))
                    }
                }
                (footer(accuracy))
            }
        }
    };
    page.into_string()
}

fn picture(drawn: &[(String, Rendered)], name: &str, label: &str) -> Markup {
    let Some((_, rendered)) = drawn.iter().find(|(n, _)| n == name) else {
        return html! {};
    };
    html! {
        figure {
            div .sheet role="img" aria-label=(label) { (PreEscaped(&rendered.svg)) }
            figcaption {
                (label) " Files: " a href=(format!("figures/{name}.svg")) { "SVG" } ", "
                a href=(format!("figures/{name}.png")) { "PNG" } "."
            }
        }
    }
}

fn factor(x: Option<f64>) -> String {
    x.map_or_else(|| "—".to_owned(), |x| format!("{} ×", padded(x, 3)))
}

fn signed(x: Option<f64>) -> String {
    let Some(x) = x else { return "—".to_owned() };
    match percent(x).as_str() {
        "no change" => "0".to_owned(),
        text => format!("{}{text}", if x < 1.0 { "−" } else { "+" }),
    }
}

fn means<'a>(series: impl Iterator<Item = &'a Series<'a>>) -> Markup {
    let all: Vec<&Series> = series.collect();
    let study = all.first().map_or("", |s| s.study);
    let (hits, boxes, flips) = (study == "intersection", study == "storage", study == "decisions");
    html! {
        div .scroll { table {
            thead { tr {
                th .name { "Method" }
                @if hits { th .name { "Rays" } } @else { th { "Arity" } th { "Setting" } }
                @if !hits && !boxes { th { "Build time" } th { "SAH" } }
                @if boxes { th { "Bytes" } th { "Box tests" } }
                th { "Rays per second" }
                @if hits { th { "Wrong hits in a million" } }
                @if flips { th { "Decisions" } th { "Otherwise" } th { "Worst excess" } }
            } }
            tbody { @for s in all { @for p in &s.points { tr {
                th .name { (s.method) }
                @if hits {
                    td .name { (s.rays) }
                } @else {
                    td { (s.arity) }
                    td { (p.setting.map_or_else(|| "—".to_owned(), |n| format!("{n} {}", unit(s.study, s.method)))) }
                }
                @if !hits && !boxes { td { (factor(p.time)) } td { (signed(p.sah)) } }
                @if boxes { td { (signed(p.bytes)) } td { (signed(p.boxes)) } }
                td { (signed(p.rate)) }
                @if hits { td { (p.wrong.map_or_else(|| "—".to_owned(), |w| grouped(&significant(w, 3)))) } }
                @if flips {
                    @if let Some((compared, different)) = p.flips {
                        td { (grouped(&compared.to_string())) } td { (grouped(&different.to_string())) }
                    } @else { td { "—" } td { "—" } }
                    td { (p.excess.map_or_else(|| "—".to_owned(), |x| signed(Some(1.0 + x)))) }
                }
            } } } }
        } }
    }
}

/// The price of watertight hits.
fn prices(accuracy: &Accuracy) -> Markup {
    let million = |x: f64| grouped(&significant(x, 3));
    html! {
        h3 id="robust" { "The price of no miss" }
        p {
            "A watertight kernel decides in f64; its twin in -fast walks the same tree and stops at an f32 test. Wrong hits of the fast one by their kind: \
             an edge slipped through, another triangle at another place, a t off by more than 4 units in the last place; in a million rays."
        }
        div .scroll { table {
            thead { tr {
                th .name { "Kernel" } th .name { "Rays" } th { "ns a ray" } th { "ns a ray, fast" } th { "Time for watertight hits" }
                th { "Wrong" } th { "Missed, fast" } th { "Other, fast" } th { "t off, fast" }
            } }
            tbody { @for p in all_prices(accuracy) { tr {
                td .name { (p.kernel) } td .name { (p.rays) }
                td { (padded(p.nanoseconds[0], 3)) } td { (padded(p.nanoseconds[1], 3)) } td { (signed(Some(p.factor()))) }
                td { (million(p.robust_wrong)) } @for wrong in p.wrong { td { (million(wrong)) } }
            } } }
        } }
    }
}

fn every<'a>(rows: impl Iterator<Item = &'a AccuracyRow>) -> Markup {
    let number = |x: Option<f64>, digits| x.map_or_else(|| "—".to_owned(), |x| padded(x, digits));
    let count = |n: Option<usize>| n.map_or_else(|| "—".to_owned(), |n| grouped(&n.to_string()));
    html! {
        div .scroll { table {
            thead { tr {
                th .name { "Study" } th .name { "Method" } th { "Arity" } th { "Setting" } th .name { "Rays" } th { "Build ms (least–most)" }
                th { "SAH" } th { "Bytes" } th { "MRays/s (least–most)" } th { "Boxes a ray" } th { "Triangles a ray" }
                th { "Missed" } th { "Other" } th { "t off" } th { "Decided otherwise" }
            } }
            tbody { @for r in rows { tr title=[(!r.note.is_empty()).then_some(&r.note)] {
                td .name { (r.study) } th .name { (r.method) } td { (r.arity) }
                td { (r.setting.map_or_else(|| "—".to_owned(), |s| s.to_string())) } td .name { (r.rays) }
                @if r.status == Status::Ok {
                    td { (number(r.build_ms, 3)) @if r.build_ms.is_some() { " (" (number(r.build_ms_min, 3)) "–" (number(r.build_ms_max, 3)) ")" } }
                    td { (number(r.sah, 4)) } td { (count(r.bytes)) }
                    td { (number(r.mrays_per_s, 3)) " (" (number(r.mrays_per_s_min, 3)) "–" (number(r.mrays_per_s_max, 3)) ")" }
                    td { (number(r.box_tests_per_ray, 4)) } td { (number(r.tri_tests_per_ray, 4)) }
                    td { (count(r.missed)) } td { (count(r.other)) } td { (count(r.off)) }
                    td { (count(r.different)) }
                } @else {
                    td colspan="10" { span .mark { (r.status.id()) @if !r.note.is_empty() { ": " (r.note) } } }
                }
            } } }
        } }
    }
}

fn footer(accuracy: &Accuracy) -> Markup {
    let distinct = |of: &dyn Fn(&AccuracyRow) -> String| {
        accuracy.rows.iter().map(of).collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(", ")
    };
    html! {
        footer {
            dl {
                dt { "Program and rows" } dd { "bvh-lab " (distinct(&|r| r.version.clone())) }
                dt { "Commit" } dd { code { (distinct(&|r| r.commit.clone())) } }
                dt { "Machine" } dd { (distinct(&|r| r.machine.clone())) "; threads " (distinct(&|r| r.threads.to_string())) }
                dt { "Rows" } dd { (accuracy.rows.len()) " settings in " code { "rows/accuracy.csv" } ", factors in "
                    a href="tables/accuracy.csv" { "tables/accuracy.csv" } ", the price of watertight hits in "
                    a href="tables/accuracy-robust.csv" { "tables/accuracy-robust.csv" } }
                dt { "Measure again" } dd { code { "bvh-lab accuracy --out DIR" } }
                dt { "Draw again" } dd { code { "bvh-lab report --rows DIR/rows --out DIR" } }
            }
        }
    }
}
