//! Tables on the page: printed above ours above the ratio, with reasons as tooltips and footnotes.

use crate::report::PRESETS;
use crate::report::cells::{Cell, CellStatus, Study};
use crate::report::number::{grouped, padded, percent, significant};
use crate::report::page::provenance::Origin;
use crate::report::printed::{self, Flag, Model, Printed};
use crate::rows::Construction;
use maud::{Markup, html};
use std::ops::RangeInclusive;

const ARITIES: [usize; 3] = [2, 4, 8];
const CONSTRUCTIONS: [Construction; 2] = [Construction::TopDown, Construction::BottomUp];

/// These tables of one preset, with a key to their colours.
pub(crate) fn section(study: &Study, preset: &str, numbers: RangeInclusive<u8>) -> Markup {
    html! {
        (key())
        @for number in numbers {
            (table(study, preset, number))
        }
    }
}

fn key() -> Markup {
    html! {
        p .soft .key {
            "In each cell: printed (struck out and corrected where misread), " b { "ours" } ", and the difference, coloured "
            span .close { "within 2 %" } span .near { "within 6 %" } span .off { "within 12 %" } span .far { "further off" }
            "Times are another machine's: they show a ratio, uncoloured."
        }
    }
}

fn table(study: &Study, preset: &str, number: u8) -> Markup {
    let cells = study.table(preset, number);
    let size_column: Vec<&Printed> =
        printed::cells().iter().filter(|p| p.table == number && p.is_size_column()).collect();
    let mut notes = Notes::default();
    let rows: Vec<Markup> = match number {
        1 => vec![html! { tr { th .name { "Triangles" } @for c in &cells { (cell_markup(c, &mut notes)) } } }],
        _ => Model::ALL
            .into_iter()
            .map(|model| {
                let size = size_column.iter().find(|p| p.model == model);
                row(model, size.copied(), &cells, &mut notes)
            })
            .collect(),
    };
    let folder = if preset == PRESETS[0] { "tables" } else { "tables/text" };
    html! {
        h3 id=(format!("{preset}-table{number}")) {
            "Table " (number) ". " (title(number)) " "
            a .soft href=(format!("{folder}/table{number}.csv")) { "CSV" }
        }
        div .scroll {
            table {
                thead { (head(number, &cells)) }
                tbody { @for row in &rows { (row) } }
            }
        }
        (notes.markup())
        (Origin::table(number, study.commit()).line())
        @if number == 2 {
            p .soft {
                "Ours is the time of the literal engine, which does the work that the thesis describes; projected where it would take longer \
                 than its budget. Below it, the time of the exact engine for the same tree, and how often that goes into the literal one. "
                a href=(format!("{folder}/table2-exact.csv")) { "CSV of both" }
            }
        }
    }
}

/// A printed cell in words, such as "Table 5, Tiny, top-down 2".
pub(crate) fn printed_name(p: &Printed) -> String {
    match (p.construction, p.arity) {
        (Some(construction), Some(arity)) => {
            format!("Table {}, {}, {} {arity}", p.table, p.model.name(), construction.id())
        }
        _ => format!("Table {}, {}, size", p.table, p.model.name()),
    }
}

fn head(number: u8, cells: &[Cell]) -> Markup {
    if number == 1 {
        return html! { tr { th .name { "Model" } @for m in Model::ALL { th { (m.name()) } } } };
    }
    let columns = |construction| ARITIES.into_iter().filter(move |k| cells.iter().any(|c| c.is(construction, *k)));
    html! {
        tr {
            th .name rowspan="2" { "Model" }
            th rowspan="2" { "Triangles" }
            @for construction in CONSTRUCTIONS {
                @let span = columns(construction).count();
                @if span > 0 {
                    th .over colspan=(span) { (construction.id()) ", branching factor" }
                }
            }
        }
        tr { @for construction in CONSTRUCTIONS { @for arity in columns(construction) { th .over { (arity) } } } }
    }
}

fn row(model: Model, size: Option<&'static Printed>, cells: &[Cell], notes: &mut Notes) -> Markup {
    let ours = cells.iter().filter(|c| c.printed.model == model);
    let triangles = ours.clone().next().map_or(0, |c| c.printed.size);
    html! {
        tr {
            th .name { (model.name()) }
            td {
                @match size {
                    Some(size) => (printed_markup(size, notes)),
                    None => (grouped(&triangles.to_string())),
                }
            }
            @for cell in ours { (cell_markup(cell, notes)) }
        }
    }
}

