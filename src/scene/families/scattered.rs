//! Single triangles strewn in a cube: a soup, and needles.

use super::Random;
use crate::scene::assemble::Assembly;

/// Edge of the cube.
const CUBE: f64 = 100.0;
/// Half the edge of the small cube that holds a soup triangle, in mean spacings of the triangles.
const SOUP_SIZE: f64 = 0.5;
/// The least and greatest length of a needle.
const NEEDLE: (f64, f64) = (2.0, 40.0);
/// Width of a needle, in lengths.
const NEEDLE_WIDTH: f64 = 1e-4;

/// Three random vertices in a small cube around a random point.
pub(super) fn soup(random: &mut Random, parts: &mut Assembly) {
    let size = SOUP_SIZE * CUBE / libm::cbrt(parts.limit() as f64);
    parts.begin("soup");
    while parts.room() > 0 {
        let centre = random.in_cube(0.0, CUBE);
        parts.push([0; 3].map(|_| centre + random.in_cube(-size, size)));
    }
}

/// Isosceles needles, 10,000 times as long as wide, in random directions.
pub(super) fn slivers(random: &mut Random, parts: &mut Assembly) {
    parts.begin("slivers");
    while parts.room() > 0 {
        let centre = random.in_cube(0.0, CUBE);
        let length = random.log_between(NEEDLE.0, NEEDLE.1);
        let along = random.direction();
        let across = along.cross(random.direction()).normalize_or(along.any_orthonormal_vector());
        let (half, base) = (along * (length / 2.0), across * (length * NEEDLE_WIDTH / 2.0));
        parts.push([centre - half - base, centre - half + base, centre + half]);
    }
}
