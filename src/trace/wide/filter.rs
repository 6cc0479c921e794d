//! Four triangles at once, in f32, and never a wrong "no": what passes is tested again in f64, one by one.
//!
//! The watertight test ([`WatertightRay`](crate::geom::WatertightRay)) shears each vertex by the ray and asks for the
//! signs of three edge functions; a triangle is passed by where two of them are of opposite signs. Here the same is computed in
//! f32, with a bound δ on how far each edge function can be from that of the f64 test, and a triangle is left out only where one
//! is below −δ and another above δ: then the f64 test's signs are these too, and it misses.
//!
//! The bound. ε = 2⁻²⁴; R is no less than any |coordinate − origin| in the scene. With |shear| ≤ 1, a sheared coordinate
//! x = d_x − s·d_z is off by at most ε·R for rounding d_x, 2ε·R for d_z and s in their product, ε·R for the product and 2ε·R for the
//! difference: 6ε·R, to first order, plus 2⁻¹⁴⁹ where products underflow. E = 8ε·R + 2⁻¹⁴⁰ covers it and the f64 test's own rounding, 2²⁹
//! times smaller. An edge function x₁y₂ − y₁x₂ of coordinates of at most L is then off by at most 4·L·E + 2·E² for its
//! coordinates and 4ε·L² for its own roundings. δ = 4.5·L·E + 5ε·L² + 3·E² + 2⁻¹⁴⁰, the excess being for the roundings of δ. L is that of the
//! triangle: small for a triangle near the ray, wherever along it. (The forward bounds of Pharr, Jakob and Humphreys,
//! *Physically Based Rendering*, section 6.8, applied to Woop, Benthin and Wald 2013.)

use super::layout::{BLOCK, Block};
use super::pack::Pack;
use crate::geom::{Aabb, Ray};

/// A ray prepared for the filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilterRay {
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
    /// 4.5·E.
    linear: f32,
    /// 3·E² + 2⁻¹⁴⁰.
    constant: f32,
}

/// 2⁻¹⁴⁰.
const ABSOLUTE: f32 = f32::from_bits(1 << 9);

impl FilterRay {
    /// Prepares `ray` for triangles within `bounds`. Where products could overflow, nothing is left out.
    #[inline(always)]
    pub fn new(ray: &Ray, bounds: &Aabb) -> Self {
        /// 2⁶⁰.
        const FAR: f32 = (1u64 << 60) as f32;
        let size = ray.direction.abs();
        // The choice of the f64 test.
        let z = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let (d, o) = (ray.direction.to_array(), ray.origin.to_array());
        let reach = (bounds.min - ray.origin).abs().max((bounds.max - ray.origin).abs()).max_element();
        // 8ε, a little more for the rounding of the reach itself.
        let error = if reach <= FAR { reach * (8.5 / (1 << 24) as f32) + ABSOLUTE } else { f32::INFINITY };
        Self {
            axes,
            origin: axes.map(|a| o[a]),
            shear: [d[axes[0]] / d[z], d[axes[1]] / d[z]],
            linear: 4.5 * error,
            constant: 3.0 * error * error + ABSOLUTE,
        }
    }

    /// Four vertices relative to the origin, sheared along the ray: the two coordinates across it.
    #[inline(always)]
    fn sheared<P: Pack<BLOCK>>(&self, v: &[[f32; BLOCK]; 3]) -> (P, P) {
        let [kx, ky, kz] = self.axes;
        let depth = P::load(&v[kz]).minus(P::splat(self.origin[2]));
        let x = P::load(&v[kx]).minus(P::splat(self.origin[0])).minus(P::splat(self.shear[0]).times(depth));
        let y = P::load(&v[ky]).minus(P::splat(self.origin[1])).minus(P::splat(self.shear[1]).times(depth));
        (x, y)
    }

    /// One bit for each triangle of `block` that the f64 test may hit, the first lowest.
    #[inline(always)]
    pub fn candidates<P: Pack<BLOCK>>(&self, block: &Block) -> u32 {
        let a = self.sheared::<P>(&block.vertices[0]);
        let b = self.sheared::<P>(&block.vertices[1]);
        let c = self.sheared::<P>(&block.vertices[2]);
        let u = c.0.times(b.1).minus(c.1.times(b.0));
        let v = a.0.times(c.1).minus(a.1.times(c.0));
        let w = b.0.times(a.1).minus(b.1.times(a.0));
        let l = a.0.magnitude().greater(a.1.magnitude());
        let l = l.greater(b.0.magnitude().greater(b.1.magnitude()));
        let l = l.greater(c.0.magnitude().greater(c.1.magnitude()));
        let quadratic = P::splat(5.0 / (1 << 24) as f32);
        let delta = l.times(P::splat(self.linear).plus(l.times(quadratic))).plus(P::splat(self.constant));
        let (least, greatest) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
        let beside = least.below(P::splat(0.0).minus(delta)) & delta.below(greatest);
        !beside & ((1 << block.count) - 1)
    }
}
