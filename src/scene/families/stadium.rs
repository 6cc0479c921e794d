//! The teapot in the stadium: nearly all triangles in a tiny object inside a huge, sparse one.

use super::Random;
use super::sheets::sheet;
use crate::scene::assemble::Assembly;
use glam::DVec3;
use std::f64::consts::TAU;

/// One triangle in so many belongs to the stadium.
const SPARSE: usize = 64;
/// But never more than these.
const MOST_SPARSE: usize = 4096;
/// Half the edge of the floor, and the inner radius of the stands.
const FLOOR: f64 = 600.0;
/// How much further out, and how high, the stands rise.
const STANDS: (f64, f64) = (300.0, 200.0);
/// Where the tiny object stands, at most, from the middle.
const OFF_CENTRE: f64 = 300.0;
/// Radii of the tiny object, a ring with bumps, and how far the bumps stick out.
const RING: (f64, f64, f64) = (1.0, 0.4, 0.05);

/// A floor of two triangles and stands around it; on it a bumpy ring about 1/600 as wide.
pub(super) fn generate(random: &mut Random, parts: &mut Assembly) {
    let sparse = (parts.limit() / SPARSE).clamp(1, MOST_SPARSE);
    let floor = sparse.min(2);
    parts.begin("floor");
    sheet(parts, 1, floor, |i, j| DVec3::new((2.0 * i as f64 - 1.0) * FLOOR, 0.0, (2.0 * j as f64 - 1.0) * FLOOR));
    let stands = sparse - floor;
    if stands > 0 {
        parts.begin("stands");
        let tiers = libm::sqrt(stands as f64 / 8.0).max(1.0) as usize;
        let columns = stands.div_ceil(2 * tiers).max(3);
        sheet(parts, columns, stands, |i, j| {
            let turn = (i % columns) as f64 * TAU / columns as f64;
            let out = j as f64 / tiers as f64;
            let r = FLOOR + STANDS.0 * out;
            // Wound towards the middle: rows go outwards, columns clockwise seen from above.
            DVec3::new(r * libm::sin(turn), STANDS.1 * out * out, r * libm::cos(turn))
        });
    }
    let dense = parts.room();
    if dense > 0 {
        parts.begin("ring");
        let place = DVec3::new(random.between(-OFF_CENTRE, OFF_CENTRE), 1.0, random.between(-OFF_CENTRE, OFF_CENTRE));
        let (lumps, waves) = (4 + random.below(5), 2 + random.below(4));
        let around = libm::sqrt(dense as f64).max(3.0) as usize;
        let tube = dense.div_ceil(2 * around).max(3);
        sheet(parts, around, dense, |i, j| {
            let turn = (i % around) as f64 * TAU / around as f64;
            let roll = (j % tube) as f64 * TAU / tube as f64;
            let bump = libm::sin(lumps as f64 * turn) * libm::cos(waves as f64 * roll);
            let minor = RING.1 + RING.2 * bump;
            let r = RING.0 + minor * libm::cos(roll);
            place + DVec3::new(r * libm::cos(turn), minor * libm::sin(roll), r * libm::sin(turn))
        });
    }
}
