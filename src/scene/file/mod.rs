//! Scenes from files, told apart by their endings; `.gz` and `.zst` behind them are unpacked on the way.

mod gltf;
mod mesh;
mod obj;
mod ply;
mod polygon;
mod source;
mod stl;
#[cfg(test)]
mod tests;
mod text;
mod tri;

use super::error::one_line;
use super::{Camera, Dropped, Material, NamedCamera, Object, Scene, SceneError};
use crate::geom::Triangle;
use glam::Vec2;
use source::{Packing, Source};
use std::io;
use std::path::Path;

pub use source::LoadProgress;

/// A kind of file a scene can be read from.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// The ending, without its dot; upper and lower case are the same.
    pub extension: &'static str,
    /// One line about it.
    pub summary: &'static str,
    read: fn(&mut Source<'_>) -> Result<Parts, SceneError>,
}

/// Every format.
pub const FORMATS: &[Format] = &[
    Format {
        extension: "obj",
        summary: "Wavefront OBJ, with its MTL files and textures; polygons are triangulated, normals not read",
        read: obj::read,
    },
    Format {
        extension: "ply",
        summary: "Stanford polygons, text or binary: vertices, faces and triangle strips",
        read: ply::read,
    },
    Format { extension: "stl", summary: "stereolithography, text or binary", read: stl::read },
    Format { extension: "gltf", summary: "glTF 2.0: nodes, materials, textures, cameras", read: gltf::read },
    Format { extension: "glb", summary: "glTF 2.0 in one binary file", read: gltf::read },
    Format {
        extension: "tri",
        summary: "raw triangles: little-endian f32, nine a triangle, no header",
        read: tri::read,
    },
];

/// What a reader finds in a file.
struct Parts {
    triangles: Vec<Triangle>,
    objects: Vec<Object>,
    materials: Vec<Material>,
    material_ids: Vec<u16>,
    texture_coordinates: Vec<[Vec2; 3]>,
    cameras: Vec<NamedCamera>,
    dropped: Dropped,
    warnings: Vec<String>,
}

/// Reads the scene in a file; its name is the path, its camera the file's first, or else one that sees all of it.
///
/// Triangles with a NaN or infinite vertex are dropped and counted; degenerate ones are kept.
///
/// # Errors
/// [`SceneError::Unreadable`] where the system refuses, [`SceneError::Malformed`] for an ending that is none of
/// [`FORMATS`] or a file that is not what its ending says, [`SceneError::Empty`] where no triangle is left.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_watched(path, &mut |_, _| {})
}

/// As [`load`]; `progress` is told every few hundred kilobytes how many bytes of the file have been read, of how many.
///
/// # Errors
/// As [`load`].
pub fn load_watched(path: &Path, progress: &mut LoadProgress<'_>) -> Result<Scene, SceneError> {
    let unreadable = |source: io::Error| SceneError::Unreadable { path: path.to_owned(), source };
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(malformed(path, None, "this is a directory; name a file in it"));
    }
    let format = format_of(path).ok_or_else(|| {
        let known: Vec<_> = FORMATS.iter().map(|format| format!(".{}", format.extension)).collect();
        malformed(path, None, format!("no known format; give a file ending in {}", known.join(" or ")))
    })?;
    let mut tell = |done: u64, size: u64| progress(done, size);
    let parts = (format.read)(&mut Source::new(path, metadata.len(), &mut tell))?;
    let name = path.display().to_string();
    if parts.triangles.is_empty() {
        return Err(SceneError::Empty { detail: what_was_there(&parts.dropped), name: one_line(path) });
    }
    let mut scene = Scene {
        name,
        triangles: parts.triangles,
        objects: parts.objects,
        materials: parts.materials,
        material_ids: parts.material_ids,
        texture_coordinates: parts.texture_coordinates,
        dropped: parts.dropped,
        warnings: parts.warnings,
        camera: Camera::framing(&crate::geom::Aabb::EMPTY),
        cameras: parts.cameras,
    };
    scene.camera = match scene.cameras.first() {
        Some(named) => named.camera,
        None => Camera::framing(&scene.bounds()),
    };
    Ok(scene)
}

/// The format of a path's ending, or of the one before `.gz` or `.zst`, if it is known.
pub(super) fn format_of(path: &Path) -> Option<&'static Format> {
    let inner = match Packing::of(path) {
        Some(_) => path.file_stem().map(Path::new)?,
        None => path,
    };
    let extension = inner.extension()?;
    FORMATS.iter().find(|format| extension.eq_ignore_ascii_case(format.extension))
}

fn what_was_there(dropped: &Dropped) -> String {
    if dropped.total() == 0 { String::new() } else { format!(" (only {dropped})") }
}

fn malformed(path: &Path, line: Option<usize>, reason: impl Into<String>) -> SceneError {
    SceneError::Malformed { path: path.to_owned(), line, reason: reason.into() }
}

/// A fault of a text, as the error it is.
fn unreadable(path: &Path, fault: text::Fault) -> SceneError {
    match fault {
        text::Fault::Io(source) => SceneError::Unreadable { path: path.to_owned(), source },
        text::Fault::Encoding(told) => malformed(path, None, told),
    }
}

/// A library's message as one short line.
fn told(message: &dyn std::fmt::Display) -> String {
    const LONGEST: usize = 200;
    let text = message.to_string();
    let words: Vec<_> = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|w| !w.is_empty()).collect();
    let line = words.join(" ");
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}
