//! The judge of all kernels: every triangle in f64, without a tree, a box or any pruning, and with bounds on what it can tell.
//!
//! A triangle is crossed by Möller and Trumbore's formula in f64, not by the test of any kernel that is exact. No f32 input
//! over- or underflows there: products of three f32 stay between 2⁻⁴⁴⁷ and 2³⁹⁰.
//!
//! Rounding leaves some questions open, and the oracle says which. A weight of a crossing (det, U, V or W of the formula) is a sum
//! of products of three differences, e₁·(d×e₂) and the like. Its forward error is at most 6u times the sum of the products'
//! magnitudes (Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, section 3.1), and that is no more than
//! u·8·|d|·|e|·|s| in 1-norms. A crossing whose weights are beyond such bounds of 0 is certain; one with a weight within them
//! is at the border, where hit and miss are both right. The bounds are those of the arithmetic that is judged, f64 or f32
//! ([`Arithmetic`]): so kernels are not blamed for what their number format cannot know, and for nothing else are excused.

use crate::geom::{Hit, Ray, Triangle};
use glam::DVec3;

/// Whose answers are judged: what a triangle test may get wrong by rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// The watertight test in f64 ([`crate::geom::WatertightRay`]).
    Watertight,
    /// Möller–Trumbore in f32 ([`Triangle::intersect`]).
    Fast,
}

/// Where a ray's line crosses a triangle, certainly or perhaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The triangle's id.
    pub triangle: u32,
    /// Ray parameter; may lie outside of the ray's interval.
    pub t: f64,
    /// How far another right answer's t may be from it: 4 units in the last place of f32, and the bound on rounding.
    pub tolerance: f64,
    /// Whether the crossing is certain; else the ray passes within rounding of the triangle's border.
    pub certain: bool,
}

/// What an answer is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// As the oracle has it: the same triangle, or one as near.
    Right,
    /// Right, where a miss (or that hit) at a triangle's border would be right as well.
    Border,
    /// Nothing, where there is a certain hit.
    Missed,
    /// A triangle that is hit, where another one is certainly nearer.
    Farther,
    /// A triangle that the ray passes by, or that is hit outside of the ray's interval.
    Beside,
    /// A triangle that is hit, but not at that t.
    Off,
}

impl Verdict {
    /// Whether the answer stands.
    pub const fn is_right(self) -> bool {
        matches!(self, Self::Right | Self::Border)
    }
}

/// All crossings of one ray.
#[derive(Clone, Debug)]
pub struct Oracle {
    t_min: f64,
    t_max: f64,
    crossings: Vec<Crossing>,
}

impl Oracle {
    /// Crosses `ray` with every one of `triangles`; a ray that is none ([`Ray::is_traceable`]) crosses nothing.
    pub fn new(triangles: &[Triangle], ray: &Ray, arithmetic: Arithmetic) -> Self {
        let crossings = if ray.is_traceable() {
            let one = |(id, triangle)| cross(id as u32, triangle, ray, arithmetic);
            triangles.iter().enumerate().filter_map(one).collect()
        } else {
            Vec::new()
        };
        // A t that f32 cannot hold is no hit.
        let t_max = f64::from(ray.t_max.min(f32::MAX));
        Self { t_min: f64::from(ray.t_min.max(f32::MIN)), t_max, crossings }
    }

    /// The crossings that may be hits, by id; some of them not certain.
    pub fn possible(&self) -> impl Iterator<Item = &Crossing> {
        self.crossings.iter().filter(|c| c.t + c.tolerance >= self.t_min && c.t - c.tolerance <= self.t_max)
    }

    /// The crossings that are certainly hits, by id.
    pub fn certain(&self) -> impl Iterator<Item = &Crossing> {
        let inside = |c: &&Crossing| c.t - c.tolerance > self.t_min && c.t + c.tolerance < self.t_max;
        self.crossings.iter().filter(|c| c.certain).filter(inside)
    }

    /// Judges the closest hit.
    pub fn judge(&self, found: Option<Hit>) -> Verdict {
        let Some(hit) = found else {
            return match (self.certain().next(), self.possible().next()) {
                (Some(_), _) => Verdict::Missed,
                (None, Some(_)) => Verdict::Border,
                (None, None) => Verdict::Right,
            };
        };
        let verdict = self.judge_one(&hit);
        let nearer = |own: &Crossing| self.certain().any(|c| c.t + c.tolerance < own.t - own.tolerance);
        if verdict.is_right() && self.of(hit.triangle).is_some_and(nearer) { Verdict::Farther } else { verdict }
    }

