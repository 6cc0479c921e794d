//! End-point overlap: Aila, Karras and Laine, "On Quality Metrics of Bounding Volume Hierarchies", HPG 2013.
//!
//! The surface area heuristic assumes rays that come from far away and hit nothing. Rays end on surfaces, and a ray that
//! ends inside a node's box must visit the node; that is wasted work where the surface belongs to another subtree. EPO
//! measures how much surface of other subtrees every box holds. This is the area-weighted form of the paper.

use super::SahParams;
use super::clip::{Clipped, overlap};
use super::sum::Sum;
use crate::bvh::Bvh;
use crate::geom::{Aabb, Triangle};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Triangles of one partial sum. Fixed, so that the result does not depend on the number of threads.
const CHUNK: usize = 1024;

/// The most nodes that all walks together may meet: a few seconds.
const MOST_VISITS: u64 = 1 << 25;

/// Σ over nodes n of C(n) · area((all geometry outside n's subtree) ∩ n's box) / area(all geometry), with C(n) the
/// [`SahParams::node_cost`] at default constants. 0 for a tree that is one leaf.
///
/// A triangle that several leaves hold (rule Q8, spatial splits) is inside the subtree of every ancestor of each of them; one that no leaf
/// holds is outside of all. Nothing is assumed about boxes: children may stick out of their parents, as with rule Q8.
///
/// `None` when the triangles have no area, or one that is not a finite number. Time is the number of pairs of a triangle
/// and a node whose boxes overlap: near n log n in common scenes, n² where everything overlaps everything. `None` too
/// where there are more than 2²⁵ such pairs: 100,000 coincident or nested triangles would take minutes.
pub fn epo(bvh: &Bvh, triangles: &[Triangle]) -> Option<f64> {
    epo_within(MOST_VISITS, bvh, triangles)
}

/// [`epo`] unless more than `most` nodes are met. Whether they are does not depend on the threads: all are counted.
fn epo_within(most: u64, bvh: &Bvh, triangles: &[Triangle]) -> Option<f64> {
    let walk = Walk::new(bvh, triangles.len())?;
    let visits = AtomicU64::new(0);
    let partial: Vec<(Sum, Sum)> = triangles
        .par_chunks(CHUNK)
        .enumerate()
        .map_init(Vec::new, |stack, (chunk, triangles)| {
            let (mut areas, mut outside) = (Sum::default(), Sum::default());
            for (id, triangle) in (chunk * CHUNK..).zip(triangles) {
                if visits.load(Relaxed) > most {
                    break;
                }
                let triangle = Clipped::new(triangle);
                // One without area adds nothing anywhere.
                if triangle.area > 0.0 {
                    areas.add(triangle.area);
                    let (weighted, met) = walk.weighted_area_outside(id, &triangle, stack);
                    visits.fetch_add(met, Relaxed);
                    outside.add(weighted);
                }
            }
            (areas, outside)
        })
        .collect();
    let area = partial.iter().map(|p| p.0.value()).collect::<Sum>().value();
    let outside = partial.iter().map(|p| p.1.value()).collect::<Sum>().value();
    let all_met = visits.into_inner() <= most;
    (all_met && area > 0.0 && area.is_finite()).then(|| outside / area)
}

/// What the walk needs to know of a node, in one cache line.
struct Stop {
    aabb: Aabb,
    /// The union of the node's box and all below it.
    hull: Aabb,
    /// Places of the subtree's nodes in preorder: its first is the node's own.
    subtree: Range<u32>,
}

struct Walk<'a> {
    bvh: &'a Bvh,
    stops: Vec<Stop>,
    /// Preorder places of the leaves that hold triangle t: `leaves[starts[t] .. starts[t + 1]]`.
    starts: Vec<usize>,
    leaves: Vec<u32>,
}

