//! Builders side by side: what rows of a comparison say, over all its scenes.

pub(crate) mod advice;
pub(crate) mod means;
pub(crate) mod originals;

use crate::report::figures::Figures;
use crate::report::files::Folder;
use crate::report::page::{self, compare::Findings};
use crate::report::{COMPARISON_PAGE, ReportError};
use crate::rows::{CompareRow, RowError, Status, read};
use std::path::Path;

/// All rows of a comparison.
#[derive(Debug)]
pub(crate) struct Comparison {
    /// In the order in which they were measured.
    pub rows: Vec<CompareRow>,
    /// Their scenes, in that order.
    pub scenes: Vec<String>,
}

/// What trees must have in common for their costs to compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Class {
    /// The most children of a node.
    pub arity: usize,
    /// The most triangles in a leaf.
    pub leaf_limit: usize,
}

impl Class {
    /// Of a row.
    pub fn of(row: &CompareRow) -> Self {
        Self { arity: row.arity, leaf_limit: row.leaf_limit }
    }
}

/// Where a contestant comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A construction of the thesis, with a reading.
    Original,
    /// A modern builder.
    Modern,
    /// A modern builder and steps that refine its tree.
    Refined,
    /// A tree from a file.
    File,
}

impl Kind {
    /// Of a row.
    pub fn of(row: &CompareRow) -> Self {
        match () {
            () if row.builder == "file" => Self::File,
            () if !row.preset.is_empty() => Self::Original,
            () if row.recipe.contains('+') => Self::Refined,
            () => Self::Modern,
        }
    }
}

/// One contestant on all scenes where it has figures.
#[derive(Clone, Debug)]
pub(crate) struct Entrant<'a> {
    /// What it is called here.
    pub label: String,
    /// Its rows, at most one a scene, all of them `ok`.
    pub rows: Vec<&'a CompareRow>,
}

impl Comparison {
    /// Reads the rows of a folder.
    ///
    /// # Errors
    /// Rows that cannot be read.
    pub fn read(rows_dir: &Path) -> Result<Self, RowError> {
        Ok(Self::of(read(rows_dir)?))
    }

    /// Of these rows.
    pub fn of(rows: Vec<CompareRow>) -> Self {
        let mut scenes: Vec<String> = Vec::new();
        for row in &rows {
            if !scenes.contains(&row.scene) {
                scenes.push(row.scene.clone());
            }
        }
        Self { rows, scenes }
    }

    /// Rows that failed their verification.
    pub fn errors(&self) -> usize {
        self.rows.iter().filter(|r| r.status == Status::Error).count()
    }

    /// Writes figures, table and page; without rows, what an earlier report left of them goes. `study` says that the study's page
    /// stands beside this one.
    ///
    /// # Errors
    /// A drawing that fails, the file system's.
    pub fn write(&self, folder: &mut Folder, study: bool) -> Result<(), ReportError> {
        const TABLE: &str = "tables/compare.csv";
        let figures = Figures::of_comparison(self)?;
        figures.write(folder)?;
        folder.remove_others("figures", "compare-")?;
        if self.rows.is_empty() {
            folder.remove(TABLE)?;
            return folder.remove(COMPARISON_PAGE);
        }
        let means = means::means(self);
        folder.write(TABLE, means::csv_text(&means).as_bytes())?;
        let (counsel, originals) = (advice::counsel(self), originals::originals(self));
        let (counsel, originals) = (&counsel, originals.as_ref());
        let findings = Findings { comparison: self, counsel, means: &means, originals, study };
        folder.write(COMPARISON_PAGE, page::compare::html(&findings, &figures).as_bytes())
    }

    /// The rows of a scene.
    pub fn of_scene<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a CompareRow> {
        self.rows.iter().filter(move |r| r.scene == scene)
    }

