//! A peer's binary tree in the laboratory's own form, so that one function scores all of them.

use bvh_lab::bvh::{Bvh, Node};
use bvh_lab::geom::{Aabb, Triangle};
use glam::{DVec3, Vec3};

/// A node of a foreign tree, as its library shows it.
pub enum Opened<N> {
    /// Its box and its two children.
    Inner(Aabb, N, N),
    /// Its box and its triangles.
    Leaf(Aabb, Vec<u32>),
}

/// A foreign tree.
pub struct PeerTree {
    /// With the boxes of leaves as the library has them, and those of inner nodes as the union of what is below.
    pub bvh: Bvh,
    /// Inner nodes whose box in the library is another than that union.
    pub loose: usize,
}

impl PeerTree {
    /// A tree of ours.
    pub fn own(bvh: Bvh) -> Self {
        Self { bvh, loose: 0 }
    }

    /// Walks a foreign tree from its root.
    pub fn convert<N>(root: N, mut open: impl FnMut(N) -> Opened<N>) -> Self {
        let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
        let mut triangle_ids = Vec::new();
        let mut pending = vec![(0, root)];
        while let Some((place, node)) = pending.pop() {
            match open(node) {
                Opened::Leaf(aabb, mut ids) => {
                    // Two parts of one triangle in one leaf are one triangle.
                    ids.sort_unstable();
                    ids.dedup();
                    nodes[place] = Node::leaf(aabb, triangle_ids.len(), ids.len());
                    triangle_ids.extend(ids);
                }
                Opened::Inner(aabb, left, right) => {
                    let first = nodes.len();
                    nodes[place] = Node::inner(aabb, first, 2);
                    nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
                    pending.extend([(first + 1, right), (first, left)]);
                }
            }
        }
        let mut bvh = Bvh { nodes, triangle_ids, arity: 2 };
        let loose = fit(&mut bvh);
        Self { bvh, loose }
    }
}

/// Makes every inner box the union of the boxes below it. Returns how many were something else.
fn fit(bvh: &mut Bvh) -> usize {
    let mut loose = 0;
    for index in (0..bvh.nodes.len()).rev().filter(|&i| !bvh.nodes[i].is_leaf()).collect::<Vec<_>>() {
        let tight = Aabb::union_of(bvh.nodes[bvh.nodes[index].range()].iter().map(|n| &n.aabb));
        loose += usize::from(bvh.nodes[index].aabb != tight);
        bvh.nodes[index].aabb = tight;
    }
    loose
}

/// Whether the leaves of a tree with spatial splits cover every triangle: each of its vertices lies in the box of a leaf that
/// holds it, but for what rounding takes off where boxes were cut. Returns the references in all leaves.
///
/// # Errors
/// One line that names the first triangle that stands nowhere or sticks out.
pub fn covers(bvh: &Bvh, triangles: &[Triangle], boxes: &[Aabb]) -> Result<usize, String> {
    const ROUNDING: f32 = 1e-5;
    let slack = Vec3::splat(ROUNDING * Aabb::union_of(boxes).extent().max_element() as f32);
    let mut inside = vec![[false; 3]; triangles.len()];
    for (index, node) in bvh.nodes.iter().enumerate() {
        let grown = Aabb::new(node.aabb.min - slack, node.aabb.max + slack);
        for &id in bvh.leaf_triangles(index) {
            let triangle = triangles.get(id as usize).ok_or_else(|| format!("there is no triangle {id}"))?;
            for (vertex, inside) in triangle.v.iter().zip(&mut inside[id as usize]) {
                *inside |= grown.contains(&Aabb::new(*vertex, *vertex));
            }
        }
    }
    // tinybvh leaves out triangles without an area, which nothing can hit.
    let lost = |id: &usize| inside[*id].contains(&false) && triangles[*id].cross() != DVec3::ZERO;
    match (0..triangles.len()).find(lost) {
        Some(id) => Err(format!("no leaf that holds triangle {id} reaches all of its vertices")),
        None => Ok(bvh.triangle_ids.len()),
    }
}
