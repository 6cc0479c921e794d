//! The figures: cost and speed against build time, a sheet a scene; flips, wrong hits and extra boxes against what they save.

use super::Accuracy;
use crate::report::figures::chart::{Line, Mark};
use crate::report::figures::curves::{Curve, Panel, Sheet};
use crate::report::figures::legend::Entry;
use crate::rows::{AccuracyRow, Status};
use plotters::style::RGBColor;

const BLUE: RGBColor = RGBColor(0, 90, 178);
const ORANGE: RGBColor = RGBColor(213, 120, 0);
const GREEN: RGBColor = RGBColor(0, 138, 100);
const PURPLE: RGBColor = RGBColor(140, 60, 150);
const COLOURS: [RGBColor; 4] = [BLUE, ORANGE, GREEN, PURPLE];

type Value = fn(&AccuracyRow) -> Option<f64>;

/// Every figure's name, and the figure where there is something to draw.
pub(crate) fn sheets(accuracy: &Accuracy, scenes: &[&str]) -> Vec<(String, Option<Sheet>)> {
    let mut all = Vec::new();
    for (i, scene) in scenes.iter().enumerate() {
        all.push((format!("accuracy-cost-{}", i + 1), trees(accuracy, scene, "SAH cost", |r| r.sah)));
        all.push((format!("accuracy-speed-{}", i + 1), trees(accuracy, scene, "MRays/s, diffuse", |r| r.mrays_per_s)));
    }
    all.push(("accuracy-decisions".to_owned(), decisions(accuracy, scenes)));
    all.push(("accuracy-hits".to_owned(), hits(accuracy, scenes)));
    all.push(("accuracy-storage".to_owned(), storage(accuracy, scenes)));
    all
}

/// Title of a panel, its study, and which of the study's methods it shows.
const PANELS: [(&str, &str, &str); 4] = [
    ("Planes, published", "planes", "top-down published"),
    ("Planes, text", "planes", "top-down text"),
    ("Bins", "bins", ""),
    ("Clustering", "clustering", ""),
];

fn trees(accuracy: &Accuracy, scene: &str, y_label: &'static str, value: Value) -> Option<Sheet> {
    let mut legend: Vec<Vec<Entry>> = Vec::new();
    let mut panels = Vec::new();
    for (title, study, method) in PANELS {
        let mut keys: Vec<(&str, usize)> = Vec::new();
        let shown = |r: &&AccuracyRow| {
            r.status == Status::Ok && r.study == study && r.scene == scene && (method.is_empty() || r.method == method)
        };
        for row in accuracy.rows.iter().filter(shown) {
            if !keys.contains(&(&row.method, row.arity)) {
                keys.push((&row.method, row.arity));
            }
        }
        let curves: Vec<Curve> = keys
            .iter()
            .zip(COLOURS.into_iter().cycle())
            .map(|(&(method, arity), colour)| {
                let rows =
                    accuracy.rows.iter().filter(shown).filter(|r| (r.method.as_str(), r.arity) == (method, arity));
                curve(rows, colour, |r| r.build_ms, value)
            })
            .collect();
        if curves.is_empty() {
            continue;
        }
        let entry = |((method, arity), curve): (&(&str, usize), &Curve)| Entry {
            line: curve.line,
            mark: Some(curve.points[0].2),
            colour: curve.colour,
            text: if study == "planes" { format!("{method}, arity {arity}") } else { (*method).to_owned() },
        };
        legend.push(keys.iter().zip(&curves).filter(|(_, c)| !c.points.is_empty()).map(entry).collect());
        panels.push(Panel { title: title.to_owned(), x_label: "Build time in milliseconds", y_label, curves });
    }
    let notes = vec![format!(
        "{scene}. Numbers beside points are planes, bins, neighbours or candidates; squares are methods that leave nothing out."
    )];
    (!panels.is_empty()).then_some(Sheet { panels, legend, notes })
}

fn curve<'a>(rows: impl Iterator<Item = &'a AccuracyRow>, colour: RGBColor, x: Value, y: Value) -> Curve {
    let mut rows: Vec<_> = rows.collect();
    // What leaves nothing out comes last.
    rows.sort_by_key(|r| (r.setting.is_none(), r.setting));
    let mut points = Vec::new();
    let mut names = Vec::new();
    for row in &rows {
        if let Some((x, y)) = x(row).zip(y(row)) {
            points.push((x, y, if row.setting.is_some() { Mark::Disc } else { Mark::Square }));
            names.push(row.setting.map_or(String::new(), |s| s.to_string()));
        }
    }
    Curve { colour, line: (points.len() > 1).then_some(Line::Solid), points, names }
}

/// Decisions in a million that are not those of costs without rounding.
fn otherwise_per_million(row: &AccuracyRow) -> Option<f64> {
    let compared = row.compared.filter(|&n| n > 0)?;
    Some(row.different? as f64 / compared as f64 * 1e6)
}

