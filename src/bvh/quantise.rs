//! Boxes in fewer bits: what a tree's boxes become when a node keeps its children's on a small grid of its own.
//!
//! The layout is that of compressed wide nodes (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs", HPG 2017, section 3.1): a node has its lower corner in f32 and, for each axis, a power
//! of two as the grid's step; a child's corner is a number of steps, lower ones rounded down, upper ones up. Deviations:
//! any arity, and 16 bits besides 8. Grids are set by exact boxes, so errors do not add up from level to level.

use super::Bvh;
use crate::geom::Aabb;
use glam::DVec3;

/// A tree with boxes as they come back from so many bits a coordinate, every one around the exact one.
///
/// Topology, slots and the root's box stay. A child's decoded box may reach beyond its parent's decoded box; it never
/// lacks anything of its own, so that traversal stays exact and only enters more boxes.
///
/// # Panics
/// Unless `bits` is between 2 and 16.
pub fn quantised(bvh: &Bvh, bits: u32) -> Bvh {
    assert!((2..=16).contains(&bits), "{bits} bits a coordinate");
    let mut result = bvh.clone();
    for index in 0..bvh.nodes.len() {
        let parent = bvh.nodes[index].aabb;
        let children = bvh.children(index);
        if children.is_empty() || !parent.is_valid() {
            continue;
        }
        // Below a node of the thesis' rule Q8 boxes may reach beyond their parent's.
        let inside = bvh.nodes[children.clone()].iter().map(|n| &n.aabb).filter(|b| b.is_valid());
        let grid = Grid::new(&parent.union(&Aabb::union_of(inside)), bits);
        for child in children {
            let aabb = bvh.nodes[child].aabb;
            if aabb.is_valid() {
                result.nodes[child].aabb = grid.around(&aabb);
            }
        }
    }
    result
}

/// Bytes of a tree whose inner nodes hold their children's boxes in so many bits a coordinate, 32 for plain f32: for
/// each of `arity` children six coordinates and a word that says where it stands, whether there is a child or not; below
/// 32 bits 16 bytes more for the grid; and the triangle ids.
pub fn stored_bytes(bvh: &Bvh, bits: u32) -> usize {
    let grid = if bits < 32 { 16 } else { 0 };
    let child = (6 * bits as usize).div_ceil(8) + 4;
    let inner = bvh.nodes.iter().filter(|n| !n.is_leaf()).count();
    inner * (grid + bvh.arity * child) + size_of_val(bvh.triangle_ids.as_slice())
}

/// The grid of one node, in f64, in which nothing overflows.
struct Grid {
    origin: DVec3,
    /// A power of two an axis.
    step: DVec3,
    /// The greatest number of steps.
    most: f64,
}

impl Grid {
    fn new(parent: &Aabb, bits: u32) -> Self {
        let most = f64::from((1u32 << bits) - 1);
        let mut grid = Self { origin: parent.min.as_dvec3(), step: DVec3::ZERO, most };
        for axis in 0..3 {
            grid.step[axis] = power_of_two_from(parent.extent()[axis] / most);
            // Decoding rounds: the last step must reach the far side nevertheless.
            while grid.at(axis, most) < parent.max[axis] {
                grid.step[axis] *= 2.0;
            }
        }
        grid
    }

    /// The coordinate so many steps from the origin, as a node decodes it.
    fn at(&self, axis: usize, steps: f64) -> f32 {
        ((self.origin[axis] + steps * self.step[axis]) as f32).min(f32::MAX)
    }

    fn around(&self, aabb: &Aabb) -> Aabb {
        let mut decoded = *aabb;
        for axis in 0..3 {
            let steps = |x: f32| (f64::from(x) - self.origin[axis]) / self.step[axis];
            let mut low = steps(aabb.min[axis]).floor().clamp(0.0, self.most);
            while self.at(axis, low) > aabb.min[axis] {
                low -= 1.0;
            }
            let mut high = steps(aabb.max[axis]).ceil().clamp(0.0, self.most);
            while self.at(axis, high) < aabb.max[axis] {
                high += 1.0;
            }
            (decoded.min[axis], decoded.max[axis]) = (self.at(axis, low), self.at(axis, high));
        }
        decoded
    }
}

/// The least power of two, 2⁻¹²⁶ at least, that is no less than `x`.
fn power_of_two_from(x: f64) -> f64 {
    let mut step = f64::from(f32::MIN_POSITIVE);
    while step < x {
        step *= 2.0;
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, random_tree, soup};
    use crate::geom::Triangle;
    use proptest::prelude::*;

    fn tree(triangles: &[Triangle], arity: usize) -> Bvh {
        let boxes = boxes(triangles);
        random_tree(9, &boxes, arity, arity)
    }

    fn areas(bvh: &Bvh) -> f64 {
        bvh.nodes.iter().map(|n| n.aabb.surface_area()).sum()
    }

    #[test]
    fn a_child_may_reach_beyond_its_parent() {
        let triangles = soup(3, 40, 0.2);
        let mut bvh = tree(&triangles, 4);
        bvh.nodes[0].aabb.max = bvh.nodes[0].aabb.min + 1e-9;
        let stored = quantised(&bvh, 8);
        assert!(stored.nodes.iter().zip(&bvh.nodes).all(|(s, e)| s.aabb.contains(&e.aabb)));
    }

    #[test]
    fn fewer_bits_make_greater_boxes_and_less_memory() {
        for arity in [2, 4, 8] {
            let bvh = tree(&soup(7, 2000, 0.1), arity);
            let [fine, coarse] = [16, 8].map(|bits| quantised(&bvh, bits));
            assert!(areas(&bvh) < areas(&fine) && areas(&fine) < 1.001 * areas(&bvh));
            assert!(areas(&fine) < areas(&coarse) && areas(&coarse) < 1.2 * areas(&bvh));
            let bytes = [32, 16, 8].map(|bits| stored_bytes(&bvh, bits));
            if arity == 8 {
                assert!(bytes[0] > bytes[1] && bytes[1] > bytes[2], "{bytes:?}");
            }
        }
    }

    #[test]
    fn a_node_of_eight_in_eight_bits_takes_what_the_layout_says() {
        let bvh = tree(&soup(7, 8, 0.1), 8);
        let inner = bvh.nodes.iter().filter(|n| !n.is_leaf()).count();
        assert_eq!(stored_bytes(&bvh, 8), inner * (16 + 8 * (6 + 4)) + 8 * 4);
        assert_eq!(stored_bytes(&bvh, 16), inner * (16 + 8 * (12 + 4)) + 8 * 4);
        assert_eq!(stored_bytes(&bvh, 32), inner * 8 * (24 + 4) + 8 * 4);
    }

    proptest! {
        #[test]
        fn decoded_boxes_contain_the_exact_ones(
            seed: u64, exponent in -120i32..120, offset in -1e6f32..1e6, bits in 2u32..=16,
        ) {
            let scale = 2f32.powi(exponent);
            let mut triangles = soup(seed, 60, 0.3);
            for t in &mut triangles {
                t.v = t.v.map(|p| (p + offset) * scale);
            }
            let bvh = tree(&triangles, 4);
            let decoded = quantised(&bvh, bits);
            for (exact, decoded) in bvh.nodes.iter().zip(&decoded.nodes) {
                prop_assert!(decoded.aabb.contains(&exact.aabb), "{exact:?} {decoded:?}");
                prop_assert_eq!(exact.kind(), decoded.kind());
            }
            prop_assert_eq!(&decoded.triangle_ids, &bvh.triangle_ids);
        }
    }
}
