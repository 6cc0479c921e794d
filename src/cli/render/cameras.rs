//! Which cameras a call of `render` asks for, and what their pictures are called.

use crate::cli::{Failure, off};
use bvh_lab::scene::{Camera, CameraError, CameraSpec, Scene};
use std::path::{Path, PathBuf};

/// The word for every camera of a file.
const ALL: &str = "all";

/// The cameras that `words` ask for; `own` where there are none.
pub fn chosen(words: &[String], scene: &Scene, own: &Camera) -> Result<Vec<Camera>, Failure> {
    if words.is_empty() {
        return Ok(vec![*own]);
    }
    let mut cameras = Vec::new();
    for word in words {
        if let Some(named) = scene.cameras.iter().find(|named| named.name == *word) {
            cameras.push(named.camera);
        } else if word == ALL && !scene.cameras.is_empty() {
            cameras.extend(scene.cameras.iter().map(|named| named.camera));
        } else {
            let refuse = |e: CameraError| {
                let told = e.to_string();
                off(format!("--camera: {}{}", told.strip_prefix("camera: ").unwrap_or(&told), known(scene)))
            };
            cameras.push(word.parse::<CameraSpec>().and_then(|spec| spec.apply(own)).map_err(refuse)?);
        }
    }
    Ok(cameras)
}

/// `; cameras of the file: a, b`, or nothing where it has none.
fn known(scene: &Scene) -> String {
    let names: Vec<_> = scene.cameras.iter().map(|named| named.name.escape_debug().to_string()).collect();
    if names.is_empty() { String::new() } else { format!("; cameras of the file: {}", names.join(", ")) }
}

/// What the `index`-th of `count` pictures is called: `path`, or with several a number behind its stem.
pub fn numbered(path: &Path, index: usize, count: usize) -> PathBuf {
    if count == 1 {
        return path.into();
    }
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!("{}-{}.{}", part(path.file_stem()), index + 1, part(path.extension())))
}