fn decisions(accuracy: &Accuracy, scenes: &[&str]) -> Option<Sheet> {
    let panel = |(title, method): (&str, &str)| {
        let one = |(scene, colour): (&&str, RGBColor)| {
            let shown = |r: &&AccuracyRow| {
                r.status == Status::Ok && r.study == "decisions" && r.scene == **scene && r.method == method
            };
            let mut curve = curve(accuracy.rows.iter().filter(shown), colour, |r| r.build_ms, otherwise_per_million);
            curve.names.iter_mut().filter(|name| !name.is_empty()).for_each(|name| name.insert(0, 'f'));
            curve
        };
        Panel {
            title: title.to_owned(),
            x_label: "Build time in milliseconds",
            y_label: "Decided otherwise in a million",
            curves: scenes.iter().zip(COLOURS.into_iter().cycle()).map(one).collect(),
        }
    };
    let titles = [("Where to split", "splits"), ("Which cluster is nearest", "merges")];
    let panels: Vec<Panel> = titles.map(panel).into_iter().filter(Panel::has_points).collect();
    let notes = vec![
        "Costs in f32, in f64 and, at squares, without rounding, by builders that differ in nothing else.".to_owned(),
    ];
    (!panels.is_empty()).then(|| Sheet { panels, legend: vec![scene_legend(scenes)], notes })
}

fn wrong_per_million(row: &AccuracyRow) -> Option<f64> {
    let traced = row.traced.filter(|&n| n > 0)?;
    Some((row.missed? + row.other? + row.off?) as f64 / traced as f64 * 1e6)
}

fn hits(accuracy: &Accuracy, scenes: &[&str]) -> Option<Sheet> {
    let kinds = ["primary", "diffuse", "edges"];
    let panel = |kind: &str| {
        let one = |(scene, colour): (&&str, RGBColor)| {
            let shown = |r: &&AccuracyRow| {
                r.status == Status::Ok && r.study == "intersection" && r.scene == **scene && r.rays == kind
            };
            let rows: Vec<_> = accuracy.rows.iter().filter(shown).collect();
            let nanoseconds = |r: &AccuracyRow| r.mrays_per_s.map(|m| 1e3 / m);
            let points: Vec<_> =
                rows.iter().filter_map(|r| Some((nanoseconds(r)?, wrong_per_million(r)?, Mark::Disc))).collect();
            let names = rows.iter().map(|r| r.method.clone()).collect();
            Curve { colour, line: None, points, names }
        };
        let title = match kind {
            "edges" => "Rays at corners and edges".to_owned(),
            _ => format!("{}{} rays", kind[..1].to_uppercase(), &kind[1..]),
        };
        Panel {
            title,
            x_label: "Nanoseconds a ray",
            y_label: "Wrong hits in a million",
            curves: scenes.iter().zip(COLOURS.into_iter().cycle()).map(one).collect(),
        }
    };
    let panels: Vec<Panel> = kinds.map(panel).into_iter().filter(Panel::has_points).collect();
    let notes =
        vec!["Against the watertight test, part of whose answers are held against all triangles in f64.".to_owned()];
    (!panels.is_empty()).then(|| Sheet { panels, legend: vec![scene_legend(scenes)], notes })
}

fn scene_legend(scenes: &[&str]) -> Vec<Entry> {
    let entry = |(scene, colour): (&&str, RGBColor)| Entry {
        line: None,
        mark: Some(Mark::Disc),
        colour,
        text: (*scene).to_owned(),
    };
    scenes.iter().zip(COLOURS.into_iter().cycle()).map(entry).collect()
}

fn storage(accuracy: &Accuracy, scenes: &[&str]) -> Option<Sheet> {
    let panel = |method: &str| {
        let one = |(scene, colour): (&&str, RGBColor)| {
            let shown = |r: &&AccuracyRow| {
                r.status == Status::Ok && r.study == "storage" && r.scene == **scene && r.method == method
            };
            let rows = accuracy.rows.iter().filter(shown);
            curve(rows, colour, |r| r.bytes.map(|b| b as f64 / r.triangles.max(1) as f64), |r| r.box_tests_per_ray)
        };
        Panel {
            title: format!("Stored boxes, {method}"),
            x_label: "Bytes a triangle",
            y_label: "Box tests a ray, diffuse",
            curves: scenes.iter().zip(COLOURS.into_iter().cycle()).map(one).collect(),
        }
    };
    let mut methods: Vec<&str> =
        accuracy.rows.iter().filter(|r| r.study == "storage").map(|r| r.method.as_str()).collect();
    methods.sort_unstable();
    methods.dedup();
    let panels: Vec<Panel> = methods.into_iter().map(panel).filter(Panel::has_points).collect();
    let notes = vec!["Numbers beside points are bits a coordinate.".to_owned()];
    (!panels.is_empty()).then(|| Sheet { panels, legend: vec![scene_legend(scenes)], notes })
}
