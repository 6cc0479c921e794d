//! Raw triangles: little-endian f32, nine a triangle, no header.

use super::mesh::Mesh;
use super::{Parts, Source, malformed};
use crate::geom::Triangle;
use crate::scene::{Dropped, Material, SceneError};
use glam::Vec3;

/// Bytes of a triangle.
const STRIDE: usize = 36;

pub(super) fn read(source: &mut Source<'_>) -> Result<Parts, SceneError> {
    let bytes = source.bytes()?;
    let (whole, rest) = bytes.as_chunks::<STRIDE>();
    if !rest.is_empty() {
        let size = bytes.len();
        let reason = format!("{size} bytes are not a whole number of triangles of {STRIDE} bytes (nine f32 each)");
        return Err(malformed(source.path, None, reason));
    }
    let mut mesh = Mesh { material_ids: vec![0; whole.len()], ..Mesh::default() };
    mesh.begin("triangles".into());
    mesh.objects[0].triangles.end = whole.len();
    mesh.triangles = whole.iter().map(triangle).collect();
    Ok(mesh.finish(vec![Material::default()], Dropped::default(), Vec::new()))
}

fn triangle(bytes: &[u8; STRIDE]) -> Triangle {
    let (numbers, _) = bytes.as_chunks::<4>();
    let vertex = |i: usize| Vec3::from([0, 1, 2].map(|axis| f32::from_le_bytes(numbers[3 * i + axis])));
    Triangle::new(vertex(0), vertex(1), vertex(2))
}
