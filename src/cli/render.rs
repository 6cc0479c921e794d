//! `bvh-lab render`: a picture, or a heat map of the work behind it.

use super::arguments::{HeatWord, RenderArguments};
use super::build::load;
use super::output::say;
use super::trace::tree;
use super::{Outcome, off, wrong};
use bvh_lab::scene::{Effect, effects, smooth_normals};
use bvh_lab::trace::{HeatMap, Kernel, Quantity, RenderOptions, render, upright};
use std::path::{Path, PathBuf};

/// Runs the command.
pub fn run(a: &RenderArguments) -> Outcome {
    let path = a.output.clone().unwrap_or_else(|| default_path(&a.scene));
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Err(off(format!("{}: pictures are written as .png", path.display())));
    }
    let scene = load(&a.scene)?;
    let bvh = tree(&scene, &a.tree)?;
    let camera = match &a.camera {
        Some(spec) => spec.apply(&scene.camera).map_err(off)?,
        None => upright(&scene.camera),
    };
    let (width, height) = a.size;
    let picture = match a.heatmap {
        None => {
            let options = RenderOptions { width, height, samples: a.samples, ..RenderOptions::default() };
            render(&scene, &smooth_normals(&scene), &bvh, &camera, &options)
        }
        Some(heat) => {
            let quantity = match heat {
                HeatWord::Nodes => Quantity::Nodes,
                HeatWord::Tests => Quantity::TriangleTests,
            };
            let map = HeatMap::trace(quantity, Kernel::Scalar, (&bvh, &scene.triangles), &camera, a.size);
            map.draw().map_err(wrong)?
        }
    };
    let left_out: Vec<_> = effects(&scene).iter().map(|e| e.effect).filter(|e| *e != Effect::Emission).collect();
    if !left_out.is_empty() && a.heatmap.is_none() {
        let names: Vec<_> = left_out.iter().map(|e| e.id()).collect();
        eprintln!("bvh-lab: {}: drawn without {}, which its materials call for", scene.name, names.join(", "));
    }
    picture.save(&path).map_err(|e| wrong(format!("cannot write {}: {e}", path.display())))?;
    say(&format!("{}: {} × {} pixels", path.display(), picture.width(), picture.height()))
}

/// The scene's name in the current folder: a colon becomes a dash, a file's folder and ending go.
fn default_path(scene: &str) -> PathBuf {
    let stem = match Path::new(scene).file_stem() {
        Some(stem) if Path::new(scene).extension().is_some() => stem.to_string_lossy().into_owned(),
        _ => scene.replace([':', '/', '\\'], "-"),
    };
    PathBuf::from(stem).with_extension("png")
}
