//! The cheapest collapse: of all trees that leaving out inner nodes and turning subtrees into leaves can give, one of least
//! SAH, by dynamic programming.
//!
//! Source: Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 4,
//! for any arity k instead of 8 and with c_trav = c_isect = 1: an inner node costs its area, a leaf its area times its
//! triangles.
//!
//! C(n, i) is the least cost at which i nodes or fewer can stand for the subtree of n. One node is a leaf (where the triangles
//! are few enough) or an inner node with at most k children, which D(n, k) distributes among the subtrees of n's two
//! children: D(n, j) = min over i of C(left, i) + C(right, j − i). And C(n, i) = min(C(n, i − 1), D(n, i)): n itself, or
//! nodes from further down.
//!
//! **Ties.** A leaf rather than an inner node, fewer nodes rather than more, fewer on the left.

use crate::bvh::Bvh;
use crate::refine::bottom_up::bottom_up;
use crate::refine::layout::depth_first;
use rayon::prelude::*;

/// The cheapest tree of arity at most `arity` that can be had from the binary tree by leaving out inner nodes and by turning
/// subtrees of at most `max_leaf` triangles into leaves. Leaves that hold more already stay as they are; children stand
/// from left to right as in the input.
///
/// A triangle that stands in several leaves of a subtree (spatial splits) counts as often, but stands once in the leaf that
/// replaces it. Time is O(nodes · arity²), memory O(nodes · arity).
///
/// # Panics
/// Where a node of the input has more than two children, or `arity` is below 2.
pub fn collapse_optimally(bvh: &Bvh, arity: usize, max_leaf: usize) -> Bvh {
    collapse_by_leaf_cost(bvh, arity, max_leaf, |triangles| triangles as f64)
}

/// [`collapse_optimally`] for leaves that cost other than one a triangle: `leaf_cost` says how much, times the leaf's area, where
/// an inner node costs its area once.
///
/// # Panics
/// As [`collapse_optimally`].
pub fn collapse_by_leaf_cost(bvh: &Bvh, arity: usize, max_leaf: usize, leaf_cost: impl Fn(usize) -> f64 + Sync) -> Bvh {
    let table = Table::new(bvh, arity, max_leaf, leaf_cost);
    let mut open = Vec::new();
    depth_first(bvh, arity, |index, children| {
        if bvh.nodes[index].is_leaf() || table.closes(index) {
            return;
        }
        table.distribute(index, arity, &mut open);
        while let Some((node, nodes)) = open.pop() {
            match table.fewest(node, nodes) {
                1 => children.push(node),
                fewest => table.distribute(node, fewest, &mut open),
            }
        }
    })
}

/// What every subtree costs with every number of nodes to stand for it.
struct Table<'a> {
    bvh: &'a Bvh,
    arity: usize,
    /// What each subtree costs as one leaf; infinitely much where it must not be one.
    as_leaf: Vec<f64>,
    /// C(n, i) at `width · n + i − 1`, for i to `width`.
    costs: Vec<f64>,
    /// Most nodes that one of two children can get: k − 1.
    width: usize,
}

impl<'a> Table<'a> {
    fn new(bvh: &'a Bvh, arity: usize, max_leaf: usize, leaf_cost: impl Fn(usize) -> f64 + Sync) -> Self {
        assert!(arity >= 2, "a node has two children or more");
        let (n, width) = (bvh.nodes.len(), arity - 1);
        let children = |index: usize| bvh.children(index);
        let mut references = vec![0usize; n];
        bottom_up(
            &mut references,
            1,
            |index, _| children(index),
            |index, own, below| {
                let node = &bvh.nodes[index];
                own[0] = if node.is_leaf() { node.count() } else { below.iter().sum() };
            },
        );
        let as_leaf = bvh.nodes.par_iter().zip(&references).map(|(node, &n)| {
            let may = node.is_leaf() || n <= max_leaf;
            if may { node.aabb.surface_area() * leaf_cost(n) } else { f64::INFINITY }
        });
        let as_leaf: Vec<f64> = as_leaf.collect();
        let mut costs = vec![0.0; n * width];
        bottom_up(
            &mut costs,
            width,
            |index, _| children(index),
            |index, own, below| {
                if below.is_empty() {
                    return own.fill(as_leaf[index]);
                }
                assert!(
                    below.len() <= 2 * width,
                    "node {index} has more than two children; the collapse is of binary trees"
                );
                let open = bvh.nodes[index].aabb.surface_area() + distributed(below, width, arity).0;
                own[0] = as_leaf[index].min(open);
                for nodes in 2..=width {
                    own[nodes - 1] = own[nodes - 2].min(distributed(below, width, nodes).0);
                }
            },
        );
        Self { bvh, arity, as_leaf, costs, width }
    }

