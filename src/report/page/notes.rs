//! Notes under the tables: what secondary rays add, what rule Q8 did, what did not finish.

use crate::report::PRESETS;
use crate::report::cells::{Cell, Study};
use crate::report::number::{grouped, significant};
use crate::report::printed::Model;
use crate::rows::{Construction, Lighting, Row, Status};
use maud::{Markup, html};

/// Nodes per pixel that the secondary rays add, printed and ours, as means over a model's cells.
pub(crate) fn secondary_rays(study: &Study) -> Markup {
    let presets: Vec<&str> = PRESETS.into_iter().filter(|p| study.has(p)).collect();
    html! {
        h3 id="secondary" { "What secondary rays add" }
        p {
            "Nodes per pixel of Tables 7 and 9 less those of Table 5, mean over the model's cells that are printed in both. In the original, \
             secondary rays start beyond the scene (direction times distance, without the ray's origin), so that each visits the \
             root alone and adds 1 per pixel that hits something; preset " code { "text" } " starts them at the hit point."
        }
        div .scroll { table {
            thead {
                tr {
                    th .name rowspan="2" { "Model" }
                    th rowspan="2" { "Pixels that hit" }
                    th .over colspan=(presets.len() + 1) { "one reflection" }
                    th .over colspan=(presets.len() + 1) { "opacity 0.5" }
                }
                tr { @for _ in [7, 9] { th { "printed" } @for preset in &presets { th { "ours, " (preset) } } } }
            }
            tbody { @for model in Model::ALL { tr {
                th .name { (model.name()) }
                td { (optional(hit_fraction(study, model))) }
                @for table in [7, 9] {
                    @let printed = |c: &Cell| c.printed.reference().map(|f| f.value);
                    td { (optional(added(study, PRESETS[0], table, model, printed))) }
                    @for preset in &presets {
                        td { (optional(added(study, preset, table, model, |c| c.ours))) }
                    }
                }
            } } }
        } }
    }
}

fn optional(x: Option<f64>) -> String {
    x.map_or("—".to_owned(), |x| format!("{x:.2}").replace('-', "−"))
}

fn hit_fraction(study: &Study, model: Model) -> Option<f64> {
    let scene = model.scene();
    let rows = study.traces.iter().filter(|r| r.scene == scene && r.preset == PRESETS[0]);
    rows.filter(|r| r.lighting == Lighting::Primary && r.status == Status::Ok).find_map(|r| r.hit_fraction)
}

/// Mean of this table's figure less Table 5's, over the model's cells with figures on both sides, so that all columns
/// mean the same cells.
fn added(study: &Study, preset: &str, table: u8, model: Model, figure: impl Fn(&Cell) -> Option<f64>) -> Option<f64> {
    let (with, without) = (study.table(preset, table), study.table(preset, 5));
    let differences: Vec<f64> = with
        .iter()
        .zip(&without)
        .filter(|(a, b)| {
            a.printed.model == model && [a, b].iter().all(|c| c.printed.printed.is_some() && c.ours.is_some())
        })
        .filter_map(|(a, b)| Some(figure(a)? - figure(b)?))
        .collect();
    (!differences.is_empty()).then(|| differences.iter().sum::<f64>() / differences.len() as f64)
}

/// What rule Q8 did to the top-down trees of arity 8, and the see-through rays that were cut.
pub(crate) fn rule_q8(study: &Study) -> Markup {
    let count = |n: Option<usize>| n.map_or("—".to_owned(), |n| grouped(&n.to_string()));
    let trees = Model::ALL.map(|model| {
        let rows = study.builds_of(PRESETS[0], model, Construction::TopDown, 8);
        (model, rows.into_iter().find(|r| r.status == Status::Ok))
    });
    html! {
        h3 id="q8" { "Rule Q8 and cut rays" }
        p {
            "At arity 8 the original had no way to split five, six or seven triangles and read a neighbour's memory instead. \
             The preset reproduces it: triangles can then stand in several leaves, or only under boxes that do not contain them, where \
             rays miss them. See-through rays that would go on for ever are cut after 100 hits."
        }
        div .scroll { table {
            thead { tr {
                th .name { "Model" } th { "Nodes under the rule" } th { "Triangles in several leaves" } th { "Triangles rays can miss" }
                th { "Empty leaves" } th { "Chains cut, top-down 2 / 4 / 8" } th { "Chains cut, bottom-up 2 / 4 / 8" }
            } }
            tbody { @for (model, tree) in &trees { tr {
                th .name { (model.name()) }
                td { (tree.map_or("—".to_owned(), |r| grouped(&r.q8_nodes.to_string()))) }
                td { (count(tree.and_then(|r| r.q8_duplicated))) }
                td { (count(tree.and_then(|r| r.q8_hidden))) }
                td { (count(tree.and_then(|r| r.empty))) }
                @for construction in [Construction::TopDown, Construction::BottomUp] {
                    td { (cuts(study, *model, construction)) }
                }
            } } }
        } }
    }
}

fn cuts(study: &Study, model: Model, construction: Construction) -> String {
    let scene = model.scene();
    let cut = |arity| {
        let row = study.traces.iter().find(|r| {
            r.preset == PRESETS[0]
                && r.scene == scene
                && r.construction == construction
                && r.arity == arity
                && r.lighting == Lighting::Opacity
        });
        let cut = row.and_then(|r| r.cut);
        cut.map_or("—".to_owned(), |n| grouped(&n.to_string()))
    };
    [2, 4, 8].map(cut).join(" / ")
}

/// Every row that did not finish, with its reason.
pub(crate) fn unfinished(study: &Study) -> Markup {
    let builds = study.builds.iter().filter(|r| r.status != Status::Ok).map(|r| {
        let cell = format!("{} {} {} k={} ({})", r.preset, r.scene, r.construction.id(), r.arity, r.engine);
        let projected = r.projected_ms.map(|ms| format!(", ≈ {} s", grouped(&significant(ms / 1000.0, 3))));
        (cell, r.status.id(), projected.unwrap_or_default(), r.note.clone())
    });
    let traces = study.traces.iter().filter(|r| r.status != Status::Ok).map(|r| {
        let (construction, lighting) = (r.construction.id(), r.lighting.id());
        let cell = format!("{} {} {construction} k={} {lighting}", r.preset, r.scene, r.arity);
        (cell, r.status.id(), String::new(), r.note.clone())
    });
    let decisions = study.decisions.iter().filter(|r| r.status != Status::Ok).map(|r| {
        let cell = format!("{} {} k={} decisions", r.preset, r.scene, r.arity);
        (cell, r.status.id(), String::new(), r.note.clone())
    });
    let experiments = study.experiments.iter().filter(|r| r.status != Status::Ok);
    let experiments = experiments.map(|r| (r.key(), r.status.id(), String::new(), r.note.clone()));
    let rows: Vec<_> = builds.chain(traces).chain(decisions).chain(experiments).collect();
    html! {
        @if !rows.is_empty() {
            details id="unfinished" {
                summary { "Cells that were capped, projected or failed (" (rows.len()) ")" }
                ul .soft {
                    @for (cell, status, projected, note) in &rows {
                        li { code { (cell) } ": " (status) (projected) @if !note.is_empty() { "; " (note) } }
                    }
                }
            }
        }
    }
}
