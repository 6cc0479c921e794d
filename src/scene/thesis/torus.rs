//! The torus, its axis vertical, with a crest pulled out of it from the med level on.

use super::Level;
use super::quad;
use crate::scene::assemble::Triangle64;
use glam::DVec3;
use std::f64::consts::PI;

/// Minor radius; the major one is 1.
const MINOR_RADIUS: f64 = 0.25;
/// Steps around the axis and around the tube on the coarsest level.
const COARSE: (usize, usize) = (24, 6);
/// What the crest's ring 6 is moved by.
const CREST: DVec3 = DVec3::new(0.0559958, -0.0413699, 0.0867026);
/// What its neighbours, rings 5 and 7, are lifted by.
const SHOULDER_LIFT: f64 = 0.0437633;
/// How far ring 8 is widened, and lowered.
const RING_8: (f64, f64) = (1.0179044, 0.0149601);

/// Points by (step around the axis, step around the tube); both ways round.
struct Grid {
    around: usize,
    tube: usize,
    points: Vec<DVec3>,
}

impl Grid {
    fn new(around: usize, tube: usize, position: impl Fn(usize, usize) -> DVec3) -> Self {
        let points = (0..around * tube).map(|i| position(i / tube, i % tube)).collect();
        Self { around, tube, points }
    }

    /// The point at (i, j), counted round.
    fn at(&self, i: usize, j: usize) -> DVec3 {
        self.points[i % self.around * self.tube + j % self.tube]
    }

    /// Linear subdivision, first around the axis, then around the tube.
    fn refined(&self) -> Self {
        let wider = Self::new(2 * self.around, self.tube, |i, j| {
            if i % 2 == 0 { self.at(i / 2, j) } else { (self.at(i / 2, j) + self.at(i / 2 + 1, j)) / 2.0 }
        });
        Self::new(wider.around, 2 * self.tube, |i, j| {
            if j % 2 == 0 { wider.at(i, j / 2) } else { (wider.at(i, j / 2) + wider.at(i, j / 2 + 1)) / 2.0 }
        })
    }

    /// One smoothing pass: half the point, an eighth of each of its four neighbours.
    fn smoothed(&self) -> Self {
        Self::new(self.around, self.tube, |i, j| {
            let axis = self.at(i + self.around - 1, j) + self.at(i + 1, j);
            self.at(i, j) / 2.0 + (axis + self.at(i, j + self.tube - 1) + self.at(i, j + 1)) / 8.0
        })
    }
}

/// The torus in local axes.
pub(super) fn triangles(level: Level) -> Vec<Triangle64> {
    let coarse = || {
        Grid::new(COARSE.0, COARSE.1, |i, j| {
            let (turn, roll) = (i as f64 * PI / 12.0, j as f64 * PI / 3.0);
            let r = 1.0 + MINOR_RADIUS * libm::cos(roll);
            DVec3::new(r * libm::cos(turn), r * libm::sin(turn), MINOR_RADIUS * libm::sin(roll))
        })
    };
    let small = || coarse().refined().smoothed().smoothed();
    let grid = match level {
        Level::Tiny => coarse(),
        Level::Small | Level::Small2940 => small(),
        Level::Med | Level::Large => crested(&small().refined()),
        Level::Huge => densified(&crested(&small().refined())),
    };
    let mut triangles = Vec::with_capacity(2 * grid.points.len());
    for i in 0..grid.around {
        for j in 0..grid.tube {
            let corners = [grid.at(i, j), grid.at(i + 1, j), grid.at(i + 1, j + 1), grid.at(i, j + 1)];
            triangles.extend(quad::cut(corners));
        }
    }
    triangles
}

/// The 96 × 24 torus with rings 5 to 8 edited.
fn crested(grid: &Grid) -> Grid {
    Grid::new(grid.around, grid.tube, |i, j| {
        let p = grid.at(i, j);
        match j {
            5 | 7 => p + DVec3::new(0.0, 0.0, SHOULDER_LIFT),
            6 => p + CREST,
            8 => DVec3::new(p.x * RING_8.0, p.y * RING_8.0, p.z - RING_8.1),
            _ => p,
        }
    })
}

/// The 24 bands around the tube split in two, those at the crest (3 to 8) in three: 54 in all.
fn densified(grid: &Grid) -> Grid {
    let parts = |band| if (3..=8).contains(&band) { 3 } else { 2 };
    let rings: Vec<(usize, f64)> = (0..grid.tube)
        .flat_map(|band| (0..parts(band)).map(move |q| (band, f64::from(q) / f64::from(parts(band)))))
        .collect();
    Grid::new(grid.around, rings.len(), |i, j| {
        let (band, t) = rings[j];
        grid.at(i, band) * (1.0 - t) + grid.at(i, band + 1) * t
    })
}