impl<'a> Walk<'a> {
    /// `None` for a tree without nodes.
    fn new(bvh: &'a Bvh, triangles: usize) -> Option<Self> {
        let nodes = &bvh.nodes;
        nodes.first()?;
        let mut stops: Vec<Stop> = nodes.iter().map(|n| Stop { aabb: n.aabb, hull: n.aabb, subtree: 0..1 }).collect();
        // Children before parents: sizes and hulls. Then parents before children: places.
        for index in (0..nodes.len()).rev() {
            for child in bvh.children(index) {
                let (size, hull) = (stops[child].subtree.end, stops[child].hull);
                stops[index].subtree.end += size;
                stops[index].hull = stops[index].hull.union(&hull);
            }
        }
        for index in 0..nodes.len() {
            let mut place = stops[index].subtree.start + 1;
            for child in bvh.children(index) {
                let size = stops[child].subtree.end;
                stops[child].subtree = place..place + size;
                place += size;
            }
        }
        let mut starts = vec![0usize; triangles + 1];
        let held = |index| bvh.leaf_triangles(index).iter().map(|&t| t as usize);
        for t in (0..nodes.len()).flat_map(held).filter(|&t| t < triangles) {
            starts[t + 1] += 1;
        }
        for t in 0..triangles {
            starts[t + 1] += starts[t];
        }
        let mut next = starts.clone();
        let mut leaves = vec![0; starts[triangles]];
        for (index, stop) in stops.iter().enumerate() {
            for t in held(index).filter(|&t| t < triangles) {
                leaves[next[t]] = stop.subtree.start;
                next[t] += 1;
            }
        }
        Some(Self { bvh, stops, starts, leaves })
    }