fn cell_markup(cell: &Cell, notes: &mut Notes) -> Markup {
    let time = printed::is_time(cell.printed.table);
    let class = match cell.ratio() {
        Some(ratio) if !time && cell.status == CellStatus::Ok => closeness(ratio),
        _ => "",
    };
    let hint = match (&cell.note[..], &cell.engine[..]) {
        ("", "") => None,
        ("", engine) => Some(format!("engine {engine}")),
        (note, "") => Some(note.to_owned()),
        (note, engine) => Some(format!("{note} (engine {engine})")),
    };
    html! {
        td class=(class) title=[hint] {
            (printed_markup(cell.printed, notes))
            span .ours { (our_markup(cell)) }
            @if let Some(ratio) = cell.ratio() {
                span .ratio { @if time { (padded(ratio, 3)) " ×" } @else { (percent(ratio)) } }
            }
            @if let Some(seconds) = cell.exact {
                span .exact {
                    "exact " b { (grouped(&padded(seconds, 3))) }
                    @if let Some(ratio) = cell.exact_ratio() { " ÷ " (grouped(&padded(ratio, 2))) }
                }
            }
        }
    }
}

fn printed_markup(p: &Printed, notes: &mut Notes) -> Markup {
    let figure = |f: &printed::Figure| grouped(&f.text);
    html! {
        span .printed title=[(!p.reason.is_empty()).then_some(&p.reason)] {
            @match (&p.printed, &p.corrected) {
                (None, _) => "—",
                (Some(plain), None) => (figure(plain)),
                (Some(wrong), Some(right)) => { span .struck { (figure(wrong)) } " " (figure(right)) }
            }
            @if p.flag == Flag::Doubtful { "?" }
            @if let Some(number) = notes.number(&p.reason) { sup { (number) } }
        }
    }
}

fn our_markup(cell: &Cell) -> Markup {
    let figure = cell.ours.map(|x| match cell.printed.table {
        1 => grouped(&x.to_string()),
        3 | 5 | 7 | 9 => format!("{x:.3}"),
        _ => grouped(&padded(x, 3)),
    });
    match (figure, cell.status) {
        (Some(figure), CellStatus::Ok) => html! { (figure) },
        (Some(figure), status) => html! { "≈ " (figure) " " span .mark { (status.id()) } },
        (None, CellStatus::Capped) => html! {
            span .mark { "capped" @if let Some(budget) = cell.budget { " at " (grouped(&significant(budget, 6))) " s" } }
        },
        (None, status) => html! { span .mark { (status.id()) } },
    }
}

fn closeness(ratio: f64) -> &'static str {
    match (ratio - 1.0).abs() {
        off if off <= 0.02 => "close",
        off if off <= crate::report::CLOSE => "near",
        off if off <= 0.12 => "off",
        _ => "far",
    }
}

fn title(number: u8) -> &'static str {
    match number {
        1 => "Triangles",
        2 => "Build time in seconds",
        3 => "Children per inner node after collapsing, bottom-up trees",
        4 => "Microseconds per pixel, primary rays",
        5 => "Nodes per pixel, primary rays",
        6 => "Microseconds per pixel, one reflection",
        7 => "Nodes per pixel, one reflection",
        8 => "Microseconds per pixel, opacity 0.5",
        _ => "Nodes per pixel, opacity 0.5",
    }
}

/// The footnotes of one table, each reason once.
#[derive(Default)]
struct Notes(Vec<String>);

impl Notes {
    /// The number of a reason, counted from 1; none for an empty one.
    fn number(&mut self, reason: &str) -> Option<usize> {
        if reason.is_empty() {
            return None;
        }
        let known = self.0.iter().position(|r| r == reason);
        Some(
            1 + known.unwrap_or_else(|| {
                self.0.push(reason.to_owned());
                self.0.len() - 1
            }),
        )
    }

    fn markup(&self) -> Markup {
        html! {
            @if !self.0.is_empty() {
                ol .notes { @for reason in &self.0 { li { (reason) "." } } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_colours() {
        assert_eq!([1.019, 0.95, 1.1, 0.5].map(closeness), ["close", "near", "off", "far"]);
    }

    #[test]
    fn a_reason_is_noted_once() {
        let mut notes = Notes::default();
        assert_eq!(["a", "", "b", "a"].map(|r| notes.number(r)), [Some(1), None, Some(2), Some(1)]);
    }
}
