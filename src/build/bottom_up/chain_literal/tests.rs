//! The chain against the specification written down word by word.

use super::{Observer, build};
use crate::build::testing::any_boxes;
use crate::build::{BuildError, Counters, Work};
use crate::bvh::tree_hash;
use crate::geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;

/// Merges in the order they happen, as pairs of ids.
#[derive(Default)]
struct Merges(Vec<[u32; 2]>, u64);

impl Observer for Merges {
    fn search(&mut self, _: u32, _: Vec3) {
        self.1 += 1;
    }
    fn merge(&mut self, a: (u32, Vec3), b: (u32, Vec3), merged: (u32, Vec3)) {
        assert_eq!(merged.0, a.0.min(b.0));
        self.0.push([a.0.min(b.0), a.0.max(b.0)]);
    }
}

/// The chain of the specification over a plain list of (id, box). Two-cluster cycles end by the rule itself; `None` when
/// the list goes round.
fn specified(boxes: &[Aabb]) -> Option<Vec<[u32; 2]>> {
    let mut live: Vec<(u32, Aabb)> = (0..).zip(boxes.iter().copied()).collect();
    let centre = |b: &Aabb| b.centre().as_vec3().as_dvec3();
    let distance = |a: &Aabb, b: &Aabb| {
        let d = centre(a) - centre(b);
        d.x * d.x + d.y * d.y + d.z * d.z
    };
    let nearest = |live: &[(u32, Aabb)], to: (u32, Aabb)| {
        let mut others: Vec<_> = live.iter().filter(|c| c.0 != to.0).copied().collect();
        others.sort_by(|a, b| distance(&a.1, &to.1).total_cmp(&distance(&b.1, &to.1)).then(a.0.cmp(&b.0)));
        others[0]
    };
    let origin = Aabb::new(Vec3::ZERO, Vec3::ZERO);
    let mut a = *live.iter().min_by(|a, b| distance(&a.1, &origin).total_cmp(&distance(&b.1, &origin)))?;
    let mut merges = Vec::new();
    if live.len() == 1 {
        return Some(merges);
    }
    let mut b = nearest(&live, a);
    let mut d = distance(&a.1, &b.1);
    let mut idle = 0;
    loop {
        let c = nearest(&live, b);
        if c.0 == a.0 || d <= distance(&b.1, &c.1) {
            live.retain(|x| x.0 != a.0 && x.0 != b.0);
            merges.push([a.0.min(b.0), a.0.max(b.0)]);
            a = (a.0.min(b.0), a.1.union(&b.1));
            live.push(a);
            if live.len() == 1 {
                return Some(merges);
            }
            b = nearest(&live, a);
            d = distance(&a.1, &b.1);
            idle = 0;
        } else {
            (a, b) = (b, c);
            idle += 1;
            if idle > 10 * boxes.len() {
                return None;
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn merges_are_as_specified(boxes in any_boxes(1..=60)) {
        let mut merges = Merges::default();
        let mut counters = Counters::default();
        match build(&boxes, &mut counters, &mut merges) {
            Ok(bvh) => {
                prop_assert_eq!(Some(merges.0), specified(&boxes));
                prop_assert_eq!(counters.get(Work::Merges), boxes.len() as u64 - 1);
                prop_assert_eq!(counters.get(Work::NearestSearches), merges.1);
                prop_assert_eq!(tree_hash(&bvh), tree_hash(&build(&boxes, &mut (), &mut ()).unwrap()));
            }
            Err(BuildError::Circling(_)) => prop_assert_eq!(specified(&boxes), None),
            Err(e) => panic!("{e}"),
        }
    }
}

#[test]
fn small_clusters_become_leaves_and_large_ones_parents() {
    // Two groups far apart: three and two boxes. Each becomes a leaf, five together a parent.
    let at = |x: f32| Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(x + 0.5, 1.0, 1.0));
    let boxes = [100.0, 0.0, 101.0, 1.0, 2.0].map(at);
    let bvh = build(&boxes, &mut (), &mut ()).unwrap();
    let leaves: Vec<Vec<u32>> = bvh
        .children(0)
        .map(|c| {
            let mut ids = bvh.leaf_triangles(c).to_vec();
            ids.sort();
            ids
        })
        .collect();
    assert_eq!(leaves, [vec![0, 2], vec![1, 3, 4]]);
}

#[test]
fn distances_scanned_are_counted_where_they_are_scanned() {
    let boxes: Vec<Aabb> = (0..3).map(|i| Aabb::new(Vec3::splat(i as f32), Vec3::splat(i as f32 + 0.5))).collect();
    let mut counters = Counters::default();
    build(&boxes, &mut counters, &mut ()).unwrap();
    // Nearest of 0 (two others), of 1 (two): mutual, merged; nearest of {0,1} (one other), of 2 (one): mutual, merged.
    assert_eq!(counters.get(Work::NearestSearches), 4);
    assert_eq!(counters.get(Work::PairDistances), 6);
}
