//! Time and work against size: exact engines beside literal ones, a panel a construction and reading.

use crate::report::figures::chart::{INK, Line, Mark};
use crate::report::figures::legend::Entry;
use crate::report::figures::loglog::{Guide, Panel, Series, Sheet};
use crate::report::growth::exponents::series;
use crate::report::growth::{Growth, milliseconds, steps};
use crate::rows::ScalingRow;
use plotters::style::RGBColor;

const BLUE: RGBColor = RGBColor(0, 90, 178);
const ORANGE: RGBColor = RGBColor(213, 120, 0);
const GREEN: RGBColor = RGBColor(0, 158, 115);

/// The colour of an arity or, bottom-up, of a reading.
fn colour(row: &ScalingRow) -> RGBColor {
    match (row.builder.as_str(), row.arity, row.preset.as_str()) {
        ("bottom-up", _, "published") | (_, 2, _) => match row.preset.as_str() {
            "text" if row.builder == "bottom-up" => ORANGE,
            "walter" => GREEN,
            _ => BLUE,
        },
        (_, 4, _) => ORANGE,
        _ => GREEN,
    }
}

/// Milliseconds against triangles; `None` without rows.
pub(crate) fn time(growth: &Growth) -> Option<Sheet> {
    let mut panels = panels(growth, "Milliseconds", milliseconds);
    panels.push(panel(growth, "Collapse of bottom-up trees, on its own", "Milliseconds", milliseconds, |r| {
        r.builder == "collapse"
    }));
    sheet(growth, panels, "Median build time. Straight lines are powers: the table has their exponents.")
}

/// Steps counted against triangles, and what the thesis' program would have done for the same trees.
pub(crate) fn work(growth: &Growth) -> Option<Sheet> {
    let mut panels = panels(growth, "Elementary steps", steps);
    let unions = |r: &ScalingRow| r.literal_unions;
    let mut program =
        panel(growth, "Top-down, published: box unions of the thesis' program", "Box unions", unions, |r| {
            (r.builder.as_str(), r.preset.as_str(), r.engine.as_str()) == ("top-down", "published", "exact")
        });
    program.series.iter_mut().for_each(|s| s.line = Some(Line::Dotted));
    panels.push(program);
    let note =
        "Combinations, distances, transitions of a dynamic program, entries of search structures looked at, together.";
    sheet(growth, panels, note)
}

fn panels(growth: &Growth, y_label: &'static str, value: fn(&ScalingRow) -> Option<f64>) -> Vec<Panel> {
    let top_down = |preset: &'static str| move |r: &ScalingRow| r.builder == "top-down" && r.preset == preset;
    vec![
        panel(growth, "Top-down, published", y_label, value, top_down("published")),
        panel(growth, "Top-down, text", y_label, value, top_down("text")),
        panel(growth, "Bottom-up, arity 2", y_label, value, |r| r.builder == "bottom-up"),
    ]
}

/// One panel of the first family's series that are `wanted`.
fn panel(
    growth: &Growth,
    title: &str,
    y_label: &'static str,
    value: fn(&ScalingRow) -> Option<f64>,
    wanted: impl Fn(&ScalingRow) -> bool,
) -> Panel {
    let family = growth.scaling.first().map(|r| r.family.as_str());
    let all = series(&growth.scaling);
    let of = |rows: &Vec<&ScalingRow>| {
        let literal = rows[0].engine == "literal";
        let (line, mark) = if literal { (Line::Dotted, Mark::Ring) } else { (Line::Solid, Mark::Disc) };
        let points = rows.iter().filter_map(|r| Some((r.triangles as f64, value(r)?, mark))).collect();
        Series { colour: colour(rows[0]), line: Some(line), points }
    };
    let series: Vec<Series> =
        all.iter().filter(|rows| Some(rows[0].family.as_str()) == family && wanted(rows[0])).map(of).collect();
    // Slopes to compare with, through the lowest point of the smallest size.
    let points = || series.iter().flat_map(|s| &s.points);
    let least = points().map(|p| (p.0, p.1)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let most =
        points().map(|p| (p.0, p.1)).filter(|p| Some(p.0) == least.map(|l| l.0)).max_by(|a, b| a.1.total_cmp(&b.1));
    let mut guides: Vec<Guide> =
        least.map(|(x, y)| Guide { slope: 1.0, through: (x, y / 2.0), label: "n" }).into_iter().collect();
    if title.starts_with("Bottom-up") {
        guides.extend(most.map(|(x, y)| Guide { slope: 3.0, through: (x, y * 2.0), label: "n³" }));
    }
    Panel { title: title.to_owned(), x_label: "Triangles", y_label, guides, series }
}

fn sheet(growth: &Growth, panels: Vec<Panel>, note: &str) -> Option<Sheet> {
    let family = growth.scaling.first()?.family.clone();
    let sample = |line, mark, colour, text: &str| Entry { line, mark, colour, text: text.to_owned() };
    let legend = vec![
        vec![
            sample(Some(Line::Solid), Some(Mark::Disc), INK, "exact"),
            sample(Some(Line::Dotted), Some(Mark::Ring), INK, "literal"),
            sample(Some(Line::Solid), None, BLUE, "arity 2"),
            sample(Some(Line::Solid), None, ORANGE, "arity 4"),
            sample(Some(Line::Solid), None, GREEN, "arity 8"),
        ],
        vec![
            sample(Some(Line::Solid), None, BLUE, "bottom-up: published"),
            sample(Some(Line::Solid), None, ORANGE, "bottom-up: text"),
            sample(Some(Line::Solid), None, GREEN, "bottom-up: walter"),
        ],
    ];
    Some(Sheet { panels, legend, notes: vec![format!("Scenes {family}:N. {note}")] })
}
