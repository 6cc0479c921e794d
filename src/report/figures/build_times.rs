//! Figure 4: build time against the branching factor, the printed panel beside ours, and faintly behind it.

use crate::report::cells::{Cell, CellStatus, Study};
use crate::report::figures::axis::Scale;
use crate::report::figures::chart::{INK, Line, Mark, Panel, Rule, Series, Sheet, colour};
use crate::report::figures::legend::Entry;
use crate::report::number::grouped;
use crate::report::printed::{Flag, Model};
use crate::rows::Construction;

/// The thesis stopped builds after eleven days.
const CAP_SECONDS: f64 = 11.0 * 24.0 * 3600.0;

/// Figure 4 for one preset.
pub(crate) fn figure4(study: &Study, preset: &str) -> Sheet {
    let cells = study.table(preset, 2);
    let panels = vec![
        Panel {
            title: "Printed (thesis, 2009 iMac)".to_owned(),
            y_label: "Build time in seconds",
            series: series(&cells, printed_point),
        },
        Panel {
            title: format!("Measured here ({preset}, {})", engines(&cells)),
            y_label: "Build time in seconds",
            series: printed_behind(&cells).chain(series(&cells, our_point)).collect(),
        },
    ];
    let values = panels.iter().flat_map(|p| &p.series).flat_map(|s| &s.points).map(|p| p.1);
    let (low, high) = values.fold((CAP_SECONDS, CAP_SECONDS), |(low, high), v| (low.min(v), high.max(v)));
    let decades = (low.log10() - 0.1).floor() as i32..(high.log10() + 0.1).ceil() as i32;
    Sheet { panels, scale: Scale::Decades(decades), rules: rules(), legend: legend(), notes: notes(&cells) }
}

/// The line at which the thesis stopped.
pub(crate) fn rules() -> Vec<Rule> {
    vec![Rule { value: CAP_SECONDS, label: "eleven days" }]
}

/// Every series of a panel; `point` gives a cell its place and mark.
pub(crate) fn series(cells: &[Cell], point: impl Fn(&Cell) -> Option<(f64, Mark)>) -> Vec<Series> {
    let mut all = Vec::new();
    for (construction, line) in [(Construction::BottomUp, Line::Dotted), (Construction::TopDown, Line::Solid)] {
        for model in Model::ALL {
            let points = cells
                .iter()
                .filter(|c| c.printed.model == model && c.printed.construction == Some(construction))
                .filter_map(|c| {
                    let (value, mark) = point(c)?;
                    // Squares stay visible behind discs where the two constructions take the same time.
                    let mark = match (construction, mark) {
                        (Construction::BottomUp, Mark::Disc) => Mark::Square,
                        (Construction::BottomUp, Mark::Ring) => Mark::Frame,
                        _ => mark,
                    };
                    Some((c.printed.arity?, value, mark))
                })
                .collect();
            all.push(Series { model, line, points });
        }
    }
    all
}

/// The printed series once more, to lie faintly behind ours.
fn printed_behind(cells: &[Cell]) -> impl Iterator<Item = Series> {
    series(cells, |cell| printed_point(cell).map(|(value, _)| (value, Mark::Speck)))
        .into_iter()
        .map(|s| Series { line: if s.line == Line::Solid { Line::Faint } else { Line::FaintDotted }, ..s })
}

fn printed_point(cell: &Cell) -> Option<(f64, Mark)> {
    match cell.printed.flag {
        Flag::Capped => Some((CAP_SECONDS, Mark::Up)),
        _ => cell.printed.reference().map(|f| (f.value, Mark::Disc)),
    }
}

/// Where a cell of ours stands.
pub(crate) fn our_point(cell: &Cell) -> Option<(f64, Mark)> {
    let positive = |x: Option<f64>| x.filter(|v| *v > 0.0);
    match cell.status {
        CellStatus::Ok => positive(cell.ours).map(|v| (v, Mark::Disc)),
        CellStatus::Projected => positive(cell.ours).map(|v| (v, Mark::Ring)),
        CellStatus::Capped => positive(cell.budget).map(|v| (v, Mark::Up)),
        CellStatus::Error | CellStatus::Missing => None,
    }
}

/// Which engines the measured times are of.
fn engines(cells: &[Cell]) -> String {
    let mut names: Vec<&str> = cells.iter().map(|c| c.engine.as_str()).filter(|e| !e.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    match names[..] {
        [] => "no rows".to_owned(),
        [one] => format!("{one} engine"),
        _ => format!("engines {}", names.join(" and ")),
    }
}

/// Models, constructions and marks.
pub(crate) fn legend() -> Vec<Vec<Entry>> {
    let models = Model::ALL.map(|model| Entry {
        line: Some(Line::Solid),
        mark: None,
        colour: colour(model),
        text: format!("{} ({})", model.name(), grouped(&triangles(model).to_string())),
    });
    let sample = |line, mark, text: &str| Entry { line, mark, colour: INK, text: text.to_owned() };
    let styles = vec![
        sample(Some(Line::Solid), Some(Mark::Disc), "top-down"),
        sample(Some(Line::Dotted), Some(Mark::Square), "bottom-up"),
        sample(None, Some(Mark::Ring), "projected from counted work"),
        sample(None, Some(Mark::Up), "takes longer than that"),
        sample(Some(Line::Faint), Some(Mark::Speck), "printed, behind ours"),
    ];
    vec![models.to_vec(), styles]
}

/// The model's triangles as printed in Table 1.
pub(crate) fn triangles(model: Model) -> usize {
    let cell = crate::report::printed::cells().iter().find(|c| c.model == model);
    cell.map_or(0, |c| c.size)
}

fn notes(cells: &[Cell]) -> Vec<String> {
    let absent = super::nodes::names(cells.iter().filter(|c| our_point(c).is_none()));
    let mut notes = vec!["Logarithmic scale. Printed misreadings are corrected; the table names them.".to_owned()];
    if !absent.is_empty() {
        notes.push(format!("Not measured here: {absent}."));
    }
    notes
}
