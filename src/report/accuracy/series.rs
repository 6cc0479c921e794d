//! Series: one method at all its settings, as factors over the setting that it is measured by, averaged over scenes.

use super::Accuracy;
use crate::rows::{AccuracyRow, Status};

/// One method at all its settings.
#[derive(Debug, PartialEq)]
pub(crate) struct Series<'a> {
    pub study: &'a str,
    pub method: &'a str,
    pub arity: usize,
    pub rays: &'a str,
    /// In rising order of the setting.
    pub points: Vec<Point>,
}

/// One setting: geometric means over scenes of its figures over those of the setting that its series is measured by.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    pub setting: Option<u32>,
    /// Scenes that have both.
    pub scenes: usize,
    /// Build time.
    pub time: Option<f64>,
    /// Cost.
    pub sah: Option<f64>,
    /// Rays per second.
    pub rate: Option<f64>,
    /// Bytes as stored.
    pub bytes: Option<f64>,
    /// Box tests per ray.
    pub boxes: Option<f64>,
    /// Wrong hits per million rays, over all scenes together: not a factor.
    pub wrong: Option<f64>,
    /// Decisions over all scenes together, and those of them that are not the exact ones.
    pub flips: Option<(usize, usize)>,
    /// The greatest relative excess of such a choice's cost.
    pub excess: Option<f64>,
}

/// All series, in the order of the rows.
pub(crate) fn all(accuracy: &Accuracy) -> Vec<Series<'_>> {
    let mut found: Vec<Series> = Vec::new();
    for row in &accuracy.rows {
        let is_same = |s: &Series| {
            (s.study, s.method, s.arity, s.rays)
                == (row.study.as_str(), row.method.as_str(), row.arity, row.rays.as_str())
        };
        if !found.iter().any(is_same) {
            let points = points(accuracy, row);
            found.push(Series { study: &row.study, method: &row.method, arity: row.arity, rays: &row.rays, points });
        }
    }
    found
}

/// What a study's settings are measured by: the method that has no setting, where the study has one; costs without rounding; the kernel `scalar`;
/// f32 for storage; else the series' own greatest setting.
pub(crate) fn zero_line<'a>(accuracy: &'a Accuracy, row: &AccuracyRow) -> Option<&'a AccuracyRow> {
    let group = accuracy.rows.iter().filter(|r| {
        r.status == Status::Ok
            && (&r.study, &r.scene, r.arity, &r.rays) == (&row.study, &row.scene, row.arity, &row.rays)
    });
    match row.study.as_str() {
        "intersection" => group.clone().find(|r| r.method == "scalar"),
        "decisions" => group.clone().find(|r| r.method == row.method && r.setting.is_none()),
        "planes" | "storage" => group.filter(|r| r.method == row.method).max_by_key(|r| r.setting),
        _ => group.clone().find(|r| r.setting.is_none()),
    }
}

fn points(accuracy: &Accuracy, of: &AccuracyRow) -> Vec<Point> {
    let key = |r: &AccuracyRow| (r.study.clone(), r.method.clone(), r.arity, r.rays.clone());
    let rows: Vec<&AccuracyRow> =
        accuracy.rows.iter().filter(|r| r.status == Status::Ok && key(r) == key(of)).collect();
    let mut settings: Vec<Option<u32>> = rows.iter().map(|r| r.setting).collect();
    settings.sort_unstable();
    settings.dedup();
    let point = |setting: Option<u32>| {
        let pairs: Vec<(&AccuracyRow, &AccuracyRow)> =
            rows.iter().filter(|r| r.setting == setting).filter_map(|r| Some((*r, zero_line(accuracy, r)?))).collect();
        let mean = |of: fn(&AccuracyRow) -> Option<f64>| {
            let logs: Option<Vec<f64>> = pairs.iter().map(|(a, b)| Some((of(a)? / of(b)?).ln())).collect();
            let logs = logs.filter(|l| !l.is_empty() && l.iter().all(|x| x.is_finite()))?;
            Some((logs.iter().sum::<f64>() / logs.len() as f64).exp())
        };
        let total = |of: fn(&AccuracyRow) -> Option<usize>| pairs.iter().map(|p| of(p.0)).sum::<Option<usize>>();
        let wrong = total(|r| Some(r.missed? + r.other? + r.off?));
        let traced = total(|r| r.traced).filter(|&n| n > 0);
        Point {
            setting,
            scenes: pairs.len(),
            time: mean(|r| r.build_ms),
            sah: mean(|r| r.sah),
            rate: mean(|r| r.mrays_per_s),
            bytes: mean(|r| r.bytes.map(|b| b as f64)),
            boxes: mean(|r| r.box_tests_per_ray),
            flips: total(|r| r.compared).zip(total(|r| r.different)),
            excess: pairs.iter().map(|p| p.0.largest_excess).max_by(|a, b| a.partial_cmp(b).expect("no NaN")).flatten(),
            wrong: wrong.zip(traced).map(|(wrong, traced)| wrong as f64 / traced as f64 * 1e6),
        }
    };
    settings.into_iter().map(point).filter(|p| p.scenes > 0).collect()
}
