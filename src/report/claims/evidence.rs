//! What claims are decided by: rows and printed numbers, looked up by tree.

use crate::report::cells::Study;
use crate::report::experiments::Experiments;
use crate::report::growth::Growth;
use crate::report::number::{padded, percent};
use crate::report::printed::{self, Model};
use crate::rows::{BuildRow, Construction, Lighting, Status, TraceRow, WorkRow};

/// So few models decide nothing about growth, or about all of them.
const ENOUGH: usize = 3;

/// One tree of the thesis' study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tree {
    /// Over which model.
    pub model: Model,
    /// How it was built.
    pub construction: Construction,
    /// Children per inner node.
    pub arity: usize,
}

/// The trees that are the same over all models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind(pub Construction, pub usize);

impl Kind {
    /// The one over a model.
    pub const fn of(self, model: Model) -> Tree {
        Tree { model, construction: self.0, arity: self.1 }
    }

    /// Such as `top-down 4`.
    pub fn name(self) -> String {
        format!("{} {}", self.0.id(), self.1)
    }
}

/// Top-down trees of this arity.
pub(crate) const fn top_down(arity: usize) -> Kind {
    Kind(Construction::TopDown, arity)
}

/// Bottom-up trees of this arity.
pub(crate) const fn bottom_up(arity: usize) -> Kind {
    Kind(Construction::BottomUp, arity)
}

/// All six kinds.
pub(crate) const KINDS: [Kind; 6] = [top_down(2), top_down(4), top_down(8), bottom_up(2), bottom_up(4), bottom_up(8)];

/// Rows and printed numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence<'a> {
    /// Rows of the study.
    pub study: &'a Study,
    /// Rows about growth.
    pub growth: &'a Growth,
}

impl<'a> Evidence<'a> {
    /// Rows of experiments.
    pub fn experiments(&self) -> Experiments<'a> {
        Experiments(&self.study.experiments)
    }

    /// The build of one engine, whatever its end.
    pub fn build(&self, preset: &str, engine: &str, tree: Tree) -> Option<&BuildRow> {
        let rows = self.study.builds_of(preset, tree.model, tree.construction, tree.arity);
        rows.into_iter().find(|r| r.engine == engine)
    }

    /// Seconds of a build: measured, else projected.
    pub fn seconds(&self, preset: &str, engine: &str, tree: Tree) -> Option<f64> {
        let row = self.build(preset, engine, tree)?;
        let ms = match row.status {
            Status::Ok => row.build_ms,
            Status::Projected => row.projected_ms,
            Status::Capped | Status::Error => None,
        };
        positive(ms).map(|ms| ms / 1e3)
    }

    /// A finished traversal.
    pub fn trace(&self, preset: &str, tree: Tree, lighting: Lighting) -> Option<&TraceRow> {
        let scene = tree.model.scene();
        self.study.traces.iter().find(|r| {
            r.status == Status::Ok
                && r.preset == preset
                && r.scene == scene
                && (r.construction, r.arity, r.lighting) == (tree.construction, tree.arity, lighting)
        })
    }

    /// Nodes per pixel.
    pub fn nodes(&self, preset: &str, tree: Tree, lighting: Lighting) -> Option<f64> {
        positive(self.trace(preset, tree, lighting)?.nodes_per_pixel)
    }

    /// Microseconds per pixel, primary rays.
    pub fn time(&self, preset: &str, tree: Tree) -> Option<f64> {
        positive(self.trace(preset, tree, Lighting::Primary)?.us_per_pixel)
    }

    /// A printed number, corrected where it is.
    pub fn printed(&self, table: u8, tree: Tree) -> Option<f64> {
        printed_cell(table, tree)?.reference().map(|f| f.value)
    }

    /// Elementary steps of the thesis' program for a tree: box unions (top-down), steps of its kd-tree or pairs (bottom-up).
    pub fn work(&self, preset: &str, tree: Tree) -> Option<f64> {
        let scene = tree.model.scene();
        let is = |r: &&WorkRow| (&*r.preset, r.construction, r.arity) == (preset, tree.construction, tree.arity);
        let row = self.growth.work.iter().filter(is).find(|r| r.scene == scene)?;
        positive(row.literal_unions.or(row.original_steps.map(|n| n as f64)).or(row.literal_steps))
    }
}

/// The printed cell of a tree.
pub(crate) fn printed_cell(table: u8, tree: Tree) -> Option<&'static printed::Printed> {
    let key = (table, tree.model, Some(tree.construction), Some(tree.arity));
    printed::cells().iter().find(|c| (c.table, c.model, c.construction, c.arity) == key)
}

fn positive(x: Option<f64>) -> Option<f64> {
    x.filter(|x| x.is_finite() && *x > 0.0)
}

/// A quantity over the models for which it is known, by growing size.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ByModel(pub Vec<(Model, f64)>);

impl ByModel {
    /// Takes it wherever `of` knows it.
    pub fn of(of: impl Fn(Model) -> Option<f64>) -> Self {
        Self(Model::ALL.into_iter().filter_map(|m| Some((m, of(m)?))).collect())
    }

    /// Whether it says something about size.
    pub fn is_enough(&self) -> bool {
        self.0.len() >= ENOUGH
    }

    /// Its values.
    pub fn values(&self) -> impl DoubleEndedIterator<Item = f64> + '_ {
        self.0.iter().map(|(_, x)| *x)
    }

    /// Whether all values are so.
    pub fn all(&self, is: impl Fn(f64) -> bool) -> bool {
        self.values().all(is)
    }

    /// Whether values never fall.
    pub fn rises(&self) -> bool {
        self.values().collect::<Vec<_>>().is_sorted()
    }

    /// The middle value; noise of single times does not move it far. NaN of none.
    pub fn median(&self) -> f64 {
        median(self.values())
    }

    /// Least and greatest.
    pub fn range(&self) -> (f64, f64) {
        range(self.values())
    }

    /// "least to greatest", to so many significant digits.
    pub fn span(&self, digits: i32) -> String {
        span(self.range(), digits)
    }

    /// Triangles and value, for fits.
    pub fn points(&self) -> Vec<(f64, f64)> {
        self.0.iter().map(|(m, x)| (triangles(*m), *x)).collect()
    }

    /// As figures.
    pub fn labelled(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.0.iter().map(|(m, x)| (m.id(), *x))
    }
}

/// Triangles of a model, as printed in Table 1.
pub(crate) fn triangles(model: Model) -> f64 {
    printed::cells().iter().find(|c| c.model == model).map_or(0.0, |c| c.size as f64)
}

/// Least and greatest of some values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// The middle one of some values; NaN of none.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

/// A range in words.
pub(crate) fn span((low, high): (f64, f64), digits: i32) -> String {
    match (padded(low, digits), padded(high, digits)) {
        (a, b) if a == b => a,
        (a, b) => format!("{a} to {b}"),
    }
}

/// Mean of some values; none of none.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), x| (sum + x, n + 1.0));
    (n > 0.0).then(|| sum / n)
}

/// Mean distance of ratios from 1, as a factor less 1: exp(mean |ln ratio|) − 1.
pub(crate) fn distance(ratios: impl Iterator<Item = f64>) -> Option<f64> {
    mean(ratios.map(|r| r.ln().abs())).map(|d| d.exp() - 1.0)
}

/// A range of ratios as changes in percent.
pub(crate) fn changes((low, high): (f64, f64)) -> String {
    format!("{} to {}", percent(low), percent(high))
}
