//! The cost of one child as an integer: the only thing that a literal engine and its exact twin share.
//!
//! Floating-point sums depend on their order, so two engines that add in different orders would disagree on ties and near
//! ties. Each child's term is therefore computed once, in f64, and rounded to fixed point; integers add associatively,
//! a tie is a tie, and "first in lexicographic order" means the same to everybody.

use crate::geom::Aabb;

/// Bits of the fixed-point scale before the node's triangle count takes its share.
pub const CHILD_COST_SCALE_BITS: u32 = 58;

/// Computes the terms of one node's children.
///
/// A term is `SA(child)/SA(node) · weight`, scaled by a power of two such that the sum over all children stays below
/// 2^[`CHILD_COST_SCALE_BITS`]: an i64 holds it with room for a mark of inadmissibility above. Every term of a node
/// without area is 0.
#[derive(Clone, Copy, Debug)]
pub struct ChildCost {
    /// Fixed-point units per unit of area and weight; 0 for a node without area.
    per_area: f64,
}

impl ChildCost {
    /// The terms of a node with box `node`, whose children's weights add up to at most `total_weight`.
    pub fn new(node: &Aabb, total_weight: usize) -> Self {
        let share = usize::BITS - total_weight.leading_zeros();
        let scale = (1u64 << (CHILD_COST_SCALE_BITS - share)) as f64;
        let area = node.surface_area();
        Self { per_area: if area > 0.0 { scale / area } else { 0.0 } }
    }

    /// The term of one child; never negative.
    #[inline(always)]
    pub fn term(&self, child: &Aabb, weight: usize) -> i64 {
        self.term_of_area(child.surface_area(), weight as f64)
    }

    /// The term of one child of surface area `area`; the same as [`ChildCost::term`].
    #[inline(always)]
    pub fn term_of_area(&self, area: f64, weight: f64) -> i64 {
        // Truncation after adding a half is rounding: the value is not negative. It compiles to one instruction
        // in baseline x86-64, where `f64::round` is a call.
        (area * self.per_area * weight + 0.5) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn sums_stay_below_the_bound_and_follow_the_area() {
        let node = Aabb::new(Vec3::ZERO, Vec3::splat(2.0));
        for n in [1, 2, 3, 7, 8, 1000, (1 << 31) - 1] {
            let cost = ChildCost::new(&node, n);
            let whole = cost.term(&node, n);
            assert!(whole > 0 && whole < 1 << CHILD_COST_SCALE_BITS, "{n}");
            let half = Aabb::new(Vec3::ZERO, Vec3::new(1.0, 2.0, 2.0));
            let error = cost.term(&half, n) as f64 / (whole as f64 * 2.0 / 3.0) - 1.0;
            assert!(error.abs() < 1e-15, "{n}: {error:e}");
            assert_eq!(cost.term(&node, 0), 0);
        }
    }

    #[test]
    fn a_node_without_area_costs_nothing() {
        let node = Aabb::new(Vec3::ZERO, Vec3::X);
        assert_eq!(ChildCost::new(&node, 9).term(&node, 9), 0);
    }

    #[test]
    fn scaling_the_scene_by_a_power_of_two_changes_no_term() {
        let node = Aabb::new(Vec3::ZERO, Vec3::new(3.0, 5.0, 7.0));
        let child = Aabb::new(Vec3::ONE, Vec3::new(2.5, 3.0, 6.9));
        let scaled = |b: &Aabb| Aabb::new(b.min * 1024.0, b.max * 1024.0);
        assert_eq!(
            ChildCost::new(&node, 77).term(&child, 33),
            ChildCost::new(&scaled(&node), 77).term(&scaled(&child), 33)
        );
    }
}
