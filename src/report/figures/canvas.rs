//! Canvas: one drawing, two backends. SVG as it is; PNG drawn at twice its size and averaged down, for smooth edges.

use crate::report::ReportError;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::FontStyle;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::sync::Once;

/// The family as CSS reads it: SVG viewers without DejaVu fall back to its twin Verdana.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Pixels drawn per pixel kept, in each direction.
const OVERSAMPLING: u32 = 2;

/// A figure in both formats.
#[derive(Debug)]
pub(crate) struct Rendered {
    /// SVG source.
    pub svg: String,
    /// PNG bytes.
    pub png: Vec<u8>,
}

/// What the drawing code needs of an error: text.
pub(crate) type Drawn = Result<(), String>;

/// A drawing area whose lengths are given in units of the SVG, whatever the backend's resolution.
pub(crate) struct Canvas<'a, DB: DrawingBackend> {
    /// Where to draw, in backend pixels.
    pub area: &'a DrawingArea<DB, Shift>,
    /// Backend pixels per unit.
    pub scale: u32,
}

impl<DB: DrawingBackend> Canvas<'_, DB> {
    /// Units to backend pixels.
    pub fn px(&self, units: i32) -> i32 {
        units * self.scale as i32
    }

    /// A stroke of this width in units.
    pub fn stroke(&self, colour: RGBAColor, width: u32) -> ShapeStyle {
        ShapeStyle { color: colour, filled: false, stroke_width: width * self.scale }
    }

    /// A text style of this size in units.
    pub fn text(&self, size: u32, colour: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
        (FAMILY, size * self.scale).into_font().color(&colour).pos(Pos::new(h, v))
    }

    /// Writes text at a position in units.
    pub fn write(&self, text: &str, style: &TextStyle, (x, y): (i32, i32)) -> Drawn {
        self.area.draw_text(text, style, (self.px(x), self.px(y))).map_err(|e| e.to_string())
    }

    /// The width of a text in units.
    pub fn width(&self, text: &str, style: &TextStyle) -> Result<i32, String> {
        let (width, _) = self.area.estimate_text_size(text, style).map_err(|e| e.to_string())?;
        Ok(width.div_ceil(self.scale) as i32)
    }
}

/// A figure that draws itself on any canvas.
pub(crate) trait Drawing {
    /// Width and height in units.
    fn size(&self) -> (u32, u32);

    /// Draws it.
    ///
    /// # Errors
    /// The backend's.
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn;
}

/// Draws a sheet in both formats.
///
/// # Errors
/// What the backends say, under the figure's name.
pub(crate) fn render(name: &str, sheet: &impl Drawing) -> Result<Rendered, ReportError> {
    register_fonts();
    both(sheet).map_err(|reason| ReportError::Draw { figure: name.to_owned(), reason })
}

fn both(sheet: &impl Drawing) -> Result<Rendered, String> {
    let (width, height) = sheet.size();
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (width, height)).into_drawing_area();
        paint(sheet, &area, 1)?;
    }

    let (wide, high) = (width * OVERSAMPLING, height * OVERSAMPLING);
    let mut pixels = vec![0; (wide * high * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, (wide, high)).into_drawing_area();
        paint(sheet, &area, OVERSAMPLING)?;
    }
    let large = image::RgbImage::from_raw(wide, high, pixels).ok_or("the bitmap has another size than asked for")?;
    let small = image::imageops::thumbnail(&large, width, height);
    let mut png = std::io::Cursor::new(Vec::new());
    small.write_to(&mut png, image::ImageFormat::Png).map_err(|e| e.to_string())?;
    Ok(Rendered { svg, png: png.into_inner() })
}

fn paint<DB: DrawingBackend>(sheet: &impl Drawing, area: &DrawingArea<DB, Shift>, scale: u32) -> Drawn {
    area.fill(&WHITE).map_err(|e| e.to_string())?;
    sheet.draw(&Canvas { area, scale })?;
    area.present().map_err(|e| e.to_string())
}

fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for (style, bytes) in [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())] {
            // A font that were not registered would show as a drawing error at the first text.
            let _ = plotters::style::register_font(FAMILY, style, bytes);
        }
    });
}
