//! Long curved strands of long thin triangles, growing out of a ball and through each other.

use super::Random;
use crate::scene::assemble::Assembly;
use glam::DVec3;

/// Segments of a strand, two triangles each; the ball has radius 1.
const SEGMENTS: usize = 16;
/// Length of a segment.
const SEGMENT: f64 = 0.25;
/// How much of a strand's own curl bends it at each segment.
const CURL: f64 = 0.3;
/// How much of chance bends it.
const JITTER: f64 = 0.2;
/// Width at the root; at the tip a quarter of it is left.
const WIDTH: f64 = 0.004;

/// Ribbons of 32 triangles, each rooted anywhere on the ball.
pub(super) fn generate(random: &mut Random, parts: &mut Assembly) {
    parts.begin("hair");
    while parts.room() > 0 {
        let mut direction = random.direction();
        let curl = random.direction();
        let mut root = direction;
        let across = direction.cross(curl).normalize_or(direction.any_orthonormal_vector());
        let side = |segment: usize| across * (WIDTH / 2.0 * (1.0 - 0.75 * segment as f64 / SEGMENTS as f64));
        for segment in 0..SEGMENTS {
            let tip = root + direction * SEGMENT;
            let (a, b) = (root - side(segment), root + side(segment));
            let (c, d) = (tip + side(segment + 1), tip - side(segment + 1));
            parts.push([a, b, c]);
            parts.push([a, c, d]);
            root = tip;
            let bend: DVec3 = curl.cross(direction) * CURL + random.in_cube(-JITTER, JITTER);
            direction = (direction + bend).normalize();
        }
    }
}
