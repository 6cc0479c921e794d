//! The eight blobs: rounded cubes, and spheres on the huge level.

use super::Level;
use super::lattice::{self, Cube};
use super::quad;
use crate::scene::assemble::Triangle64;
use glam::DVec3;
use std::f64::consts::PI;

/// Radius factor of corners and edge midpoints of the coarse lattice.
const CORNER: f64 = 0.8929189;
/// Radius factor of its face centres.
const FACE_CENTRE: f64 = 1.4305928;
/// Radius of the huge level's sphere, before the object's scale.
const SPHERE_RADIUS: f64 = 1.2;

/// One blob in local axes.
pub(super) fn triangles(level: Level) -> Vec<Triangle64> {
    let cube = match level {
        Level::Tiny => Cube::new(1, |index| DVec3::from(index.map(|i| i as f64 * 2.0 - 1.0))),
        Level::Small | Level::Small2940 => coarse(),
        Level::Med => coarse().refined().smoothed(),
        Level::Large => coarse().refined().smoothed().refined().smoothed().smoothed(),
        Level::Huge => return sphere(96, 40),
    };
    lattice::surface([cube.n; 3], |index| cube.at(index))
}

/// The 2-lattice that every finer blob is subdivided from.
fn coarse() -> Cube {
    Cube::new(2, |index| {
        let p = DVec3::from(index.map(|i| i as f64 - 1.0));
        let is_face_centre = p.abs().element_sum() == 1.0;
        p * if is_face_centre { FACE_CENTRE } else { CORNER }
    })
}

/// A sphere of `segments` × `rings`: both pole fans first, then the bands between them.
fn sphere(segments: usize, rings: usize) -> Vec<Triangle64> {
    let point = |ring: usize, segment: usize| {
        let polar = ring as f64 * PI / rings as f64;
        let turn = (segment % segments) as f64 * 2.0 * PI / segments as f64;
        let r = libm::sin(polar);
        DVec3::new(r * libm::cos(turn), r * libm::sin(turn), libm::cos(polar))
    };
    let mut triangles = Vec::new();
    triangles.extend((0..segments).map(|s| [point(0, s), point(1, s), point(1, s + 1)]));
    triangles.extend((0..segments).map(|s| [point(rings - 1, s), point(rings, s), point(rings - 1, s + 1)]));
    for ring in 1..rings - 1 {
        for s in 0..segments {
            let corners = [point(ring, s), point(ring + 1, s), point(ring + 1, s + 1), point(ring, s + 1)];
            triangles.extend(quad::cut(corners));
        }
    }
    triangles.iter().map(|t| t.map(|p| p * SPHERE_RADIUS)).collect()
}
