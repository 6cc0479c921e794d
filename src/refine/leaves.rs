//! Leaves where the surface area heuristic wants them: subtrees that cost more than the leaf that would replace them.
//!
//! Source: the termination test of MacDonald and Booth 1990, taken bottom-up over a finished tree as in Bittner, Hapala and
//! Havran 2013 ("Fast Insertion-Based Optimization of Bounding Volume Hierarchies", section 3) and Meister and Bittner
//! 2018. With c_trav = c_isect = 1 a subtree of n triangles becomes a leaf when n ≤ `max_leaf` and area · n is not
//! above what the best form of its subtree costs. Every subtree is decided on its own, so the outcome is the cheapest tree
//! that can be had by turning subtrees into leaves; with spatial splits, if a triangle counts as often as it stands in leaves.

use super::bottom_up::bottom_up;
use super::layout::depth_first;
use crate::bvh::Bvh;

/// Turns subtrees of at most `max_leaf` triangles into leaves where that does not raise the cost. Leaves that hold more
/// already stay as they are.
///
/// The input is a valid tree of any arity. A triangle that stands in several leaves of a subtree (spatial splits) stands
/// once in the leaf that replaces it, whose box is that of the subtree. The output stands in depth-first order, siblings
/// next to each other. Time is O(nodes).
pub fn open_leaves(bvh: &Bvh, max_leaf: usize) -> Bvh {
    // The costs go before the new tree comes.
    let closed: Vec<bool> = decide(bvh, max_leaf).into_iter().map(|best| best.closed).collect();
    depth_first(bvh, bvh.arity, |index, children| {
        if !closed[index] {
            children.extend(bvh.children(index));
        }
    })
}

/// What is best for a subtree.
#[derive(Clone, Copy, Default)]
struct Best {
    /// Whether it is a leaf.
    closed: bool,
    references: usize,
    cost: f64,
}

/// For every node, what it is in the outcome (if it is reached).
fn decide(bvh: &Bvh, max_leaf: usize) -> Vec<Best> {
    let mut all = vec![Best::default(); bvh.nodes.len()];
    bottom_up(
        &mut all,
        1,
        |index, _| bvh.children(index),
        |index, own, below| {
            let node = &bvh.nodes[index];
            let area = node.aabb.surface_area();
            let references =
                if node.is_leaf() { node.count() } else { below.iter().map(|child| child.references).sum() };
            let as_leaf = area * references as f64;
            let open = area + below.iter().map(|child| child.cost).sum::<f64>();
            let closed = node.is_leaf() || references <= max_leaf && as_leaf <= open;
            own[0] = Best { closed, references, cost: if closed { as_leaf } else { open } };
        },
    );
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Node;
    use crate::bvh::testing::{boxes, random_tree, soup};
    use crate::bvh::{Limits, tree_hash, validate};
    use crate::cost::{SahParams, sah};
    use crate::geom::Aabb;
    use glam::Vec3;
    use proptest::prelude::*;

    fn brick(x: f32) -> Aabb {
        Aabb::new(Vec3::ZERO, Vec3::new(x, 1.0, 1.0))
    }

    #[test]
    fn by_hand() {
        // Three alike: 1 + 1 + … is never below a leaf of three. Inner over inner over leaves.
        let bvh = Bvh {
            nodes: vec![
                Node::inner(brick(1.0), 1, 2),
                Node::inner(brick(1.0), 3, 2),
                Node::leaf(brick(1.0), 2, 1),
                Node::leaf(brick(1.0), 0, 1),
                Node::leaf(brick(1.0), 1, 1),
            ],
            triangle_ids: vec![7, 8, 9],
            arity: 2,
        };
        let one = open_leaves(&bvh, 4);
        assert_eq!((one.nodes.len(), one.triangle_ids), (1, vec![7, 8, 9]));
        let two = open_leaves(&bvh, 2);
        assert_eq!((two.nodes.len(), two.leaf_triangles(1)), (3, &[7, 8][..]));
        assert_eq!(open_leaves(&bvh, 1).nodes.len(), 5);
        // Small leaves in a large box are worth their node: 14 · 2 against 14 + 6 + 6.
        let far = Bvh {
            nodes: vec![Node::inner(brick(3.0), 1, 2), Node::leaf(brick(1.0), 0, 1), Node::leaf(brick(1.0), 1, 1)],
            triangle_ids: vec![0, 1],
            arity: 2,
        };
        assert_eq!(open_leaves(&far, 4).nodes.len(), 3);
    }

    #[test]
    fn a_triangle_of_two_leaves_stands_once_in_their_union() {
        let bvh = Bvh {
            nodes: vec![Node::inner(brick(1.0), 1, 2), Node::leaf(brick(1.0), 0, 1), Node::leaf(brick(1.0), 1, 1)],
            triangle_ids: vec![3, 3],
            arity: 2,
        };
        let one = open_leaves(&bvh, 4);
        assert_eq!((one.root().count(), one.triangle_ids), (1, vec![3]));
    }

    /// The least cost over every way of closing subtrees.
    fn least(bvh: &Bvh, index: usize, max_leaf: usize) -> (f64, usize) {
        let node = &bvh.nodes[index];
        let area = node.aabb.surface_area();
        if node.is_leaf() {
            return (area * node.count() as f64, node.count());
        }
        let below: Vec<_> = node.range().map(|child| least(bvh, child, max_leaf)).collect();
        let n = below.iter().map(|b| b.1).sum();
        let open = area + below.iter().map(|b| b.0).sum::<f64>();
        (if n <= max_leaf { open.min(area * n as f64) } else { open }, n)
    }

    proptest! {
        #[test]
        fn the_cheapest_of_all_ways(seed: u64, n in 1usize..60, arity in 2usize..5, max_leaf in 1usize..7) {
            let boxes = boxes(&soup(seed, n, 0.4));
            let bvh = random_tree(seed, &boxes, arity, 1);
            let opened = open_leaves(&bvh, max_leaf);
            let limits = Limits { max_leaf, ..Limits::default() };
            prop_assert!(validate(&opened, &boxes, &limits).is_ok());
            let cost = sah(&opened, SahParams::default()).unwrap() * bvh.root().aabb.surface_area();
            let (expected, _) = least(&bvh, 0, max_leaf);
            prop_assert!((cost - expected).abs() <= 1e-9 * expected, "{cost} {expected}");
            prop_assert_eq!(tree_hash(&open_leaves(&bvh, 1)), tree_hash(&bvh));
        }
    }
}
