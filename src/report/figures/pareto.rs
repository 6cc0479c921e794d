//! Build time against what a tree is worth: every contestant a point, and the front of those that nothing beats in both.

use crate::report::comparison::{Class, Comparison, Kind, build_ms, front, mrays, positive};
use crate::report::figures::axis::Axis;
use crate::report::figures::canvas::{Canvas, Drawing, Drawn};
use crate::report::figures::chart::{GREY, GRID, INK, Line, Mark};
use crate::report::figures::labels::{Box2, place};
use crate::report::figures::legend::{self, Entry};
use crate::report::figures::marks;
use crate::report::number::{grouped, padded, significant};
use crate::rows::{CompareRow, Status};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

const WIDTH: i32 = 1600;
const PANEL_HEIGHT: i32 = 720;
const LEGEND_ROW: i32 = 40;
const NOTE_ROW: i32 = 28;
const LABEL: u32 = 19;

/// One contestant.
#[derive(Clone, Debug)]
struct Point {
    name: String,
    kind: Kind,
    ms: f64,
    value: f64,
}

/// One chart.
#[derive(Clone, Debug)]
struct Panel {
    title: String,
    y_label: &'static str,
    /// Whether the upper left corner is the best one, not the lower left.
    more_is_better: bool,
    points: Vec<Point>,
}

/// Both charts of one scene and class.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    panels: Vec<Panel>,
    note: String,
}

/// The charts; `None` with fewer than two points in each.
pub(crate) fn sheet(comparison: &Comparison, scene: &str, class: Class) -> Option<Sheet> {
    let rows: Vec<&CompareRow> =
        comparison.of_scene(scene).filter(|r| Class::of(r) == class && r.status == Status::Ok).collect();
    let points = |of: &dyn Fn(&CompareRow) -> Option<f64>| -> Vec<Point> {
        let point = |r: &&CompareRow| {
            Some(Point { name: r.name(), kind: Kind::of(r), ms: build_ms(r)?, value: positive(of(r))? })
        };
        rows.iter().filter_map(point).collect()
    };
    let short = comparison.short(scene);
    let panels = [
        Panel {
            title: format!("{short}: build time against SAH"),
            y_label: "SAH",
            more_is_better: false,
            points: points(&|r| r.sah),
        },
        Panel {
            title: format!("{short}: build time against rays per second"),
            y_label: "Million rays per second",
            more_is_better: true,
            points: points(&mrays),
        },
    ];
    let panels: Vec<Panel> = panels.into_iter().filter(|p| p.points.len() > 1).collect();
    let first = rows.first().filter(|_| !panels.is_empty())?;
    let threads = first.trace_threads;
    let note = format!(
        "{} triangles, arity {}, leaves of at most {}; rays: half primary, half diffuse, kernel {}, {threads} thread{}",
        grouped(&first.triangles.to_string()),
        class.arity,
        class.leaf_limit,
        first.kernel,
        if threads == 1 { "" } else { "s" }
    );
    Some(Sheet { panels, note })
}

const BLUE: RGBColor = RGBColor(0, 90, 178);
const GREEN: RGBColor = RGBColor(0, 128, 92);
const ORANGE: RGBColor = RGBColor(196, 96, 0);

fn look(kind: Kind) -> (RGBColor, Mark, &'static str) {
    match kind {
        Kind::Original => (ORANGE, Mark::Up, "the thesis' constructions"),
        Kind::Modern => (BLUE, Mark::Disc, "modern builders"),
        Kind::Refined => (GREEN, Mark::Square, "refined trees"),
        Kind::File => (INK, Mark::Cross, "trees from files"),
    }
}

