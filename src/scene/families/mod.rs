//! Families of generated scenes: any number of triangles, from a seed.
//!
//! The same family, count and seed give the same bits on every machine: f64 arithmetic, `libm` for what is more than
//! that, and one rounding to f32. Every family's parameters are fixed and pinned by a hash in the tests.

mod boxes;
mod extremes;
mod hairball;
mod random;
mod scattered;
mod sheets;
mod spheres;
mod stadium;
#[cfg(test)]
mod tests;

use super::assemble::Assembly;
use super::{Camera, Scene};
use random::Random;

/// The seed where none is given.
pub const DEFAULT_SEED: u64 = 1;

/// The most triangles a generated scene may have.
pub const MOST_TRIANGLES: usize = 100_000_000;

/// A family of generated scenes.
pub struct Family {
    /// Its name in `gen:NAME:TRIANGLES[:SEED]`.
    pub name: &'static str,
    /// One line about it, with its fixed parameters.
    pub summary: &'static str,
    /// Whether the seed makes a difference.
    pub seeded: bool,
    generate: fn(&mut Random, &mut Assembly),
}

impl Family {
    /// Exactly `triangles` triangles of this family, between 1 and [`MOST_TRIANGLES`] (numbers outside are moved to
    /// the nearer end), in front of a camera that sees them all.
    pub fn generate(&self, triangles: usize, seed: u64) -> Scene {
        let mut parts = Assembly::with_limit(triangles.clamp(1, MOST_TRIANGLES));
        (self.generate)(&mut Random::new(seed), &mut parts);
        let camera = Camera::framing(&parts.bounds());
        parts.finish(&format!("gen:{}:{triangles}:{seed}", self.name), camera)
    }
}

/// Every family.
pub const FAMILIES: &[Family] = &[
    Family {
        name: "spheres",
        summary: "spheres of 48, 224 or 960 triangles, a grid cell of a 100³ cube each, radius 0.1–0.5 cells",
        seeded: true,
        generate: spheres::generate,
    },
    Family {
        name: "terrain",
        summary: "a height field of 100 × 100, six octaves of value noise, the coarsest 20 high",
        seeded: true,
        generate: sheets::terrain,
    },
    Family {
        name: "soup",
        summary: "small random triangles, uniform in a 100³ cube, each about as large as its share of space",
        seeded: true,
        generate: scattered::soup,
    },
    Family {
        name: "hairball",
        summary: "curved ribbons of 32 long thin triangles, 4 long, growing out of a ball of radius 1",
        seeded: true,
        generate: hairball::generate,
    },
    Family {
        name: "stadium",
        summary: "a ring 3 wide holding nearly all triangles, in a stadium 1,800 wide (1 in 64, at most 4,096)",
        seeded: true,
        generate: stadium::generate,
    },
    Family {
        name: "slivers",
        summary: "needles 2–40 long and 10,000 times as long as wide, in random directions in a 100³ cube",
        seeded: true,
        generate: scattered::slivers,
    },
    Family {
        name: "coincident",
        summary: "one triangle again and again",
        seeded: false,
        generate: extremes::coincident,
    },
    Family {
        name: "nested",
        summary: "concentric triangles, each half the one before (closer beyond 121, all between 2⁶⁰ and 2⁻⁶⁰)",
        seeded: false,
        generate: extremes::nested,
    },
    Family {
        name: "grid",
        summary: "unit squares in a plane on integer coordinates: ties everywhere",
        seeded: false,
        generate: sheets::grid,
    },
    Family {
        name: "boxes",
        summary: "a town of axis-aligned boxes on 8 × 8 plots: towers, walls, slabs, on a raster of 1/16",
        seeded: true,
        generate: boxes::generate,
    },
];
