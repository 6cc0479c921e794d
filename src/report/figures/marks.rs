//! Marks: lines and points in backend pixels, the same in panels and in the legend.

use crate::report::figures::canvas::{Canvas, Drawn};
use crate::report::figures::chart::{Line, Mark};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// A position in backend pixels.
type BackendCoord = (i32, i32);

const STROKE: u32 = 3;
const RADIUS: i32 = 7;
/// Opacity of what lies behind.
const FAINT: f64 = 0.4;

/// A line through points given in backend pixels.
///
/// # Errors
/// The backend's.
pub(crate) fn line<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    path: &[BackendCoord],
    line: Line,
    colour: RGBColor,
) -> Drawn {
    let style = canvas.stroke(colour.to_rgba(), STROKE);
    let path = path.iter().copied();
    let faint = canvas.stroke(colour.mix(FAINT), STROKE - 1);
    let drawn = match line {
        Line::Faint => canvas.area.draw(&PathElement::new(path.collect::<Vec<_>>(), faint)),
        Line::FaintDotted => canvas.area.draw(&DashedPathElement::new(path, canvas.px(3), canvas.px(7), faint)),
        Line::Solid => canvas.area.draw(&PathElement::new(path.collect::<Vec<_>>(), style)),
        Line::Dotted => canvas.area.draw(&DashedPathElement::new(path, canvas.px(4), canvas.px(7), style)),
        Line::Dashed => {
            let thin = canvas.stroke(colour.mix(0.75), STROKE - 1);
            canvas.area.draw(&DashedPathElement::new(path, canvas.px(14), canvas.px(9), thin))
        }
    };
    drawn.map_err(|e| e.to_string())
}

/// A point's mark at a position in backend pixels.
///
/// # Errors
/// The backend's.
pub(crate) fn mark<DB: DrawingBackend>(canvas: &Canvas<DB>, at: BackendCoord, mark: Mark, colour: RGBColor) -> Drawn {
    let stroke = canvas.stroke(colour.to_rgba(), STROKE);
    let radius = canvas.px(RADIUS);
    let area = canvas.area;
    let drawn = match mark {
        Mark::Disc => area.draw(&Circle::new(at, radius, colour.filled())),
        Mark::Ring => area
            .draw(&Circle::new(at, radius, WHITE.filled()))
            .and_then(|()| area.draw(&Circle::new(at, radius, stroke))),
        Mark::Square => area.draw(&Rectangle::new(square(at, radius), colour.filled())),
        Mark::Frame => {
            let [(x0, y0), (x1, y1)] = square(at, radius);
            let corners = vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)];
            area.draw(&Rectangle::new([(x0, y0), (x1, y1)], WHITE.filled()))
                .and_then(|()| area.draw(&PathElement::new(corners, stroke)))
        }
        Mark::Up => {
            let side = radius * 5 / 4;
            let corners = [(0, -side), (side, side * 3 / 4), (-side, side * 3 / 4), (0, -side)];
            let corners: Vec<_> = corners.iter().map(|(x, y)| (at.0 + x, at.1 + y)).collect();
            area.draw(&Polygon::new(corners.clone(), WHITE.filled()))
                .and_then(|()| area.draw(&PathElement::new(corners, stroke)))
        }
        Mark::Speck => area.draw(&Circle::new(at, radius * 4 / 7, colour.mix(FAINT).filled())),
        Mark::Cross => [1, -1].into_iter().try_for_each(|slope| {
            let arm = radius * 6 / 7;
            let ends = vec![(at.0 - arm, at.1 - slope * arm), (at.0 + arm, at.1 + slope * arm)];
            area.draw(&PathElement::new(ends, stroke))
        }),
    };
    drawn.map_err(|e| e.to_string())
}

fn square(at: BackendCoord, half: i32) -> [BackendCoord; 2] {
    [(at.0 - half, at.1 - half), (at.0 + half, at.1 + half)]
}
