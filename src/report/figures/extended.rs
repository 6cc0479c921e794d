//! Figure 4 extended: the literal engines' build times beside those of the exact engines for the same trees.

use crate::report::cells::{CellStatus, Study};
use crate::report::figures::axis::Scale;
use crate::report::figures::build_times::{legend, our_point, rules, series};
use crate::report::figures::chart::{Panel, Sheet};

/// Figure 4 with both engines, for one preset; `None` where the exact engine built nothing.
pub(crate) fn figure4(study: &Study, preset: &str) -> Option<Sheet> {
    let (literal, exact) = (study.table(preset, 2), study.exact_times(preset));
    if !exact.iter().any(|c| c.status == CellStatus::Ok && c.ours.is_some_and(|s| s > 0.0)) {
        return None;
    }
    let panel = |title: String, cells: &[_]| Panel {
        title,
        y_label: "Build time in seconds",
        series: series(cells, our_point),
    };
    let panels = vec![
        panel(format!("Literal engines ({preset})"), &literal),
        panel(format!("Exact engines, the same trees ({preset})"), &exact),
    ];
    let rules = rules();
    let values = panels.iter().flat_map(|p| &p.series).flat_map(|s| &s.points).map(|p| p.1);
    let (low, high) =
        values.chain(rules.iter().map(|r| r.value)).fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
    let decades = (low.log10() - 0.1).floor() as i32..(high.log10() + 0.1).ceil() as i32;
    let mut legend = legend();
    // Nothing printed lies behind these.
    legend.iter_mut().for_each(|row| row.retain(|e| !e.text.starts_with("printed")));
    let notes = vec!["Logarithmic scale, the same in both panels.".to_owned()];
    Some(Sheet { panels, scale: Scale::Decades(decades), rules, legend, notes })
}
