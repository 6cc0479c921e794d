//! Figure 3: the thesis' largest scene, rendered once and kept beside the rows.

use crate::build::{self, BuildOptions, Counters, Input};
use crate::render::{Frame, Stage, StageError, StageOptions};
use crate::rows::{RowError, write_whole};
use crate::scene::{Scene, SceneError};
use image::ImageFormat;
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

/// Renders `figure3.png` into the folder of the rows, unless a whole one is there; it never stands there in part.
///
/// # Errors
/// [`PictureError`].
pub fn figure3(rows: &Path) -> Result<(), PictureError> {
    let path = rows.join("figure3.png");
    if image::open(&path).is_ok() {
        return Ok(());
    }
    std::fs::create_dir_all(rows).map_err(|source| RowError::Io { what: "create", path: rows.into(), source })?;
    let scene = Scene::load(SCENE)?;
    let builder = build::find("top-down").expect("it is registered");
    let bvh = (builder.counted)(Input::of_boxes(&scene.boxes()), &BuildOptions::default(), &mut Counters::default())?;
    let stage = Stage::new(&scene, &bvh, &StageOptions::default())?;
    let picture = stage.render(&scene.camera.upright(), &Frame { width: 900, height: 900, rays_per_pixel: 9 });
    let picture = picture.film.to_srgb(stage.exposure(&picture.film));
    let mut png = Vec::new();
    picture
        .write_to(&mut Cursor::new(&mut png), ImageFormat::Png)
        .map_err(|source| PictureError::Encode { path: path.clone(), source })?;
    write_whole(&path, &png).map_err(PictureError::Write)
}
