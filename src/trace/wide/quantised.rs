//! Nodes that keep their children's boxes in 8 or 16 bits a coordinate, on a grid of their own.
//!
//! The layout is after Ylitie, Karras and Laine ("Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
//! HPG 2017, section 3.1; the idea is Mahovsky and Wyvill's, "Memory-Conserving Bounding Volume Hierarchies with Coherent
//! Raytracing", 2006): the node's lower corner in f32, for each axis a power of two as the grid's step, planes as numbers of
//! steps. A node of eight takes 128 bytes with 8 bits and 192 with 16, where f32 takes 256. Children are named in full and the
//! order of each octant is kept, as in f32: the boxes are all that differs.
//!
//! **Hits are those of f32 boxes, bit for bit.** A plane is decoded as f32(f32(steps · step) + corner). The product is exact, a
//! power of two of at least 2⁻¹²⁶ times a whole number; and it is this very decoding that decides how planes are rounded when the
//! node is made. So a decoded box contains the exact one as f32 numbers, whatever the scene's extent and place; the box test is
//! monotone (`slab.rs`), so a search enters all that it would enter by exact boxes; and what it does at leaves is the same.
//! Grids are set by exact boxes, so errors do not add up from level to level.

use super::layout::{NONE, WideNode};
use super::node::{Node, Side};
use super::pack::Pack;

/// Whole numbers that steps are counted in.
pub trait Steps: Copy {
    /// The greatest.
    const MOST: u32;

    /// A number no greater than [`Self::MOST`].
    fn new(n: u32) -> Self;

    /// The numbers as f32.
    fn load<const W: usize, P: Pack<W>>(from: &[Self; W]) -> P;
}

impl Steps for u8 {
    const MOST: u32 = Self::MAX as u32;

    fn new(n: u32) -> Self {
        n as Self
    }
    #[inline(always)]
    fn load<const W: usize, P: Pack<W>>(from: &[Self; W]) -> P {
        P::of_u8(from)
    }
}

impl Steps for u16 {
    const MOST: u32 = Self::MAX as u32;

    fn new(n: u32) -> Self {
        n as Self
    }
    #[inline(always)]
    fn load<const W: usize, P: Pack<W>>(from: &[Self; W]) -> P {
        P::of_u16(from)
    }
}

/// A node with its children's boxes on a grid.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct GridNode<const W: usize, S> {
    /// By axis, then lower and upper plane, then child.
    steps: [[[S; W]; 2]; 3],
    child: [u32; W],
    order: [u32; 8],
    /// What steps are counted from.
    corner: [f32; 3],
    /// The step of each axis, as the exponent bits of an f32: 1 to 254.
    exponent: [u8; 3],
    count: u8,
}

/// For every number of children: ∞ where there is one, else −∞.
static ENDS: [[f32; 8]; 9] = {
    let mut ends = [[f32::NEG_INFINITY; 8]; 9];
    let mut count = 0;
    while count < 9 {
        let mut lane = 0;
        while lane < count {
            ends[count][lane] = f32::INFINITY;
            lane += 1;
        }
        count += 1;
    }
    ends
};

impl<S: Steps> Node<8> for GridNode<8, S> {
    #[inline(always)]
    fn count(&self) -> usize {
        usize::from(self.count)
    }
    #[inline(always)]
    fn child(&self) -> &[u32; 8] {
        &self.child
    }
    #[inline(always)]
    fn order(&self) -> &[u32; 8] {
        &self.order
    }
    #[inline(always)]
    fn planes<P: Pack<8>>(&self, axis: usize, side: Side) -> P {
        let step = P::splat(step(self.exponent[axis]));
        S::load::<8, P>(&self.steps[axis][side as usize]).times(step).plus(P::splat(self.corner[axis]))
    }
    #[inline(always)]
    fn ends<P: Pack<8>>(&self) -> P {
        P::load(&ENDS[usize::from(self.count) % ENDS.len()])
    }
}

#[inline(always)]
fn step(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << 23)
}

/// The grid of one axis.
struct Grid {
    corner: f32,
    exponent: u8,
}

impl Grid {
    /// From `low` to `high`, both finite, in at most `most` steps as small as may be.
    fn new(low: f32, high: f32, most: u32) -> Self {
        let wanted = (f64::from(high) - f64::from(low)) / f64::from(most);
        // The power of two that is no more than it; 0 and what f32 calls subnormal give the least normal one.
        let exponent = ((wanted.to_bits() >> 52) as i32 - 1023 + 127).clamp(1, 254);
        let mut grid = Self { corner: low, exponent: exponent as u8 };
        while grid.at(most) < high && grid.exponent < 254 {
            grid.exponent += 1;
        }
        grid
    }

    /// A plane, as nodes decode it.
    fn at(&self, steps: u32) -> f32 {
        steps as f32 * step(self.exponent) + self.corner
    }

    fn steps(&self, x: f32) -> f64 {
        (f64::from(x) - f64::from(self.corner)) / f64::from(step(self.exponent))
    }

    /// The most steps that are not beyond `x`.
    fn down(&self, x: f32, most: u32) -> u32 {
        let mut n = (self.steps(x).floor() as u32).min(most);
        while self.at(n) > x && n > 0 {
            n -= 1;
        }
        n
    }

    /// The least steps that are not before `x`.
    fn up(&self, x: f32, most: u32) -> u32 {
        let mut n = (self.steps(x).ceil() as u32).min(most);
        while self.at(n) < x && n < most {
            n += 1;
        }
        n
    }
}

