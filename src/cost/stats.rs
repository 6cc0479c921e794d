//! The shape of a tree: degrees, depths, leaf sizes.

use crate::bvh::{Bvh, NodeKind};

/// Counts over a finished tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeStats {
    /// Inner nodes.
    pub inner: usize,
    /// Leaves, empty ones included.
    pub leaves: usize,
    /// Leaves without triangles.
    pub empty: usize,
    /// Children per inner node (all of them, empty leaves included); `None` for a tree that is one leaf.
    pub avg_degree: Option<f64>,
    /// Edges between the root and the deepest node: 0 for a tree that is one leaf.
    pub max_depth: usize,
    /// Triangles in the fullest leaf.
    pub max_leaf: usize,
    /// Leaves by number of triangles: the index is the number, the last entry is not 0.
    pub leaf_histogram: Vec<usize>,
    /// Inner nodes by number of children: the index is the number, the last entry is not 0.
    pub degree_histogram: Vec<usize>,
    /// Bytes of nodes and triangle ids, without the triangles themselves.
    pub bytes: usize,
}

/// Counts what a valid tree consists of.
pub fn stats(bvh: &Bvh) -> TreeStats {
    let mut stats = TreeStats { bytes: bvh.bytes(), ..TreeStats::default() };
    // Parents stand before their children: their depth is known when the children's is asked for.
    let mut depths = vec![0usize; bvh.nodes.len()];
    let mut children_in_all = 0;
    for (index, node) in bvh.nodes.iter().enumerate() {
        stats.max_depth = stats.max_depth.max(depths[index]);
        match node.kind() {
            NodeKind::Leaf(slots) => {
                stats.leaves += 1;
                count(&mut stats.leaf_histogram, slots.len());
            }
            NodeKind::Inner(children) => {
                stats.inner += 1;
                children_in_all += children.len();
                count(&mut stats.degree_histogram, children.len());
                let below = depths[index] + 1;
                depths[children].fill(below);
            }
        }
    }
    stats.empty = stats.leaf_histogram.first().copied().unwrap_or(0);
    stats.max_leaf = stats.leaf_histogram.len().saturating_sub(1);
    stats.avg_degree = (stats.inner > 0).then(|| children_in_all as f64 / stats.inner as f64);
    stats
}

fn count(histogram: &mut Vec<usize>, value: usize) {
    if histogram.len() <= value {
        histogram.resize(value + 1, 0);
    }
    histogram[value] += 1;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Node;
    use crate::bvh::testing::{boxes, random_tree, soup};
    use crate::geom::Aabb;

    const B: Aabb = Aabb::EMPTY;

    #[test]
    fn by_hand() {
        let bvh = Bvh {
            nodes: vec![
                Node::inner(B, 1, 3),
                Node::leaf(B, 0, 0),
                Node::inner(B, 4, 2),
                Node::leaf(B, 0, 1),
                Node::leaf(B, 1, 4),
                Node::leaf(B, 5, 1),
            ],
            triangle_ids: (0..6).collect(),
            arity: 4,
        };
        let expected = TreeStats {
            inner: 2,
            leaves: 4,
            empty: 1,
            avg_degree: Some(2.5),
            max_depth: 2,
            max_leaf: 4,
            leaf_histogram: vec![1, 2, 0, 0, 1],
            degree_histogram: vec![0, 0, 1, 1],
            bytes: 6 * 32 + 6 * 4,
        };
        assert_eq!(stats(&bvh), expected);
    }

    #[test]
    fn one_leaf_has_no_degree() {
        let bvh = Bvh { nodes: vec![Node::leaf(B, 0, 2)], triangle_ids: vec![0, 1], arity: 2 };
        let s = stats(&bvh);
        assert_eq!((s.inner, s.leaves, s.max_depth, s.max_leaf, s.avg_degree), (0, 1, 0, 2, None));
        assert!(s.degree_histogram.is_empty());
    }

    #[test]
    fn histograms_add_up() {
        for seed in 0..20 {
            let boxes = boxes(&soup(seed, 500, 0.1));
            let bvh = random_tree(seed, &boxes, 8, 4);
            let s = stats(&bvh);
            let weighted = |h: &[usize]| h.iter().enumerate().map(|(value, n)| value * n).sum::<usize>();
            assert_eq!(s.leaf_histogram.iter().sum::<usize>(), s.leaves);
            assert_eq!(s.degree_histogram.iter().sum::<usize>(), s.inner);
            assert_eq!(weighted(&s.leaf_histogram), 500);
            assert_eq!(weighted(&s.degree_histogram) + 1, bvh.nodes.len());
        }
    }
}
