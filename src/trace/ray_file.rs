//! Ray files: rays from elsewhere, exactly as they are.

use crate::geom::Ray;
use glam::Vec3;
use std::path::{Path, PathBuf};

/// Bytes of one ray: eight little-endian f32, origin xyz, t_min, direction xyz, t_max.
const RAY_BYTES: usize = 32;

/// Why there are no rays.
#[derive(Debug, thiserror::Error)]
pub enum RayFileError {
    /// The file could not be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The size does not fit.
    #[error(
        "{path}: {bytes} bytes are not a multiple of 32; a ray is eight little-endian f32: \
         origin xyz, t_min, direction xyz, t_max",
        path = path.display()
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: usize,
    },
}

/// Reads a `.rays` file; rays with NaN or infinities are kept, and miss.
///
/// # Errors
/// [`RayFileError`].
pub fn read_rays(path: &Path) -> Result<Vec<Ray>, RayFileError> {
    let bytes = std::fs::read(path).map_err(|source| RayFileError::Io { path: path.into(), source })?;
    let (rays, rest) = bytes.as_chunks::<RAY_BYTES>();
    if !rest.is_empty() {
        return Err(RayFileError::Size { path: path.into(), bytes: bytes.len() });
    }
    Ok(rays.iter().map(decode).collect())
}

fn decode(bytes: &[u8; RAY_BYTES]) -> Ray {
    let number = |i: usize| f32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
    Ray {
        origin: Vec3::new(number(0), number(1), number(2)),
        t_min: number(3),
        direction: Vec3::new(number(4), number(5), number(6)),
        t_max: number(7),
    }
}

/// Writes a `.rays` file.
///
/// # Errors
/// [`RayFileError::Io`].
pub fn write_rays(path: &Path, rays: &[Ray]) -> Result<(), RayFileError> {
    let bytes: Vec<u8> = rays
        .iter()
        .flat_map(|r| {
            let (o, d) = (r.origin, r.direction);
            [o.x, o.y, o.z, r.t_min, d.x, d.y, d.z, r.t_max]
        })
        .flat_map(f32::to_le_bytes)
        .collect();
    std::fs::write(path, bytes).map_err(|source| RayFileError::Io { path: path.into(), source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::Random;
    use crate::trace::testing::any_ray;

    #[test]
    fn rays_survive_the_file_bit_by_bit() {
        let mut random = Random(1);
        let mut rays: Vec<_> = (0..100).map(|_| any_ray(&mut random)).collect();
        rays[3].t_max = f32::NAN;
        rays[4].origin.y = -0.0;
        let file = tempfile::NamedTempFile::new().unwrap();
        write_rays(file.path(), &rays).unwrap();
        let bits = |rays: &[Ray]| -> Vec<u8> { bytemuck::cast_slice(rays).to_vec() };
        assert_eq!(bits(&read_rays(file.path()).unwrap()), bits(&rays));
        assert_eq!(std::fs::metadata(file.path()).unwrap().len(), 3200);
    }

    #[test]
    fn a_torn_file_and_no_file_say_so() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(read_rays(file.path()).unwrap().is_empty());
        std::fs::write(file.path(), [0; 33]).unwrap();
        let torn = read_rays(file.path()).unwrap_err();
        assert!(matches!(torn, RayFileError::Size { bytes: 33, .. }) && torn.to_string().contains("multiple of 32"));
        assert!(matches!(read_rays(Path::new("no/such.rays")), Err(RayFileError::Io { .. })));
    }
}
