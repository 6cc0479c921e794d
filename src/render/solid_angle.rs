//! The solid angle of a triangle, and directions spread evenly over it.

use glam::DVec3;

/// A triangle as it is seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SolidAngle {
    /// Unit vectors towards the corners.
    towards: [DVec3; 3],
    /// Sine and cosine of half the solid angle, up to a common factor (van Oosterom and Strackee 1983).
    sine: f64,
    cosine: f64,
}

impl SolidAngle {
    /// Of the triangle with corners at `ways` from the point.
    #[inline]
    pub(super) fn of(ways: [DVec3; 3]) -> Self {
        let [a, b, c] = ways;
        let lengths = ways.map(DVec3::length);
        // The product of edges and not of the ways themselves: those of a small triangle far away are all but the same.
        let volume = a.dot((b - a).cross(c - a)).abs();
        let towards = ways.map(DVec3::normalize_or_zero);
        let [p, q, r] = towards;
        let sine = volume / (lengths[0] * lengths[1] * lengths[2]);
        Self { towards, sine, cosine: 1.0 + p.dot(q) + q.dot(r) + r.dot(p) }
    }

    /// Unit vectors towards the corners.
    pub(super) fn towards(&self) -> [DVec3; 3] {
        self.towards
    }

    /// What stands in for its size where trigonometry would be too dear: it grows with it, from 0 to 2 at a full turn.
    #[inline]
    pub(super) fn stand_in(&self) -> f64 {
        let share = self.sine / (self.sine + self.cosine.abs());
        // Not a number from a corner of the triangle, from where it has no size.
        if self.cosine >= 0.0 { share.max(0.0) } else { 2.0 - share }
    }

    /// How large it is.
    pub(super) fn steradians(&self) -> f64 {
        2.0 * libm::atan2(self.sine, self.cosine)
    }

    /// A direction of unit length in it, by two numbers of [0, 1]: uniform over the solid angle (Arvo 1995).
    ///
    /// The first number moves corner c along its arc with a to where the triangle has that share of the solid angle. With t a unit
    /// vector across a towards c and c' = a cos θ + t sin θ, van Oosterom's formula for a, b, c' is linear in tan θ/2. The
    /// second moves from b towards c' by even steps of the cosine.
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let [a, b, c] = self.towards;
        let half = libm::atan2(self.sine, self.cosine);
        let across = |of: DVec3, from: DVec3| (of - from * of.dot(from)).normalize_or_zero();
        let t = across(c, a);
        let (sine, cosine) = (libm::sin(u * half), libm::cos(u * half));
        let tangent = sine * (1.0 + a.dot(b)) / (cosine * a.cross(b).dot(t).abs() - sine * b.dot(t));
        // cos θ and sin θ by the tangent of half the angle; beyond a straight angle it is infinite.
        let squared = tangent * tangent;
        let moved =
            if squared.is_finite() { (a * (1.0 - squared) + t * (2.0 * tangent)) / (1.0 + squared) } else { -a };
        let z = 1.0 - v * (1.0 - moved.dot(b));
        (b * z + across(moved, b) * (1.0 - z * z).max(0.0).sqrt()).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const OCTANT: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

    fn towards(corners: [[f64; 3]; 3]) -> [DVec3; 3] {
        corners.map(|c| DVec3::from(c).normalize())
    }

    #[test]
    fn known_solid_angles() {
        let steradians = |corners| SolidAngle::of(corners).steradians();
        assert!((steradians(OCTANT) - PI / 2.0).abs() < 1e-14, "an eighth of the sphere");
        // Far away it is area over squared distance.
        let far = towards([[0.0, 0.0, 1e3], [1.0, 0.0, 1e3], [0.0, 1.0, 1e3]]);
        assert!((steradians(far) / 0.5e-6 - 1.0).abs() < 1e-5);
        // Nearly all around: from just above a large triangle it is the half sphere.
        let near = towards([[-1e3, -1e3, -1e-3], [2e3, -1e3, -1e-3], [-1e3, 2e3, -1e-3]]);
        assert!((steradians(near) - 2.0 * PI).abs() < 1e-4);
        assert_eq!(steradians(towards([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])), 0.0, "from its plane");
    }

    #[test]
    fn directions_are_in_the_triangle_and_uniform() {
        let wide = towards([[-3.0, -2.0, -0.1], [4.0, -1.0, -0.2], [0.5, 3.0, -0.1]]);
        let thin = towards([[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, 2.0, 1.0]]);
        for corners in [OCTANT, wide, thin] {
            let [a, b, c] = corners;
            let sign = a.dot(b.cross(c)).signum();
            let inside = |p: DVec3, [a, b, c]: [DVec3; 3]| {
                [(a, b), (b, c), (c, a)].iter().all(|(p0, p1)| p0.cross(*p1).dot(p) * sign > -1e-9)
            };
            // Parts that tile it: each has as many directions as its share of the solid angle says.
            let middle = ((a + b) / 2.0).normalize();
            let part = [a, middle, c];
            let share = SolidAngle::of(part).steradians() / SolidAngle::of(corners).steradians();
            let n = 200;
            let mut found = 0;
            for i in 0..n * n {
                let at = [i % n, i / n].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                let direction = SolidAngle::of(corners).sample(at);
                assert!(direction.is_normalized() && inside(direction, corners), "{direction}");
                found += u32::from(inside(direction, part));
            }
            let counted = f64::from(found) / f64::from(n * n);
            assert!((counted - share).abs() < 0.01, "{counted} {share}");
        }
    }

    #[test]
    fn the_stand_in_grows_with_the_solid_angle() {
        let cap = |height: f64| towards([[-1.0, -1.0, height], [2.0, -1.0, height], [-1.0, 2.0, height]]);
        let shares: Vec<f64> = (1..200).rev().map(|i| SolidAngle::of(cap(f64::from(i) * 0.05)).stand_in()).collect();
        assert!(shares.is_sorted_by(|a, b| a < b) && shares[0] > 0.0, "{shares:?}");
        let octant = SolidAngle::of(OCTANT).stand_in();
        assert!(octant > 0.4 && octant < 0.6, "{octant}");
        let from_a_corner = SolidAngle::of([DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!((from_a_corner.stand_in(), from_a_corner.steradians().is_nan()), (0.0, true));
        // Smaller than the rounding of the unit vectors towards its corners.
        let speck = [[1e9, 0.0, 0.0], [1e9, 1e-2, 0.0], [1e9, 0.0, 1e-2]].map(DVec3::from);
        assert!((SolidAngle::of(speck).steradians() / 0.5e-22 - 1.0).abs() < 1e-6);
    }
}
