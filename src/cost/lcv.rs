//! Leaf count variability (LCV): Aila, Karras and Laine, "On Quality Metrics of Bounding Volume Hierarchies", HPG 2013, section 4.
//!
//! The standard deviation, over rays, of the number of leaves that a ray intersects. The paper's reason: rays that are traced side
//! by side (SIMD lanes, threads of a warp) wait for the slowest of them, so of two trees with the same mean the one whose rays
//! differ less is the faster. The figure belongs to a tree *and a set of rays*; figures of other sets do not compare.
//!
//! Here a leaf counts where its box meets the ray between `t_min` and `t_max`, both included. The caller decides what that is:
//! for rays that end at their closest hit these are the leaves that no front-to-back traversal can leave out, and none that
//! an ideal one would not enter; it depends on no order of traversal. For lines without an end it is the leaf term of the
//! surface area heuristic's model. `crate::lab` has the set that the laboratory's figures are about.

use crate::bvh::{Bvh, NodeKind};
use crate::geom::{Aabb, Ray};
use rayon::prelude::*;

/// Rays that one thread takes at a time.
const CHUNK: usize = 1024;

/// How many leaves rays meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafCounts {
    /// Rays that were counted: all that can be traced.
    pub rays: usize,
    /// Leaves per ray, on average.
    pub mean: f64,
    /// Leaf count variability: the standard deviation of the leaves per ray (of these rays, not of an estimated population).
    pub lcv: f64,
}

/// Counts, for each ray, the leaves whose box it meets between `t_min` and `t_max`; empty leaves, which a traversal enters like
/// others, included. Rays that cannot hit anything ([`Ray::is_traceable`]) are left out; `None` if that leaves none, and for a
/// tree without nodes.
///
/// The box test is in f64, closed, and monotone under rounding, so the walk counts exactly what a look at every leaf's box counts.
/// Counts are added as integers: the figure does not depend on the number of threads. Nothing is assumed about boxes:
/// children may stick out of their parents, as with rule Q8.
pub fn leaf_counts(bvh: &Bvh, rays: &[Ray]) -> Option<LeafCounts> {
    if bvh.nodes.is_empty() {
        return None;
    }
    let hulls = hulls(bvh);
    let of_chunk = |stack: &mut Vec<usize>, rays: &[Ray]| {
        rays.iter()
            .filter(|ray| ray.is_traceable())
            .fold(Moments::default(), |sum, ray| sum.and(u64::from(leaves_met(bvh, &hulls, &Line::new(ray), stack))))
    };
    let moments = rays.par_chunks(CHUNK).map_init(Vec::new, of_chunk).reduce(Moments::default, Moments::plus);
    moments.finish()
}

/// The union of every node's box and all below it.
fn hulls(bvh: &Bvh) -> Vec<Aabb> {
    let mut hulls: Vec<Aabb> = bvh.nodes.iter().map(|n| n.aabb).collect();
    for index in (0..hulls.len()).rev() {
        hulls[index] = bvh.children(index).fold(hulls[index], |hull, child| hull.union(&hulls[child]));
    }
    hulls
}

fn leaves_met(bvh: &Bvh, hulls: &[Aabb], line: &Line, stack: &mut Vec<usize>) -> u32 {
    let mut met = 0;
    stack.push(0);
    while let Some(index) = stack.pop() {
        match bvh.nodes[index].kind() {
            NodeKind::Leaf(_) => met += u32::from(line.meets(&bvh.nodes[index].aabb)),
            NodeKind::Inner(children) if line.meets(&hulls[index]) => stack.extend(children),
            NodeKind::Inner(_) => {}
        }
    }
    met
}

/// A ray prepared for box tests: origin and inverse direction in f64, where no finite f32 over- or underflows.
struct Line {
    origin: [f64; 3],
    /// `None` along axes on which the ray does not move.
    inverse: [Option<f64>; 3],
    t_min: f64,
    t_max: f64,
}

impl Line {
    fn new(ray: &Ray) -> Self {
        let inverse = |d: f32| (d != 0.0).then(|| 1.0 / f64::from(d));
        Self {
            origin: ray.origin.to_array().map(f64::from),
            inverse: ray.direction.to_array().map(inverse),
            t_min: ray.t_min.into(),
            t_max: ray.t_max.into(),
        }
    }

    /// Differences and products with one factor are monotone, so a box inside another is met only where that is.
    fn meets(&self, aabb: &Aabb) -> bool {
        let (mut entry, mut exit) = (self.t_min, self.t_max);
        let (min, max) = (aabb.min.to_array(), aabb.max.to_array());
        for axis in 0..3 {
            let (from, to) = (f64::from(min[axis]) - self.origin[axis], f64::from(max[axis]) - self.origin[axis]);
            match self.inverse[axis] {
                Some(inverse) => {
                    let (near, far) = if inverse < 0.0 { (to, from) } else { (from, to) };
                    entry = entry.max(near * inverse);
                    exit = exit.min(far * inverse);
                }
                None if from <= 0.0 && to >= 0.0 => {}
                None => return false,
            }
        }
        entry <= exit
    }
}

/// Sums of leaves met and of their squares.
#[derive(Clone, Copy, Default)]
struct Moments {
    rays: u64,
    leaves: u64,
    squares: u128,
}

impl Moments {
    fn and(self, leaves: u64) -> Self {
        self.plus(Self { rays: 1, leaves, squares: u128::from(leaves) * u128::from(leaves) })
    }

    fn plus(self, other: Self) -> Self {
        Self { rays: self.rays + other.rays, leaves: self.leaves + other.leaves, squares: self.squares + other.squares }
    }

