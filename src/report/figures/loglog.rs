//! Charts with two logarithmic axes: panels of series in a grid over one legend.

use crate::report::figures::axis::Axis;
use crate::report::figures::canvas::{Canvas, Drawing, Drawn};
use crate::report::figures::chart::{GREY, GRID, INK, Line, Mark};
use crate::report::figures::legend::{self, Entry};
use crate::report::figures::marks;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// One line of a panel, or points without a line.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// Its colour.
    pub colour: RGBColor,
    /// The stroke through its points, if any.
    pub line: Option<Line>,
    /// x, y, mark; those not above 0 are left out.
    pub points: Vec<(f64, f64, Mark)>,
}

/// A straight line behind the series: a power of x.
#[derive(Clone, Debug)]
pub(crate) struct Guide {
    /// Its exponent.
    pub slope: f64,
    /// A point that it passes.
    pub through: (f64, f64),
    /// What it says, at its upper end.
    pub label: &'static str,
}

/// A chart.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Above it.
    pub title: String,
    /// Below its axis.
    pub x_label: &'static str,
    /// Beside its axis.
    pub y_label: &'static str,
    /// Behind everything.
    pub guides: Vec<Guide>,
    /// Its lines.
    pub series: Vec<Series>,
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
const PANEL_HEIGHT: i32 = 640;
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
            panel.draw(&area, canvas, panel.decades(|p| p.0), panel.decades(|p| p.1))?;
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

/// Whether a point has a place on logarithmic axes.
fn drawable(point: &(f64, f64, Mark)) -> bool {
    [point.0, point.1].iter().all(|v| v.is_finite() && *v > 0.0)
}

/// A power of ten, such as 10⁻³.
fn power_of_ten(exponent: f64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let superscript = |c: char| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]);
    match exponent as i64 {
        0 => "1".into(),
        1 => "10".into(),
        e => format!("10{}", e.to_string().chars().map(superscript).collect::<String>()),
    }
}

impl Panel {
    /// The decades that all points lie in, with a margin; whole ones where two powers of ten would not be among them.
    fn decades(&self, of: fn((f64, f64)) -> f64) -> Range<f64> {
        const MARGIN: f64 = 0.15;
        let points = self.series.iter().flat_map(|s| &s.points);
        let values = points.filter(|p| drawable(p)).map(|p| of((p.0, p.1)).log10());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if !(low.is_finite() && high.is_finite()) {
            return 0.0..1.0;
        }
        let (low, high) = (low - MARGIN, high + MARGIN);
        if high.floor() - low.ceil() >= 1.0 { low..high } else { low.floor()..high.ceil() }
    }

    fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        canvas: &Canvas<DB>,
        x: Range<f64>,
        y: Range<f64>,
    ) -> Drawn {
        let ticks = |r: &Range<f64>| (r.start.ceil() as i64..=r.end.floor() as i64).map(|t| t as f64).collect();
        let mut chart = ChartBuilder::on(area)
            .margin(canvas.px(12))
            .margin_top(canvas.px(58))
            .margin_right(canvas.px(34))
            .x_label_area_size(canvas.px(70))
            .y_label_area_size(canvas.px(104))
            .build_cartesian_2d(Axis::new(x.clone(), ticks(&x)), Axis::new(y.clone(), ticks(&y)))
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
            .x_label_formatter(&|t| power_of_ten(*t))
            .y_label_formatter(&|t| power_of_ten(*t))
            .set_all_tick_mark_size(canvas.px(6))
            .draw()
            .map_err(|e| e.to_string())?;
        let at = |(px, py): (f64, f64)| chart.backend_coord(&(px, py));
        let scale = canvas.scale as i32;
        let middle = (at((x.start, y.start)).0 + at((x.end, y.start)).0) / 2 / scale;
        canvas.write(
            &self.title,
            &canvas.text(27, INK, HPos::Center, VPos::Center),
            (middle, at((x.start, y.end)).1 / scale - 26),
        )?;
        for guide in &self.guides {
            let Some((from, to)) = guide.within(&x, &y) else { continue };
            marks::line(canvas, &[at(from), at(to)], Line::Faint, GREY)?;
            let (tx, ty) = at(to);
            let style = canvas.text(19, GREY, HPos::Right, VPos::Bottom);
            canvas.write(guide.label, &style, (tx / scale - 6, ty / scale + 22))?;
        }
        let place = |p: &(f64, f64, Mark)| at((p.0.log10(), p.1.log10()));
        for series in &self.series {
            let path: Vec<_> = series.points.iter().filter(|p| drawable(p)).map(place).collect();
            if let Some(line) = series.line {
                marks::line(canvas, &path, line, series.colour)?;
            }
        }
        for series in &self.series {
            for point in series.points.iter().filter(|p| drawable(p)) {
                marks::mark(canvas, place(point), point.2, series.colour)?;
            }
        }
        Ok(())
    }
}

impl Guide {
    /// Its ends inside the panel, in decades.
    fn within(&self, x: &Range<f64>, y: &Range<f64>) -> Option<((f64, f64), (f64, f64))> {
        let (px, py) = (self.through.0.log10(), self.through.1.log10());
        if !(px.is_finite() && py.is_finite()) {
            return None;
        }
        let height = |t: f64| py + self.slope * (t - px);
        let reach = |h: f64| px + (h - py) / self.slope;
        let from = x.start.max(reach(y.start));
        let to = x.end.min(reach(y.end));
        (from < to).then(|| ((from, height(from)), (to, height(to))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_ten_are_written_as_such() {
        assert_eq!([-3.0, 0.0, 1.0, 12.0].map(power_of_ten), ["10⁻³", "1", "10", "10¹²"]);
    }

    #[test]
    fn panels_end_close_to_their_points_and_name_two_powers() {
        let panel = |points: &[(f64, f64)]| Panel {
            title: String::new(),
            x_label: "",
            y_label: "",
            guides: Vec::new(),
            series: vec![Series {
                colour: INK,
                line: None,
                points: points.iter().map(|p| (p.0, p.1, Mark::Disc)).collect(),
            }],
        };
        let wide = panel(&[(1e3, 1.0), (1e6, 1.0)]).decades(|p| p.0);
        assert!((wide.start - 2.85).abs() < 1e-9 && (wide.end - 6.15).abs() < 1e-9);
        assert_eq!(panel(&[(300.0, 1.0)]).decades(|p| p.0), 2.0..3.0);
        assert_eq!(panel(&[(1e3, 1.0), (f64::INFINITY, 2.0), (-1.0, 2.0)]).decades(|p| p.1), -1.0..1.0);
        assert_eq!(panel(&[]).decades(|p| p.1), 0.0..1.0);
    }

    #[test]
    fn guides_end_at_the_panel() {
        let guide = Guide { slope: 1.0, through: (1e3, 1e1), label: "n" };
        assert_eq!(guide.within(&(3.0..6.0), &(0.0..3.0)), Some(((3.0, 1.0), (5.0, 3.0))));
        assert_eq!(guide.within(&(3.0..6.0), &(7.0..9.0)), None);
    }
}
