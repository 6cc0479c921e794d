//! In which numbers the costs of `top-down published` are added: exact integers, or the original's f32.
//!
//! Source: Beick 2014, "Construction Algorithms", as its program did it: 0.125 + Σ SA(child)/SA(node)·(triangles − 1), every
//! operation in f32, the sum from left to right. [`ChildCost`] has the same terms in f64, rounded once, and adds them
//! exactly; its sums leave out the 0.125, the same for every choice.
//!
//! Deviation: a node whose area is no finite number above 0 in f32 counts as one without area, and all its terms are 0. So
//! an area that overflows splits at the first choice, where the original would have compared with infinity and NaN.

use crate::build::ChildCost;
use crate::geom::Aabb;

/// How the costs of choices are added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Costs {
    /// As integers: sums do not depend on their order, ties are ties.
    #[default]
    Exact,
    /// In f32 from left to right, as the thesis' program did.
    Single,
}

impl Costs {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Single];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Single => "f32",
        }
    }
}

/// What a search over split positions needs of an arithmetic: the terms of one node's children, and their sums.
///
/// Addition is monotone, rounded or not: a ≤ b gives a + t ≤ b + t. Terms are never negative.
pub(super) trait Arithmetic: Copy {
    /// A term or a sum of terms.
    type Cost: Copy + Default + PartialOrd + std::ops::Add<Output = Self::Cost>;

    /// The sum before the first child.
    const EMPTY: Self::Cost;
    /// Above every sum.
    const ABOVE: Self::Cost;
    /// Below every sum.
    const BELOW: Self::Cost;

    /// The terms of a node of `n` triangles with box `node`.
    fn of_node(node: &Aabb, n: usize) -> Self;

    /// The term of one child.
    fn term(&self, child: &Aabb, weight: usize) -> Self::Cost;

    /// The greatest sum that stays at or below `limit` when `term` is added; [`Arithmetic::BELOW`] when none does.
    fn room(limit: Self::Cost, term: Self::Cost) -> Self::Cost;
}

impl Arithmetic for ChildCost {
    type Cost = i64;

    const EMPTY: i64 = 0;
    const ABOVE: i64 = i64::MAX;
    const BELOW: i64 = i64::MIN;

    fn of_node(node: &Aabb, n: usize) -> Self {
        Self::new(node, n)
    }

    #[inline(always)]
    fn term(&self, child: &Aabb, weight: usize) -> i64 {
        Self::term(self, child, weight)
    }

    #[inline(always)]
    fn room(limit: i64, term: i64) -> i64 {
        if limit < term { Self::BELOW } else { limit - term }
    }
}

/// The original's terms: f32 throughout.
#[derive(Clone, Copy, Debug)]
pub(super) struct SingleCost {
    /// Area of the node; 0 for one without a finite area above 0.
    area: f32,
}

impl Arithmetic for SingleCost {
    type Cost = f32;

    const EMPTY: f32 = 0.125;
    const ABOVE: f32 = f32::INFINITY;
    const BELOW: f32 = f32::NEG_INFINITY;

    fn of_node(node: &Aabb, _n: usize) -> Self {
        let area = node.surface_area_f32();
        Self { area: if area > 0.0 && area.is_finite() { area } else { 0.0 } }
    }

    /// A child lies in its node, and f32 operations are monotone: the quotient is at most 1, so all sums are finite.
    #[inline(always)]
    fn term(&self, child: &Aabb, weight: usize) -> f32 {
        if self.area > 0.0 { child.surface_area_f32() / self.area * weight as f32 } else { 0.0 }
    }

    /// A sum rounds to `limit` or less up to the middle between `limit` and its successor. f64 holds that middle exactly,
    /// and its distance to `term` to within one step of the result, which the sums themselves then decide.
    #[inline(always)]
    fn room(limit: f32, term: f32) -> f32 {
        if limit < term {
            return Self::BELOW;
        }
        let middle = 0.5 * (f64::from(limit) + f64::from(limit.next_up()));
        let mut room = (middle - f64::from(term)) as f32;
        while room + term > limit {
            room = room.next_down();
        }
        while room.next_up() + term <= limit {
            room = room.next_up();
        }
        room
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    /// The greatest f32 from 0 up whose sum with `term` is at most `limit`, by bisection over all of them: the bits of
    /// floats from 0 up are in order.
    fn by_bisection(limit: f32, term: f32) -> f32 {
        if limit < term {
            return SingleCost::BELOW;
        }
        let (mut fits, mut exceeds) = (0, f32::INFINITY.to_bits());
        while exceeds - fits > 1 {
            let middle = (fits + exceeds) / 2;
            if f32::from_bits(middle) + term <= limit { fits = middle } else { exceeds = middle }
        }
        f32::from_bits(fits)
    }

    proptest! {
        #[test]
        fn room_is_the_greatest_sum_that_fits(limit in 0u32..0x4e80_0000, term in 0u32..0x4e80_0000, close in -40i32..40) {
            let (limit, term) = (f32::from_bits(limit), f32::from_bits(term));
            let near = f32::from_bits(limit.to_bits().saturating_add_signed(close));
            for term in [term, near, term * limit / (term + limit), 0.0, limit, 0.125, limit * 0.5] {
                prop_assert_eq!(SingleCost::room(limit, term), by_bisection(limit, term), "{} {}", limit, term);
            }
        }
    }

    #[test]
    fn room_of_integers() {
        assert_eq!([ChildCost::room(7, 3), ChildCost::room(7, 7), ChildCost::room(7, 8)], [4, 0, i64::MIN]);
        assert_eq!(ChildCost::room(i64::MIN, 0), i64::MIN);
        assert_eq!(SingleCost::room(f32::NEG_INFINITY, 0.0), f32::NEG_INFINITY);
    }

    #[test]
    fn areas_beyond_f32_count_as_none() {
        let cube = |side: f32| Aabb::new(Vec3::ZERO, Vec3::splat(side));
        for node in [cube(3e19), cube(f32::MAX), cube(0.0), cube(1e-30), Aabb::new(Vec3::splat(f32::MIN), Vec3::MAX)] {
            assert_eq!(SingleCost::of_node(&node, 9).term(&node, 8), 0.0);
        }
        // A flat box of overflowing extent has the area infinity · 0.
        let flat = Aabb::new(Vec3::new(f32::MIN, 0.0, 0.0), Vec3::new(f32::MAX, 0.0, 0.0));
        assert_eq!(SingleCost::of_node(&flat, 9).term(&flat, 8), 0.0);
        let node = cube(1e18);
        assert_eq!(SingleCost::of_node(&node, 9).term(&node, 8), 8.0);
    }
}
