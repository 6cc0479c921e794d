//! Charts against the branching factor: panels of lines, side by side over one legend.

use crate::report::figures::axis::{Axis, Scale};
use crate::report::figures::canvas::{Canvas, Drawing, Drawn};
use crate::report::figures::legend::{self, Entry};
use crate::report::figures::marks;
use crate::report::printed::Model;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

pub(crate) const INK: RGBColor = RGBColor(34, 34, 34);
pub(crate) const GREY: RGBColor = RGBColor(90, 90, 90);
pub(crate) const GRID: RGBColor = RGBColor(222, 222, 222);

/// Colours that stay apart for colour-blind readers, one a model (after Okabe and Ito 2008, the last two darkened).
pub(crate) const fn colour(model: Model) -> RGBColor {
    match model {
        Model::Tiny => RGBColor(86, 180, 233),
        Model::Small => RGBColor(230, 159, 0),
        Model::Med => RGBColor(0, 158, 115),
        Model::Large => RGBColor(0, 90, 178),
        Model::Huge => RGBColor(204, 61, 110),
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// Unbroken.
    Solid,
    /// Short strokes.
    Dotted,
    /// Long strokes, lighter.
    Dashed,
    /// Unbroken, thin and pale.
    Faint,
    /// Short strokes, thin and pale.
    FaintDotted,
}

/// How a point is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A filled disc.
    Disc,
    /// A ring.
    Ring,
    /// A filled square.
    Square,
    /// The outline of a square.
    Frame,
    /// A triangle that points up.
    Up,
    /// A cross.
    Cross,
    /// A small pale disc.
    Speck,
}

/// One line of a panel.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    /// Gives the colour.
    pub model: Model,
    /// The stroke.
    pub line: Line,
    /// Branching factor, value, mark.
    pub points: Vec<(usize, f64, Mark)>,
}

/// A chart.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Above it.
    pub title: String,
    /// Beside its axis.
    pub y_label: &'static str,
    /// Its lines.
    pub series: Vec<Series>,
}

/// A horizontal line to read values against.
#[derive(Clone, Debug)]
pub(crate) struct Rule {
    /// Where.
    pub value: f64,
    /// What it says, written on the line.
    pub label: &'static str,
}

/// A whole figure.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    /// Side by side.
    pub panels: Vec<Panel>,
    /// Common to the panels.
    pub scale: Scale,
    /// In every panel.
    pub rules: Vec<Rule>,
    /// Below the panels, in rows.
    pub legend: Vec<Vec<Entry>>,
    /// Below the legend, one line each.
    pub notes: Vec<String>,
}

const WIDTH: u32 = 1600;
const PANEL_HEIGHT: i32 = 780;
const LEGEND_ROW: i32 = 40;
const NOTE_ROW: i32 = 28;

impl Drawing for Sheet {
    fn size(&self) -> (u32, u32) {
        let below = LEGEND_ROW * self.legend.len() as i32 + NOTE_ROW * self.notes.len() as i32 + 30;
        (WIDTH, (PANEL_HEIGHT + below) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        let (top, _) = canvas.area.split_vertically(canvas.px(PANEL_HEIGHT));
        for (panel, area) in self.panels.iter().zip(top.split_evenly((1, self.panels.len()))) {
            self.draw_panel(panel, &area, canvas)?;
        }
        let mut y = PANEL_HEIGHT + LEGEND_ROW / 2;
        for row in &self.legend {
            legend::draw_row(canvas, row, WIDTH as i32, y)?;
            y += LEGEND_ROW;
        }
        let style = canvas.text(20, GREY, HPos::Center, VPos::Center);
        for note in &self.notes {
            canvas.write(note, &style, (WIDTH as i32 / 2, y))?;
            y += NOTE_ROW;
        }
        Ok(())
    }
}

impl Sheet {
    fn draw_panel<DB: DrawingBackend>(
        &self,
        panel: &Panel,
        area: &DrawingArea<DB, Shift>,
        canvas: &Canvas<DB>,
    ) -> Drawn {
        let range = self.scale.range();
        let mut chart = ChartBuilder::on(area)
            .margin(canvas.px(14))
            .margin_top(canvas.px(62))
            .margin_right(canvas.px(30))
            .x_label_area_size(canvas.px(72))
            .y_label_area_size(canvas.px(self.scale.label_width()))
            .build_cartesian_2d(Axis::new(0.7..3.3, vec![1.0, 2.0, 3.0]), Axis::new(range.clone(), self.scale.ticks()))
            .map_err(|e| e.to_string())?;
        let labels = canvas.text(24, INK, HPos::Center, VPos::Center);
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(canvas.stroke(GRID.to_rgba(), 1))
            .axis_style(canvas.stroke(GREY.to_rgba(), 1))
            .label_style(labels.clone())
            .axis_desc_style(labels)
            .x_desc("Branching factor")
            .y_desc(panel.y_label)
            .x_label_formatter(&|x| format!("{}", 2f64.powf(*x)))
            .y_label_formatter(&|y| self.scale.label(*y))
            .set_all_tick_mark_size(canvas.px(6))
            .draw()
            .map_err(|e| e.to_string())?;

        // Lines and marks are drawn in pixels, by the code that draws the legend's samples too.
        let at = |x: f64, value: f64| chart.backend_coord(&(x, self.scale.place(value)));
        let (left, right) = (at(0.7, self.scale.value(range.start)), at(3.3, self.scale.value(range.start)));
        let middle = (left.0 + right.0) / 2 / canvas.scale as i32;
        let bold = canvas.text(28, INK, HPos::Center, VPos::Center);
        canvas.write(&panel.title, &bold, (middle, 34))?;
        let small = canvas.text(19, GREY, HPos::Left, VPos::Bottom);
        for rule in &self.rules {
            let y = at(1.0, rule.value).1;
            marks::line(canvas, &[(left.0, y), (right.0, y)], Line::Dashed, GREY)?;
            let scale = canvas.scale as i32;
            canvas.write(rule.label, &small, (left.0 / scale + 10, y / scale - 5))?;
        }
        for series in &panel.series {
            let place = |p: &(usize, f64, Mark)| at((p.0 as f64).log2(), p.1);
            let path: Vec<_> = series.points.iter().map(place).collect();
            marks::line(canvas, &path, series.line, colour(series.model))?;
        }
        for series in &panel.series {
            for point in &series.points {
                let position = at((point.0 as f64).log2(), point.1);
                marks::mark(canvas, position, point.2, colour(series.model))?;
            }
        }
        Ok(())
    }
}
