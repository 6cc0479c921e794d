//! Four triangles at once, in f32, and never a wrong "no": what passes is tested again in f64, one by one.
//!
//! The watertight test ([`WatertightRay`](crate::geom::WatertightRay)) shears each vertex by the ray and asks for the
//! signs of three edge functions; a triangle is passed by where two of them are of opposite signs. Here the same is computed in
//! f32, with a bound δ on how far each edge function can be from that of the f64 test, and a triangle is left out only where one
//! is below −δ and another above δ: then the f64 test's signs are these too, and it misses.
//!
//! The bound. ε = 2⁻²⁴; L is the greatest sheared coordinate of the triangle's vertices, Z their greatest depth, both by magnitude.
//! With |shear| ≤ 1, no vertex is farther from the origin than R = L + Z along any axis. A sheared coordinate x = d_x − s·d_z is off by
//! at most ε·R for rounding d_x, 2ε·R for d_z and s in their product, ε·R for the product and 2ε·R for the difference: 6ε·R, to
//! first order, plus 2⁻¹⁴⁹ where products underflow. E = 8ε·R + 2⁻¹⁴⁰ covers it and the f64 test's own rounding, 2²⁹ times smaller. An
//! edge function x₁y₂ − y₁x₂ of coordinates of at most L is then off by at most 4·L·E + 2·E² for its coordinates and 4ε·L² for its own
//! roundings. δ = 4.5·L·E + 5ε·L² + 3·E² + 2⁻¹⁴⁰, the excess being for the roundings of δ. It is small for a triangle near the ray and
//! for one near its origin, however large the scene. (The forward bounds of Pharr, Jakob and Humphreys, *Physically Based
//! Rendering*, section 6.8, applied to Woop, Benthin and Wald 2013.)
//!
//! **Sure hits.** Where all three edge functions are above δ, or all below −δ, the f64 test's have these signs too: it hits, and its
//! determinant D is their sum. Its t is a mean of the vertices' depths z, weighted by the edge functions over D. With q = δ/|D| as
//! computed here, the weights are off by 5δ/|D| in all, which is at most 8q for q ≤ ⅛ (D is off by 3δ), and any two means by no more
//! than the triangle's extent along z, so 8q bounds the error over that extent for every q; roundings add 16ε of the extent
//! and 4ε of the greatest depth, those of t itself and of its being moved into the triangle's box less than 16ε of t.

use super::layout::{BLOCK, Block};
use super::pack::Pack;
use crate::geom::{Ray, shear_axes};
use crate::trace::slab::Slabs;
use glam::Vec3A;

/// A ray prepared for the filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilterRay {
    axes: [usize; 3],
    origin: [f32; 3],
    shear: [f32; 2],
    /// 1 / direction along the third axis.
    scale: f32,
    /// 2⁻¹⁴⁰; infinite where products could overflow.
    constant: f32,
}

/// 2⁻²⁴: a rounding.
const EPSILON: f32 = 1.0 / (1 << 24) as f32;

/// 2⁻¹⁴⁰.
const ABSOLUTE: f32 = f32::from_bits(1 << 9);

impl FilterRay {
    /// Prepares a ray for triangles with no coordinate beyond `reach`. Where products could overflow, nothing is left out.
    #[inline(always)]
    pub fn new(ray: &Ray, slabs: &Slabs, reach: f32) -> Self {
        /// 2⁵⁸.
        const FAR: f32 = (1u64 << 58) as f32;
        let axes = shear_axes(ray.direction);
        let [x, y, z] = axes;
        let (direction, origin, inverse) = (ray.direction.to_array(), ray.origin.to_array(), slabs.inverse.to_array());
        let shear = (Vec3A::from(ray.direction) / direction[z]).to_array();
        Self {
            axes,
            origin: [origin[x], origin[y], origin[z]],
            shear: [shear[x], shear[y]],
            scale: inverse[z],
            constant: if reach.max(slabs.origin.abs().max_element()) <= FAR { ABSOLUTE } else { f32::INFINITY },
        }
    }

