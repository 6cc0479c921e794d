//! `render --heatmap`: the work behind each pixel, by one tree or by two side by side.

use crate::cli::arguments::{HeatWord, RenderArguments, TreeArguments};
use crate::cli::output::say;
use crate::cli::{Failure, Outcome, off, wrong};
use bvh_lab::build::{Brake, BuildOptions, Input};
use bvh_lab::bvh::Bvh;
use bvh_lab::geom::Triangle;
use bvh_lab::render::{HeatMap, Quantity, draw};
use bvh_lab::scene::{Camera, Scene};
use bvh_lab::trace::Kernel;
use std::path::Path;

/// The trees to be drawn, each with its name: `own`, and one by the builder of `--against`, of the same arity.
pub fn trees(a: &RenderArguments, scene: &Scene, own: Bvh) -> Result<Vec<(String, Bvh)>, Failure> {
    let arity = own.arity;
    let mut trees = vec![(name(&a.tree, arity)?, own)];
    if let Some(recipe) = &a.against {
        let options = BuildOptions { arity, refine: recipe.refine, ..BuildOptions::default() };
        let boxes = scene.boxes();
        let input = Input::of_triangles(&scene.triangles, &boxes);
        let bvh = (recipe.builder.timed)(input, &options, &mut Brake::default()).map_err(wrong)?;
        trees.push((format!("{}{}, arity {arity}", recipe.builder.id, recipe.refine), bvh));
    }
    Ok(trees)
}

fn name(tree: &TreeArguments, arity: usize) -> Result<String, Failure> {
    let what = match &tree.file {
        Some(path) => path.display().to_string(),
        None => format!("{}{}", tree.builder.builder.id, tree.options().map_err(off)?.refine),
    };
    Ok(format!("{what}, arity {arity}"))
}

/// Draws the maps of all trees into one picture.
pub fn map(
    word: HeatWord,
    trees: &[(String, Bvh)],
    (triangles, camera): (&[Triangle], &Camera),
    size: (u32, u32),
    path: &Path,
) -> Outcome {
    let quantity = match word {
        HeatWord::Nodes => Quantity::Nodes,
        HeatWord::Tests => Quantity::TriangleTests,
        HeatWord::Time => Quantity::Time,
    };
    let traced = |bvh| HeatMap::trace(quantity, Kernel::Scalar, (bvh, triangles), camera, size);
    let maps: Vec<_> = trees.iter().map(|(name, bvh)| (name.as_str(), traced(bvh))).collect();
    let drawn = draw(&maps.iter().map(|(name, map)| (*name, map)).collect::<Vec<_>>()).map_err(wrong)?;
    drawn.save(path).map_err(|e| wrong(format!("cannot write {}: {e}", path.display())))?;
    say(&format!("{}: {} × {} pixels", path.display(), drawn.width(), drawn.height()))
}
