//! Figures 3, 4 and 5, and those about growth: each drawn once, by code that does not know whether it draws SVG or pixels.

mod axis;
mod build_times;
pub(crate) mod canvas;
pub(crate) mod chart;
pub(crate) mod curves;
mod experiments;
mod extended;
mod labels;
pub(crate) mod legend;
mod loglog;
mod marks;
mod nodes;
mod pareto;
mod picture;
mod scaling;
mod why;

use crate::report::cells::Study;
use crate::report::comparison::Comparison;
use crate::report::experiments::Experiments;
use crate::report::files::Folder;
use crate::report::growth::Growth;
use crate::report::growth::laws::Residual;
use crate::report::page::compare::figure_name;
use crate::report::{PRESETS, ReportError};
use canvas::{Drawing, Rendered};
use std::path::Path;

/// The figures of a report by file name, in page order; `None` where the rows hold nothing to draw.
#[derive(Debug)]
pub(crate) struct Figures {
    all: Vec<(String, Option<Rendered>)>,
    /// Whose rows they are drawn from.
    commit: String,
}

impl Figures {
    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Option<&Rendered>)> {
        self.all.iter().map(|(name, rendered)| (name.as_str(), rendered.as_ref()))
    }

    /// Writes them in both formats; what was not drawn goes, if an earlier report left it.
    ///
    /// # Errors
    /// The file system's.
    pub fn write(&self, folder: &mut Folder) -> Result<(), ReportError> {
        for (name, rendered) in self.iter() {
            for (ending, bytes) in [("svg", rendered.map(|r| r.svg.as_bytes())), ("png", rendered.map(|r| &r.png[..]))]
            {
                let file = format!("figures/{name}.{ending}");
                match bytes {
                    Some(bytes) => folder.write(&file, bytes)?,
                    None => folder.remove(&file)?,
                }
            }
        }
        Ok(())
    }

    /// The commit whose program measured what they are drawn from.
    pub fn commit(&self) -> &str {
        &self.commit
    }

    /// The one of this name, where it was drawn.
    pub fn get(&self, name: &str) -> Option<&Rendered> {
        self.iter().find(|(n, _)| *n == name).and_then(|(_, rendered)| rendered)
    }
}

/// Draws one figure that stands on a page of its own.
///
/// # Errors
/// A drawing that fails.
pub(crate) fn rendered(name: &str, drawing: &impl Drawing) -> Result<Rendered, ReportError> {
    canvas::render(name, drawing)
}

/// Draws everything the rows allow. Figures of the headline preset are always drawn: they show the printed numbers at least.
///
/// # Errors
/// A picture that is not a PNG; a drawing that fails.
pub(crate) fn draw_all(study: &Study, rows_dir: &Path) -> Result<Figures, ReportError> {
    let pictures =
        ["figure3", "figure3-lit", "wrong-pixels"].map(|name| Ok((name.to_owned(), picture::picture(rows_dir, name)?)));
    let mut figures = pictures.into_iter().collect::<Result<Vec<_>, ReportError>>()?;
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
    Ok(Figures { all: figures, commit: study.commit().to_owned() })
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
        self.add("why", why::why(residuals))?;
        let rows = Experiments(&study.experiments);
        self.add("lookup", experiments::lookup(rows))?;
        self.add("candidates", experiments::candidates(rows))
    }

    /// Those of builders side by side, one a scene and class.
    ///
    /// # Errors
    /// A drawing that fails.
    pub fn of_comparison(comparison: &Comparison) -> Result<Self, ReportError> {
        let commit = comparison.rows.first().map_or(String::new(), |r| r.commit.clone());
        let mut figures = Self { all: Vec::new(), commit };
        for (i, scene) in comparison.scenes.iter().enumerate() {
            for class in comparison.classes() {
                figures.add(&figure_name(i, class), pareto::sheet(comparison, scene, class))?;
            }
        }
        Ok(figures)
    }

    fn add(&mut self, name: &str, sheet: Option<impl Drawing>) -> Result<(), ReportError> {
        let rendered = sheet.map(|s| canvas::render(name, &s)).transpose()?;
        self.all.push((name.to_owned(), rendered));
        Ok(())
    }
}
