//! Scenes from files, told apart by their endings.

mod obj;
#[cfg(test)]
mod tests;
mod text;
mod tri;

use super::error::one_line;
use super::{Camera, Dropped, Material, Object, Scene, SceneError};
use crate::geom::Triangle;
use std::io;
use std::path::Path;

/// A kind of file a scene can be read from.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// The ending, without its dot; upper and lower case are the same.
    pub extension: &'static str,
    /// One line about it.
    pub summary: &'static str,
    read: fn(&Path, &[u8]) -> Result<Parts, SceneError>,
}

/// Every format.
pub const FORMATS: &[Format] = &[
    Format {
        extension: "obj",
        summary: "Wavefront OBJ, with its MTL files; polygons are triangulated, normals and textures not read",
        read: obj::read,
    },
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
    dropped: Dropped,
    warnings: Vec<String>,
}

/// Reads the scene in a file; its name is the path, its camera sees all of it.
///
/// Triangles with a NaN or infinite vertex are dropped and counted; degenerate ones are kept.
///
/// # Errors
/// [`SceneError::Unreadable`] where the system refuses, [`SceneError::Malformed`] for an ending that is none of
/// [`FORMATS`] or a file that is not what its ending says, [`SceneError::Empty`] where no triangle is left.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let unreadable = |source: io::Error| SceneError::Unreadable { path: path.to_owned(), source };
    if std::fs::metadata(path).map_err(unreadable)?.is_dir() {
        return Err(malformed(path, None, "this is a directory; name a file in it"));
    }
    let format = format_of(path).ok_or_else(|| {
        let known: Vec<_> = FORMATS.iter().map(|format| format!(".{}", format.extension)).collect();
        malformed(path, None, format!("no known format; give a file ending in {}", known.join(" or ")))
    })?;
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let parts = (format.read)(path, &bytes)?;
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
        dropped: parts.dropped,
        warnings: parts.warnings,
        camera: Camera::framing(&crate::geom::Aabb::EMPTY),
    };
    scene.camera = Camera::framing(&scene.bounds());
    Ok(scene)
}

/// The format of a path's ending, if it is known.
pub(super) fn format_of(path: &Path) -> Option<&'static Format> {
    let extension = path.extension()?;
    FORMATS.iter().find(|format| extension.eq_ignore_ascii_case(format.extension))
}

fn what_was_there(dropped: &Dropped) -> String {
    let counted = |count: usize, what: &str| (count > 0).then(|| format!("{count} {what}"));
    let found: Vec<String> = [
        counted(dropped.not_finite, "triangles with a NaN or infinite vertex"),
        counted(dropped.points_and_lines, "points and lines"),
    ]
    .into_iter()
    .flatten()
    .collect();
    if found.is_empty() { String::new() } else { format!(" (only {})", found.join(" and ")) }
}

fn malformed(path: &Path, line: Option<usize>, reason: impl Into<String>) -> SceneError {
    SceneError::Malformed { path: path.to_owned(), line, reason: reason.into() }
}