    /// Four vertices relative to the origin, sheared along the ray: two coordinates across it and one along.
    #[inline(always)]
    fn sheared<P: Pack<BLOCK>>(&self, v: &[[f32; BLOCK]; 3]) -> [P; 3] {
        let [kx, ky, kz] = self.axes;
        let depth = P::load(&v[kz]).minus(P::splat(self.origin[2]));
        let x = P::load(&v[kx]).minus(P::splat(self.origin[0])).minus(P::splat(self.shear[0]).times(depth));
        let y = P::load(&v[ky]).minus(P::splat(self.origin[1])).minus(P::splat(self.shear[1]).times(depth));
        [x, y, depth]
    }

    /// On which sides of their edges the ray passes the triangles of `block`.
    #[inline(always)]
    pub fn sides<P: Pack<BLOCK>>(&self, block: &Block) -> Sides<P> {
        let a = self.sheared::<P>(&block.vertices[0]);
        let b = self.sheared::<P>(&block.vertices[1]);
        let c = self.sheared::<P>(&block.vertices[2]);
        let u = c[0].times(b[1]).minus(c[1].times(b[0]));
        let v = a[0].times(c[1]).minus(a[1].times(c[0]));
        let w = b[0].times(a[1]).minus(b[1].times(a[0]));
        let larger = |p: &[P; 3]| p[0].magnitude().greater(p[1].magnitude());
        let l = larger(&a).greater(larger(&b)).greater(larger(&c));
        let z = a[2].magnitude().greater(b[2].magnitude()).greater(c[2].magnitude());
        // 8ε, a little more for its own rounding.
        let e = l.plus(z).times(P::splat(8.5 * EPSILON)).plus(P::splat(ABSOLUTE));
        let linear = l.times(P::splat(5.0 * EPSILON)).plus(e.times(P::splat(4.5)));
        let delta = l.times(linear).plus(e.times(e).times(P::splat(3.0))).plus(P::splat(self.constant));
        Sides { edges: [u, v, w], delta, depths: [a[2], b[2], c[2]] }
    }

    /// Bounds on t of those triangles that are hit for certain.
    #[inline(always)]
    pub fn bounds<P: Pack<BLOCK>>(&self, sides: &Sides<P>) -> Bounds<P> {
        let Sides { edges: [u, v, w], delta, depths: [a, b, c] } = *sides;
        let (least, greatest) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
        let sure = delta.below(least) | greatest.below(P::splat(0.0).minus(delta));
        let inverse = P::splat(1.0).over(u.plus(v).plus(w));
        let depth = c.plus(u.times(inverse).times(a.minus(c))).plus(v.times(inverse).times(b.minus(c)));
        let (near, far) = (a.lesser(b).lesser(c), a.greater(b).greater(c));
        let doubt = delta.times(inverse.magnitude()).times(P::splat(8.0)).plus(P::splat(16.0 * EPSILON));
        let away = near.magnitude().greater(far.magnitude());
        let error = far.minus(near).times(doubt).plus(away.times(P::splat(4.0 * EPSILON)));
        let scale = P::splat(self.scale);
        let (one, other) = (depth.minus(error).times(scale), depth.plus(error).times(scale));
        let (least, most) = (one.lesser(other), one.greater(other));
        let room = |t: P| t.magnitude().times(P::splat(16.0 * EPSILON)).plus(P::splat(ABSOLUTE));
        Bounds { sure, least: least.minus(room(least)), most: most.plus(room(most)) }
    }
}

/// On which sides of its edges the ray passes each of four triangles.
pub(super) struct Sides<P> {
    edges: [P; 3],
    delta: P,
    /// Of the vertices, along the axis where the direction is greatest.
    depths: [P; 3],
}

impl<P: Pack<BLOCK>> Sides<P> {
    /// One bit for each triangle of `block` that the f64 test may hit, the first lowest.
    #[inline(always)]
    pub fn candidates(&self, block: &Block) -> u32 {
        let [u, v, w] = self.edges;
        let (least, greatest) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
        let beside = least.below(P::splat(0.0).minus(self.delta)) & self.delta.below(greatest);
        !beside & ((1 << block.count) - 1)
    }
}

/// What f32 knows of where four triangles are hit.
pub(super) struct Bounds<P> {
    /// One bit for each triangle that the f64 test hits for certain, the first lowest; t is bounded for these.
    pub sure: u32,
    pub least: P,
    pub most: P,
}