    /// A scene's name where there is little room: of a path, the file, unless two have the same.
    pub fn short<'a>(&self, scene: &'a str) -> &'a str {
        let file = |s: &'a str| s.rsplit(['/', '\\']).next().unwrap_or(s);
        let shared = self.scenes.iter().filter(|s| s.rsplit(['/', '\\']).next() == Some(file(scene))).count() > 1;
        if shared { scene } else { file(scene) }
    }

    /// The classes, in the order of the rows.
    pub fn classes(&self) -> Vec<Class> {
        let mut classes = Vec::new();
        for class in self.rows.iter().map(Class::of) {
            if !classes.contains(&class) {
                classes.push(class);
            }
        }
        classes
    }

    /// The class of most rows: the one that costs are told of where only one can be.
    pub fn main_class(&self) -> Option<Class> {
        let rows = |class: &Class| self.rows.iter().filter(|r| Class::of(r) == *class).count();
        self.classes().into_iter().rev().max_by_key(rows)
    }

    /// A contestant's name, with arity and leaf limit where the rows have several.
    pub fn label(&self, row: &CompareRow) -> String {
        let mut label = row.name();
        if self.rows.iter().any(|r| r.arity != row.arity) {
            label.push_str(&format!(", arity {}", row.arity));
        }
        // The thesis' own leaves have a limit of their own whatever is asked for.
        if self.rows.iter().any(|r| r.leaf_limit != row.leaf_limit) {
            label.push_str(&format!(", leaves of {}", row.leaf_limit));
        }
        label
    }

    /// The contestants in the order of the rows, each with its finished rows.
    pub fn entrants(&self) -> Vec<Entrant<'_>> {
        let mut entrants: Vec<Entrant> = Vec::new();
        for row in &self.rows {
            let label = self.label(row);
            let known = entrants.iter_mut().find(|e| e.label == label);
            let finished = row.status == Status::Ok;
            match known {
                Some(entrant) => entrant.rows.extend(finished.then_some(row)),
                None => entrants.push(Entrant { label, rows: finished.then_some(row).into_iter().collect() }),
            }
        }
        entrants
    }
}

/// Milliseconds of a finished build.
pub(crate) fn build_ms(row: &CompareRow) -> Option<f64> {
    positive(row.build_ms)
}

/// Nanoseconds a ray takes, half of the rays primary and half diffuse; all of them primary where nothing is seen.
pub(crate) fn ray_ns(row: &CompareRow) -> Option<f64> {
    let ns = |mrays: Option<f64>| positive(mrays).map(|m| 1e3 / m);
    match (ns(row.primary_mrays), ns(row.diffuse_mrays)) {
        (Some(primary), Some(diffuse)) => Some(0.5 * (primary + diffuse)),
        (Some(primary), None) if row.diffuse_rays == 0 => Some(primary),
        _ => None,
    }
}

/// Million rays per second, of that mixture.
pub(crate) fn mrays(row: &CompareRow) -> Option<f64> {
    ray_ns(row).map(|ns| 1e3 / ns)
}

/// Inner nodes and leaves.
pub(crate) fn nodes(row: &CompareRow) -> Option<f64> {
    Some((row.inner? + row.leaves?) as f64)
}

/// Bytes of the tree for each triangle of the scene.
pub(crate) fn bytes_a_triangle(row: &CompareRow) -> Option<f64> {
    positive(Some(row.bytes? as f64 / row.triangles as f64))
}

/// The most bytes that a build holds for each triangle of the scene.
pub(crate) fn peak_bytes_a_triangle(row: &CompareRow) -> Option<f64> {
    positive(Some(row.peak_bytes? as f64 / row.triangles as f64))
}

/// What a ratio or a logarithm can be taken of.
pub(crate) fn positive(x: Option<f64>) -> Option<f64> {
    x.filter(|x| x.is_finite() && *x > 0.0)
}

/// The geometric mean; `None` of none.
pub(crate) fn geometric_mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.into_iter().fold((0.0, 0usize), |(sum, n), x| (sum + x.ln(), n + 1));
    (n > 0).then(|| (sum / n as f64).exp())
}

/// Which of the points (x, y), the less of both the better, no other one beats in both: from the left to the right.
pub(crate) fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < best;
        best = best.min(points[i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fronts_hold_what_nothing_beats() {
        let points = [(1.0, 9.0), (2.0, 9.0), (2.0, 5.0), (3.0, 6.0), (4.0, 1.0), (4.0, 2.0), (0.5, 10.0)];
        assert_eq!(front(&points), [6, 0, 2, 4]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn means_are_geometric() {
        assert_eq!(geometric_mean([]), None);
        assert!((geometric_mean([1.0, 4.0, 16.0]).unwrap() - 4.0).abs() < 1e-12);
    }
}
