//! Charts of a quantity against what it costs: a logarithmic axis below, a linear one beside, names at the points.

use crate::report::figures::axis::{Axis, Scale};
use crate::report::figures::canvas::{Canvas, Drawing, Drawn};
use crate::report::figures::chart::{GREY, GRID, INK, Line, Mark};
use crate::report::figures::legend::{self, Entry};
use crate::report::figures::marks;
use crate::report::number::{grouped, significant};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// Points of one method.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub colour: RGBColor,
    /// The stroke through its points, if any.
    pub line: Option<Line>,
    /// x above 0, y, mark.
    pub points: Vec<(f64, f64, Mark)>,
    /// What stands beside each point; may be empty.
    pub names: Vec<String>,
}

/// A chart.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    pub title: String,
    pub x_label: &'static str,
    pub y_label: &'static str,
    pub curves: Vec<Curve>,
}

/// A whole figure.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    /// In rows of two.
    pub panels: Vec<Panel>,
    /// Below the panels, in rows.
    pub legend: Vec<Vec<Entry>>,
    /// Below the legend, one line each.
    pub notes: Vec<String>,
}

const WIDTH: i32 = 1600;
const PANEL_HEIGHT: i32 = 560;
const LEGEND_ROW: i32 = 40;
const NOTE_ROW: i32 = 28;
const COLUMNS: usize = 2;

impl Drawing for Sheet {
    fn size(&self) -> (u32, u32) {
        let below = LEGEND_ROW * self.legend.len() as i32 + NOTE_ROW * self.notes.len() as i32 + 30;
        (WIDTH as u32, (self.panels_height() + below) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        let (top, _) = canvas.area.split_vertically(canvas.px(self.panels_height()));
        let rows = self.panels.len().div_ceil(COLUMNS);
        let areas = top.split_evenly((rows, self.panels.len().min(COLUMNS)));
        for (panel, area) in self.panels.iter().zip(areas) {
            panel.draw(&area, canvas)?;
        }
        let mut y = self.panels_height() + LEGEND_ROW / 2;
        for row in &self.legend {
            legend::draw_row(canvas, row, WIDTH, y)?;
            y += LEGEND_ROW;
        }
        let style = canvas.text(20, GREY, HPos::Center, VPos::Center);
        for note in &self.notes {
            canvas.write(note, &style, (WIDTH / 2, y))?;
            y += NOTE_ROW;
        }
        Ok(())
    }
}

impl Sheet {
    fn panels_height(&self) -> i32 {
        PANEL_HEIGHT * self.panels.len().div_ceil(COLUMNS) as i32
    }
}

fn drawable(point: &(f64, f64, Mark)) -> bool {
    point.0.is_finite() && point.0 > 0.0 && point.1.is_finite()
}

impl Panel {
    /// Whether anything can be drawn.
    pub fn has_points(&self) -> bool {
        self.curves.iter().flat_map(|c| &c.points).any(drawable)
    }

    fn span(&self, of: fn(&(f64, f64, Mark)) -> f64) -> (f64, f64) {
        let values = self.curves.iter().flat_map(|c| &c.points).filter(|p| drawable(p)).map(of);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low <= high { (low, high) } else { (1.0, 1.0) }
    }

    /// Decades of x, with room for names at the right.
    fn x(&self) -> Range<f64> {
        let (low, high) = self.span(|p| p.0.log10());
        let margin = (0.08 * (high - low)).max(0.05);
        low - margin..high + 1.5 * margin
    }

    /// y, with a margin; from 0 where 0 is near.
    fn y(&self) -> Range<f64> {
        let (low, high) = self.span(|p| p.1);
        let margin = (0.1 * (high - low)).max(0.02 * high.abs()).max(1e-3);
        let from = if low >= 0.0 && low < 0.35 * high { 0.0_f64.min(low - margin) } else { low - margin };
        from..high + margin
    }

