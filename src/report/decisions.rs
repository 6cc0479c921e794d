//! The table of decisions: what costs in f32 change, as CSV and in words.

use crate::report::number::{grouped, significant};
use crate::rows::{DecisionRow, Status};

/// Rows in the order in which they are shown: by size, then arity.
pub(crate) fn in_order(rows: &[DecisionRow]) -> Vec<&DecisionRow> {
    let mut rows: Vec<_> = rows.iter().collect();
    rows.sort_by(|a, b| (a.triangles, &a.scene, a.arity).cmp(&(b.triangles, &b.scene, b.arity)));
    rows
}

/// Whether a row has figures; an error row never has any.
pub(crate) fn has_figures(row: &DecisionRow) -> bool {
    row.status == Status::Ok
}

/// f32 over exact, where both are numbers and the exact one is not 0.
pub(crate) fn ratio(exact: Option<f64>, single: Option<f64>) -> Option<f64> {
    Some(single? / exact.filter(|&x| x != 0.0)?).filter(|r| r.is_finite())
}

/// Ratios of SAH, EPO and nodes per pixel.
pub(crate) fn ratios(row: &DecisionRow) -> [Option<f64>; 3] {
    [
        ratio(row.exact_sah, row.f32_sah),
        ratio(row.exact_epo, row.f32_epo),
        ratio(row.exact_nodes_per_pixel, row.f32_nodes_per_pixel),
    ]
}

/// The table as CSV text.
pub(crate) fn csv_text(rows: &[DecisionRow]) -> String {
    let mut text = String::from(
        "scene,triangles,arity,compared,different,rounded_ties,same_cost,largest_excess,same_tree,exact_sah,f32_sah,exact_epo,\
         f32_epo,exact_nodes_per_pixel,f32_nodes_per_pixel,status\n",
    );
    for row in in_order(rows) {
        let shown = has_figures(row);
        let count = |n: Option<usize>| n.filter(|_| shown).map_or(String::new(), |n| n.to_string());
        let figure = |x: Option<f64>| x.filter(|_| shown).map_or(String::new(), |x| significant(x, 6));
        let same_tree = shown.then(|| (row.exact_tree_hash == row.f32_tree_hash).to_string());
        let fields = [
            quoted(&row.scene),
            row.triangles.to_string(),
            row.arity.to_string(),
            count(row.compared),
            count(row.different),
            count(row.rounded_ties),
            count(row.same_cost),
            row.largest_excess.filter(|_| shown).map_or(String::new(), |x| format!("{x:.3e}")),
            same_tree.unwrap_or_default(),
            figure(row.exact_sah),
            figure(row.f32_sah),
            figure(row.exact_epo),
            figure(row.f32_epo),
            figure(row.exact_nodes_per_pixel),
            figure(row.f32_nodes_per_pixel),
            row.status.id().to_owned(),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

/// A scene can be a file of any name.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// What the table shows as a whole.
pub(crate) struct Totals {
    compared: usize,
    different: usize,
    rounded_ties: usize,
    same_cost: usize,
    largest_excess: f64,
    /// Least and greatest ratio of SAH, EPO and nodes per pixel; 1 where no row has one.
    changes: [(f64, f64); 3],
}

impl Totals {
    /// Of all rows with figures; `None` where no node was compared.
    pub fn of(rows: &[DecisionRow]) -> Option<Self> {
        let rows: Vec<_> = rows.iter().filter(|r| has_figures(r)).collect();
        let sum = |of: fn(&DecisionRow) -> Option<usize>| rows.iter().filter_map(|r| of(r)).sum::<usize>();
        let extremes = |quantity: usize| {
            let ratios = rows.iter().filter_map(|r| ratios(r)[quantity]);
            let all = ratios.map(|r| (r, r)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
            all.unwrap_or((1.0, 1.0))
        };
        let totals = Self {
            compared: sum(|r| r.compared),
            different: sum(|r| r.different),
            rounded_ties: sum(|r| r.rounded_ties),
            same_cost: sum(|r| r.same_cost),
            largest_excess: rows.iter().filter_map(|r| r.largest_excess).fold(0.0, f64::max),
            changes: [0, 1, 2].map(extremes),
        };
        (totals.compared > 0).then_some(totals)
    }

    /// What f32 changes.
    pub fn in_one_sentence(&self) -> String {
        let between = |(least, most): (f64, f64)| format!("{} to {}", change(least), change(most));
        format!(
            "Costs in f32 split {} of {} nodes ({}) differently, each at an excess of {:.1e} or less; whole trees change in SAH \
             by {} and in nodes per pixel by {}.",
            number(self.different),
            number(self.compared),
            share(self.different, self.compared),
            self.largest_excess,
            between(self.changes[0]),
            between(self.changes[2]),
        )
    }

    /// Where the differences come from.
    pub fn in_detail(&self) -> String {
        format!(
            "At {} of these nodes the f32 sums of both choices are equal and the order decides, at {} rounding turns the order \
             round; at {} both choices cost the same to one part in 10¹³ in exact numbers.",
            number(self.rounded_ties),
            number(self.different.saturating_sub(self.rounded_ties)),
            number(self.same_cost),
        )
    }
}

fn number(n: usize) -> String {
    grouped(&n.to_string())
}

/// A share in percent.
pub(crate) fn share(part: usize, whole: usize) -> String {
    if whole == 0 { "—".to_owned() } else { format!("{:.1} %", 100.0 * part as f64 / whole as f64) }
}

/// A ratio as a signed difference in percent, to a thousandth.
pub(crate) fn change(ratio: f64) -> String {
    let text = format!("{:+.3} %", (ratio - 1.0) * 100.0);
    match &text[..] {
        "-0.000 %" | "+0.000 %" => "0.000 %".to_owned(),
        _ => text.replace('-', "−"),
    }
}