    /// Σ C(n) · area(triangle ∩ n's box) over the nodes n that do not hold the triangle, and how many nodes were met.
    fn weighted_area_outside(&self, id: usize, triangle: &Clipped, stack: &mut Vec<usize>) -> (f64, u64) {
        let holders = &self.leaves[self.starts[id]..self.starts[id + 1]];
        let params = SahParams::default();
        let (mut sum, mut met) = (0.0, 0);
        stack.push(0);
        while let Some(index) = stack.pop() {
            met += 1;
            let stop = &self.stops[index];
            let holds = holders.iter().any(|leaf| stop.subtree.contains(leaf));
            if !holds {
                let area = triangle.area_within(&stop.aabb);
                if area > 0.0 {
                    sum += params.node_cost(&self.bvh.nodes[index]) * area;
                } else if stop.hull == stop.aabb {
                    // All below lies in a box that has none of the triangle.
                    continue;
                }
            }
            let children = self.bvh.children(index);
            stack.extend(children.filter(|&child| overlap(&self.stops[child].hull, &triangle.aabb)));
        }
        (sum, met)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Node;
    use crate::bvh::testing::{boxes, median_split, random_tree, soup};
    use glam::Vec3;

    #[test]
    fn too_many_overlaps_end_without_a_figure() {
        let triangles = vec![soup(1, 1, 0.1)[0]; 64];
        let bvh = median_split(&boxes(&triangles), 1);
        // All 64 triangles meet all 127 nodes.
        assert!(epo_within(64 * 127, &bvh, &triangles).is_some());
        assert_eq!(epo_within(64 * 127 - 1, &bvh, &triangles), None);
    }

    /// By definition: every node against every triangle.
    fn literal(bvh: &Bvh, triangles: &[Triangle]) -> f64 {
        let mut below: Vec<Vec<u32>> = vec![Vec::new(); bvh.nodes.len()];
        let (mut sum, mut area) = (0.0, 0.0);
        for index in (0..bvh.nodes.len()).rev() {
            let node = &bvh.nodes[index];
            let mut held = bvh.leaf_triangles(index).to_vec();
            held.extend(bvh.children(index).flat_map(|c| below[c].clone()));
            let cost = if node.is_leaf() { node.count() as f64 } else { 1.0 };
            for (id, t) in triangles.iter().enumerate() {
                if !held.contains(&(id as u32)) {
                    sum += cost * Clipped::new(t).area_within(&node.aabb);
                }
            }
            below[index] = held;
        }
        triangles.iter().for_each(|t| area += t.area());
        sum / area
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs()
    }

    /// Two squares of area 1 in the plane z = 0, at x = 0 … 1 and at x = `x` … `x` + 1, each of two triangles.
    fn squares(x: f32) -> (Bvh, Vec<Triangle>) {
        let square = |x: f32| {
            let p = |dx, dy| Vec3::new(x + dx, dy, 0.0);
            [Triangle::new(p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0)), Triangle::new(p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0))]
        };
        let triangles = [square(0.0), square(x)].concat();
        let b = boxes(&triangles);
        let bvh = Bvh {
            nodes: vec![Node::inner(Aabb::union_of(&b), 1, 2), Node::leaf(b[0], 0, 2), Node::leaf(b[2], 2, 2)],
            triangle_ids: (0..4).collect(),
            arity: 2,
        };
        (bvh, triangles)
    }

    #[test]
    fn by_hand() {
        let (bvh, triangles) = squares(2.0);
        assert_eq!(epo(&bvh, &triangles), Some(0.0));
        // A quarter of each square lies in the other's leaf, which costs 2: 2 · (2 · ¼) / 2.
        let (bvh, triangles) = squares(0.75);
        assert_eq!(epo(&bvh, &triangles), Some(0.5));
        // Touching squares share an edge, no area.
        let (bvh, triangles) = squares(1.0);
        assert_eq!(epo(&bvh, &triangles), Some(0.0));
        // A triangle that no leaf holds is outside of root and leaf: (1 + 2) · ½ more, and ½ more area.
        let (bvh, mut triangles) = squares(2.0);
        triangles.push(triangles[0]);
        assert_eq!(epo(&bvh, &triangles), Some(1.5 / 2.5));
    }

    #[test]
    fn no_area_no_figure() {
        let points = vec![Triangle::new(Vec3::ONE, Vec3::ONE, Vec3::ONE); 3];
        assert_eq!(epo(&median_split(&boxes(&points), 1), &points), None);
        let (mut bvh, triangles) = squares(2.0);
        bvh.nodes.clear();
        assert_eq!(epo(&bvh, &triangles), None);
    }

    #[test]
    fn equals_the_definition() {
        for seed in 0..60 {
            let n = 1 + seed as usize * 3;
            let triangles = soup(seed, n, [0.02, 0.3, 1.0][seed as usize % 3]);
            let b = boxes(&triangles);
            let trees = [median_split(&b, 4), random_tree(seed, &b, 2 + seed as usize % 7, 4)];
            for bvh in trees {
                let (fast, slow) = (epo(&bvh, &triangles).unwrap(), literal(&bvh, &triangles));
                assert!(close(fast, slow), "{seed}: {fast} {slow}");
            }
        }
    }

    #[test]
    fn equals_the_definition_with_children_outside_their_parents_and_triangles_held_twice() {
        for seed in 0..30 {
            let triangles = soup(seed, 80, 0.2);
            let b = boxes(&triangles);
            let mut bvh = random_tree(seed, &b, 4, 3);
            // Every third box shrinks towards a corner, and some slots are taken over by their neighbours' triangles.
            for node in bvh.nodes.iter_mut().step_by(3) {
                node.aabb.max = node.aabb.min + (node.aabb.max - node.aabb.min) * 0.3;
            }
            for slot in (0..80).step_by(9) {
                bvh.triangle_ids[slot] = bvh.triangle_ids[(slot + 7) % 80];
            }
            let (fast, slow) = (epo(&bvh, &triangles).unwrap(), literal(&bvh, &triangles));
            assert!(close(fast, slow), "{seed}: {fast} {slow}");
        }
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let triangles = soup(9, 5000, 0.05);
        let bvh = median_split(&boxes(&triangles), 4);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| epo(&bvh, &triangles)).unwrap().to_bits()
        };
        assert!(with(1) == with(2) && with(2) == with(5));
    }
}
