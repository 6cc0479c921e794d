//! The pages: self-contained HTML files, figures and styles inside them; here that of the study.

mod claims;
pub(crate) mod compare;
mod decisions;
mod experiments;
pub(crate) mod growth;
mod notes;
mod provenance;
mod tables;

use crate::report::PRESETS;
use crate::report::cells::Study;
use crate::report::claims::{Judged, Suspect};
use crate::report::experiments::Experiments;
use crate::report::figures::Figures;
use crate::report::summary::{Summary, Within};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use provenance::Origin;

/// What was found about the thesis' claims and its printed figures.
pub(crate) struct Verdicts {
    /// Claims.
    pub judged: Vec<Judged>,
    /// Printed figures that break a rule.
    pub suspects: Vec<Suspect>,
}

/// The whole page as text.
///
/// `others` are the pages beside it: file and what it is about.
pub(crate) fn html(
    study: &Study,
    summary: &Summary,
    figures: &Figures,
    fits: &growth::Fits,
    verdicts: &Verdicts,
    others: &[(&str, &str)],
) -> String {
    let headline = PRESETS[0];
    let body = html! {
        h1 { "Bounding volume hierarchies by top-down and bottom-up construction" }
        (introduction())
        @if !others.is_empty() {
            p { "Beside this page: " @for (i, (file, about)) in others.iter().enumerate() { @if i > 0 { ", " } a href=(file) { (about) } } "." }
        }
        (claims::section(&verdicts.judged))
        h2 id="numbers" { "The numbers" }
        (headlines(summary))
        (figure3(figures))
        h2 id="build-times" { "Build times" }
        (drawing(figures, "figure4", "Figure 4. Build time against the branching factor, printed and measured.", html! {
            "Figure 4. Seconds to build against the branching factor, one colour a model; unbroken lines are top-down builds, \
             dotted lines bottom-up ones. The thesis projected its Huge point at arity 8; here it stands as what is known: more \
             than eleven days."
            " Ours are fast for two reasons that say nothing about trees: the machine, and that what combinations have in common is \
             computed once, where the original united the boxes of all triangles again for each combination. The rows hold both \
             counts, " code { "combinations" } " and " code { "original_unions" } "."
        }))
        (tables::section(study, headline, 1..=3))
        (growth::figure4_extended(figures, headline, "figure4-extended"))
        (growth::sections(fits, figures))
        h2 id="nodes" { "Traversal" }
        (drawing(figures, "figure5", "Figure 5. Nodes per pixel against the branching factor, printed over measured.", html! {
            "Figure 5. Nodes visited per pixel, primary rays only. Node counts do not depend on the machine: they are what tells \
             whether the trees are the same."
        }))
        (tables::section(study, headline, 4..=9))
        (notes::secondary_rays(study))
        (notes::rule_q8(study))
        (decisions::section(study))
        (experiments::sections(Experiments(&study.experiments), figures))
        (claims::digits(&verdicts.suspects))
        (notes::unfinished(study))
        @for preset in PRESETS.into_iter().skip(1).filter(|p| study.has(p)) {
            (other_preset(study, figures, preset))
        }
        (provenance::footer(study, fits.growth))
    };
    document("bvh-lab: the study", &body)
}