    /// Exact up to the last division: the variance times the square of the number of rays is an integer.
    fn finish(self) -> Option<LeafCounts> {
        let (rays, leaves) = (u128::from(self.rays), u128::from(self.leaves));
        let spread = rays.checked_mul(self.squares)? - leaves * leaves;
        (rays > 0).then(|| LeafCounts {
            rays: self.rays as usize,
            mean: self.leaves as f64 / self.rays as f64,
            lcv: (spread as f64).sqrt() / self.rays as f64,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Node;
    use crate::bvh::testing::{Random, boxes, median_split, random_tree, soup};
    use glam::Vec3;
    use proptest::prelude::*;

    /// Leaves met by a look at each leaf's box on its own, slab by slab in another form: two roots a slab, sorted.
    fn literal(bvh: &Bvh, ray: &Ray) -> u64 {
        let meets = |b: &Aabb| {
            let mut inside = (f64::from(ray.t_min), f64::from(ray.t_max));
            for axis in 0..3 {
                let (o, d) = (f64::from(ray.origin[axis]), f64::from(ray.direction[axis]));
                let (lo, hi) = (f64::from(b.min[axis]), f64::from(b.max[axis]));
                if d == 0.0 {
                    if o < lo || o > hi {
                        return false;
                    }
                    continue;
                }
                let mut roots = [lo - o, hi - o].map(|x| x * (1.0 / d));
                roots.sort_by(f64::total_cmp);
                inside = (inside.0.max(roots[0]), inside.1.min(roots[1]));
            }
            inside.0 <= inside.1
        };
        bvh.nodes.iter().filter(|n| n.is_leaf() && meets(&n.aabb)).count() as u64
    }

    fn by_definition(bvh: &Bvh, rays: &[Ray]) -> (f64, f64) {
        let counts: Vec<f64> = rays.iter().filter(|r| r.is_traceable()).map(|r| literal(bvh, r) as f64).collect();
        let mean = counts.iter().sum::<f64>() / counts.len() as f64;
        let variance = counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / counts.len() as f64;
        (mean, variance.sqrt())
    }

    fn rays(seed: u64, n: usize) -> Vec<Ray> {
        let mut random = Random(seed);
        (0..n)
            .map(|i| {
                let origin = random.point(3.0) - 1.0;
                let mut direction = random.point(2.0) - 1.0;
                // Every sign of every axis, zeros among them, and rays that end.
                direction[i % 3] *= [1.0, 0.0, -0.0, -1.0][i % 4];
                let t_max = if i % 5 == 0 { random.unit() } else { f32::INFINITY };
                Ray { t_max, ..Ray::new(origin, direction) }
            })
            .collect()
    }

    #[test]
    fn by_hand() {
        let unit = |x: f32| Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 1.0, 1.0));
        let bvh = Bvh {
            nodes: vec![
                Node::inner(Aabb::new(Vec3::ZERO, Vec3::new(4.0, 1.0, 1.0)), 1, 3),
                Node::leaf(unit(0.0), 0, 1),
                Node::leaf(unit(1.0), 1, 1),
                Node::leaf(unit(3.0), 2, 1),
            ],
            triangle_ids: vec![0, 1, 2],
            arity: 4,
        };
        let along = Ray::new(Vec3::new(-1.0, 0.5, 0.5), Vec3::X);
        let of = |rays: &[Ray]| leaf_counts(&bvh, rays).map(|c| (c.rays, c.mean, c.lcv));
        assert_eq!(of(&[along]), Some((1, 3.0, 0.0)));
        // Through the face that two leaves share: both. Up to 3 from −1: not the last. Beside: none.
        let across = Ray::new(Vec3::new(1.0, -1.0, 0.5), Vec3::Y);
        let short = Ray { t_max: 3.0, ..along };
        let beside = Ray::new(Vec3::new(2.5, -1.0, 0.5), Vec3::Y);
        assert_eq!(of(&[across]), Some((1, 2.0, 0.0)));
        assert_eq!(of(&[short]), Some((1, 2.0, 0.0)));
        assert_eq!(of(&[Ray { t_max: 4.0, ..along }]), Some((1, 3.0, 0.0)), "ends are included");
        assert_eq!(of(&[along, beside]), Some((2, 1.5, 1.5)));
        let nothing = Ray::new(Vec3::NAN, Vec3::X);
        assert_eq!(of(&[along, nothing, beside]), Some((2, 1.5, 1.5)));
        assert_eq!(of(&[nothing]), None);
        assert_eq!(leaf_counts(&Bvh { nodes: Vec::new(), ..bvh }, &[along]), None);
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let bvh = median_split(&boxes(&soup(9, 3000, 0.05)), 4);
        let rays = rays(3, 5000);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| leaf_counts(&bvh, &rays)).unwrap()
        };
        assert!(with(1) == with(2) && with(1) == with(5));
    }

    proptest! {
        #[test]
        fn as_by_definition(seed: u64, n in 1usize..120, arity in 2usize..9, q8: bool) {
            let mut bvh = random_tree(seed, &boxes(&soup(seed, n, 0.3)), arity, 3);
            if q8 {
                // Children that stick out of their parents.
                for node in bvh.nodes.iter_mut().step_by(3) {
                    node.aabb.max = node.aabb.min + (node.aabb.max - node.aabb.min) * 0.3;
                }
            }
            let rays = rays(!seed, 60);
            let counts = leaf_counts(&bvh, &rays).unwrap();
            let (mean, lcv) = by_definition(&bvh, &rays);
            prop_assert_eq!(counts.rays, 60);
            prop_assert!((counts.mean - mean).abs() < 1e-12 && (counts.lcv - lcv).abs() < 1e-9, "{counts:?} {mean} {lcv}");
        }
    }
}
