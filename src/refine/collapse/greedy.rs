//! The collapse by area: of a wide node's children, the one that most rays would enter gives way to its own.
//!
//! Source: Wald, Benthin and Boulos 2008, "Getting Rid of Packets: Efficient SIMD Single-Ray Traversal using Multi-branching
//! BVHs", section 3; what most renderers do.

use crate::bvh::Bvh;
use crate::refine::layout::depth_first;

/// Replaces the inner child of the largest area by its children for as long as a node then has at most `arity`; of equal
/// areas the leftmost. From the root down.
///
/// The input is a valid tree, its leaves stay as they are. The output's arity is `arity`, or the input's where that is
/// greater. Time is O(nodes · arity).
pub fn collapse_greedily(bvh: &Bvh, arity: usize) -> Bvh {
    depth_first(bvh, arity.max(bvh.arity), |index, children| {
        children.extend(bvh.children(index));
        loop {
            let fits = |&child: &usize| {
                let node = &bvh.nodes[child];
                !node.is_leaf() && children.len() - 1 + node.count() <= arity
            };
            let area = |place: usize| bvh.nodes[children[place]].aabb.surface_area();
            let places = (0..children.len()).filter(|&place| fits(&children[place]));
            // The last of equals is taken: so from the right.
            let Some(place) = places.rev().max_by(|&a, &b| area(a).total_cmp(&area(b))) else { break };
            let opened = children[place];
            children.splice(place..=place, bvh.children(opened));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, random_tree, soup, tighten};
    use crate::bvh::{Limits, Node, tree_hash, validate};
    use crate::geom::Aabb;
    use glam::Vec3;
    use proptest::prelude::*;

    #[test]
    fn the_largest_child_is_opened_first() {
        // Root over two pairs; the right pair is the larger by far.
        let boxes: Vec<_> = [0.0, 1.0, 5.0, 9.0].map(|x| Aabb::new(Vec3::X * x, Vec3::X * x + Vec3::ONE)).into();
        let pairs = [Node::inner(Aabb::EMPTY, 1, 2), Node::inner(Aabb::EMPTY, 3, 2), Node::inner(Aabb::EMPTY, 5, 2)];
        let leaves = (0..4).map(|slot| Node::leaf(Aabb::EMPTY, slot, 1));
        let mut bvh =
            Bvh { nodes: pairs.into_iter().chain(leaves).collect(), triangle_ids: (0..4).collect(), arity: 2 };
        tighten(&mut bvh, &boxes);
        let wide = collapse_greedily(&bvh, 3);
        assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
        let degrees: Vec<_> = wide.children(0).map(|child| wide.children(child).len()).collect();
        assert_eq!(degrees, [2, 0, 0]);
        assert_eq!(collapse_greedily(&bvh, 4).children(0).len(), 4);
    }

    proptest! {
        #[test]
        fn no_child_is_left_that_would_fit(seed: u64, n in 1usize..120, arity in 2usize..17) {
            let boxes = boxes(&soup(seed, n, 0.1));
            let bvh = random_tree(seed, &boxes, 2, 3);
            let wide = collapse_greedily(&bvh, arity);
            prop_assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
            for index in 0..wide.nodes.len() {
                let children = wide.children(index);
                prop_assert!(children.len() <= arity);
                let inner = children.clone().any(|child| !wide.nodes[child].is_leaf());
                prop_assert!(!inner || children.len() == arity);
            }
            if arity == 2 {
                prop_assert_eq!(tree_hash(&wide), tree_hash(&bvh));
            }
        }
    }
}
