//! The scan of all pairs against a sort of all pairs at every step, and against its closed-form count.

use super::{Distance, build};
use crate::build::testing::any_boxes;
use crate::build::{Brake, BuildError, Counters, Work};
use crate::bvh::{Bvh, tree_hash};
use crate::geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;

/// The tree written as text: a leaf as its sorted ids, a parent as its children.
fn written(bvh: &Bvh, index: usize) -> String {
    if bvh.nodes[index].is_leaf() {
        let mut ids = bvh.leaf_triangles(index).to_vec();
        ids.sort();
        return format!("{ids:?}");
    }
    let children: Vec<_> = bvh.children(index).map(|c| written(bvh, c)).collect();
    format!("({})", children.join(" "))
}

/// All pairs with their keys (distance, first id, second id), sorted anew at every step.
fn specified(boxes: &[Aabb], distance: Distance) -> String {
    let mut live: Vec<(Vec<u32>, Aabb, String)> =
        (0..).zip(boxes).map(|(id, b): (u32, _)| (vec![id], *b, format!("[{id}]"))).collect();
    let far = |a: &Aabb, b: &Aabb| match distance {
        Distance::Centres => {
            let d = a.centre() - b.centre();
            d.x * d.x + d.y * d.y + d.z * d.z
        }
        Distance::UnionArea => a.union(b).surface_area(),
    };
    while live.len() > 1 {
        let mut pairs = Vec::new();
        for (i, a) in live.iter().enumerate() {
            for (j, b) in live.iter().enumerate().filter(|(j, _)| *j != i) {
                if a.0[0] < b.0[0] {
                    pairs.push((far(&a.1, &b.1), a.0[0], b.0[0], i, j));
                }
            }
        }
        pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
        let (_, _, _, i, j) = pairs[0];
        let (a, b) = (live[i].clone(), live[j].clone());
        let mut ids = [a.0, b.0].concat();
        ids.sort();
        let text = if ids.len() <= 4 { format!("{ids:?}") } else { format!("({} {})", a.2, b.2) };
        live[i] = (ids, a.1.union(&b.1), text);
        live.remove(j);
    }
    live.remove(0).2
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn tree_is_as_specified(boxes in any_boxes(1..=40)) {
        for distance in [Distance::Centres, Distance::UnionArea] {
            let mut counters = Counters::default();
            let bvh = build(&boxes, distance, &mut counters).unwrap();
            prop_assert_eq!(written(&bvh, 0), specified(&boxes, distance));
            let n = boxes.len() as u64;
            prop_assert_eq!(counters.get(Work::PairDistances), n * (n * n - 1) / 6);
            prop_assert_eq!(counters.get(Work::Merges), n - 1);
            let united = if distance == Distance::UnionArea { n * (n * n - 1) / 6 } else { 0 };
            prop_assert_eq!(counters.get(Work::BoxUnions), n - 1 + united);
            prop_assert_eq!(tree_hash(&bvh), tree_hash(&build(&boxes, distance, &mut ()).unwrap()));
        }
    }
}

#[test]
fn centre_distance_and_union_area_can_disagree() {
    // Three of each: a large box, a small one near its centre, and a small one a little farther off.
    let cube = |x: f32, half: f32| Aabb::new(Vec3::new(x - half, -half, -half), Vec3::new(x + half, half, half));
    let all: Vec<Aabb> = [cube(0.0, 50.0), cube(1.0, 0.5), cube(3.0, 0.5)].into_iter().flat_map(|b| [b; 3]).collect();
    let hash = |d| tree_hash(&build(&all, d, &mut ()).unwrap());
    assert_ne!(hash(Distance::Centres), hash(Distance::UnionArea));
}

#[test]
fn a_stopped_build_says_how_many_clusters_were_left() {
    let boxes: Vec<Aabb> = (0..600).map(|i| Aabb::new(Vec3::splat(i as f32), Vec3::splat(i as f32 + 0.5))).collect();
    let mut brake = Brake::new(Some(std::time::Instant::now()));
    let Err(BuildError::Stopped(left)) = build(&boxes, Distance::Centres, &mut brake) else {
        panic!("a deadline in the past stops the build");
    };
    assert_eq!(left.pending, [600]);
}
