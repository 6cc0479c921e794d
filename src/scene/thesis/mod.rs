//! The thesis' scene at its tessellations: a cup, eight blobs, a slab and a torus, generated from parameters.
//!
//! Beick's Figure 3 (thesis, 2014). Points are computed in f64 and rounded to f32 once; triangle ids follow the order
//! written here, because the published builders break ties by id. The parameters were measured on the author's
//! published files; the file of the level `huge` is lost, and only its counts are known.

mod blob;
mod cup;
mod lattice;
mod quad;
mod slab;
#[cfg(test)]
mod tests;
mod torus;

use super::assemble::Assembly;
use super::{Camera, Scene};
use glam::{DVec3, Vec3};
use quad::Placement;

/// A tessellation of the thesis' scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Level {
    /// 648 triangles.
    Tiny,
    /// 2,540 triangles: the count the thesis means, with a coarser slab than the surviving file's.
    Small,
    /// 2,940 triangles: the surviving file's "Small".
    Small2940,
    /// 11,516 triangles.
    Med,
    /// 25,340 triangles.
    Large,
    /// 88,748 triangles; its parts are chosen to meet the known counts.
    Huge,
}

impl Level {
    /// Its entry in [`LEVELS`].
    pub fn info(self) -> &'static LevelInfo {
        &LEVELS[self as usize]
    }
}

/// What there is to say about a [`Level`] without generating it.
#[derive(Clone, Copy, Debug)]
pub struct LevelInfo {
    /// The level.
    pub level: Level,
    /// Its name after `thesis:`.
    pub name: &'static str,
    /// How many triangles it has.
    pub triangles: usize,
    /// Surface area in square scene units, to four decimals.
    pub surface_area: f64,
    /// One line about it.
    pub summary: &'static str,
}

/// Every level, from the coarsest to the finest, in the order of [`Level`].
pub const LEVELS: &[LevelInfo] = &[
    LevelInfo {
        level: Level::Tiny,
        name: "tiny",
        triangles: 648,
        surface_area: 762.4795,
        summary: "Figure 3, cubes for blobs",
    },
    LevelInfo {
        level: Level::Small,
        name: "small",
        triangles: 2_540,
        surface_area: 741.1056,
        summary: "Figure 3 with the thesis' count (printed so in Table 1): a slab of 112 triangles",
    },
    LevelInfo {
        level: Level::Small2940,
        name: "small2940",
        triangles: 2_940,
        surface_area: 741.1056,
        summary: "Figure 3 as in the surviving file of Small: a slab of 512 triangles",
    },
    LevelInfo {
        level: Level::Med,
        name: "med",
        triangles: 11_516,
        surface_area: 756.0067,
        summary: "Figure 3, blobs and torus subdivided and smoothed, the slab bulged",
    },
    LevelInfo {
        level: Level::Large,
        name: "large",
        triangles: 25_340,
        surface_area: 748.6781,
        summary: "Figure 3, with grooves in the cup",
    },
    LevelInfo {
        level: Level::Huge,
        name: "huge",
        triangles: 88_748,
        surface_area: 746.8282,
        summary: "Figure 3 with the known counts of the lost file: spheres for blobs, everything finer",
    },
];

/// The camera of every level; its `up` turns the thesis' picture upside down.
pub const CAMERA: Camera =
    Camera { eye: Vec3::new(22.0, 22.0, 32.0), look_at: Vec3::ZERO, up: Vec3::new(0.0, -1.0, 0.0), fov_degrees: 30.0 };

const CUP: Placement = Placement::uniform([-0.846907, -0.237633, -2.423190], 1.4496125);
const TORUS: Placement = Placement::uniform([3.921158, 1.746835, 2.060894], 2.577009);
const SLAB: Placement =
    Placement { loc: DVec3::new(-6.385649, 5.361899, 0.343184), scale: DVec3::new(1.0, 5.217342, 7.418953) };
const BLOB_NAMES: [&str; 8] = ["A", "B", "C", "D", "E", "F", "G", "H"];
const TINY_BLOBS: [Placement; 8] = [
    Placement::uniform([8.411344, 1.429286, -4.561950], 1.439553),
    Placement::uniform([9.071236, 0.144228, 5.785327], 1.322321),
    Placement::uniform([3.808531, 1.298840, 2.002382], 0.603991),
    Placement::uniform([0.616921, 3.892485, 6.152051], 0.603991),
    Placement::uniform([-0.033386, 4.809557, -3.016536], 0.603991),
    Placement::uniform([-0.729989, 10.165934, 0.086579], 0.561885),
    Placement::uniform([1.793369, 10.105069, -3.883293], 0.561885),
    Placement::uniform([1.060864, 10.284799, -1.826524], 1.322321),
];
const BLOBS: [Placement; 8] = [
    Placement::uniform([8.452355, 1.772895, -4.555751], 1.322321),
    Placement::uniform([9.071236, 0.144228, 5.785327], 1.322321),
    Placement::uniform([3.922379, 1.506974, 2.025239], 0.629875),
    Placement::uniform([0.639152, 3.884331, 6.059883], 0.629875),
    Placement::uniform([-0.094839, 5.378910, -2.541951], 0.629875),
    Placement::uniform([-0.872503, 10.306562, -0.102231], 0.629875),
    Placement::uniform([1.638509, 10.140035, -3.899896], 0.629875),
    Placement::uniform([1.081857, 10.297029, -1.836590], 1.322321),
];

/// Generates a level, in world axes (y up) and scene units.
pub fn generate(level: Level) -> Scene {
    let info = level.info();
    let mut parts = Assembly::with_limit(info.triangles);
    let mut add = |name: &str, place: &Placement, triangles: &[_]| {
        parts.begin(name);
        triangles.iter().for_each(|t| parts.push(place.apply(t)));
    };
    add("cup", &CUP, &cup::triangles(level));
    let blob = blob::triangles(level);
    let places = if level == Level::Tiny { &TINY_BLOBS } else { &BLOBS };
    for (name, place) in BLOB_NAMES.iter().zip(places) {
        add(name, place, &blob);
    }
    add("slab", &SLAB, &slab::triangles(level));
    add("torus", &TORUS, &torus::triangles(level));
    let name = LEVELS.iter().find(|info| info.level == level).map_or("", |info| info.name);
    parts.finish(&format!("thesis:{name}"), CAMERA)
}