    fn of(&self, triangle: u32) -> Option<&Crossing> {
        self.crossings.iter().find(|c| c.triangle == triangle)
    }

    /// Judges a hit for itself, whatever else there is.
    fn judge_one(&self, hit: &Hit) -> Verdict {
        let t = f64::from(hit.t);
        match self.of(hit.triangle) {
            None => Verdict::Beside,
            Some(crossing) if (t - crossing.t).abs() > crossing.tolerance => Verdict::Off,
            Some(_) if !(self.t_min..=self.t_max).contains(&t) => Verdict::Beside,
            Some(crossing) if crossing.certain => Verdict::Right,
            Some(_) => Verdict::Border,
        }
    }

    /// Judges all hits, which must come by t, then id: the worst verdict on any, or [`Verdict::Missed`] where a certain one lacks.
    pub fn judge_all(&self, found: &[Hit]) -> Verdict {
        let ordered = found.is_sorted_by(|a, b| a.t < b.t || (a.t == b.t && a.triangle < b.triangle));
        if !ordered || self.certain().any(|c| !found.iter().any(|hit| hit.triangle == c.triangle)) {
            return Verdict::Missed;
        }
        let verdicts: Vec<_> = found.iter().map(|hit| self.judge_one(hit)).collect();
        let worst =
            verdicts.iter().find(|v| !v.is_right()).or_else(|| verdicts.iter().find(|v| **v == Verdict::Border));
        worst.copied().unwrap_or(Verdict::Right)
    }

    /// Judges the answer to whether there is a hit.
    pub fn judge_any(&self, found: bool) -> Verdict {
        match (found, self.certain().next(), self.possible().next()) {
            (true, Some(_), _) | (false, _, None) => Verdict::Right,
            (_, None, Some(_)) => Verdict::Border,
            (true, None, None) => Verdict::Beside,
            (false, Some(_), _) => Verdict::Missed,
        }
    }
}

fn cross(id: u32, triangle: &Triangle, ray: &Ray, arithmetic: Arithmetic) -> Option<Crossing> {
    // A triangle without area is never hit: what all tests mean by that is the area in f64.
    if triangle.cross() == DVec3::ZERO {
        return None;
    }
    let [a, b, c] = triangle.v.map(|p| p.as_dvec3());
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2, s) = (b - a, c - a, o - a);
    let (p, q) = (d.cross(e2), s.cross(e1));
    let (det, u, v, height) = (e1.dot(p), s.dot(p), d.dot(q), e2.dot(q));
    let w = det - u - v;
    let bound = Bounds::new([a - o, b - o, c - o], [e1, e2], d, arithmetic);
    let least = u.min(v).min(w);
    let greatest = u.max(v).max(w);
    if least < -bound.weight && greatest > bound.weight {
        return None;
    }
    let certain = least > bound.weight || greatest < -bound.weight;
    if det.abs() <= 2.0 * bound.det {
        // In the plane of the triangle, for all that one can tell: t is anything.
        return Some(Crossing { triangle: id, t: 0.0, tolerance: f64::INFINITY, certain: false });
    }
    let t = height / det;
    let slack = (bound.height + t.abs() * bound.det) / (det.abs() - bound.det);
    Some(Crossing { triangle: id, t, tolerance: 4.0 * ulp(t) + slack, certain })
}

/// How far rounding can have moved what a crossing is computed from.
struct Bounds {
    /// Of U, V and W.
    weight: f64,
    det: f64,
    /// Of the numerator of t.
    height: f64,
}

impl Bounds {
    /// `from_origin`: the vertices seen from the ray's origin.
    fn new(from_origin: [DVec3; 3], edges: [DVec3; 2], d: DVec3, arithmetic: Arithmetic) -> Self {
        let norm = |v: DVec3| v.abs().element_sum();
        let d = norm(d);
        let e = norm(edges[0]).max(norm(edges[1]));
        let s = norm(from_origin[0]);
        let unit = match arithmetic {
            Arithmetic::Watertight => 2f64.powi(-53),
            Arithmetic::Fast => 2f64.powi(-24),
        };
        let mut bound =
            Self { weight: 16.0 * unit * d * e * (e + s), det: 8.0 * unit * d * e * e, height: 8.0 * unit * e * e * s };
        if arithmetic == Arithmetic::Watertight {
            // That test's edge functions are of vertices seen from the origin, sheared: off by up to 16u of the product of
            // two; it has its t from them, so it is off by as much of their depth.
            let r = from_origin.map(norm).into_iter().fold(0.0, f64::max);
            let sheared = 16.0 * unit * d * r * r;
            bound.weight = bound.weight.max(sheared);
            bound.det = bound.det.max(3.0 * sheared);
            bound.height = bound.height.max(3.0 * sheared * r / d);
        }
        bound
    }
}