    /// Round numbers within the decades: 1, 2 and 5 of each, 1 alone where there are many, more where there is less than one.
    fn x_ticks(range: &Range<f64>) -> Vec<f64> {
        let of_decade: &[f64] = match range.end - range.start {
            decades if decades > 2.5 => &[1.0],
            decades if decades > 0.7 => &[1.0, 2.0, 5.0],
            _ => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
        };
        let decades = range.start.floor() as i32..=range.end.ceil() as i32;
        let all = decades.flat_map(|d| of_decade.iter().map(move |m| m.log10() + f64::from(d)));
        all.filter(|t| range.contains(t)).collect()
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, canvas: &Canvas<DB>) -> Drawn {
        let (x, y) = (self.x(), self.y());
        let mut ticks = fine_ticks(&y);
        // The margin below nothing has none.
        let (least, _) = self.span(|p| p.1);
        ticks.retain(|&tick| least < 0.0 || tick >= 0.0);
        let mut chart = ChartBuilder::on(area)
            .margin(canvas.px(12))
            .margin_top(canvas.px(58))
            .margin_right(canvas.px(34))
            .x_label_area_size(canvas.px(70))
            .y_label_area_size(canvas.px(124))
            .build_cartesian_2d(Axis::new(x.clone(), Self::x_ticks(&x)), Axis::new(y.clone(), ticks))
            .map_err(|e| e.to_string())?;
        let labels = canvas.text(23, INK, HPos::Center, VPos::Center);
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(canvas.stroke(GRID.to_rgba(), 1))
            .axis_style(canvas.stroke(GREY.to_rgba(), 1))
            .label_style(labels.clone())
            .axis_desc_style(labels)
            .x_desc(self.x_label)
            .y_desc(self.y_label)
            .x_label_formatter(&|t| grouped(&significant(10f64.powf(*t), 2)))
            .y_label_formatter(&|t| grouped(&significant(*t, 4)))
            .set_all_tick_mark_size(canvas.px(6))
            .draw()
            .map_err(|e| e.to_string())?;
        let at = |(px, py): (f64, f64)| chart.backend_coord(&(px, py));
        let scale = canvas.scale as i32;
        let middle = (at((x.start, y.start)).0 + at((x.end, y.start)).0) / 2 / scale;
        let top = at((x.start, y.end)).1 / scale;
        canvas.write(&self.title, &canvas.text(27, INK, HPos::Center, VPos::Center), (middle, top - 26))?;
        let place = |p: &(f64, f64, Mark)| at((p.0.log10(), p.1));
        for curve in &self.curves {
            let path: Vec<_> = curve.points.iter().filter(|p| drawable(p)).map(place).collect();
            if let Some(line) = curve.line {
                marks::line(canvas, &path, line, curve.colour)?;
            }
        }
        // A name that would lie on another one is left out; the table has it.
        let mut written: Vec<(i32, i32)> = Vec::new();
        for curve in &self.curves {
            let style = canvas.text(19, curve.colour, HPos::Left, VPos::Bottom);
            for (point, name) in curve.points.iter().zip(&curve.names).filter(|(p, _)| drawable(p)) {
                let (px, py) = place(point);
                marks::mark(canvas, (px, py), point.2, curve.colour)?;
                let to = (px / scale + 9, py / scale - 6);
                let room = 14 + 11 * name.chars().count() as i32;
                let is_free = |w: &(i32, i32)| (w.0 - to.0).abs() > room || (w.1 - to.1).abs() > 20;
                if !name.is_empty() && written.iter().all(is_free) {
                    canvas.write(name, &style, to)?;
                    written.push(to);
                }
            }
        }
        Ok(())
    }
}

/// Ticks of a linear axis whose range may be below 1: about eight, 0 among them where it is in the range.
fn fine_ticks(range: &Range<f64>) -> Vec<f64> {
    let span = range.end - range.start;
    let factor = 10f64.powf((8.0 / span).log10().ceil());
    let ticks = Scale::Linear(range.start * factor..range.end * factor).ticks();
    let every = ticks.len().div_ceil(9).max(1);
    let step = ticks.get(1).map_or(1.0, |second| second - ticks[0]);
    let is_kept = |tick: &f64| (tick / step).round() as i64 % every as i64 == 0;
    ticks.into_iter().filter(is_kept).map(|t| t / factor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: &[(f64, f64)]) -> Panel {
        let points = points.iter().map(|&(x, y)| (x, y, Mark::Disc)).collect();
        let curve = Curve { colour: INK, line: None, points, names: Vec::new() };
        Panel { title: String::new(), x_label: "", y_label: "", curves: vec![curve] }
    }

    #[test]
    fn ranges_hold_all_points_and_ticks_are_few() {
        for points in
            [&[(1.0, 20.0), (60.0, 22.0)][..], &[(2.0, 0.0)], &[(3.0, 0.25), (3.1, 0.43)], &[(1.0, 2e5), (9e4, 1.0)]]
        {
            let panel = panel(points);
            let (x, y) = (panel.x(), panel.y());
            assert!(panel.has_points());
            for p in points {
                assert!(x.contains(&p.0.log10()) && (y.contains(&p.1)), "{p:?} {x:?} {y:?}");
            }
            let ticks = fine_ticks(&y);
            assert!((2..=12).contains(&ticks.len()), "{y:?}: {ticks:?}");
            assert!(!y.contains(&0.0) || ticks.contains(&0.0), "{y:?}: {ticks:?}");
            assert!(Panel::x_ticks(&x).len() <= 10);
        }
        assert!(!panel(&[(-1.0, 2.0), (1.0, f64::NAN)]).has_points());
    }
}
