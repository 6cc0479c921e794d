//! Raw triangles: little-endian f32, nine a triangle, no header.

use super::{Parts, malformed};
use crate::geom::Triangle;
use crate::scene::{Dropped, Material, Object, SceneError};
use glam::Vec3;
use std::path::Path;

/// Bytes of a triangle.
const STRIDE: usize = 36;

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Parts, SceneError> {
    let (whole, rest) = bytes.as_chunks::<STRIDE>();
    if !rest.is_empty() {
        let size = bytes.len();
        let reason = format!("{size} bytes are not a whole number of triangles of {STRIDE} bytes (nine f32 each)");
        return Err(malformed(path, None, reason));
    }
    let triangles: Vec<Triangle> = whole.iter().map(triangle).filter(Triangle::is_finite).collect();
    Ok(Parts {
        objects: vec![Object { name: "triangles".into(), triangles: 0..triangles.len() }],
        materials: vec![Material::default()],
        material_ids: vec![0; triangles.len()],
        dropped: Dropped { not_finite: whole.len() - triangles.len(), ..Dropped::default() },
        warnings: Vec::new(),
        triangles,
    })
}

fn triangle(bytes: &[u8; STRIDE]) -> Triangle {
    let (numbers, _) = bytes.as_chunks::<4>();
    let vertex = |i: usize| Vec3::from([0, 1, 2].map(|axis| f32::from_le_bytes(numbers[3 * i + axis])));
    Triangle::new(vertex(0), vertex(1), vertex(2))
}
