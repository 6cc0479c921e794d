//! Triangles no split can tell apart, and triangles inside triangles.

use super::Random;
use crate::scene::assemble::Assembly;
use glam::DVec3;

/// An equilateral triangle around the origin, on no axis plane.
const TILTED: [DVec3; 3] = [DVec3::new(1.0, 0.0, -1.0), DVec3::new(-1.0, 1.0, 0.0), DVec3::new(0.0, -1.0, 1.0)];
/// The largest nested triangle is 2 to this power, the smallest 2 to its negative: areas stay normal numbers in f32.
const OCTAVES: f64 = 60.0;

/// The same triangle again and again.
pub(super) fn coincident(_: &mut Random, parts: &mut Assembly) {
    parts.begin("coincident");
    while parts.room() > 0 {
        parts.push(TILTED);
    }
}

/// Concentric triangles in geometric ratio, the largest first: half of the one before, up to 121 triangles.
/// With more the ratio is closer to 1, so that all fit between 2⁶⁰ and 2⁻⁶⁰.
///
/// Neighbours differ in f32 up to about 7·10⁸ triangles, more than a generated scene may have.
pub(super) fn nested(_: &mut Random, parts: &mut Assembly) {
    let steps = (parts.limit() - 1) as f64;
    let top = OCTAVES.min(steps / 2.0);
    parts.begin("nested");
    for i in 0..parts.limit() {
        let exponent = if i == 0 { top } else { top - 2.0 * top * (i as f64 / steps) };
        parts.push(TILTED.map(|p| p * libm::exp2(exponent)));
    }
}
