//! Quads cut into triangles, and local axes turned into world axes.

use crate::scene::assemble::Triangle64;
use glam::DVec3;

/// Cuts the quad `abcd` (counter-clockwise from outside) along its shorter diagonal; among equal ones along `ac`.
///
/// The tolerance keeps rounding from deciding between diagonals that are equal by symmetry.
pub(super) fn cut([a, b, c, d]: [DVec3; 4]) -> [Triangle64; 2] {
    let (ac, bd) = (squared(a - c), squared(b - d));
    if ac <= bd * (1.0 + 1e-6) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

/// Squared length, summed x, y, z.
fn squared(v: DVec3) -> f64 {
    v.x * v.x + v.y * v.y + v.z * v.z
}

/// An object's place in the world: `loc + scale · (x, z, −y)` of its local, z-up points.
#[derive(Clone, Copy)]
pub(super) struct Placement {
    /// Translation, in world axes.
    pub(super) loc: DVec3,
    /// Scale, along world axes.
    pub(super) scale: DVec3,
}

impl Placement {
    /// A translation and one scale for all axes.
    pub(super) const fn uniform(loc: [f64; 3], scale: f64) -> Self {
        Self { loc: DVec3::from_array(loc), scale: DVec3::splat(scale) }
    }

    /// A local triangle in the world.
    pub(super) fn apply(&self, triangle: &Triangle64) -> Triangle64 {
        triangle.map(|p| DVec3::new(p.x, p.z, -p.y) * self.scale + self.loc)
    }
}
