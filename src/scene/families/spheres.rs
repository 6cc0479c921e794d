//! Tessellated spheres of varied sizes in a cube, none touching another.

use super::Random;
use crate::scene::assemble::Assembly;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Edge of the cube.
const CUBE: f64 = 100.0;
/// Segments and rings a sphere may have: 48, 224 or 960 triangles.
const TESSELLATIONS: [(usize, usize); 3] = [(8, 4), (16, 8), (32, 16)];
/// Least and greatest radius, in cells.
const RADII: (f64, f64) = (0.1, 0.5);

/// Each sphere stands somewhere in a cell of its own of a cubic grid.
pub(super) fn generate(random: &mut Random, parts: &mut Assembly) {
    let (mut tessellations, mut triangles) = (Vec::new(), 0);
    while triangles < parts.limit() {
        let (segments, rings) = TESSELLATIONS[random.below(TESSELLATIONS.len())];
        tessellations.push((segments, rings));
        triangles += 2 * segments * (rings - 1);
    }
    let side = (1..).find(|side: &usize| side.pow(3) >= tessellations.len()).unwrap_or(1);
    let mut cells: Vec<usize> = (0..side.pow(3)).collect();
    let cell_size = CUBE / side as f64;
    for (i, (segments, rings)) in tessellations.into_iter().enumerate() {
        // Fisher and Yates' shuffle, as far as it is needed.
        let other = i + random.below(cells.len() - i);
        cells.swap(i, other);
        let cell = [cells[i] % side, cells[i] / side % side, cells[i] / (side * side)].map(|c| c as f64);
        let radius = random.log_between(RADII.0, RADII.1);
        let centre = (DVec3::from(cell) + random.in_cube(radius, 1.0 - radius)) * cell_size;
        parts.begin(format!("sphere {i}"));
        sphere(parts, centre, radius * cell_size, segments, rings);
    }
}

/// Rings from pole to pole along y; triangles at the poles, quads cut in two between them.
fn sphere(parts: &mut Assembly, centre: DVec3, radius: f64, segments: usize, rings: usize) {
    let point = |ring: usize, segment: usize| {
        let turn = (segment % segments) as f64 * TAU / segments as f64;
        let (r, y) = match ring {
            0 => (0.0, 1.0),
            _ if ring == rings => (0.0, -1.0),
            _ => {
                let polar = ring as f64 * PI / rings as f64;
                (libm::sin(polar), libm::cos(polar))
            }
        };
        centre + radius * DVec3::new(r * libm::sin(turn), y, r * libm::cos(turn))
    };
    for ring in 0..rings {
        for s in 0..segments {
            let (a, b) = (point(ring, s), point(ring + 1, s));
            let (c, d) = (point(ring + 1, s + 1), point(ring, s + 1));
            if ring + 1 < rings {
                parts.push([a, b, c]);
            }
            if ring > 0 {
                parts.push([a, if ring + 1 < rings { c } else { b }, d]);
            }
        }
    }
}
