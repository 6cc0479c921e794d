//! Axis-aligned boxes like a town's: towers, walls and slabs, all on one raster.

use super::Random;
use crate::scene::assemble::Assembly;
use glam::DVec3;

/// Edge of a plot, in scene units; one box stands on each.
const PLOT: f64 = 8.0;
/// Every coordinate is a multiple of this.
const RASTER: f64 = 1.0 / 16.0;
/// Faces as corner numbers (bit 0: x, bit 1: y, bit 2: z), outward.
const FACES: [[u8; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Plots row by row in a square, each with a tower, a wall along either axis, or a slab.
pub(super) fn generate(random: &mut Random, parts: &mut Assembly) {
    let boxes = parts.limit().div_ceil(2 * FACES.len());
    let side = (1..).find(|n: &usize| n * n >= boxes).unwrap_or(1);
    for i in 0..boxes {
        let thin = random.between(0.1, 0.4);
        let (x, z) = (random.between(2.0, PLOT), random.between(2.0, PLOT));
        let size = match random.below(4) {
            0 | 1 => DVec3::new(x, random.log_between(2.0, 60.0), z),
            2 if random.unit() < 0.5 => DVec3::new(PLOT, random.between(2.0, 4.0), thin),
            2 => DVec3::new(thin, random.between(2.0, 4.0), PLOT),
            _ => DVec3::new(x, thin, z),
        };
        let size = DVec3::from(size.to_array().map(on_raster));
        let shift = |room: f64, random: &mut Random| (random.unit() * room / RASTER).floor() * RASTER;
        let (sx, sz) = (shift(PLOT - size.x, random), shift(PLOT - size.z, random));
        let low = DVec3::new((i % side) as f64 * PLOT + sx, 0.0, (i / side) as f64 * PLOT + sz);
        parts.begin(format!("box {i}"));
        for face in FACES {
            let [a, b, c, d] = face.map(|corner| {
                let bit = |k: u8| f64::from(corner >> k & 1);
                low + size * DVec3::new(bit(0), bit(1), bit(2))
            });
            parts.push([a, b, c]);
            parts.push([a, c, d]);
        }
    }
}

/// The nearest multiple of [`RASTER`] above zero.
fn on_raster(x: f64) -> f64 {
    (x / RASTER).round().max(1.0) * RASTER
}