impl Drawing for Sheet {
    fn size(&self) -> (u32, u32) {
        (WIDTH as u32, (self.panels_height() + LEGEND_ROW + NOTE_ROW + 24) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        let (top, _) = canvas.area.split_vertically(canvas.px(self.panels_height()));
        for (panel, area) in self.panels.iter().zip(top.split_evenly((self.panels.len(), 1))) {
            panel.draw(&area, canvas)?;
        }
        let present = |kind: &Kind| self.panels.iter().flat_map(|p| &p.points).any(|p| p.kind == *kind);
        let kinds = [Kind::Original, Kind::Modern, Kind::Refined].into_iter().filter(present);
        let mut entries: Vec<Entry> = kinds
            .map(|kind| {
                let (colour, mark, text) = look(kind);
                Entry { line: None, mark: Some(mark), colour, text: text.into() }
            })
            .collect();
        let text = "the front: nothing beats these in both".to_owned();
        entries.push(Entry { line: Some(Line::Faint), mark: None, colour: GREY, text });
        let y = self.panels_height() + LEGEND_ROW / 2;
        legend::draw_row(canvas, &entries, WIDTH, y)?;
        let style = canvas.text(20, GREY, HPos::Center, VPos::Center);
        canvas.write(&self.note, &style, (WIDTH / 2, y + LEGEND_ROW))
    }
}

impl Sheet {
    fn panels_height(&self) -> i32 {
        PANEL_HEIGHT * self.panels.len() as i32
    }
}

impl Panel {
    /// The least and greatest value that the axis shows: where few contestants are far worse than most, these stand at its edge.
    fn values(&self) -> Range<f64> {
        let mut sorted: Vec<f64> = self.points.iter().map(|p| p.value).collect();
        sorted.sort_by(f64::total_cmp);
        let (least, most) = (sorted[0], sorted[sorted.len() - 1]);
        /// Beyond the worst quarter's edge by this factor is far.
        const FAR: f64 = 1.3;
        let (low, high) = match self.more_is_better {
            true => {
                let far = sorted[sorted.len() / 4] / FAR;
                (sorted.iter().copied().find(|v| *v >= far).unwrap_or(least), most)
            }
            false => {
                let far = sorted[sorted.len() * 3 / 4] * FAR;
                (least, sorted.iter().copied().rfind(|v| *v <= far).unwrap_or(most))
            }
        };
        let margin = (0.08 * (high - low)).max(0.01 * high);
        low - margin..high + margin
    }

    /// The front, from the left to the right.
    fn front(&self) -> Vec<usize> {
        let sign = if self.more_is_better { -1.0 } else { 1.0 };
        front(&self.points.iter().map(|p| (p.ms, sign * p.value)).collect::<Vec<_>>())
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, canvas: &Canvas<DB>) -> Drawn {
        let logs = || self.points.iter().map(|p| p.ms.log10());
        let x = logs().fold(f64::INFINITY, f64::min) - 0.12..logs().fold(f64::NEG_INFINITY, f64::max) + 0.12;
        let y = self.values();
        let mut chart = ChartBuilder::on(area)
            .margin(canvas.px(12))
            .margin_top(canvas.px(58))
            .margin_right(canvas.px(34))
            .x_label_area_size(canvas.px(70))
            .y_label_area_size(canvas.px(104))
            .build_cartesian_2d(Axis::new(x.clone(), time_ticks(&x)), Axis::new(y.clone(), linear_ticks(&y)))
            .map_err(|e| e.to_string())?;
        let labels = canvas.text(23, INK, HPos::Center, VPos::Center);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(canvas.stroke(GRID.to_rgba(), 1))
            .axis_style(canvas.stroke(GREY.to_rgba(), 1))
            .label_style(labels.clone())
            .axis_desc_style(labels)
            .x_desc("Build time, ms")
            .y_desc(self.y_label)
            .x_label_formatter(&|t| grouped(&significant(10f64.powf(*t), 3)))
            .y_label_formatter(&|v| significant(*v, 6))
            .set_all_tick_mark_size(canvas.px(6))
            .draw()
            .map_err(|e| e.to_string())?;
        let scale = canvas.scale as i32;
        let at = |px: f64, py: f64| chart.backend_coord(&(px, py));
        let (low_left, high_right) = (at(x.start, y.start), at(x.end, y.end));
        let room = Box2 {
            x0: low_left.0 / scale + 4,
            y0: high_right.1 / scale + 4,
            x1: high_right.0 / scale - 4,
            y1: low_left.1 / scale - 4,
        };
        let title = canvas.text(27, INK, HPos::Center, VPos::Center);
        canvas.write(&self.title, &title, ((room.x0 + room.x1) / 2, room.y0 - 30))?;
        let shown = |p: &Point| at(p.ms.log10(), p.value.clamp(y.start, y.end));

        let front = self.front();
        let mut steps = Vec::new();
        for pair in front.windows(2) {
            let (a, b) = (shown(&self.points[pair[0]]), shown(&self.points[pair[1]]));
            steps.extend([a, (b.0, a.1), b]);
        }
        marks::line(canvas, &steps, Line::Faint, GREY)?;

        // Names of the front first: they are what the figure is about.
        let mut order = front.clone();
        order.extend((0..self.points.len()).filter(|i| !front.contains(i)));
        let points: Vec<_> =
            order.iter().map(|&i| shown(&self.points[i])).map(|(x, y)| (x / scale, y / scale)).collect();
        let names: Vec<String> = order.iter().map(|&i| self.name(&self.points[i], &y)).collect();
        let style = |i: usize| canvas.text(LABEL, look(self.points[i].kind).0, HPos::Left, VPos::Top);
        let sizes =
            order.iter().zip(&names).map(|(&i, name)| Ok((canvas.width(name, &style(i))? + 4, LABEL as i32 + 4)));
        let sizes = sizes.collect::<Result<Vec<_>, String>>()?;
        let lines: Vec<Box2> = steps.windows(2).map(|ends| segment(ends[0], ends[1], scale)).collect();
        let placed = place(&points, &sizes, &lines, room);
        for ((&i, label), point) in order.iter().zip(&placed).zip(&points) {
            if let Some(to) = label.and_then(|l| l.leader) {
                let ends = vec![(point.0 * scale, point.1 * scale), (to.0 * scale, to.1 * scale)];
                let thin = canvas.stroke(look(self.points[i].kind).0.mix(0.5), 1);
                canvas.area.draw(&PathElement::new(ends, thin)).map_err(|e| e.to_string())?;
            }
        }
        for ((&i, label), name) in order.iter().zip(&placed).zip(&names) {
            if let Some(label) = label {
                canvas.write(name, &style(i), (label.at.x0 + 2, label.at.y0))?;
            }
        }
        for &i in order.iter().rev() {
            let (colour, mark, _) = look(self.points[i].kind);
            marks::mark(canvas, shown(&self.points[i]), mark, colour)?;
        }
        Ok(())
    }

