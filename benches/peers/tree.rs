//! A peer's binary tree in the laboratory's own form, so that one function scores all of them; and equal leaves for all.

use bvh_lab::bvh::{Bvh, Node};
use bvh_lab::geom::{Aabb, Triangle};
use bvh_lab::refine::open_leaves;
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

/// Equal leaves for all: every leaf is taken apart into single triangles, by sweeps for the least SAH, then subtrees of at
/// most `max_leaf` triangles become leaves again wherever that lowers the cost ([`open_leaves`]).
///
/// A tree whose leaves keep the limit never gets worse by it: its own leaves are among the choices. A tree with larger
/// leaves gets the lower levels that it was not made to build.
pub fn equal_leaves(bvh: &Bvh, boxes: &[Aabb], max_leaf: usize) -> Bvh {
    let mut nodes = bvh.nodes.clone();
    let mut triangle_ids = Vec::with_capacity(bvh.triangle_ids.len());
    for (index, node) in bvh.nodes.iter().enumerate().filter(|(_, node)| node.is_leaf()) {
        let part = |id: u32| within(&boxes[id as usize], &node.aabb);
        let mut parts: Vec<_> = bvh.leaf_triangles(index).iter().map(|&id| (part(id), id)).collect();
        let mut pending = vec![(index, 0..parts.len())];
        while let Some((place, range)) = pending.pop() {
            if range.len() <= 1 {
                // A leaf of one keeps the library's own box.
                let aabb = if parts.len() == 1 { node.aabb } else { parts[range.start].0 };
                nodes[place] = Node::leaf(aabb, triangle_ids.len(), 1);
                triangle_ids.push(parts[range.start].1);
                continue;
            }
            let middle = range.start + sweep(&mut parts[range.clone()]);
            let first = nodes.len();
            nodes[place] = Node::inner(node.aabb, first, 2);
            nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
            pending.extend([(first + 1, middle..range.end), (first, range.start..middle)]);
        }
    }
    let mut apart = Bvh { nodes, triangle_ids, arity: 2 };
    fit(&mut apart);
    open_leaves(&apart, max_leaf)
}

/// The part of a triangle's box that lies in its leaf's: less than all of it where spatial splits cut.
fn within(triangle: &Aabb, leaf: &Aabb) -> Aabb {
    let part = Aabb::new(triangle.min.max(leaf.min), triangle.max.min(leaf.max));
    if part.is_empty() { *leaf } else { part }
}

/// Sorts `parts` for the split of the least SAH and returns where it is; in the middle where there are too many to try.
fn sweep(parts: &mut [(Aabb, u32)]) -> usize {
    const MOST: usize = 256;
    let n = parts.len();
    if n > MOST {
        return n / 2;
    }
    let sort = |parts: &mut [(Aabb, u32)], axis: usize| {
        parts.sort_by(|a, b| a.0.centre()[axis].total_cmp(&b.0.centre()[axis]).then(a.1.cmp(&b.1)));
    };
    let mut best = (f64::INFINITY, 0, n / 2);
    for axis in 0..3 {
        sort(parts, axis);
        let mut right = vec![Aabb::EMPTY; n + 1];
        for i in (0..n).rev() {
            right[i] = right[i + 1].union(&parts[i].0);
        }
        let mut left = Aabb::EMPTY;
        for i in 1..n {
            left = left.union(&parts[i - 1].0);
            let cost = left.surface_area() * i as f64 + right[i].surface_area() * (n - i) as f64;
            if cost < best.0 {
                best = (cost, axis, i);
            }
        }
    }
    sort(parts, best.1);
    best.2
}
