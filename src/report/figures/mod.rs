//! Figures 3, 4 and 5, and those about growth: each drawn once, by code that does not know whether it draws SVG or pixels.

mod axis;
mod build_times;
mod canvas;
mod chart;
mod extended;
mod labels;
mod legend;
mod loglog;
mod marks;
mod nodes;
mod pareto;
mod picture;
mod scaling;
mod why;

use crate::report::cells::Study;
use crate::report::comparison::Comparison;
use crate::report::growth::Growth;
use crate::report::growth::laws::Residual;
use crate::report::page::compare::figure_name;
use crate::report::{PRESETS, ReportError};
use canvas::{Drawing, Rendered};
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

impl Figures {
    /// Draws those about growth besides: Figure 4 extended, time and work against size, predicted against taken.
    ///
    /// # Errors
    /// A drawing that fails.
    pub fn extend(&mut self, study: &Study, growth: &Growth, residuals: &[Residual]) -> Result<(), ReportError> {
        for preset in PRESETS {
            let suffix = if preset == PRESETS[0] { String::new() } else { format!("_{preset}") };
            self.add(&format!("figure4-extended{suffix}"), extended::figure4(study, preset))?;
        }
        self.add("scaling-time", scaling::time(growth))?;
        self.add("scaling-work", scaling::work(growth))?;
        self.add("why", why::why(residuals))
    }

    /// Those of builders side by side, one a scene and class.
    ///
    /// # Errors
    /// A drawing that fails.
    pub fn of_comparison(comparison: &Comparison) -> Result<Self, ReportError> {
        let mut figures = Self(Vec::new());
        for (i, scene) in comparison.scenes.iter().enumerate() {
            for class in comparison.classes() {
                figures.add(&figure_name(i, class), pareto::sheet(comparison, scene, class))?;
            }
        }
        Ok(figures)
    }

    fn add(&mut self, name: &str, sheet: Option<impl Drawing>) -> Result<(), ReportError> {
        let rendered = sheet.map(|s| canvas::render(name, &s)).transpose()?;
        self.0.push((name.to_owned(), rendered));
        Ok(())
    }
}
