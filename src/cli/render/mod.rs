//! `bvh-lab render`: a picture, or a heat map of the work behind it.

mod cameras;
mod explain;
mod heat;

use super::arguments::RenderArguments;
use super::build::load;
use super::output::{json, say};
use super::trace::tree;
use super::{Failure, Outcome, off, wrong};
use bvh_lab::bvh::Bvh;
use bvh_lab::render::{Frame, Stage, StageOptions};
use bvh_lab::scene::{Camera, Effect};
use cameras::{chosen, numbered};
use explain::Report;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Rays a pixel where nothing is asked for: noise of area lights takes more than edges do.
const RAYS_PER_PIXEL: u32 = 4;
const RAYS_PER_PIXEL_WITH_LIGHTS: u32 = 16;

/// Runs the command.
pub fn run(a: &RenderArguments) -> Outcome {
    let path = output(a)?;
    let scene = load(&a.scene)?;
    let bvh = tree(&scene, &a.tree)?;
    let options = StageOptions { demand: a.demand(), depth: a.depth, ..StageOptions::default() };
    let stage = Stage::new(&scene, &bvh, &options).map_err(wrong)?;
    let cameras = chosen(&a.camera, &scene, &stage.viewpoint())?;
    let paths: Vec<_> = (0..cameras.len()).map(|i| numbered(&path, i, cameras.len())).collect();
    if let Some(word) = a.heatmap {
        let trees = heat::trees(a, &scene, bvh)?;
        return cameras
            .iter()
            .zip(&paths)
            .try_for_each(|(camera, path)| heat::map(word, &trees, (&scene.triangles, camera), a.size, path));
    }
    for line in stage.warnings() {
        eprintln!("bvh-lab: {}: {line}", scene.name);
    }
    pictures(a, (&stage, &bvh), &options, &cameras, &paths)
}

fn output(a: &RenderArguments) -> Result<PathBuf, Failure> {
    let path = a.output.clone().unwrap_or_else(|| default_path(&a.scene));
    let is = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
    match (is("png"), is("exr"), a.heatmap) {
        (true, ..) | (_, true, None) => Ok(path),
        (_, true, Some(_)) => Err(off(format!("{}: heat maps are written as .png", path.display()))),
        _ => Err(off(format!("{}: pictures are written as .png or .exr", path.display()))),
    }
}

/// Takes a picture with each camera and tells of it.
fn pictures(
    a: &RenderArguments,
    (stage, bvh): (&Stage, &Bvh),
    options: &StageOptions,
    cameras: &[Camera],
    paths: &[PathBuf],
) -> Outcome {
    let default = if stage.effects().has(Effect::Shadow) { RAYS_PER_PIXEL_WITH_LIGHTS } else { RAYS_PER_PIXEL };
    let frame = Frame { width: a.size.0, height: a.size.1, rays_per_pixel: a.rays_per_pixel().unwrap_or(default) };
    let mut reports = Vec::new();
    for (camera, path) in cameras.iter().zip(paths) {
        let begin = Instant::now();
        let picture = stage.render(camera, &frame);
        let seconds = begin.elapsed().as_secs_f64();
        picture.film.save(path, stage.exposure(&picture.film) * a.exposure.exp2()).map_err(wrong)?;
        let mut report = Report::new(path, stage, &frame, &picture, seconds);
        if a.explain {
            report.force((stage.scene(), bvh), options, camera, &frame, &picture)?;
        }
        reports.push(report);
    }
    match (a.json, a.explain, reports.as_slice()) {
        (true, _, [one]) => json(one),
        (true, _, several) => json(&several),
        (_, true, reports) => say(&reports.iter().map(Report::text).collect::<Vec<_>>().join("\n\n")),
        _ => paths
            .iter()
            .try_for_each(|path| say(&format!("{}: {} × {} pixels", path.display(), frame.width, frame.height))),
    }
}

/// The scene's name in the current folder: a colon becomes a dash, a file's folder and ending go.
fn default_path(scene: &str) -> PathBuf {
    let stem = match Path::new(scene).file_stem() {
        Some(stem) if Path::new(scene).extension().is_some() => stem.to_string_lossy().into_owned(),
        _ => scene.replace([':', '/', '\\'], "-"),
    };
    PathBuf::from(stem).with_extension("png")
}
