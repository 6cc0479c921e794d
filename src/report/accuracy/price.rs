//! What watertight hits cost in time: every kernel that has a twin in f32 beside it, in one table.

use super::Accuracy;
use crate::rows::{AccuracyRow, Status};

/// A kernel and its fast twin on one kind of rays, over all scenes that have both.
#[derive(Debug, PartialEq)]
pub(crate) struct Price<'a> {
    /// The watertight one.
    pub kernel: &'a str,
    pub rays: &'a str,
    /// Scenes that have both.
    pub scenes: usize,
    /// Nanoseconds a ray, geometric mean: watertight, then fast.
    pub nanoseconds: [f64; 2],
    /// Wrong hits of the fast one in a million rays: missed, of another triangle, at a t that is off.
    pub wrong: [f64; 3],
    /// All wrong hits of the watertight one in a million.
    pub robust_wrong: f64,
}

impl Price<'_> {
    /// Time of the watertight kernel over that of the fast one.
    pub fn factor(&self) -> f64 {
        self.nanoseconds[0] / self.nanoseconds[1]
    }
}

/// All of them, in the order of the rows.
pub(crate) fn all(accuracy: &Accuracy) -> Vec<Price<'_>> {
    let rows: Vec<&AccuracyRow> =
        accuracy.rows.iter().filter(|r| r.study == "intersection" && r.status == Status::Ok).collect();
    let mut prices: Vec<Price> = Vec::new();
    for row in &rows {
        if prices.iter().any(|p| (p.kernel, p.rays) == (&row.method, &row.rays)) {
            continue;
        }
        let twin = format!("{}-fast", row.method);
        let same = rows.iter().copied().filter(|r| r.method == row.method && r.rays == row.rays);
        let with_twin = same.filter_map(|robust| {
            let is_twin = |r: &&AccuracyRow| r.method == twin && r.scene == robust.scene && r.rays == robust.rays;
            Some((robust, rows.iter().copied().find(is_twin)?))
        });
        let pairs: Vec<(&AccuracyRow, &AccuracyRow)> = with_twin.collect();
        prices.extend(price(row, &pairs));
    }
    prices
}

fn price<'a>(of: &'a AccuracyRow, pairs: &[(&AccuracyRow, &AccuracyRow)]) -> Option<Price<'a>> {
    let logs = |r: &AccuracyRow| r.mrays_per_s.filter(|&m| m > 0.0).map(|m| (1e3 / m).ln());
    let mean = |of: &[Option<f64>]| {
        let all: Option<Vec<f64>> = of.iter().copied().collect();
        let all = all.filter(|all| !all.is_empty())?;
        Some((all.iter().sum::<f64>() / all.len() as f64).exp())
    };
    let robust: Vec<_> = pairs.iter().map(|p| logs(p.0)).collect();
    let fast: Vec<_> = pairs.iter().map(|p| logs(p.1)).collect();
    let in_a_million = |rows: &[&AccuracyRow], of: fn(&AccuracyRow) -> Option<usize>| {
        let wrong: usize = rows.iter().map(|r| of(r)).sum::<Option<usize>>()?;
        let traced = rows.iter().map(|r| r.traced).sum::<Option<usize>>().filter(|&n| n > 0)?;
        Some(wrong as f64 / traced as f64 * 1e6)
    };
    let (robust_rows, fast_rows): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
    Some(Price {
        kernel: &of.method,
        rays: &of.rays,
        scenes: pairs.len(),
        nanoseconds: [mean(&robust)?, mean(&fast)?],
        wrong: [
            in_a_million(&fast_rows, |r| r.missed)?,
            in_a_million(&fast_rows, |r| r.other)?,
            in_a_million(&fast_rows, |r| r.off)?,
        ],
        robust_wrong: in_a_million(&robust_rows, |r| Some(r.missed? + r.other? + r.off?))?,
    })
}
