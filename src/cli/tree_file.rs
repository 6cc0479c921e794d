//! `--tree`: trees from files. `bvh-lab build SCENE --tree`: what one is worth, as it is or refitted to a scene that has moved.

use super::arguments::{BuildArguments, Recipe};
use super::build::{BuildReport, finish, load, milliseconds, repeats};
use super::output::{short, spread_text};
use super::{Failure, Outcome, off, wrong};
use bvh_lab::build::BuildOptions;
use bvh_lab::bvh::file::{self, FileError, SavedTree, UnfittedTree};
use bvh_lab::bvh::{Limits, validate_parts};
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::lab::{BuildCell, repeat};
use bvh_lab::refine::refit;
use bvh_lab::rows::Spread;
use bvh_lab::scene::Scene;
use serde::Serialize;
use std::path::Path;

/// What refitting did to a tree.
#[derive(Debug, Serialize)]
pub struct RefitReport {
    /// Time to refit, from triangles (boxes included).
    pub ms: Spread,
    /// Cost of the tree as the file has it, over the vertices it was built for.
    pub sah_before: Option<f64>,
    /// Cost after over cost before. Each is relative to the area of its own root, so this falls below 1 where the root grew more
    /// than what is below it; what the old topology costs is [`Self::growth_over_fresh`].
    pub growth: Option<f64>,
    /// The builder of a fresh tree of the same scene, if one was asked for; arity and leaf limit are those of the file.
    pub against: Option<String>,
    /// Its cost.
    pub fresh_sah: Option<f64>,
    /// Its build time.
    pub fresh_build_ms: Option<Spread>,
    /// Cost of the refitted tree over that of the fresh one.
    pub growth_over_fresh: Option<f64>,
}

impl RefitReport {
    /// Two lines for people.
    pub fn text(&self, after: Option<f64>) -> Vec<String> {
        let ratio = |x: Option<f64>| x.map_or_else(|| "–".into(), |x| format!("{x:.3}"));
        let cost = |x: Option<f64>| x.map_or_else(|| "–".into(), short);
        let (before, after) = (cost(self.sah_before), cost(after));
        let mut lines = vec![format!(
            "refit       {}; SAH {before} → {after}, {} times",
            spread_text(&self.ms, "ms"),
            ratio(self.growth)
        )];
        if let Some(builder) = &self.against {
            let (fresh, growth) = (cost(self.fresh_sah), ratio(self.growth_over_fresh));
            let built = self.fresh_build_ms.map_or_else(|| "–".into(), |ms| spread_text(&ms, "ms"));
            lines.push(format!(
                "fresh       {builder}: {built}; SAH {fresh}, of which the refitted tree costs {growth} times"
            ));
        }
        lines
    }
}

/// The tree in a file, checked against the scene.
pub fn read(path: &Path, scene: &Scene) -> Result<SavedTree, Failure> {
    file::read(path, &scene.triangles).map_err(wrong)
}

/// Runs `build SCENE --tree`.
pub fn run(a: &BuildArguments, path: &Path) -> Outcome {
    let scene = load(&a.scene)?;
    let (saved, refitted) = if a.refit {
        let (saved, report) = refit_file(a, path, &scene)?;
        (saved, Some(report))
    } else {
        (read(path, &scene)?, None)
    };
    let mut report = BuildReport::of_file(&scene, path, &saved);
    report.refit = refitted;
    finish(a, &scene, report, Some((&saved.bvh, &saved.limits)))
}

/// Reads a tree of a scene with as many triangles and gives it the boxes of this one.
fn refit_file(a: &BuildArguments, path: &Path, scene: &Scene) -> Result<(SavedTree, RefitReport), Failure> {
    let UnfittedTree { mut bvh, limits, scene: mark } = file::read_unfitted(path).map_err(wrong)?;
    if mark.triangles != scene.triangles.len() {
        let (path, built_for, here) = (path.display(), mark.triangles, scene.triangles.len());
        return Err(wrong(format!(
            "{path}: built for a scene of {built_for} triangles, and this one has {here}: only their vertices may have moved"
        )));
    }
    let against = match &a.against {
        Some(recipe) => Some(fresh_cell(a, recipe, &limits, bvh.arity)?),
        None => None,
    };
    let sah_before = sah(&bvh, SahParams::default());
    let seconds = repeat(&repeats(&a.run), || {
        refit(&mut bvh, &scene.boxes());
        Ok::<(), Failure>(())
    })?;
    let coverage = validate_parts(&bvh, &scene.triangles, &scene.boxes(), &limits)
        .map_err(|violations| wrong(FileError::Invalid { path: path.into(), violations }))?;
    let after = sah(&bvh, SahParams::default());
    let over = |below: Option<f64>| after.zip(below).filter(|(_, b)| *b > 0.0).map(|(a, b)| a / b);
    let mut report = RefitReport {
        ms: milliseconds(seconds),
        sah_before,
        growth: over(sah_before),
        against: None,
        fresh_sah: None,
        fresh_build_ms: None,
        growth_over_fresh: None,
    };
    if let Some(cell) = &against {
        let (fresh, _) = BuildReport::measure(scene, cell)?;
        report.against = Some(fresh.made_by());
        (report.fresh_sah, report.growth_over_fresh) = (fresh.sah, over(fresh.sah));
        report.fresh_build_ms = fresh.build_ms;
    }
    Ok((SavedTree { bvh, limits, coverage }, report))
}

/// A build of the same arity and leaf limit as the tree in the file.
fn fresh_cell(
    a: &BuildArguments,
    recipe: &Recipe,
    limits: &Limits,
    arity: usize,
) -> Result<BuildCell<'static>, Failure> {
    let Recipe { builder, refine } = *recipe;
    let plain = BuildOptions::default();
    let options = BuildOptions {
        arity,
        refine,
        preset: builder.presets.first().copied().unwrap_or(plain.preset),
        engine: builder.engines.first().copied().unwrap_or(plain.engine),
        max_leaf: builder.limits_leaves(&refine).then_some(limits.max_leaf),
        ..plain
    };
    builder.check(&options).map_err(off)?;
    Ok(BuildCell { builder, options, budget: None, repeats: repeats(&a.run) })
}
