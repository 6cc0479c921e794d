//! References: triangles, or parts of triangles, each with a box around it.
//!
//! **No part is lost.** Cut in two, a triangle must be found by every ray that the triangle tests say hits it. They say
//! so of a ray that passes beside it by a rounding, and they report the hit a rounding before or behind the place where
//! it is. So a part's box is drawn wider than the part by a margin, across the cutting plane too, but never beyond the
//! box that was cut. Then for every point of the triangle there is a leaf whose box holds all that lies within the
//! margin of it, as far as the triangle's own box does. Which is what a ray is held to in the end: see `trace::closest`.
//!
//! The margin covers the watertight test in f64, whose point of a hit is wrong by some roundings (2⁻⁵³) of the extent,
//! times the extent over the height in a slender triangle, times 1/sin of the angle at which the ray meets the plane.
//! 2⁻²⁰ of the extent, or 2⁻⁴⁴ of it over the slenderness, leaves room for angles down to 2⁻²⁰ and less.

use crate::build::Input;
use crate::geom::{Aabb, Polygon, cut};
use glam::{DVec3, Vec3};

/// A triangle or a part of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// A box that holds the part.
    pub aabb: Aabb,
    /// The triangle.
    pub id: u32,
}

/// What is cut: triangles where they are known, or else boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a>(pub Input<'a>);

impl Source<'_> {
    /// Puts the part of the triangle in the reference's box into `polygon`; `false` where triangles are not known.
    #[inline]
    pub fn part(&self, reference: &Reference, polygon: &mut Polygon) -> bool {
        let id = reference.id as usize;
        let Some(triangles) = self.0.triangles else { return false };
        polygon.clear();
        polygon.extend(triangles[id].v.map(|p| p.as_dvec3()));
        let (whole, part) = (&self.0.boxes[id], &reference.aabb);
        for axis in 0..3 {
            if part.min[axis] > whole.min[axis] {
                *polygon = cut(polygon, axis, f64::from(part.min[axis]), 1.0);
            }
            if part.max[axis] < whole.max[axis] {
                *polygon = cut(polygon, axis, f64::from(part.max[axis]), -1.0);
            }
        }
        true
    }

    /// How far a box is drawn beyond the part it is around, in scene units.
    fn margin(&self, id: u32) -> f64 {
        const LEAST: f64 = 1.0 / (1 << 20) as f64;
        const SLENDER: f64 = 1.0 / (1u64 << 44) as f64;
        let extent = self.0.boxes[id as usize].extent().max_element();
        let twice_area = self.0.triangles.map_or(0.0, |t| t[id as usize].cross().length());
        // One without area is never hit.
        let over_slenderness = if twice_area > 0.0 { SLENDER * (extent * extent / twice_area) } else { 0.0 };
        extent * LEAST.max(over_slenderness)
    }

    /// Cuts a reference at a plane inside its box: boxes of the part below and of the part above.
    ///
    /// A box is empty where nothing is left for that side, or so little that the reference goes whole to the other.
    pub fn cut(&self, reference: &Reference, axis: usize, at: f32) -> [Aabb; 2] {
        let whole = &reference.aabb;
        let only_below = [*whole, Aabb::EMPTY];
        let only_above = [Aabb::EMPTY, *whole];
        let plane = f64::from(at);
        let margin = self.margin(reference.id);
        let (top, bottom) = (round_up(plane + margin), round_down(plane - margin));
        if top >= whole.max[axis] {
            return only_below;
        }
        if bottom <= whole.min[axis] {
            return only_above;
        }
        let mut polygon = Polygon::new();
        if !self.part(reference, &mut polygon) {
            let (mut below, mut above) = (*whole, *whole);
            (below.max[axis], above.min[axis]) = (top, bottom);
            return [below, above];
        }
        let (below, above) = (cut(&polygon, axis, plane, -1.0), cut(&polygon, axis, plane, 1.0));
        match (below.is_empty(), above.is_empty()) {
            (_, true) => only_below,
            (true, false) => only_above,
            (false, false) => [around(&below, margin, whole), around(&above, margin, whole)],
        }
    }
}

/// The box around a polygon with its margin, as far as it lies in `whole`.
fn around(polygon: &Polygon, margin: f64, whole: &Aabb) -> Aabb {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &corner in polygon {
        (low, high) = (low.min(corner), high.max(corner));
    }
    let low = (low - margin).to_array().map(round_down);
    let high = (high + margin).to_array().map(round_up);
    Aabb::new(whole.min.max(Vec3::from(low)), whole.max.min(Vec3::from(high)))
}

/// The greatest f32 that is not above `x`.
fn round_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// The least f32 that is not below `x`.
fn round_up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}