    /// C(n, 1) and so on of all children of a node.
    fn below(&self, node: usize) -> &[f64] {
        let children = self.bvh.children(node);
        &self.costs[children.start * self.width..children.end * self.width]
    }

    /// Whether one node for the subtree is best a leaf.
    fn closes(&self, node: usize) -> bool {
        let open = self.bvh.nodes[node].aabb.surface_area() + distributed(self.below(node), self.width, self.arity).0;
        self.as_leaf[node] <= open
    }

    /// The fewest nodes that stand for the subtree as cheaply as so many may.
    fn fewest(&self, node: usize, nodes: usize) -> usize {
        let costs = &self.costs[node * self.width..][..nodes];
        1 + costs.iter().position(|&cost| cost == costs[nodes - 1]).expect("the cost of all of them is among them")
    }

    /// Puts the children of `node` on the stack with the nodes that each gets, the left one on top.
    fn distribute(&self, node: usize, nodes: usize, stack: &mut Vec<(usize, usize)>) {
        let children = self.bvh.children(node);
        let left = distributed(self.below(node), self.width, nodes).1;
        if children.len() == 2 {
            stack.push((children.start + 1, nodes - left));
        }
        stack.push((children.start, left));
    }
}

/// D(n, `nodes`) for two nodes or more, from the `width` costs of each of the children of n; and how many of them the left one
/// gets.
fn distributed(below: &[f64], width: usize, nodes: usize) -> (f64, usize) {
    let (left, right) = below.split_at(width);
    if right.is_empty() {
        return (left[nodes.min(width) - 1], nodes.min(width));
    }
    let sums = left.iter().zip(right[..nodes - 1].iter().rev()).map(|(l, r)| l + r).zip(1..);
    sums.fold((f64::INFINITY, 1), |best, one| if one.0 < best.0 { one } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, median_split, random_tree, soup, tighten};
    use crate::bvh::{Limits, Node, tree_hash, validate};
    use crate::cost::{SahParams, sah};
    use crate::geom::Aabb;
    use crate::refine::{collapse, collapse_greedily, open_leaves};
    use glam::Vec3;
    use proptest::prelude::*;

    fn cost(bvh: &Bvh) -> f64 {
        sah(bvh, SahParams::default()).unwrap() * bvh.root().aabb.surface_area()
    }

    /// Every list of nodes that can stand for a subtree, as pairs of their number and their cost.
    fn lists(
        bvh: &Bvh,
        node: usize,
        arity: usize,
        max_leaf: usize,
        leaf: fn(usize) -> f64,
    ) -> (Vec<(usize, f64)>, usize) {
        let area = bvh.nodes[node].aabb.surface_area();
        let children = bvh.children(node);
        if children.is_empty() {
            let n = bvh.nodes[node].count();
            return (vec![(1, area * leaf(n))], n);
        }
        let (left, of_left) = lists(bvh, children.start, arity, max_leaf, leaf);
        let (right, of_right) = lists(bvh, children.start + 1, arity, max_leaf, leaf);
        let n = of_left + of_right;
        let mut all: Vec<_> = left.iter().flat_map(|l| right.iter().map(move |r| (l.0 + r.0, l.1 + r.1))).collect();
        all.retain(|list| list.0 <= arity);
        let mut one: Vec<_> = all.iter().map(|list| (1, area + list.1)).collect();
        if n <= max_leaf {
            one.push((1, area * leaf(n)));
        }
        all.extend(one);
        (all, n)
    }

    /// Inner nodes at even places, each over the leaf behind it and the next inner node.
    fn chain(inner: usize) -> (Bvh, Vec<Aabb>) {
        let boxes: Vec<_> =
            (0..=inner).map(|x| Aabb::new(Vec3::X * x as f32, Vec3::X * x as f32 + Vec3::ONE)).collect();
        let pair = |i: usize| [Node::inner(Aabb::EMPTY, 2 * i + 1, 2), Node::leaf(Aabb::EMPTY, i, 1)];
        let mut nodes: Vec<_> = (0..inner).flat_map(pair).collect();
        nodes.push(Node::leaf(Aabb::EMPTY, inner, 1));
        let mut bvh = Bvh { nodes, triangle_ids: (0..=inner as u32).collect(), arity: 2 };
        tighten(&mut bvh, &boxes);
        (bvh, boxes)
    }

    proptest! {
        #[test]
        fn the_cheapest_of_all_collapses(seed: u64, n in 1usize..10, arity in 2usize..7, in_leaf in 1usize..3, max_leaf in 1usize..5) {
            let boxes = boxes(&soup(seed, n, 0.4));
            let bvh = random_tree(seed, &boxes, 2, in_leaf);
            let limits = Limits { max_leaf: max_leaf.max(in_leaf), ..Limits::default() };
            for leaf in [(|n| n as f64) as fn(usize) -> f64, |n| 0.6 * n.div_ceil(4) as f64] {
                let wide = collapse_by_leaf_cost(&bvh, arity, max_leaf, leaf);
                prop_assert!(validate(&wide, &boxes, &limits).is_ok());
                prop_assert!(wide.nodes.iter().all(|node| node.is_leaf() || (2..=arity).contains(&node.count())));
                let node_cost = |node: &Node| node.aabb.surface_area() * if node.is_leaf() { leaf(node.count()) } else { 1.0 };
                let cost: f64 = wide.nodes.iter().map(node_cost).sum();
                let all = lists(&bvh, 0, arity, max_leaf, leaf).0;
                let least = all.iter().filter(|l| l.0 == 1).map(|l| l.1).fold(f64::INFINITY, f64::min);
                prop_assert!((cost - least).abs() <= 1e-12 * least, "{cost} {least}");
            }
        }

        #[test]
        fn never_above_the_others(seed: u64, n in 1usize..150, at in 0usize..4, max_leaf in 1usize..5) {
            let arity = [2, 4, 8, 16][at];
            let boxes = boxes(&soup(seed, n, 0.1));
            for bvh in [random_tree(seed, &boxes, 2, 1), median_split(&boxes, 1)] {
                let bvh = open_leaves(&bvh, max_leaf);
                let best = collapse_optimally(&bvh, arity, max_leaf);
                let limits = Limits { max_leaf, ..Limits::default() };
                prop_assert!(validate(&best, &boxes, &limits).is_ok());
                for other in [collapse_greedily(&bvh, arity), collapse(&bvh, arity)] {
                    prop_assert!(cost(&best) <= cost(&other) * (1.0 + 1e-12));
                }
                // At arity 2 there is nothing to leave out.
                if arity == 2 {
                    prop_assert_eq!(tree_hash(&best), tree_hash(&open_leaves(&bvh, max_leaf)));
                }
            }
        }
    }

    #[test]
    fn small_and_deep_trees() {
        let none = Bvh { nodes: Vec::new(), triangle_ids: Vec::new(), arity: 2 };
        assert!(collapse_optimally(&none, 4, 4).nodes.is_empty());
        let (deep, boxes) = chain(50_000);
        for arity in [4, 16] {
            let wide = collapse_optimally(&deep, arity, 4);
            assert!(validate(&wide, &boxes, &Limits::default()).is_ok());
            assert!(wide.nodes.len() < deep.nodes.len());
        }
    }

    #[test]
    fn equal_boxes_fill_leaves() {
        let same = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 1000];
        let bvh = median_split(&same, 1);
        let wide = collapse_optimally(&bvh, 4, 4);
        assert!(validate(&wide, &same, &Limits::default()).is_ok());
        assert!(wide.nodes.iter().all(|node| !node.is_leaf() || node.count() > 1));
    }
}
