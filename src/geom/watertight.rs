//! The watertight ray–triangle test: no ray slips between two triangles that share an edge or a vertex.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. Deviation: everything is computed in
//! f64 from the f32 input. A vertex is sheared to the same point whatever triangle it belongs to, and the sign of an edge
//! function `a·b − c·d` is never wrong: rounding is monotone, so at worst it comes out as zero, and zero counts as
//! inside. So the paper's second pass in higher precision is not needed, nothing over- or underflows for any f32 input,
//! and t is correct to about one rounding to f32.

use super::{Ray, Triangle};
use glam::{DVec3, Vec3};

/// One of the three axes, in a type that needs no check as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(crate) enum Axis {
    X,
    Y,
    Z,
}

/// A ray prepared for the watertight test: the shear that turns it into the z axis.
#[derive(Clone, Copy, Debug)]
pub struct WatertightRay {
    /// The axis along which the direction is greatest becomes z.
    axes: [Axis; 3],
    /// In the order of `axes`.
    origin: DVec3,
    shear: DVec3,
}

/// The axes in the order that the watertight test looks at them in: that along which `direction` is greatest comes last.
#[inline(always)]
fn shear_axes(direction: Vec3) -> [Axis; 3] {
    static ORDERS: [[Axis; 3]; 3] =
        [[Axis::Y, Axis::Z, Axis::X], [Axis::Z, Axis::X, Axis::Y], [Axis::X, Axis::Y, Axis::Z]];
    let [x, y, z] = direction.abs().to_array();
    // Without branches: nobody can guess them.
    let larger = usize::from(y > x);
    let last = if (z > x) & (z > y) { 2 } else { larger };
    ORDERS[last]
}

