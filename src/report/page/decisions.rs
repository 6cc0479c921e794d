//! The table of decisions on the page: what costs in f32 change.

use crate::report::cells::Study;
use crate::report::decisions::{Totals, change, has_figures, in_order, ratios, share};
use crate::report::number::{grouped, padded};
use crate::rows::DecisionRow;
use maud::{Markup, html};

/// The section; nothing without rows.
pub(crate) fn section(study: &Study) -> Markup {
    let rows = in_order(&study.decisions);
    html! {
        @if !rows.is_empty() {
            h3 id="decisions" { "Costs in f32 " a .soft href="tables/decisions.csv" { "CSV" } }
            p {
                "The original added its costs in f32, from left to right; ours are exact, so that ties are ties. Both decide here on \
                 the same triangles at every node of the exact top-down tree; then each builds a tree of its own."
                @if let Some(totals) = Totals::of(&study.decisions) { " " b { (totals.in_one_sentence()) } " " (totals.in_detail()) }
            }
            div .scroll { table {
                thead {
                    tr {
                        th .name rowspan="2" { "Scene" } th rowspan="2" { "Arity" } th rowspan="2" { "Nodes compared" }
                        th .over colspan="4" { "split differently" } th rowspan="2" { "Largest excess" }
                        @for quantity in ["SAH", "EPO", "nodes per pixel"] { th .over colspan="2" { (quantity) } }
                    }
                    tr {
                        th { "nodes" } th { "share" } th { "tied in f32" } th { "same exact cost" }
                        @for _ in 0..3 { th { "exact" } th { "f32 changes it by" } }
                    }
                }
                tbody { @for row in rows { (line(row)) } }
            } }
        }
    }
}

fn line(row: &DecisionRow) -> Markup {
    let count = |n: Option<usize>| n.map_or("—".to_owned(), |n| grouped(&n.to_string()));
    let exact = [row.exact_sah, row.exact_epo, row.exact_nodes_per_pixel];
    html! {
        tr title=[(!row.note.is_empty()).then_some(&row.note)] {
            th .name { (row.scene) }
            td { (row.arity) }
            @if has_figures(row) {
                td { (count(row.compared)) }
                td { (count(row.different)) }
                td { (share(row.different.unwrap_or(0), row.compared.unwrap_or(0))) }
                td { (count(row.rounded_ties)) }
                td { (count(row.same_cost)) }
                td { (row.largest_excess.map_or("—".to_owned(), |x| if x == 0.0 { "0".into() } else { format!("{x:.1e}") })) }
                @for (exact, ratio) in exact.into_iter().zip(ratios(row)) {
                    td { (exact.map_or("—".to_owned(), |x| padded(x, 4))) }
                    td { (ratio.map_or("—".to_owned(), change)) }
                }
            } @else {
                td colspan="12" { span .mark { (row.status.id()) } }
            }
        }
    }
}
