//! Times taken against times predicted from counted work by one constant: printed ones, and ours.

use crate::report::figures::chart::{GREY, INK, Mark};
use crate::report::figures::legend::Entry;
use crate::report::figures::loglog::{Guide, Panel, Series, Sheet};
use crate::report::growth::laws::Residual;
use crate::report::growth::samples::Times;
use crate::report::printed::Flag;
use crate::rows::Construction;
use plotters::style::RGBColor;

/// Colours of arity 2, 4 and 8, and of bottom-up builds.
const COLOURS: [RGBColor; 4] =
    [RGBColor(86, 180, 233), RGBColor(0, 90, 178), RGBColor(94, 60, 153), RGBColor(213, 120, 0)];

fn colour(r: &Residual) -> RGBColor {
    match (r.sample.construction, r.sample.arity) {
        (Construction::BottomUp, _) => COLOURS[3],
        (_, 2) => COLOURS[0],
        (_, 4) => COLOURS[1],
        _ => COLOURS[2],
    }
}

fn mark(r: &Residual) -> Mark {
    match (r.sample.flag, r.sample.construction) {
        (Flag::Capped, _) => Mark::Up,
        (Flag::Doubtful, Construction::TopDown) => Mark::Ring,
        (Flag::Doubtful, Construction::BottomUp) => Mark::Frame,
        (_, Construction::TopDown) => Mark::Disc,
        (_, Construction::BottomUp) => Mark::Square,
    }
}

/// The figure; `None` where nothing can be predicted.
pub(crate) fn why(residuals: &[Residual]) -> Option<Sheet> {
    let panel = |times: Times, title: &str, y_label| {
        let points = residuals.iter().filter(|r| r.sample.times == times);
        let series: Vec<Series> = points
            .map(|r| Series { colour: colour(r), line: None, points: vec![(r.predicted, r.sample.seconds, mark(r))] })
            .collect();
        // The diagonal, and a factor of two on both sides of it.
        let guides = match series.is_empty() {
            true => Vec::new(),
            false => [1.0, 2.0, 0.5].map(|factor| Guide { slope: 1.0, through: (1.0, factor), label: "" }).into(),
        };
        Panel { title: title.to_owned(), x_label: "Seconds predicted from the count", y_label, guides, series }
    };
    let panels = vec![
        panel(Times::Printed, "Printed: the thesis' program", "Seconds printed (Table 2, corrected)"),
        panel(Times::Ours, "Measured: our literal engines", "Seconds measured"),
    ];
    if panels.iter().all(|p| p.series.is_empty()) {
        return None;
    }
    let sample = |mark, colour, text: &str| Entry { line: None, mark: Some(mark), colour, text: text.to_owned() };
    let legend = vec![
        vec![
            sample(Mark::Disc, COLOURS[0], "top-down, arity 2"),
            sample(Mark::Disc, COLOURS[1], "arity 4"),
            sample(Mark::Disc, COLOURS[2], "arity 8"),
            sample(Mark::Square, COLOURS[3], "bottom-up"),
        ],
        vec![
            sample(Mark::Ring, INK, "doubtful print, not fitted"),
            sample(Mark::Up, GREY, "given up after eleven days: at least so long"),
        ],
    ];
    let notes = vec![
        "Pale lines: as predicted, and a factor of two off. One constant an algorithm; the tables name it.".to_owned(),
    ];
    Some(Sheet { panels, legend, notes })
}
