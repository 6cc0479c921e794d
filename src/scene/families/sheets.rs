//! Sheets of quads: a height field, and a plane of equal squares on integer coordinates.

use super::Random;
use crate::scene::assemble::Assembly;
use glam::DVec3;

/// Edge of the terrain.
const EDGE: f64 = 100.0;
/// Height of the coarsest octave; each finer one has half of it.
const HEIGHT: f64 = 20.0;
/// Cells along an edge of each octave's lattice.
const OCTAVES: [usize; 6] = [4, 8, 16, 32, 64, 128];

/// A sheet of quads, `columns` wide and as long as there is room, each cut from its first to its third corner.
///
/// `at(i, j)` is the point in column i, row j.
pub(super) fn sheet(parts: &mut Assembly, columns: usize, triangles: usize, at: impl Fn(usize, usize) -> DVec3) {
    for quad in 0..triangles.div_ceil(2) {
        let (i, j) = (quad % columns, quad / columns);
        parts.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        if 2 * quad + 1 < triangles {
            parts.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
}

/// Columns that make a sheet of so many triangles about as long as wide.
fn columns(triangles: usize) -> usize {
    (1..).find(|n: &usize| 2 * n * n >= triangles).unwrap_or(1)
}

/// Value noise: random heights on lattices, blended by 3t² − 2t³, octaves summed.
pub(super) fn terrain(random: &mut Random, parts: &mut Assembly) {
    let lattices: Vec<Vec<f64>> =
        OCTAVES.iter().map(|cells| (0..(cells + 1) * (cells + 1)).map(|_| random.unit()).collect()).collect();
    let noise = |x: f64, z: f64| {
        let octave = |(&cells, values): (&usize, &Vec<f64>)| {
            let split = |t: f64| {
                let scaled = t * cells as f64;
                let cell = (scaled as usize).min(cells - 1);
                let f = scaled - cell as f64;
                (cell, f * f * (3.0 - 2.0 * f))
            };
            let ((i, u), (j, v)) = (split(x), split(z));
            let value = |i: usize, j: usize| values[j * (cells + 1) + i];
            let row = |j| value(i, j) * (1.0 - u) + value(i + 1, j) * u;
            row(j) * (1.0 - v) + row(j + 1) * v
        };
        let heights = OCTAVES.iter().zip(&lattices).map(octave);
        heights.enumerate().map(|(k, h)| h * HEIGHT / (1_u32 << k) as f64).sum::<f64>()
    };
    let triangles = parts.limit();
    let columns = columns(triangles);
    parts.begin("terrain");
    sheet(parts, columns, triangles, |i, j| {
        let (x, z) = (i as f64 / columns as f64, j as f64 / columns as f64);
        DVec3::new(x * EDGE, noise(x, z), z * EDGE)
    });
}

/// Unit squares in the plane y = 0.
pub(super) fn grid(_: &mut Random, parts: &mut Assembly) {
    let triangles = parts.limit();
    parts.begin("grid");
    sheet(parts, columns(triangles), triangles, |i, j| DVec3::new(i as f64, 0.0, j as f64));
}
