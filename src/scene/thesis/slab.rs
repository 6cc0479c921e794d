//! The slab: a box grid, bulged towards one side from the med level on.

use super::Level;
use super::lattice;
use crate::scene::assemble::Triangle64;
use glam::DVec3;

/// Knots over |x| of the bulge.
const KNOTS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Scale of the cross-section at the knots.
const SCALE: [f64; 5] = [1.0570767, 1.0570767, 1.0570767, 1.0, 1.0];
/// Lift of the cross-section at the knots.
const LIFT: [f64; 5] = [0.0495984, 0.0495984, 0.0, 0.0, 0.0];
/// Where the huge level's sections stand, besides the middle one; mirrored.
const HUGE_SECTIONS: [f64; 6] = [0.25, 0.375, 0.5, 0.625, 0.75, 1.0];

/// A cross-section of the slab: place, scale and lift.
struct Section {
    x: f64,
    scale: f64,
    lift: f64,
}

/// The slab in local axes.
pub(super) fn triangles(level: Level) -> Vec<Triangle64> {
    let (cells, bulged) = match level {
        Level::Tiny => ([1, 1, 1], false),
        Level::Small => ([2, 6, 2], false),
        Level::Small2940 => ([4, 8, 8], false),
        Level::Med => ([8, 16, 16], true),
        Level::Large => ([16, 32, 32], true),
        Level::Huge => ([12, 62, 26], true),
    };
    let xs = if level == Level::Huge {
        let mirrored = HUGE_SECTIONS.iter().rev().map(|x| -x);
        mirrored.chain([0.0]).chain(HUGE_SECTIONS).collect()
    } else {
        evenly(cells[0])
    };
    let sections: Vec<_> =
        xs.into_iter().map(|x| if bulged { bulge(x) } else { Section { x, scale: 1.0, lift: 0.0 } }).collect();
    let (ys, zs) = (evenly(cells[1]), evenly(cells[2]));
    lattice::surface(cells, |[i, j, k]| {
        let Section { x, scale, lift } = sections[i];
        DVec3::new(x, ys[j] * scale, zs[k] * scale + lift)
    })
}

fn bulge(x: f64) -> Section {
    let distance = x.abs();
    let stretched: [f64; 5] = std::array::from_fn(|i| KNOTS[i] * SCALE[i]);
    let sign = if x == 0.0 { 0.0 } else { x.signum() };
    Section {
        x: sign * interpolate(distance, &stretched),
        scale: interpolate(distance, &SCALE),
        lift: interpolate(distance, &LIFT),
    }
}

/// Piecewise linear through `values` at [`KNOTS`], for x in 0 … 1.
fn interpolate(x: f64, values: &[f64; 5]) -> f64 {
    let right = KNOTS.partition_point(|&k| k <= x);
    if right == KNOTS.len() {
        return values[right - 1];
    }
    let left = right - 1;
    let slope = (values[right] - values[left]) / (KNOTS[right] - KNOTS[left]);
    slope * (x - KNOTS[left]) + values[left]
}

/// `cells` + 1 even steps from −1 to 1, both ends exact.
fn evenly(cells: usize) -> Vec<f64> {
    let step = 2.0 / cells as f64;
    (0..=cells).map(|i| if i == cells { 1.0 } else { i as f64 * step - 1.0 }).collect()
}