    /// With its value where the axis does not reach so far.
    fn name(&self, point: &Point, y: &Range<f64>) -> String {
        match y.contains(&point.value) {
            true => point.name.clone(),
            false => format!("{} ({})", point.name, padded(point.value, 3)),
        }
    }
}

/// A stretch of the front, in units.
fn segment(a: (i32, i32), b: (i32, i32), scale: i32) -> Box2 {
    let (x0, x1) = (a.0.min(b.0) / scale, a.0.max(b.0) / scale);
    let (y0, y1) = (a.1.min(b.1) / scale, a.1.max(b.1) / scale);
    Box2 { x0: x0 - 1, y0: y0 - 1, x1: x1 + 2, y1: y1 + 2 }
}

/// 1, 2 and 5 of every decade, or the powers of ten alone where these would be many.
fn time_ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = range.start.floor() as i32..=range.end.ceil() as i32;
    let of: &[f64] = if range.end - range.start > 5.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let ticks = decades.flat_map(|d| of.iter().map(move |m| f64::from(d) + m.log10()));
    ticks.filter(|t| range.contains(t)).collect()
}

/// Four to ten round values.
fn linear_ticks(range: &Range<f64>) -> Vec<f64> {
    let span = range.end - range.start;
    let base = 10f64.powf((span / 4.0).log10().floor());
    let step = [5.0, 2.0, 1.0].map(|m| m * base).into_iter().find(|s| span / s >= 4.0).unwrap_or(base);
    let (first, last) = ((range.start / step).ceil() as i64, (range.end / step).floor() as i64);
    (first..=last.min(first + 20)).map(|i| i as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(time_ticks(&(0.0..1.5)).len(), 5);
        for (range, first) in [(43.0..57.0, 44.0), (0.0..1.0, 0.0), (997.0..1003.0, 997.0), (2.0..2.9, 2.0)] {
            let ticks = linear_ticks(&range);
            assert!((4..=11).contains(&ticks.len()), "{range:?}: {ticks:?}");
            assert!((ticks[0] - first).abs() < 1e-9, "{range:?}: {ticks:?}");
        }
    }

    #[test]
    fn a_few_bad_values_do_not_squeeze_the_others() {
        let point = |value| Point { name: String::new(), kind: Kind::Modern, ms: 1.0, value };
        let points: Vec<Point> = [44.0, 45.0, 46.0, 47.0, 48.0, 49.0, 50.0, 188.0].map(point).into();
        let panel = |more_is_better, points| Panel { title: String::new(), y_label: "", more_is_better, points };
        let values = panel(false, points.clone()).values();
        assert!(values.end < 55.0 && values.start > 40.0, "{values:?}");
        let inverse = points.iter().map(|p| point(1.0 / p.value)).collect();
        let values = panel(true, inverse).values();
        assert!(values.start > 1.0 / 55.0 && values.end > 1.0 / 44.0, "{values:?}");
    }
}
