//! Equal leaves for all: what makes the costs of trees comparable whose builders end their leaves by rules of their own.
//!
//! The thesis' constructions stop at four triangles whatever the cost, other libraries at one, at eight, or where a cost of their own
//! says so. Here leaves are taken apart into single triangles, by the sweeps of MacDonald and Booth 1990, and made anew where the
//! surface area heuristic wants them ([`open_leaves`]): what is left to compare is the tree above.

use super::bottom_up::unite;
use super::open_leaves;
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;

/// Larger leaves are halved, not swept: they come from builders that did not look at their cost at all.
const MOST_SWEPT: usize = 256;

/// Takes every leaf of a binary tree apart into single triangles, by sweeps for the least SAH; then subtrees of at most `max_leaf`
/// triangles become leaves again wherever that lowers the cost ([`open_leaves`]). A triangle of which a leaf holds a part (spatial
/// splits) counts with that part of its box.
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
    unite(&mut nodes, |leaf| leaf.aabb);
    open_leaves(&Bvh { nodes, triangle_ids, arity: 2 }, max_leaf)
}

/// The part of a triangle's box that lies in its leaf's: less than all of it where spatial splits cut.
fn within(triangle: &Aabb, leaf: &Aabb) -> Aabb {
    let part = Aabb::new(triangle.min.max(leaf.min), triangle.max.min(leaf.max));
    if part.is_empty() { *leaf } else { part }
}

/// Sorts `parts` for the split of the least SAH and returns where it is; in the middle where there are too many to try.
fn sweep(parts: &mut [(Aabb, u32)]) -> usize {
    let n = parts.len();
    if n > MOST_SWEPT {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::{Limits, validate};
    use crate::cost::{SahParams, sah};
    use crate::scene::Scene;

    /// A leaf over all triangles.
    fn one_leaf(boxes: &[Aabb]) -> Bvh {
        let nodes = vec![Node::leaf(Aabb::union_of(boxes), 0, boxes.len())];
        Bvh { nodes, triangle_ids: (0..boxes.len() as u32).collect(), arity: 2 }
    }

    #[test]
    fn equal_leaves_keep_the_limit_and_the_triangles_and_never_raise_the_cost_of_trees_that_kept_it() {
        let scene = Scene::load("gen:soup:400").unwrap();
        let boxes = scene.boxes();
        let limits = |max_leaf| Limits { max_leaf, ..Limits::default() };
        let cost = |bvh: &Bvh| sah(bvh, SahParams::default()).unwrap();
        // 400 are beyond what is swept at once, so the middle is taken first.
        let large = equal_leaves(&one_leaf(&boxes), &boxes, 4);
        validate(&large, &boxes, &limits(4)).unwrap();
        assert!(cost(&large) < 0.5 * cost(&one_leaf(&boxes)));
        let again = equal_leaves(&large, &boxes, 4);
        validate(&again, &boxes, &limits(4)).unwrap();
        assert!(cost(&again) <= cost(&large) * (1.0 + 1e-12));
        let single = equal_leaves(&large, &boxes, 1);
        validate(&single, &boxes, &limits(1)).unwrap();
        assert!(cost(&equal_leaves(&single, &boxes, 4)) <= cost(&single));
    }
}
