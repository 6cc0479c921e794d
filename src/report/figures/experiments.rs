//! Figures of experiments: time per pixel with and without the linear lookup, and cost against the number of candidates.

use crate::report::experiments::Experiments;
use crate::report::figures::chart::{INK, Line, Mark};
use crate::report::figures::curves;
use crate::report::figures::legend::Entry;
use crate::report::figures::loglog::{Guide, Panel, Series, Sheet};
use crate::report::printed::{self, Model};
use crate::rows::{Construction, Experiment};
use plotters::style::RGBColor;

const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 90, 178),
    RGBColor(213, 120, 0),
    RGBColor(0, 138, 100),
    RGBColor(140, 60, 150),
    RGBColor(200, 60, 60),
    RGBColor(90, 90, 90),
];
const ARITIES: [usize; 3] = [2, 4, 8];

fn sample(line: Option<Line>, mark: Option<Mark>, colour: RGBColor, text: impl Into<String>) -> Entry {
    Entry { line, mark, colour, text: text.into() }
}

/// Microseconds per pixel against triangles: printed, with the linear lookup, without. A panel a construction, a colour an arity.
pub(crate) fn lookup(rows: Experiments) -> Option<Sheet> {
    rows.of(Experiment::Lookup).next()?;
    let panels = [Construction::TopDown, Construction::BottomUp].map(|construction| {
        let mut series = Vec::new();
        for (arity, colour) in ARITIES.into_iter().zip(COLOURS) {
            let printed = printed::cells()
                .iter()
                .filter(|c| (c.table, c.construction, c.arity) == (4, Some(construction), Some(arity)));
            let points = printed.filter_map(|c| Some((c.size as f64, c.reference()?.value, Mark::Cross)));
            series.push(Series { colour, line: Some(Line::Dashed), points: points.collect() });
            for (setting, line, mark) in
                [("lookup=linear", Line::Dotted, Mark::Ring), ("lookup=direct", Line::Solid, Mark::Disc)]
            {
                let of = |m: Model| {
                    let row = rows.tree(Experiment::Lookup, &m.scene(), (construction, arity), setting)?;
                    Some((row.triangles as f64, row.us_per_pixel?, mark))
                };
                let points = Model::ALL.into_iter().filter_map(of).collect();
                series.push(Series { colour, line: Some(line), points });
            }
        }
        let first = series.iter().flat_map(|s| s.points.first()).map(|p| (p.0, p.1)).next();
        let guides = first.map(|(x, y)| Guide { slope: 1.0, through: (x, 0.25 * y), label: "n" }).into_iter().collect();
        Panel {
            title: format!(
                "{}, published",
                if construction == Construction::TopDown { "Top-down" } else { "Bottom-up" }
            ),
            x_label: "Triangles",
            y_label: "Microseconds per pixel",
            guides,
            series,
        }
    });
    let legend = vec![
        ARITIES.iter().zip(COLOURS).map(|(k, c)| sample(Some(Line::Solid), None, c, format!("arity {k}"))).collect(),
        vec![
            sample(Some(Line::Dashed), Some(Mark::Cross), INK, "printed (Table 4)"),
            sample(Some(Line::Dotted), Some(Mark::Ring), INK, "here, with the linear lookup"),
            sample(Some(Line::Solid), Some(Mark::Disc), INK, "here, without"),
        ],
    ];
    Some(Sheet {
        panels: panels.to_vec(),
        legend,
        notes: vec!["Primary rays; the same trees in both settings.".into()],
    })
}

/// SAH over the least of the series, against candidates per axis. A panel a preset and arity, a colour a scene.
pub(crate) fn candidates(rows: Experiments) -> Option<curves::Sheet> {
    let scenes = rows.scenes(Experiment::Candidates);
    let mut panels = Vec::new();
    for preset in crate::report::PRESETS {
        for arity in ARITIES {
            let curves: Vec<curves::Curve> = scenes
                .iter()
                .zip(COLOURS.into_iter().cycle())
                .map(|(scene, colour)| {
                    let sweep = rows.sweep(scene, preset, arity);
                    let least = sweep.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
                    let points: Vec<_> = sweep.iter().map(|&(n, sah)| (n as f64, sah / least, Mark::Disc)).collect();
                    let names = vec![String::new(); points.len()];
                    curves::Curve { colour, line: Some(Line::Solid), points, names }
                })
                .filter(|c| !c.points.is_empty())
                .collect();
            if !curves.is_empty() {
                panels.push(curves::Panel {
                    title: format!("Top-down, {preset}, arity {arity}"),
                    x_label: "Candidates per axis",
                    y_label: "SAH, over the least",
                    curves,
                });
            }
        }
    }
    let names = |part: &[&str], from: usize| {
        part.iter()
            .enumerate()
            .map(|(i, s)| sample(Some(Line::Solid), Some(Mark::Disc), COLOURS[(from + i) % COLOURS.len()], *s))
            .collect::<Vec<_>>()
    };
    let legend = scenes.chunks(3).enumerate().map(|(i, part)| names(part, 3 * i)).collect();
    let notes = vec!["Rule Q8 is off. Each line is divided by its own least value.".into()];
    (!panels.is_empty()).then_some(curves::Sheet { panels, legend, notes })
}
