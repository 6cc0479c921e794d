//! Legend: samples of lines and marks with their names, in centred rows.

use crate::report::figures::canvas::{Canvas, Drawn};
use crate::report::figures::chart::{INK, Line, Mark};
use crate::report::figures::marks;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// One sample with its name.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    /// The stroke of the sample, if any.
    pub line: Option<Line>,
    /// The mark in its middle, if any.
    pub mark: Option<Mark>,
    /// Its colour.
    pub colour: RGBColor,
    /// Its name.
    pub text: String,
}

const SAMPLE: i32 = 64;
const MARK_ONLY: i32 = 20;
const GAP: i32 = 12;
const BETWEEN: i32 = 40;

impl Entry {
    fn sample_width(&self) -> i32 {
        if self.line.is_some() { SAMPLE } else { MARK_ONLY }
    }
}

/// Draws a row centred at height `y` (units).
///
/// # Errors
/// The backend's.
pub(crate) fn draw_row<DB: DrawingBackend>(canvas: &Canvas<DB>, row: &[Entry], width: i32, y: i32) -> Drawn {
    let style = canvas.text(23, INK, HPos::Left, VPos::Center);
    let widths = row
        .iter()
        .map(|entry| Ok(entry.sample_width() + GAP + canvas.width(&entry.text, &style)?))
        .collect::<Result<Vec<_>, String>>()?;
    let total = widths.iter().sum::<i32>() + BETWEEN * (row.len() as i32 - 1);
    let mut x = (width - total) / 2;
    for (entry, width) in row.iter().zip(widths) {
        let end = x + entry.sample_width();
        let (left, middle, right) = (canvas.px(x), canvas.px((x + end) / 2), canvas.px(end));
        if let Some(line) = entry.line {
            marks::line(canvas, &[(left, canvas.px(y)), (right, canvas.px(y))], line, entry.colour)?;
        }
        if let Some(mark) = entry.mark {
            marks::mark(canvas, (middle, canvas.px(y)), mark, entry.colour)?;
        }
        // Text centred by its box sits a little high beside a mark.
        canvas.write(&entry.text, &style, (end + GAP, y + 3))?;
        x += width + BETWEEN;
    }
    Ok(())
}
