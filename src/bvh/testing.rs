//! Quick trees and triangles for the tests of modules that walk, check or change finished trees.

use super::{Bvh, Node};
use crate::geom::{Aabb, Triangle};
use glam::Vec3;

/// SplitMix64 (Steele, Lea, Flood 2014): small, seeded, the same everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `0 .. n`, near enough for tests.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u64 << 24) as f32
    }

    pub fn point(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * size
    }
}

/// `n` triangles of about `size` in the unit cube.
pub fn soup(seed: u64, n: usize, size: f32) -> Vec<Triangle> {
    let mut random = Random(seed);
    (0..n)
        .map(|_| {
            let at = random.point(1.0);
            Triangle::new(at + random.point(size), at + random.point(size), at + random.point(size))
        })
        .collect()
}

pub fn boxes(triangles: &[Triangle]) -> Vec<Aabb> {
    triangles.iter().map(Triangle::aabb).collect()
}

/// Splits at the median centre of the longest axis: a plain, sensible binary tree.
pub fn median_split(boxes: &[Aabb], max_leaf: usize) -> Bvh {
    split_with(boxes, 2, max_leaf, |ids| {
        let centres = Aabb::around(ids.iter().map(|&id| boxes[id as usize].centre().as_vec3()));
        let axis = (centres.max - centres.min).max_position();
        let key = |id: u32| boxes[id as usize].centre()[axis];
        ids.select_nth_unstable_by(ids.len() / 2, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
        vec![ids.len() / 2]
    })
}

/// Shuffles and cuts at random: a bad tree with every degree from 2 to `arity` and every leaf size to `max_leaf`.
pub fn random_tree(seed: u64, boxes: &[Aabb], arity: usize, max_leaf: usize) -> Bvh {
    let mut random = Random(seed);
    split_with(boxes, arity, max_leaf, |ids| {
        for i in (1..ids.len()).rev() {
            ids.swap(i, random.below(i + 1));
        }
        let degree = 2 + random.below(arity.min(ids.len()) - 1);
        let mut cuts: Vec<usize> = Vec::new();
        while cuts.len() < degree - 1 {
            let cut = 1 + random.below(ids.len() - 1);
            if !cuts.contains(&cut) {
                cuts.push(cut);
            }
        }
        cuts.sort_unstable();
        cuts
    })
}

/// Top-down by `split`, which orders the ids it is given and returns where to cut them.
fn split_with(boxes: &[Aabb], arity: usize, max_leaf: usize, mut split: impl FnMut(&mut [u32]) -> Vec<usize>) -> Bvh {
    let mut ids: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
    let mut stack = vec![(0, 0..boxes.len())];
    while let Some((index, slots)) = stack.pop() {
        if slots.len() <= max_leaf {
            nodes[index] = Node::leaf(Aabb::EMPTY, slots.start, slots.len());
            continue;
        }
        let mut ends = split(&mut ids[slots.clone()]);
        ends.push(slots.len());
        let first = nodes.len();
        nodes[index] = Node::inner(Aabb::EMPTY, first, ends.len());
        let mut start = 0;
        for (child, end) in ends.into_iter().enumerate() {
            nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
            stack.push((first + child, slots.start + start..slots.start + end));
            start = end;
        }
    }
    let mut bvh = Bvh { nodes, triangle_ids: ids, arity };
    tighten(&mut bvh, boxes);
    bvh
}

/// Gives every node the box of what stands below it.
pub fn tighten(bvh: &mut Bvh, boxes: &[Aabb]) {
    for index in (0..bvh.nodes.len()).rev() {
        let below = if bvh.nodes[index].is_leaf() {
            Aabb::union_of(bvh.leaf_triangles(index).iter().map(|&id| &boxes[id as usize]))
        } else {
            Aabb::union_of(bvh.nodes[bvh.children(index)].iter().map(|n| &n.aabb))
        };
        bvh.nodes[index].aabb = below;
    }
}
