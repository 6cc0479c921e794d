//! Boxes for tests: random ones, and ones on a small integer grid that provoke ties everywhere.

use super::{BuildError, Counters};
use crate::bvh::{Bvh, TreeHash, tree_hash};
use crate::geom::Aabb;
use crate::simd::Simd;
use glam::Vec3;
use proptest::prelude::*;

/// Boxes with random corners in a cube.
pub fn scattered(n: impl Into<proptest::collection::SizeRange>) -> impl Strategy<Value = Vec<Aabb>> {
    let corner = || (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let aabb = (corner(), corner(), 0.0f32..0.3).prop_map(|(a, b, size)| Aabb::around([a, a + b * size]));
    proptest::collection::vec(aabb, n)
}

/// Boxes with corners on a grid of few integers: equal keys, duplicates, flat boxes, equal areas.
pub fn on_a_grid(n: impl Into<proptest::collection::SizeRange>) -> impl Strategy<Value = Vec<Aabb>> {
    let corner = || (0u8..4, 0u8..4, 0u8..3).prop_map(|(x, y, z)| Vec3::new(x.into(), y.into(), z.into()));
    let aabb = (corner(), corner()).prop_map(|(a, b)| Aabb::around([a, b]));
    proptest::collection::vec(aabb, n)
}

/// Either of the two.
pub fn any_boxes(n: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Vec<Aabb>> {
    prop_oneof![scattered(n.clone()), on_a_grid(n)]
}

/// Triangles below each inner node, in no particular order.
pub fn inner_sizes(bvh: &Bvh) -> Vec<usize> {
    let mut below = vec![0; bvh.nodes.len()];
    let mut sizes = Vec::new();
    for index in (0..bvh.nodes.len()).rev() {
        let node = &bvh.nodes[index];
        below[index] = if node.is_leaf() { node.count() } else { bvh.children(index).map(|c| below[c]).sum() };
        if !node.is_leaf() {
            sizes.push(below[index]);
        }
    }
    sizes
}

/// Every choice of `k` of `from`, in lexicographic order.
pub fn choices(from: &[usize], k: usize) -> Vec<Vec<usize>> {
    if k == 0 {
        return vec![vec![]];
    }
    let mut all = Vec::new();
    for (i, &first) in from.iter().enumerate() {
        for mut rest in choices(&from[i + 1..], k - 1) {
            rest.insert(0, first);
            all.push(rest);
        }
    }
    all
}

/// Six boxes along x, one at each multiple of `pitch`, the last two lower than 1 by so many times 2⁻²⁴. With candidates after
/// the second and the fourth they part as 2 | 4 or 4 | 2: the same terms in another order where all heights are the same.
pub fn six_in_a_row(pitch: f32, steps_lower: u8) -> Vec<Aabb> {
    let lower = 1.0 - f32::from(steps_lower) * f32::EPSILON / 2.0;
    let height = |i: usize| if i < 4 { 1.0 } else { lower };
    let from = |i: usize| Vec3::new(pitch * i as f32, 0.0, 0.0);
    (0..6).map(|i| Aabb::new(from(i), from(i) + Vec3::new(1.0, height(i), 1.0))).collect()
}

/// The tree and the work of `build`, which are the same by every level of vector instructions and on any number of threads.
///
/// # Panics
/// If they are not.
pub fn same_everywhere(build: impl Fn(Simd, &mut Counters) -> Result<Bvh, BuildError> + Sync) -> (TreeHash, Counters) {
    let run = |threads, simd| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut work = Counters::default();
        let bvh = pool.install(|| build(simd, &mut work)).unwrap();
        (tree_hash(&bvh), work)
    };
    let expected = run(1, Simd::Baseline);
    for simd in Simd::available() {
        for threads in [1, 2, 7] {
            assert!(run(threads, simd) == expected, "{simd:?} {threads}");
        }
    }
    expected
}
