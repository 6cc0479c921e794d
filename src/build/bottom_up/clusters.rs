//! The clusters of the literal engines: merging two, and the tree that is left in the end.

use crate::build::MAX_LEAF;
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use glam::DVec3;

/// A cluster of triangles: what is below it, and what distances are measured by.
#[derive(Clone, Debug)]
pub(super) struct Cluster {
    /// Its smallest triangle id.
    pub id: u32,
    /// Box around its triangles.
    pub aabb: Aabb,
    /// Centre of that box.
    pub centre: DVec3,
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
        Self { id, aabb, centre: aabb.centre(), content }
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

/// Distances computed at a time.
pub(super) const LANES: usize = 8;

/// How exact centres are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    /// Rounded to f32, as in the original's kd-tree.
    Single,
    /// As f64 has them.
    Double,
}

impl Cluster {
    /// The centre of its box, as exact as `precision` has it.
    pub fn centre(&self, precision: Precision) -> DVec3 {
        match precision {
            Precision::Single => self.centre.as_vec3().as_dvec3(),
            Precision::Double => self.centre,
        }
    }
}

/// Centres by coordinate: one loop over them compiles to SIMD of whatever width there is, with the same results.
#[derive(Debug)]
pub(super) struct Centres {
    precision: Precision,
    coordinates: [Vec<f64>; 3],
}

impl Centres {
    /// The centres of `clusters`, in their order.
    pub fn of(clusters: &[Cluster], precision: Precision) -> Self {
        let axis = |axis: usize| clusters.iter().map(|c| c.centre(precision)[axis]).collect();
        Self { precision, coordinates: [0, 1, 2].map(axis) }
    }

    /// The centre at `index`.
    #[inline(always)]
    pub fn get(&self, index: usize) -> DVec3 {
        let [x, y, z] = &self.coordinates;
        DVec3::new(x[index], y[index], z[index])
    }

    /// Puts the centre of `cluster` at `index`.
    pub fn set(&mut self, index: usize, cluster: &Cluster) {
        for (axis, coordinates) in self.coordinates.iter_mut().enumerate() {
            coordinates[index] = cluster.centre(self.precision)[axis];
        }
    }

    /// Takes out the centre at `index`; the last one takes its place.
    pub fn swap_remove(&mut self, index: usize) {
        for coordinates in &mut self.coordinates {
            coordinates.swap_remove(index);
        }
    }

    /// Takes out the centre at `index`; those behind it move up.
    pub fn remove(&mut self, index: usize) {
        for coordinates in &mut self.coordinates {
            coordinates.remove(index);
        }
    }

    /// Squared distances from `point` to the centres `from`, from + 1, …, at most [`LANES`] of them; returns how
    /// many. Entries beyond them are infinite.
    #[inline(always)]
    pub fn distances(&self, point: DVec3, from: usize, out: &mut [f64; LANES]) -> usize {
        let [x, y, z] = &self.coordinates;
        let n = (x.len() - from).min(LANES);
        if let (Some(x), Some(y), Some(z)) =
            (x[from..].first_chunk::<LANES>(), y[from..].first_chunk::<LANES>(), z[from..].first_chunk::<LANES>())
        {
            for k in 0..LANES {
                out[k] = distance_squared(point, DVec3::new(x[k], y[k], z[k]));
            }
        } else {
            *out = [f64::INFINITY; LANES];
            for k in 0..n {
                out[k] = distance_squared(point, DVec3::new(x[from + k], y[from + k], z[from + k]));
            }
        }
        n
    }
}

/// The least of some distances, by halves: a chain of eight minima would wait for each other.
#[inline(always)]
pub(super) fn least(distances: &[f64; LANES]) -> f64 {
    let lower = |a: f64, b: f64| if b < a { b } else { a };
    let d = distances;
    let quarter = [lower(d[0], d[4]), lower(d[1], d[5]), lower(d[2], d[6]), lower(d[3], d[7])];
    lower(lower(quarter[0], quarter[2]), lower(quarter[1], quarter[3]))
}

/// Squared distance of two centres: differences and squares in f64, added x, y, z.
#[inline(always)]
pub(super) fn distance_squared(a: DVec3, b: DVec3) -> f64 {
    let d = a - b;
    d.x * d.x + d.y * d.y + d.z * d.z
}
