//! The surface area heuristic: Goldsmith and Salmon 1987, MacDonald and Booth 1990.

use super::sum::Sum;
use crate::bvh::{Bvh, Node};

/// The constants of the surface area heuristic. Only their ratio matters for comparing trees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SahParams {
    /// Cost of visiting an inner node.
    pub c_trav: f64,
    /// Cost of testing one triangle.
    pub c_isect: f64,
}

impl Default for SahParams {
    /// Both 1: what every row and table of the laboratory uses.
    fn default() -> Self {
        Self { c_trav: 1.0, c_isect: 1.0 }
    }
}

impl SahParams {
    /// What a ray pays at a node that it enters: `c_trav` at an inner node, `c_isect` times the triangles of a leaf.
    pub fn node_cost(&self, node: &Node) -> f64 {
        if node.is_leaf() { self.c_isect * node.count() as f64 } else { self.c_trav }
    }
}

/// Expected cost of a ray that enters the root's box: Σ area(node)/area(root) · [`SahParams::node_cost`] over all nodes of
/// a valid tree.
///
/// `None` when the root has no area or one that is not a finite number, or when there is no root.
pub fn sah(bvh: &Bvh, params: SahParams) -> Option<f64> {
    let root_area = bvh.nodes.first()?.aabb.surface_area();
    if !(root_area > 0.0 && root_area.is_finite()) {
        return None;
    }
    let terms = bvh.nodes.iter().map(|node| node.aabb.surface_area() / root_area * params.node_cost(node));
    Some(terms.collect::<Sum>().value())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use glam::Vec3;

    fn brick(x: f32, y: f32, z: f32) -> Aabb {
        Aabb::new(Vec3::ZERO, Vec3::new(x, y, z))
    }

    fn tree(nodes: Vec<Node>) -> Bvh {
        Bvh { nodes, triangle_ids: (0..8).collect(), arity: 2 }
    }

    #[test]
    fn by_hand() {
        // Areas 6·4 = 24, and 2(2 + 2 + 4) = 16 for each half.
        let bvh = tree(vec![
            Node::inner(brick(2.0, 2.0, 2.0), 1, 2),
            Node::leaf(brick(1.0, 2.0, 2.0), 0, 3),
            Node::leaf(brick(1.0, 2.0, 2.0), 3, 2),
        ]);
        let expected = 1.0 + 16.0 / 24.0 * 5.0;
        assert!((sah(&bvh, SahParams::default()).unwrap() - expected).abs() < 1e-15);
        let params = SahParams { c_trav: 2.0, c_isect: 0.5 };
        assert!((sah(&bvh, params).unwrap() - (2.0 + 16.0 / 24.0 * 2.5)).abs() < 1e-15);
        let leaf = tree(vec![Node::leaf(brick(1.0, 2.0, 3.0), 0, 4)]);
        assert_eq!(sah(&leaf, SahParams::default()), Some(4.0));
    }

    #[test]
    fn no_area_no_figure() {
        assert_eq!(sah(&tree(Vec::new()), SahParams::default()), None);
        let line = tree(vec![Node::leaf(brick(1.0, 0.0, 0.0), 0, 1)]);
        assert_eq!(sah(&line, SahParams::default()), None);
        let nan = tree(vec![Node::leaf(brick(f32::NAN, 1.0, 1.0), 0, 1)]);
        assert_eq!(sah(&nan, SahParams::default()), None);
        let huge = brick(f32::MAX, f32::MAX, f32::MAX);
        assert_eq!(sah(&tree(vec![Node::leaf(huge, 0, 1)]), SahParams::default()), Some(1.0));
    }
}
