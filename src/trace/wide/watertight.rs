//! Four triangles at once by the watertight test, in f64 as [`WatertightRay`] has it, operation by operation.
//!
//! **Where t is well known.** Kernel `scalar` holds every t to the interval in which the ray is in the triangle's own box
//! ([`accepted`](crate::trace::closest::accepted)). That changes nothing where t is correct to a rounding of f32, as the box test
//! is padded by more; here it is found out when that is so. u = 2⁻⁵³; L is the greatest sheared coordinate of the triangle's vertices,
//! Z their greatest depth, both by magnitude. No vertex is farther from the origin than R = L + Z along any axis, so a
//! sheared coordinate is off by at most 8u·R, and an edge function, of coordinates of at most L, by δ = 4.5·L·8u·R + 5u·L² + …,
//! less than 2⁻⁴⁷·L·R. t over the shear's scale is N / D: D, the sum of the three edge functions, is off by 3δ, and N, the sum of their
//! products with the depths, by 3δ·Z and by roundings of less than 8u·|D|·Z, as edge functions of a triangle that is hit are of one sign. With
//! |N| ≤ |D|·Z, N / D is off by less than (6δ + 10u·|D|)·Z / |D|: so B = (2⁻⁴⁴·L·R + 2⁻⁴⁹·|D|)·Z bounds the error of t·D / scale. (The forward
//! bounds of Pharr, Jakob and Humphreys, *Physically Based Rendering*, section 6.8, applied to Woop, Benthin and Wald 2013.)
//!
//! - |N| ≥ 2²⁴·B: t is known to a rounding of f32. (Then the triangle has an area too: of one without, |D| ≤ 3δ.)
//! - |N| > 2·B and t < 0: the triangle is behind the origin for certain, as the one is that a ray has just left. So is the entry
//!   into its box, and in f32 as well: signs of differences and products are never wrong there. No ray counts hits behind its origin here.
//! - |N| > 2·B and t ≥ 0, and |D| ≥ 2⁻⁴⁴·R²: the triangle is hit before the origin, and has an area, but its box may move t. So for rays
//!   into the surface that they start on. (The area is asked for as `WatertightRay` does it: a component of the cross product is
//!   computed as zero only if it is less than 2⁻⁴⁸·R², as edges are no longer than 2R along any axis; sheared, where no factor is greater
//!   than one, all three together give a |D| of less than 3·2⁻⁴⁸·R² + 3δ, which is less than 2⁻⁴⁴·R².)
//!   Where any hit is enough t itself does not matter: if no edge function is within δ of zero the exact line goes through the triangle,
//!   so through its box, whose interval holds the exact t; with the t computed, off by half at most, far within the ray's interval,
//!   the hit stands whatever the box does to it.
//! - Else the test is made again, alone, with the triangle's box.

use super::layout::{BLOCK, Block};
use super::pack::Pack;
use super::pack64::Pack64;
use crate::geom::{Axis, Ray, WatertightRay};
use crate::trace::closest::Goal;

/// Of four triangles: bits one each, the first lowest.
pub(super) struct Found {
    /// Hit, at a `t` that is well known and within the ray's interval.
    pub surely: u32,
    /// Hit, at a `t` to be held to the triangle's own box.
    pub held: u32,
    /// To be tested alone.
    pub perhaps: u32,
    pub t: [f32; BLOCK],
}

impl Found {
    const NOTHING: Self = Self { surely: 0, held: 0, perhaps: 0, t: [0.0; BLOCK] };
}

