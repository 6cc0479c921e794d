//! Figures 3, 4 and 5: each drawn once, by code that does not know whether it draws SVG or pixels.

mod axis;
mod build_times;
mod canvas;
mod chart;
mod legend;
mod marks;
mod nodes;
mod picture;

use crate::report::cells::Study;
use crate::report::{PRESETS, ReportError};
use canvas::Rendered;
use std::path::Path;

/// The figures of a report by file name, in page order; `None` where the rows hold nothing to draw.
#[derive(Debug)]
pub(crate) struct Figures(Vec<(String, Option<Rendered>)>);

impl Figures {
    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Option<&Rendered>)> {
        self.0.iter().map(|(name, rendered)| (name.as_str(), rendered.as_ref()))
    }

    /// The one of this name, where it was drawn.
    pub fn get(&self, name: &str) -> Option<&Rendered> {
        self.iter().find(|(n, _)| *n == name).and_then(|(_, rendered)| rendered)
    }
}

/// Draws everything the rows allow. Figures of the headline preset are always drawn: they show the printed numbers at least.
///
/// # Errors
/// A picture that is not a PNG; a drawing that fails.
pub(crate) fn draw_all(study: &Study, rows_dir: &Path) -> Result<Figures, ReportError> {
    let mut figures = vec![("figure3".to_owned(), picture::figure3(rows_dir)?)];
    for preset in PRESETS {
        let headline = preset == PRESETS[0];
        let name = |figure: &str| match headline {
            true => figure.to_owned(),
            false => format!("{figure}_{preset}"),
        };
        let wanted = headline || study.has(preset);
        for (figure, draw) in
            [("figure4", build_times::figure4 as fn(&Study, &str) -> chart::Sheet), ("figure5", nodes::figure5)]
        {
            let rendered = match wanted {
                true => Some(canvas::render(&name(figure), &draw(study, preset))?),
                false => None,
            };
            figures.push((name(figure), rendered));
        }
    }
    Ok(Figures(figures))
}
