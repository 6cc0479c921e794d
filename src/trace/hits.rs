//! Answers of ray sets as bytes: what `--hits-out` writes and `hit_hash` hashes.

use crate::geom::Hit;
use std::io;
use std::path::Path;

/// The answer for one ray, 8 bytes.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct HitRecord {
    /// Triangle id, [`u32::MAX`] for a miss.
    pub triangle: u32,
    /// Ray parameter, +∞ for a miss.
    pub t: f32,
}

impl HitRecord {
    /// The record of a miss.
    pub const MISS: Self = Self { triangle: u32::MAX, t: f32::INFINITY };

    /// Whether something was hit.
    pub fn is_hit(&self) -> bool {
        self.triangle != u32::MAX
    }
}

impl From<Option<Hit>> for HitRecord {
    #[inline]
    fn from(hit: Option<Hit>) -> Self {
        hit.map_or(Self::MISS, |Hit { triangle, t }| Self { triangle, t })
    }
}

/// The records as `--hits-out` has them: u32 id and f32 t a ray, little-endian.
pub fn hit_bytes(hits: &[HitRecord]) -> Vec<u8> {
    hits.iter()
        .flat_map(|h| {
            let mut bytes = [0; 8];
            bytes[..4].copy_from_slice(&h.triangle.to_le_bytes());
            bytes[4..].copy_from_slice(&h.t.to_le_bytes());
            bytes
        })
        .collect()
}

/// 128 bits of BLAKE3 over [`hit_bytes`], as 32 hex digits.
pub fn hit_hash(hits: &[HitRecord]) -> String {
    let hash = blake3::hash(&hit_bytes(hits));
    hash.to_hex()[..32].to_string()
}

/// Writes [`hit_bytes`] to a file.
///
/// # Errors
/// What the system says.
pub fn write_hits(path: &Path, hits: &[HitRecord]) -> io::Result<()> {
    std::fs::write(path, hit_bytes(hits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_and_hash_are_pinned() {
        let hits = [Some(Hit { triangle: 258, t: 1.5 }).into(), None.into()];
        let bytes = hit_bytes(&hits);
        assert_eq!(bytes, [2, 1, 0, 0, 0, 0, 0xc0, 0x3f, 255, 255, 255, 255, 0, 0, 0x80, 0x7f]);
        assert_eq!(hit_hash(&hits), blake3::hash(&bytes).to_hex().as_str()[..32]);
        assert_ne!(hit_hash(&hits), hit_hash(&hits[..1]));
        assert!(hits[0].is_hit() && !hits[1].is_hit());
        let file = tempfile::NamedTempFile::new().unwrap();
        write_hits(file.path(), &hits).unwrap();
        assert_eq!(std::fs::read(file.path()).unwrap(), bytes);
    }
}