impl<const W: usize, S: Steps> From<&WideNode<W>> for GridNode<W, S> {
    fn from(exact: &WideNode<W>) -> Self {
        let count = exact.child.iter().take_while(|&&child| child != NONE).count();
        let mut node = Self {
            steps: [[[S::new(0); W]; 2]; 3],
            child: exact.child,
            order: exact.order,
            corner: [0.0; 3],
            exponent: [1; 3],
            count: count as u8,
        };
        for axis in 0..3 {
            let [lower, upper] = exact.bounds[axis].each_ref().map(|planes| &planes[..count]);
            let low = lower.iter().copied().fold(f32::INFINITY, f32::min);
            let high = upper.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            // Else nothing is in it: boxes of no children, or of none that holds a triangle.
            if low <= high {
                let grid = Grid::new(low, high, S::MOST);
                for lane in 0..count {
                    node.steps[axis][0][lane] = S::new(grid.down(lower[lane], S::MOST));
                    node.steps[axis][1][lane] = S::new(grid.up(upper[lane], S::MOST));
                }
                (node.corner[axis], node.exponent[axis]) = (grid.corner, grid.exponent);
            }
        }
        node
    }
}

#[cfg(test)]
mod tests {
    use super::super::WideBvh;
    use super::super::pack::Portable;
    use super::*;
    use crate::bvh::testing::soup;
    use crate::geom::Triangle;
    use crate::trace::testing::median_split;
    use proptest::prelude::*;

    fn decoded<N: Node<8>>(node: &N, axis: usize, side: Side) -> [f32; 8] {
        let mut planes = [0.0; 8];
        node.planes::<Portable<8>>(axis, side).store(&mut planes);
        planes
    }

    /// Whether the node's boxes contain the exact ones; by how many steps of the grid they are greater, at most.
    fn excess<S: Steps + std::fmt::Debug>(exact: &WideNode<8>) -> f64 {
        let node = GridNode::<8, S>::from(exact);
        let mut most = 0.0_f64;
        assert_eq!(Node::<8>::count(&node), exact.count());
        for axis in 0..3 {
            let [lower, upper] = [Side::Lower, Side::Upper].map(|side| decoded(&node, axis, side));
            for lane in 0..exact.count() {
                let [low, high] = exact.bounds[axis].map(|planes| planes[lane]);
                assert!(lower[lane] <= low && high <= upper[lane], "{axis} {lane}: {low} {high}, {node:?}");
                let grown = f64::from(upper[lane]) - f64::from(high) + f64::from(low) - f64::from(lower[lane]);
                most = most.max(grown / f64::from(step(node.exponent[axis])));
            }
        }
        most
    }

    #[test]
    fn nodes_are_as_small_as_they_are_said_to_be() {
        let bytes = [size_of::<GridNode<8, u8>>(), size_of::<GridNode<8, u16>>(), size_of::<WideNode<8>>()];
        assert_eq!(bytes, [128, 192, 256]);
    }

    #[test]
    fn places_without_a_child_are_never_entered() {
        for count in 0..=8 {
            let mut exact = WideNode::<8> { child: [NONE; 8], ..WideNode::EMPTY };
            // Boxes without extent: planes alone could not keep a ray out of the empty places.
            (0..count).for_each(|lane| exact.child[lane] = lane as u32);
            (0..3).for_each(|axis| {
                (0..count).for_each(|lane| exact.bounds[axis].iter_mut().for_each(|p| p[lane] = 1e30))
            });
            let node = GridNode::<8, u8>::from(&exact);
            let mut ends = [0.0; 8];
            node.ends::<Portable<8>>().store(&mut ends);
            let there = |lane: usize| if lane < count { f32::INFINITY } else { f32::NEG_INFINITY };
            assert_eq!(ends, std::array::from_fn(there));
            assert!(decoded(&node, 0, Side::Lower)[..count].iter().all(|&plane| plane == 1e30));
        }
    }

    #[test]
    fn the_greatest_and_least_extents_end_and_contain() {
        for (low, high) in [(f32::MIN, f32::MAX), (0.0, f32::MAX), (-1e-45, 1e-45), (-0.0, 0.0), (f32::MAX, f32::MAX)] {
            let mut exact = WideNode::<8>::EMPTY;
            (exact.child[0], exact.child[1]) = (0, 1);
            for planes in &mut exact.bounds {
                (planes[0][0], planes[1][0], planes[0][1], planes[1][1]) = (low, low, high, high);
            }
            excess::<u8>(&exact);
            excess::<u16>(&exact);
        }
    }

    proptest! {
        #[test]
        fn boxes_only_grow_and_by_less_than_a_step_a_plane(
            seed: u64, exponent in -130_i32..120, offset in prop::sample::select(vec![0.0_f32, 1.0, -1e3, 3e6, -1e8]),
        ) {
            let scale = f64::exp2(f64::from(exponent));
            let mut triangles = soup(seed, 60, 0.3);
            for t in &mut triangles {
                t.v = t.v.map(|p| ((p + offset).as_dvec3() * scale).as_vec3());
            }
            prop_assume!(triangles.iter().all(Triangle::is_finite));
            let wide = WideBvh::<8>::new(&median_split(&triangles, 2), &triangles);
            for node in &wide.nodes {
                let (coarse, fine) = (excess::<u8>(node), excess::<u16>(node));
                // Far from the origin and among the least numbers f32 itself is coarser than the grid.
                if offset == 0.0 && exponent > -90 {
                    prop_assert!(coarse <= 2.01 && fine <= 3.0, "{coarse} {fine}");
                }
            }
        }
    }
}