/// The distance between numbers of f32 at `t`; below the normal numbers 2⁻¹⁴⁹.
fn ulp(t: f64) -> f64 {
    let t = (t.abs() as f32).min(f32::MAX.next_down());
    f64::from(t.next_up()) - f64::from(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const BEHIND: Triangle =
        Triangle::new(Vec3::new(0.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0), Vec3::new(0.0, 1.0, -1.0));
    const FRONT: Triangle = Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y);

    fn oracle(x: f32, y: f32) -> Oracle {
        let ray = Ray::new(Vec3::new(x, y, 1.0), Vec3::NEG_Z);
        Oracle::new(&[BEHIND, FRONT], &ray, Arithmetic::Watertight)
    }

    fn hit(triangle: u32, t: f32) -> Option<Hit> {
        Some(Hit { triangle, t })
    }

    #[test]
    fn every_way_to_be_wrong_is_told_apart() {
        let inside = oracle(0.25, 0.25);
        assert_eq!(inside.judge(hit(1, 1.0)), Verdict::Right);
        assert_eq!(inside.judge(hit(1, f32::from_bits(1.0f32.to_bits() + 4))), Verdict::Right);
        assert_eq!(inside.judge(hit(1, f32::from_bits(1.0f32.to_bits() + 6))), Verdict::Off);
        assert_eq!(inside.judge(hit(0, 2.0)), Verdict::Farther);
        assert_eq!(inside.judge(hit(7, 1.0)), Verdict::Beside);
        assert_eq!(inside.judge(None), Verdict::Missed);
        assert_eq!(oracle(0.75, 0.75).judge(None), Verdict::Right);
        assert_eq!(oracle(0.75, 0.75).judge(hit(1, 1.0)), Verdict::Beside);
        assert_eq!([true, false].map(|any| inside.judge_any(any)), [Verdict::Right, Verdict::Missed]);
        assert_eq!([true, false].map(|any| oracle(2.0, 2.0).judge_any(any)), [Verdict::Beside, Verdict::Right]);
    }

    #[test]
    fn at_the_border_both_answers_are_right() {
        for (x, y) in [(0.0, 0.25), (0.5, 0.5), (0.0, 0.0), (1.0, 0.0)] {
            let edge = oracle(x, y);
            assert_eq!([hit(1, 1.0), None].map(|h| edge.judge(h)), [Verdict::Border, Verdict::Border]);
            assert_eq!([true, false].map(|any| edge.judge_any(any)), [Verdict::Border, Verdict::Border]);
        }
        let near = oracle(1e-12, 0.25);
        assert_eq!(near.judge(None), Verdict::Missed);
    }

    #[test]
    fn the_interval_counts() {
        let ray = Ray { t_max: 1.5, ..Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z) };
        let judge = |ray: Ray, h| Oracle::new(&[BEHIND, FRONT], &ray, Arithmetic::Watertight).judge(h);
        assert_eq!(judge(Ray { t_min: 1.25, ..ray }, None), Verdict::Right);
        assert_eq!(judge(Ray { t_min: 1.25, ..ray }, hit(1, 1.0)), Verdict::Beside);
        assert_eq!(judge(Ray { t_min: 0.5, ..ray }, None), Verdict::Missed);
        assert_eq!(judge(Ray { t_min: f32::NAN, ..ray }, None), Verdict::Right);
    }

    #[test]
    fn no_scale_is_too_small_or_too_large() {
        for scale in [1e-44_f32, 1e-30, 1e19, 1e37] {
            let large = [BEHIND, FRONT].map(|t| Triangle { v: t.v.map(|p| p * 4.0 * scale) });
            let ray = Ray::new(Vec3::new(scale, scale, 4.0 * scale), Vec3::NEG_Z);
            let oracle = Oracle::new(&large, &ray, Arithmetic::Watertight);
            assert_eq!(oracle.judge(hit(1, 4.0 * scale)), Verdict::Right, "{scale:e}");
            assert_eq!(oracle.judge(None), Verdict::Missed, "{scale:e}");
        }
    }
}
