//! The clusters of the literal engines: merging two, and the tree that is left in the end.

use super::super::top_down::MAX_LEAF;
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use glam::{DVec3, Vec3};

/// A cluster of triangles: what is below it, and what distances are measured by.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// Its smallest triangle id.
    pub id: u32,
    /// Box around its triangles.
    pub aabb: Aabb,
    /// Centre of that box, rounded to f32 as in the original's kd-tree.
    pub centre: Vec3,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    /// At most [`MAX_LEAF`] triangles.
    Leaf(Vec<u32>),
    /// Two clusters of the [`Dead`] ones, the smaller id first.
    Inner([usize; 2]),
}

/// Clusters that were merged into larger ones.
#[derive(Debug, Default)]
pub(super) struct Dead(Vec<Cluster>);

impl Cluster {
    fn new(aabb: Aabb, id: u32, content: Content) -> Self {
        Self { id, aabb, centre: aabb.centre().as_vec3(), content }
    }

    /// The cluster of one triangle.
    pub fn of_triangle(id: u32, aabb: Aabb) -> Self {
        Self::new(aabb, id, Content::Leaf(vec![id]))
    }

    /// Merges two clusters: into one leaf if it is not too full, else into a parent of both.
    pub fn merge(self, other: Self, dead: &mut Dead) -> Self {
        let (first, second) = if self.id < other.id { (self, other) } else { (other, self) };
        let (aabb, id) = (first.aabb.union(&second.aabb), first.id);
        match (&first.content, &second.content) {
            (Content::Leaf(a), Content::Leaf(b)) if a.len() + b.len() <= MAX_LEAF => {
                Self::new(aabb, id, Content::Leaf([a.as_slice(), b].concat()))
            }
            _ => {
                let at = dead.0.len();
                dead.0.extend([first, second]);
                Self::new(aabb, id, Content::Inner([at, at + 1]))
            }
        }
    }

    /// The binary tree below the last cluster.
    pub fn into_tree(self, dead: &Dead) -> Bvh {
        let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
        let mut triangle_ids = Vec::new();
        let mut pending = vec![(0, &self)];
        while let Some((node, cluster)) = pending.pop() {
            nodes[node] = match &cluster.content {
                Content::Leaf(ids) => {
                    triangle_ids.extend_from_slice(ids);
                    Node::leaf(cluster.aabb, triangle_ids.len() - ids.len(), ids.len())
                }
                Content::Inner([a, b]) => {
                    let first = nodes.len();
                    nodes.resize(first + 2, Node::leaf(Aabb::EMPTY, 0, 0));
                    pending.extend([(first + 1, &dead.0[*b]), (first, &dead.0[*a])]);
                    Node::inner(cluster.aabb, first, 2)
                }
            };
        }
        Bvh { nodes, triangle_ids, arity: 2 }
    }
}

/// One cluster per box, in id order.
pub(super) fn clusters(boxes: &[Aabb]) -> Vec<Cluster> {
    (0u32..).zip(boxes).map(|(id, &aabb)| Cluster::of_triangle(id, aabb)).collect()
}

/// Squared distance of two centres: differences and squares in f64, added x, y, z.
#[inline(always)]
pub(super) fn distance_squared(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x * d.x + d.y * d.y + d.z * d.z
}