/// Tests the triangles of `block`.
#[inline(always)]
pub(super) fn test<Q: Pack<BLOCK>, D: Pack64, G: Goal>(prepared: &WatertightRay, ray: &Ray, block: &Block) -> Found {
    let prepared = Prepared::<D>::new(prepared);
    let [a, b, c] = &block.vertices;
    let (a, b, c) = (prepared.sheared(a), prepared.sheared(b), prepared.sheared(c));
    let u = c[0].times(b[1]).minus(c[1].times(b[0]));
    let v = a[0].times(c[1]).minus(a[1].times(c[0]));
    let w = b[0].times(a[1]).minus(b[1].times(a[0]));
    let zero = D::splat(0.0);
    let (least, greatest) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
    let beside = least.below(zero) & zero.below(greatest);
    let candidates = !beside & ((1 << block.count) - 1);
    if candidates == 0 {
        return Found::NOTHING;
    }
    let determinant = u.plus(v).plus(w);
    let numerator = u.times(a[2]).plus(v.times(b[2])).plus(w.times(c[2]));
    let mut found = Found::NOTHING;
    numerator.over(determinant).times(prepared.shear[2]).store(&mut found.t);
    let l = across(&a).greater(across(&b)).greater(across(&c));
    let z = a[2].magnitude().greater(b[2].magnitude()).greater(c[2].magnitude());
    let areas = l.times(l.plus(z)).times(D::splat(power(-44)));
    let bound = areas.plus(determinant.magnitude().times(D::splat(power(-49)))).times(z);
    let size = numerator.magnitude();
    // All false for NaN.
    let well = bound.times(D::splat(power(24))).below(size);
    let signed = bound.times(D::splat(2.0)).below(size);
    let t = Q::load(&found.t);
    let within = Q::splat(ray.t_min).at_most(t) & t.at_most(Q::splat(ray.t_max.min(f32::MAX)));
    let behind = t.below(Q::splat(TINY));
    found.surely = candidates & well & within;
    let doubtful = candidates & !well & !(signed & behind);
    if doubtful != 0 {
        let reach = l.plus(z);
        let area = reach.times(reach).times(D::splat(power(-44))).below(determinant.magnitude());
        found.held = doubtful & signed & area & !t.below(Q::splat(0.0));
        found.perhaps = doubtful & !found.held;
        if G::FIRST_IS_ENOUGH {
            let edges = u.magnitude().lesser(v.magnitude()).lesser(w.magnitude());
            let through = l.times(reach).times(D::splat(power(-47))).below(edges);
            let within = Q::splat(4.0 * ray.t_min).below(t) & t.below(Q::splat(0.25 * ray.t_max));
            found.surely |= found.held & through & within;
            found.held &= !found.surely;
        }
    }
    found
}

/// −2⁻¹⁰⁰: distances to the box do not underflow either.
const TINY: f32 = -f32::from_bits((127 - 100) << 23);

/// 2 to the power of `exponent`.
const fn power(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// The greater of the coordinates across the ray.
#[inline(always)]
fn across<D: Pack64>(vertices: &[D; 3]) -> D {
    vertices[0].magnitude().greater(vertices[1].magnitude())
}

/// A [`WatertightRay`], each number four times.
struct Prepared<D> {
    axes: [Axis; 3],
    origin: [D; 3],
    shear: [D; 3],
}

impl<D: Pack64> Prepared<D> {
    #[inline(always)]
    fn new(ray: &WatertightRay) -> Self {
        let (o, s) = (ray.origin(), ray.shear());
        Self {
            axes: ray.axes(),
            origin: [D::splat(o.x), D::splat(o.y), D::splat(o.z)],
            shear: [D::splat(s.x), D::splat(s.y), D::splat(s.z)],
        }
    }

    /// Four vertices relative to the origin, sheared along the ray: two coordinates across it and one along.
    #[inline(always)]
    fn sheared(&self, v: &[[f32; BLOCK]; 3]) -> [D; 3] {
        let [x, y, z] = self.axes;
        let depth = D::load(&v[z as usize]).minus(self.origin[2]);
        [
            D::load(&v[x as usize]).minus(self.origin[0]).minus(self.shear[0].times(depth)),
            D::load(&v[y as usize]).minus(self.origin[1]).minus(self.shear[1].times(depth)),
            depth,
        ]
    }
}
