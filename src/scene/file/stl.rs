//! STL: the binary form (50 bytes a triangle) and the text.
//!
//! Read here: the crate `stl_io` (0.11) takes a binary file whose header begins with `solid` for text, loses every solid
//! behind the first `endsolid`, refuses a file for one NaN, and names no line.

use super::mesh::Mesh;
use super::text::{self, Lines};
use super::{Parts, Source, malformed};
use crate::geom::Triangle;
use crate::scene::{Dropped, Material, SceneError};
use glam::Vec3;

/// Bytes before the first binary triangle: 80 of a free header, 4 of the count.
const HEADER: usize = 84;
/// Bytes of a binary triangle: a normal, three vertices, two bytes of anything.
const STRIDE: usize = 50;

pub(super) fn read(source: &mut Source<'_>) -> Result<Parts, SceneError> {
    let path = source.path;
    let bytes = source.bytes()?;
    let mut warnings = Vec::new();
    let mesh = if is_text(&bytes) {
        solids(&bytes, &mut warnings).map_err(|(line, reason)| malformed(path, line, reason))?
    } else {
        binary(&bytes, &mut warnings).map_err(|reason| malformed(path, None, reason))?
    };
    Ok(mesh.finish(vec![Material::default()], Dropped::default(), warnings))
}

/// Triangles that a binary file promises.
fn promised(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// Many a binary file begins with `solid`, too: it is one if it has the very size that it promises, or holds a NUL.
fn is_text(bytes: &[u8]) -> bool {
    let exact = promised(bytes).is_some_and(|count| count.checked_mul(STRIDE) == Some(bytes.len() - HEADER));
    let begins = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    begins && !exact && !bytes[..bytes.len().min(1024)].contains(&0)
}

fn binary(bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh, String> {
    let Some(count) = promised(bytes) else {
        return Err(format!("{} bytes are too few for an STL file", bytes.len()));
    };
    let (whole, _) = bytes[HEADER..].as_chunks::<STRIDE>();
    if whole.len() < count {
        return Err(format!("the file ends after {} of {count} triangles; fetch it anew", whole.len()));
    }
    let extra = bytes.len() - HEADER - count * STRIDE;
    if extra > 0 {
        warnings.push(format!("{extra} bytes behind the last of {count} triangles are ignored"));
    }
    let mut mesh = Mesh::default();
    mesh.begin("solid".into());
    for bytes in &whole[..count] {
        let (numbers, _) = bytes.as_chunks::<4>();
        let vertex = |i: usize| Vec3::from([0, 1, 2].map(|axis| f32::from_le_bytes(numbers[3 * i + axis])));
        mesh.triangle(Triangle::new(vertex(1), vertex(2), vertex(3)), 0);
    }
    Ok(mesh)
}

/// The solids of a text: all of its words but the vertices are decoration, and each `endloop` needs three of those.
fn solids(bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh, (Option<usize>, String)> {
    let mut lines = Lines::new(bytes);
    let mut mesh = Mesh::default();
    let mut corners: Vec<Vec3> = Vec::new();
    let mut is_open = false;
    let mut last = 0;
    loop {
        let line = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err(text::Fault::Io(error)) => return Err((None, error.to_string())),
            Err(text::Fault::Encoding(told)) => return Err((None, told.into())),
        };
        let fault = |reason: String| (Some(line.number), reason);
        last = line.number;
        let (keyword, rest) = line.split();
        match keyword.to_ascii_lowercase().as_slice() {
            b"solid" => {
                let name = text::decode(rest);
                mesh.begin(if name.is_empty() { "solid".into() } else { name.into_owned() });
                is_open = true;
            }
            b"endsolid" => is_open = false,
            b"facet" | b"outer" | b"endfacet" => {}
            b"vertex" => corners.push(vertex(rest).map_err(fault)?),
            b"endloop" => {
                let &[a, b, c] = corners.as_slice() else {
                    return Err(fault(format!("a facet with {} vertices; it has three", corners.len())));
                };
                mesh.triangle(Triangle::new(a, b, c), 0);
                corners.clear();
            }
            other => return Err(fault(format!("'{}' has no meaning in STL", text::decode(other).escape_debug()))),
        }
    }
    if !corners.is_empty() {
        return Err((Some(last), "the file ends within a facet; fetch it anew".into()));
    }
    if is_open {
        warnings.push("the last solid has no end: the file may have been cut short".into());
    }
    Ok(mesh)
}

fn vertex(rest: &[u8]) -> Result<Vec3, String> {
    let mut words = text::words(rest);
    let mut point = [0.0; 3];
    for coordinate in &mut point {
        let word = words.next().ok_or("a vertex needs three numbers")?;
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        *coordinate = number.ok_or_else(|| format!("'{}' is not a number", text::decode(word).escape_debug()))?;
    }
    Ok(point.into())
}
