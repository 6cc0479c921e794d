//! The cup: a profile turned around an axis in 32 flat sides.

use super::Level;
use super::quad;
use crate::scene::assemble::Triangle64;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The axis, in local x and y.
const AXIS: DVec2 = DVec2::new(0.3192527, 0.2131926);
/// Heights of the foot, the rim and the floor inside.
const FOOT: f64 = 0.5661922;
const RIM: f64 = 3.9820459;
const FLOOR: f64 = 0.9551182;
/// Outer radius at the foot and at the rim.
const OUTER: (f64, f64) = (1.0, 1.4464045);
/// Inner radius at the floor and at the rim.
const INNER: (f64, f64) = (0.9027731, 1.3197958);
/// Radius factor inside a groove.
const GROOVE: f64 = 0.9715627;
/// Heights of the grooved wall's rings, in eighths of the wall.
const GROOVED_HEIGHTS: [f64; 13] =
    [0.0, 1.0, 2.0, 3.0, 10.0 / 3.0, 11.0 / 3.0, 4.0, 13.0 / 3.0, 14.0 / 3.0, 5.0, 6.0, 7.0, 8.0];
/// Which of those rings lie in a groove.
const GROOVED: [usize; 3] = [4, 6, 8];

/// A point of the profile.
#[derive(Clone, Copy)]
struct Ring {
    radius: f64,
    height: f64,
}

impl Ring {
    const fn new(radius: f64, height: f64) -> Self {
        Self { radius, height }
    }

    /// The way from here to `to`, `step` of `steps` done.
    fn towards(self, to: Self, step: usize, steps: usize) -> Self {
        let (k, n) = (step as f64, steps as f64);
        Self::new(self.radius + (to.radius - self.radius) * k / n, self.height + (to.height - self.height) * k / n)
    }
}

/// The cup in local axes.
pub(super) fn triangles(level: Level) -> Vec<Triangle64> {
    let sides = match level {
        Level::Tiny => 32,
        Level::Small | Level::Small2940 | Level::Huge => 64,
        Level::Med | Level::Large => 128,
    };
    let outline = outline(sides);
    let rings: Vec<Vec<DVec3>> = profile(level)
        .iter()
        .map(|ring| outline.iter().map(|&p| (AXIS + ring.radius * p).extend(ring.height)).collect())
        .collect();
    let mut triangles = Vec::new();
    for pair in rings.windows(2) {
        for s in 0..sides {
            let next = (s + 1) % sides;
            triangles.extend(quad::cut([pair[0][s], pair[0][next], pair[1][next], pair[1][s]]));
        }
    }
    let strip = cap_strip(sides);
    let (foot, floor) = (&rings[0], &rings[rings.len() - 1]);
    triangles.extend(strip.iter().map(|&[a, b, c]| [foot[c], foot[b], foot[a]]));
    triangles.extend(strip.iter().map(|&[a, b, c]| [floor[a], floor[b], floor[c]]));
    triangles
}

/// Radii and heights from the foot up the outer wall, over the rim and down inside.
fn profile(level: Level) -> Vec<Ring> {
    let (foot, outer_rim) = (Ring::new(OUTER.0, FOOT), Ring::new(OUTER.1, RIM));
    let (floor, inner_rim) = (Ring::new(INNER.0, FLOOR), Ring::new(INNER.1, RIM));
    let (mut rings, rim_steps, inner_steps): (Vec<_>, _, _) = match level {
        Level::Tiny => (vec![foot, outer_rim], 1, 1),
        Level::Small | Level::Small2940 => ((0..=2).map(|k| foot.towards(outer_rim, k, 2)).collect(), 2, 2),
        Level::Med => ((0..=4).map(|k| foot.towards(outer_rim, k, 4)).collect(), 4, 4),
        Level::Large => (grooved_wall(), 4, 8),
        Level::Huge => (densified(&grooved_wall()), 2, 12),
    };
    rings.extend((1..=rim_steps).map(|k| outer_rim.towards(inner_rim, k, rim_steps)));
    rings.extend((1..=inner_steps).map(|k| inner_rim.towards(floor, k, inner_steps)));
    rings
}

/// The outer wall with its three grooves.
fn grooved_wall() -> Vec<Ring> {
    let ring = |(i, eighths): (usize, &f64)| {
        let height = FOOT + (RIM - FOOT) * eighths / 8.0;
        let radius = OUTER.0 + (OUTER.1 - OUTER.0) * (height - FOOT) / (RIM - FOOT);
        Ring::new(radius * if GROOVED.contains(&i) { GROOVE } else { 1.0 }, height)
    };
    GROOVED_HEIGHTS.iter().enumerate().map(ring).collect()
}

/// The wall's twelve bands split in four, the first and the last in three: 46 in all.
fn densified(wall: &[Ring]) -> Vec<Ring> {
    let last = wall.len() - 1;
    let mut rings = Vec::new();
    for (i, pair) in wall.windows(2).enumerate() {
        let parts = if i == 0 || i + 1 == last { 3 } else { 4 };
        rings.extend((0..parts).map(|q| {
            let t = f64::from(q) / f64::from(parts);
            Ring::new(pair[0].radius * (1.0 - t) + pair[1].radius * t, pair[0].height * (1.0 - t) + pair[1].height * t)
        }));
    }
    rings.push(wall[last]);
    rings
}

/// A regular 32-gon of radius 1 whose chords are split linearly into `sides`/32 parts, from +y towards −x.
fn outline(sides: usize) -> Vec<DVec2> {
    let corner = |i: usize| {
        let turn = (i % 32) as f64 * PI / 16.0;
        DVec2::new(-libm::sin(turn), libm::cos(turn))
    };
    let parts = sides / 32;
    (0..sides)
        .map(|s| {
            let t = (s % parts) as f64 / parts as f64;
            corner(s / parts) * (1.0 - t) + corner(s / parts + 1) * t
        })
        .collect()
}

/// An n-gon as the zig-zag strip 0, 1, n−1, 2, n−2, …: a fan would have zero-area triangles, because the corners
/// on a split chord are collinear.
fn cap_strip(n: usize) -> Vec<[usize; 3]> {
    let zigzag: Vec<usize> = std::iter::once(0).chain((1..n / 2).flat_map(|q| [q, n - q])).chain([n / 2]).collect();
    zigzag
        .windows(3)
        .enumerate()
        .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
        .collect()
}
