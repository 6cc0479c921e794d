//! Figure 3: the thesis' largest scene, as it is and in materials and light of ours, rendered once and kept beside the rows.

use super::dressing::dressed;
use crate::build::{self, Brake, BuildOptions, Input};
use crate::render::{Frame, Stage, StageError, StageOptions};
use crate::rows::{RowError, write_whole};
use crate::scene::{Scene, SceneError};
use image::{ImageFormat, RgbImage};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The scene of the thesis' Figure 3.
const SCENE: &str = "thesis:huge";

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The scene could not be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No tree was built over it.
    #[error("{SCENE}: {0}")]
    Build(#[from] build::BuildError),
    /// It was not made ready.
    #[error("{SCENE}: {0}")]
    Stage(#[from] StageError),
    /// The file system refused.
    #[error(transparent)]
    Write(#[from] RowError),
    /// The picture could not be encoded.
    #[error("cannot write {path}: {source}", path = path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder said.
        source: image::ImageError,
    },
}

/// Renders `figure3.png` and `figure3-lit.png` into the folder of the rows, unless whole ones are there; they never stand there in
/// part.
///
/// # Errors
/// [`PictureError`].
pub fn figure3(rows: &Path) -> Result<(), PictureError> {
    std::fs::create_dir_all(rows).map_err(|source| RowError::Io { what: "create", path: rows.into(), source })?;
    let as_it_is = Frame { width: 900, height: 900, rays_per_pixel: 9 };
    once(&rows.join("figure3.png"), || taken(&Scene::load(SCENE)?, &as_it_is))?;
    let lit = Frame { width: 640, height: 640, rays_per_pixel: 128 };
    once(&rows.join("figure3-lit.png"), || taken(&dressed(Scene::load(SCENE)?), &lit))
}

fn once(path: &Path, picture: impl FnOnce() -> Result<RgbImage, PictureError>) -> Result<(), PictureError> {
    if image::open(path).is_ok() {
        return Ok(());
    }
    let mut png = Vec::new();
    picture()?
        .write_to(&mut Cursor::new(&mut png), ImageFormat::Png)
        .map_err(|source| PictureError::Encode { path: path.into(), source })?;
    write_whole(path, &png).map_err(PictureError::Write)
}

/// A picture by the scene's own camera. The tree is one that is built in no time: it is how a picture is made, not what it shows.
fn taken(scene: &Scene, frame: &Frame) -> Result<RgbImage, PictureError> {
    let builder = build::find("binned-sah").expect("it is registered");
    let boxes = scene.boxes();
    let bvh = (builder.timed)(Input::of_boxes(&boxes), &BuildOptions::default(), &mut Brake::default())?;
    let stage = Stage::new(scene, &bvh, &StageOptions::default())?;
    let film = stage.render(&scene.camera.upright(), frame).film;
    Ok(film.to_srgb(stage.exposure(&film)))
}
