//! Refitting: new boxes for the same tree, after vertices have moved.
//!
//! The oldest way to keep a hierarchy over moving geometry (van den Bergen, "Efficient Collision Detection of Complex Deformable
//! Models using AABB Trees", Journal of Graphics Tools 2(4), 1997; Wald, Boulos and Shirley, "Ray Tracing Deformable Scenes
//! Using Dynamic Bounding Volume Hierarchies", ACM TOG 26(1), 2007): topology and leaves stay, boxes are united anew from the
//! leaves up. It takes a fraction of a build; what it costs is quality, as triangles that were neighbours drift apart. How
//! much is the growth of the tree's cost, [`crate::cost::sah`]: over that before, or, as the area of the root changes too, over that
//! of a fresh tree.

use super::bottom_up::unite;
use crate::bvh::Bvh;
use crate::geom::Aabb;

/// Gives every leaf the union of the boxes of its triangles (by id) and every inner node that of its children, in time linear in
/// nodes and slots. Any tree of any arity will do if children stand behind their parents; the boxes that it had do not matter.
/// A leaf without triangles gets [`Aabb::EMPTY`], which no ray enters.
///
/// All threads share the work where subtrees stand in one piece, as in trees from here. A triangle that spatial splits
/// have put into several leaves counts with all of its box in each, so such a tree loses what the splits had won; nodes of
/// the thesis' rule Q8 become tight like all others.
///
/// # Panics
/// On a triangle id beyond `boxes`.
pub fn refit(bvh: &mut Bvh, boxes: &[Aabb]) {
    let ids = &bvh.triangle_ids;
    unite(&mut bvh.nodes, |leaf| Aabb::union_of(ids[leaf.range()].iter().map(|&id| &boxes[id as usize])));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{Random, boxes, median_split, random_tree, soup};
    use crate::bvh::{Limits, Node, tree_hash, validate};
    use crate::cost::{SahParams, sah};
    use crate::geom::Triangle;
    use proptest::prelude::*;

    /// Every triangle moved on its own, by up to `by` along each axis.
    fn shaken(triangles: &[Triangle], seed: u64, by: f32) -> Vec<Triangle> {
        let mut random = Random(seed);
        let moved = |t: &Triangle| {
            let step = random.point(2.0 * by) - by;
            Triangle { v: t.v.map(|p| p + step) }
        };
        triangles.iter().map(moved).collect()
    }

    /// All triangle ids below a node, found from the top.
    fn below(bvh: &Bvh, index: usize) -> Vec<u32> {
        let mut ids = bvh.leaf_triangles(index).to_vec();
        ids.extend(bvh.children(index).flat_map(|child| below(bvh, child)));
        ids
    }

    proptest! {
        #[test]
        fn every_box_is_that_of_the_triangles_below(seed: u64, n in 1usize..80, arity in 2usize..9, max_leaf in 1usize..5) {
            let before = soup(seed, n, 0.3);
            let built = random_tree(seed, &boxes(&before), arity, max_leaf);
            let moved = boxes(&shaken(&before, !seed, 0.5));
            let mut bvh = built.clone();
            refit(&mut bvh, &moved);
            for (index, node) in bvh.nodes.iter().enumerate() {
                let by_force = Aabb::union_of(below(&bvh, index).iter().map(|&id| &moved[id as usize]));
                prop_assert_eq!(node.aabb, by_force);
            }
            prop_assert_eq!(tree_hash(&bvh), tree_hash(&built));
            prop_assert!(validate(&bvh, &moved, &Limits::default()).is_ok());
            // And back again: nothing of the way is left.
            refit(&mut bvh, &boxes(&before));
            prop_assert_eq!(bvh, built);
        }
    }

    #[test]
    fn the_farther_triangles_move_the_more_the_tree_costs() {
        let before = soup(4, 2000, 0.03);
        let built = median_split(&boxes(&before), 4);
        let cost = |by: f32| {
            let mut bvh = built.clone();
            refit(&mut bvh, &boxes(&shaken(&before, 9, by)));
            sah(&bvh, SahParams::default()).unwrap()
        };
        let costs = [0.0, 0.02, 0.1, 0.3].map(cost);
        assert_eq!(costs[0], sah(&built, SahParams::default()).unwrap());
        assert!(costs.is_sorted_by(|a, b| a * 1.02 < *b), "{costs:?}");
    }

    #[test]
    fn many_threads_one_tree_and_leaves_without_triangles() {
        let b = boxes(&soup(2, 20_000, 0.1));
        let built = median_split(&b, 2);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut bvh = built.clone();
            bvh.nodes.iter_mut().for_each(|n| n.aabb = Aabb::EMPTY);
            pool.install(|| refit(&mut bvh, &b));
            bvh
        };
        assert!(with(1) == built && with(3) == built);
        let mut bvh = Bvh {
            nodes: vec![Node::inner(b[0], 1, 2), Node::leaf(b[1], 0, 0), Node::leaf(b[2], 0, 1)],
            triangle_ids: vec![1],
            arity: 2,
        };
        refit(&mut bvh, &b);
        assert_eq!([0, 1, 2].map(|i| bvh.nodes[i].aabb), [b[1], Aabb::EMPTY, b[1]]);
    }

    #[test]
    fn as_deep_as_there_are_triangles() {
        let n = 50_000;
        let b = boxes(&soup(3, n, 0.1));
        // A chain: every inner node has a leaf and the rest.
        let mut nodes = vec![Node::inner(Aabb::EMPTY, 1, 2)];
        for i in 0..n - 1 {
            nodes.push(Node::leaf(Aabb::EMPTY, i, 1));
            let next = nodes.len() + 1;
            nodes.push(if i + 2 < n { Node::inner(Aabb::EMPTY, next, 2) } else { Node::leaf(Aabb::EMPTY, i + 1, 1) });
        }
        let mut bvh = Bvh { nodes, triangle_ids: (0..n as u32).collect(), arity: 2 };
        refit(&mut bvh, &b);
        assert!(validate(&bvh, &b, &Limits::default()).is_ok());
    }
}