impl WatertightRay {
    /// Prepares `ray`, which must be traceable ([`Ray::is_traceable`]); of others, every test is a miss.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let axes = shear_axes(ray.direction);
        let (d, o): (&[f32; 3], &[f32; 3]) = (bytemuck::cast_ref(&ray.direction), bytemuck::cast_ref(&ray.origin));
        let [dx, dy, dz] = axes.map(|axis| f64::from(d[axis as usize]));
        let [x, y, z] = axes.map(|axis| f64::from(o[axis as usize]));
        // Four divisions for three: as one instruction.
        let [sx, sy, sz, _] = [dx, dy, 1.0, 1.0].map(|d| d / dz);
        Self { axes, origin: DVec3::new(x, y, z), shear: DVec3::new(sx, sy, sz) }
    }

    /// The order in which axes are looked at: that along which the direction is greatest comes last.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [Axis; 3] {
        self.axes
    }

    /// In the order of [`Self::axes`].
    #[inline(always)]
    pub(crate) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// What is taken off the first two axes for each step along the third; t over the depth along it.
    #[inline(always)]
    pub(crate) fn shear(&self) -> DVec3 {
        self.shear
    }

    /// A vertex relative to the origin, sheared along the ray: two coordinates across it and one along.
    #[inline(always)]
    fn sheared(&self, vertex: impl Fn(Axis) -> f32) -> (f64, f64, f64) {
        let [x, y, z] = self.axes.map(|axis| f64::from(vertex(axis)));
        let depth = z - self.origin.z;
        (x - self.origin.x - self.shear.x * depth, y - self.origin.y - self.shear.y * depth, depth)
    }

    /// Where the line of the ray meets `triangle`, two-sided, boundary included: t, unlimited by the ray's interval.
    ///
    /// `None` where it passes beside, lies in the plane, or the triangle has no area.
    #[inline]
    pub fn meets(&self, triangle: &Triangle) -> Option<f32> {
        let corners = self.corners(triangle);
        let [a, b, c] = corners;
        // Each edge function is looked at before the next is computed: most triangles are passed by.
        let u = c.0 * b.1 - c.1 * b.0;
        let v = a.0 * c.1 - a.1 * c.0;
        if (u < 0.0 && v > 0.0) || (u > 0.0 && v < 0.0) {
            return None;
        }
        let w = b.0 * a.1 - b.1 * a.0;
        if (w < 0.0 && (u > 0.0 || v > 0.0)) || (w > 0.0 && (u < 0.0 || v < 0.0)) {
            return None;
        }
        let det = u + v + w;
        // The area is asked for only here: rounding can leave a needle a determinant, but no area.
        if det == 0.0 || det.is_nan() || triangle.cross() == DVec3::ZERO {
            return None;
        }
        Some(self.t(corners, [u, v, w], det))
    }

    #[inline(always)]
    fn corners(&self, triangle: &Triangle) -> [(f64, f64, f64); 3] {
        // Picked from memory in f32: picking from registers by a variable axis would go through the stack.
        triangle.v.each_ref().map(|vertex| {
            let vertex: &[f32; 3] = bytemuck::cast_ref(vertex);
            self.sheared(|axis| vertex[axis as usize])
        })
    }

    #[inline(always)]
    fn t(&self, [a, b, c]: [(f64, f64, f64); 3], [u, v, w]: [f64; 3], det: f64) -> f32 {
        ((u * a.2 + v * b.2 + w * c.2) / det * self.shear.z) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: Triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);

    fn meets(triangle: &Triangle, origin: Vec3, direction: Vec3) -> Option<f32> {
        WatertightRay::new(&Ray::new(origin, direction)).meets(triangle)
    }

    #[test]
    fn hits_from_both_sides_boundary_included() {
        let [a, b, c] = T.v;
        let turned = [T, Triangle::new(b, c, a), Triangle::new(c, a, b), Triangle::new(a, c, b)];
        let cases = [
            (0.25, 0.25, true),
            (0.0, 0.0, true),
            (0.5, 0.5, true),
            (0.5, 0.0, true),
            (0.0, 0.5, true),
            (1.0, 0.0, true),
            (0.75, 0.75, false),
            (-0.1, 0.5, false),
            (1.1, 0.0, false),
        ];
        for triangle in turned {
            for z in [-2.0, 2.0] {
                for (x, y, hit) in cases {
                    let t = meets(&triangle, Vec3::new(x, y, z), Vec3::new(0.0, 0.0, -z));
                    assert_eq!(t, hit.then_some(1.0), "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn in_plane_rays_needles_and_nan_miss() {
        assert_eq!(meets(&T, Vec3::new(-1.0, 0.25, 0.0), Vec3::X), None);
        assert_eq!(meets(&T, Vec3::new(-1.0, 0.25, -0.0), Vec3::new(1.0, -0.0, 0.0)), None);
        let d = Vec3::new(0.3, 0.7, 0.11);
        let needle = Triangle::new(d, d * 2.0, d * 4.0);
        let point = Triangle::new(d, d, d);
        for towards in [d, d * 2.0, d * 3.0, d * 1.5 + Vec3::X * 1e-8] {
            let eye = Vec3::new(1.0, 2.0, 3.0);
            assert_eq!(meets(&needle, eye, towards - eye), None);
            assert_eq!(meets(&point, eye, towards - eye), None);
        }
        assert_eq!(meets(&T, Vec3::splat(f32::NAN), Vec3::NEG_Z), None);
    }

    #[test]
    fn extreme_scales_keep_the_hit() {
        for scale in [1e-44_f32, 1e-30, 1.0, 1e19, 1e37] {
            let t = Triangle::new(Vec3::ZERO, Vec3::X * scale * 4.0, Vec3::Y * scale * 4.0);
            let ray = (Vec3::new(scale, scale, scale), Vec3::NEG_Z);
            assert_eq!(meets(&t, ray.0, ray.1), Some(scale), "{scale:e}");
        }
        assert_eq!(
            meets(&T, Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z * 1e-44),
            Some((1.0 / f64::from(1e-44_f32)) as f32)
        );
    }
}
