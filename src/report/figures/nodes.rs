//! Figure 5: nodes per pixel against the branching factor, a panel a construction, printed over ours.

use crate::report::cells::{Cell, Study};
use crate::report::figures::axis::Scale;
use crate::report::figures::build_times::triangles;
use crate::report::figures::chart::{INK, Line, Mark, Panel, Series, Sheet, colour};
use crate::report::figures::legend::Entry;
use crate::report::number::grouped;
use crate::report::printed::Model;
use crate::rows::Construction;

/// Figure 5 for one preset: primary rays, Table 5.
pub(crate) fn figure5(study: &Study, preset: &str) -> Sheet {
    let cells = study.table(preset, 5);
    let panels = [Construction::TopDown, Construction::BottomUp].map(|construction| {
        let of = |line, mark, value: fn(&Cell) -> Option<f64>| {
            let cells = &cells;
            Model::ALL.into_iter().map(move |model| Series {
                model,
                line,
                points: cells
                    .iter()
                    .filter(|c| c.printed.model == model && c.printed.construction == Some(construction))
                    .filter_map(|c| Some((c.printed.arity?, value(c)?, mark)))
                    .collect(),
            })
        };
        let ours = of(Line::Solid, Mark::Disc, |c| c.ours);
        let printed = of(Line::Dashed, Mark::Cross, |c| c.printed.reference().map(|f| f.value));
        Panel {
            title: match construction {
                Construction::TopDown => format!("Top-down (preset {preset})"),
                Construction::BottomUp => format!("Bottom-up (preset {preset})"),
            },
            y_label: "Nodes per pixel",
            series: ours.chain(printed).collect(),
        }
    });
    let values = panels.iter().flat_map(|p| &p.series).flat_map(|s| &s.points).map(|p| p.1);
    let high = values.fold(1.0, f64::max);
    Sheet {
        panels: panels.to_vec(),
        scale: Scale::Linear(0.0..(high + 0.5).ceil()),
        rules: Vec::new(),
        legend: legend(),
        notes: notes(&cells),
    }
}

fn legend() -> Vec<Vec<Entry>> {
    let models = Model::ALL.map(|model| Entry {
        line: Some(Line::Solid),
        mark: Some(Mark::Disc),
        colour: colour(model),
        text: format!("{} ({})", model.name(), grouped(&triangles(model).to_string())),
    });
    let sample =
        |line, mark, text: &str| Entry { line: Some(line), mark: Some(mark), colour: INK, text: text.to_owned() };
    let styles =
        vec![sample(Line::Solid, Mark::Disc, "measured here"), sample(Line::Dashed, Mark::Cross, "printed (Table 5)")];
    vec![models.to_vec(), styles]
}

fn notes(cells: &[Cell]) -> Vec<String> {
    let printed = names(cells.iter().filter(|c| c.printed.reference().is_none()));
    let ours = names(cells.iter().filter(|c| c.ours.is_none()));
    let mut notes = vec![format!("Not printed, their builds were stopped at eleven days: {printed}.")];
    if !ours.is_empty() {
        notes.push(format!("Not measured here: {ours}."));
    }
    notes
}

/// Cells by name, such as "Huge bottom-up 2, 4, 8"; the first ones, where there are too many for a line.
pub(crate) fn names<'a>(cells: impl Iterator<Item = &'a Cell>) -> String {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for cell in cells {
        let p = cell.printed;
        let group = format!("{} {}", p.model.name(), p.construction.map_or("", |c| c.id()));
        let arity = p.arity.map_or(String::new(), |k| k.to_string());
        match groups.last_mut().filter(|(name, _)| *name == group) {
            Some((_, arities)) => arities.push(arity),
            None => groups.push((group, vec![arity])),
        }
    }
    const SHOWN: usize = 4;
    let more = groups.len().saturating_sub(SHOWN);
    let shown: Vec<String> = groups.iter().take(SHOWN).map(|(name, ks)| format!("{name} {}", ks.join("/"))).collect();
    match more {
        0 => shown.join(", "),
        _ => format!("{}, and {more} more rows of the table", shown.join(", ")),
    }
}