/// A self-contained HTML file.
pub(crate) fn document(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

fn introduction() -> Markup {
    html! {
        p .lead {
            "A reproduction of Kevin Beick's thesis " em { "Analyzing Performance of Bounding Volume Hierarchies for Ray Tracing" }
            " (University of Oregon, 2014): five sizes of one scene, trees of arity 2, 4 and 8 built from the top down and from the \
             bottom up, traced under three lighting cases. Every cell shows the printed number above ours."
        }
        p .soft {
            "Preset " code { "published" } " does what the author's program did and is the headline; preset " code { "text" }
            " does what the thesis says in words. This page is drawn from rows of measurements and computes nothing but comparisons."
        }
    }
}

fn headlines(summary: &Summary) -> Markup {
    let tile = |big: String, small: &str| html! { div .tile { b { (big) } (small) } };
    let of = |w: &Within| match w.printed - w.compared {
        0 => format!("{} of {}", w.within, w.printed),
        missing => format!("{} of {} (+{missing} not measured)", w.within, w.compared),
    };
    let cells = &summary.cells;
    html! {
        div .tiles {
            (tile(of(&summary.table5), "Table 5 cells within 6 % (Tiny to Large, arity 2 and 4)"))
            (tile(of(&summary.table5_all), "Table 5 cells within 6 %, all that are printed"))
            (tile(of(&summary.table3), "average degrees (Table 3) within 0.2"))
            @if summary.engines_agree.1 > 0 {
                (tile(format!("{} of {}", summary.engines_agree.0, summary.engines_agree.1),
                    "trees that two engines built and that are the same, by hash"))
            }
        }
        p .soft {
            "Cells of Tables 2 to 9, preset published: " (cells.ok) " measured, " (cells.projected) " projected, " (cells.capped) " capped, "
            (cells.error) " failed, " (cells.missing) " without a row. Rows that failed their verification, any preset: "
            (summary.error_rows) ". Cells of arity 8, top-down, pass through a memory fault of the original program (rule Q8) and \
             cannot be met exactly."
        }
    }
}

fn figure3(figures: &Figures) -> Markup {
    html! {
        @if figures.get("figure3").is_some() { h2 id="scene" { "The scene" } }
        (photograph(figures, "figure3", "Figure 3. The thesis scene, rendered by this program.",
            "Figure 3. The scene as this program renders it; the five models differ only in how finely it is cut into triangles."))
        (photograph(figures, "figure3-lit", "The thesis scene with glass, mirrors and lamps.",
            "The same triangles from the same camera, with materials and lamps of ours: glass with Fresnel reflection and total internal \
             reflection, polished metal, lacquer, soft shadows of area lights, 128 rays a pixel. The picture that the thesis' three \
             lighting cases are parts of."))
    }
}

/// A picture that the study left; nothing where it left none.
fn photograph(figures: &Figures, name: &str, alternative: &str, caption: &str) -> Markup {
    let Some(rendered) = figures.get(name) else {
        return html! {};
    };
    let data = STANDARD.encode(&rendered.png);
    html! {
        figure {
            div .sheet { img alt=(alternative) src=(format!("data:image/png;base64,{data}")); }
            figcaption { (caption) (Origin::figure(name, figures.commit()).line()) }
        }
    }
}

fn drawing(figures: &Figures, name: &str, label: &str, caption: Markup) -> Markup {
    let Some(rendered) = figures.get(name) else {
        return html! {};
    };
    html! {
        figure {
            div .sheet role="img" aria-label=(label) { (PreEscaped(&rendered.svg)) }
            figcaption {
                (caption) " Files: " a href=(format!("figures/{name}.svg")) { "SVG" } ", "
                a href=(format!("figures/{name}.png")) { "PNG" } "."
                (Origin::figure(name, figures.commit()).line())
            }
        }
    }
}

/// A figure or table of the headline preset by name, such as `figure5` or `table3`, for the paper; nothing where it was not drawn.
pub(crate) fn exhibit(study: &Study, figures: &Figures, name: &str) -> Markup {
    let caption = match name {
        "figure3" => return figure3(figures),
        "figure4" => "Seconds to build against the branching factor: printed, and here by the literal engines.",
        "figure5" => "Nodes per pixel against the branching factor, printed over measured; primary rays.",
        "lookup" => {
            "Time per pixel against the number of triangles: printed, and here with and without the linear lookup."
        }
        "candidates" => "SAH against the number of candidates per axis, each line over its own least value.",
        "wrong-pixels" => {
            "Large through the six trees of the program (top-down above, bottom-up below; arity 2, 4, 8): red pixels see a farther surface \
             than the closest."
        }
        table => {
            let number = table.strip_prefix("table").and_then(|n| n.parse().ok());
            return number.map_or(html! {}, |n| tables::section(study, PRESETS[0], n..=n));
        }
    };
    drawing(figures, name, caption, html! { (caption) })
}

fn other_preset(study: &Study, figures: &Figures, preset: &str) -> Markup {
    html! {
        h2 id=(preset) { "Preset " code { (preset) } }
        p { "The same study by what the thesis says in words, against the same printed numbers." }
        @let caption = html! { "Figures 4 and 5 for this preset." };
        (drawing(figures, &format!("figure4_{preset}"), "Figure 4 for this preset.", html! {}))
        (drawing(figures, &format!("figure5_{preset}"), "Figure 5 for this preset.", caption))
        (growth::figure4_extended(figures, preset, &format!("figure4-extended_{preset}")))
        details {
            summary { "Tables 2 to 9 for this preset" }
            (tables::section(study, preset, 2..=9))
        }
    }
}
