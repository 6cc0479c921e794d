//! The tree against its definition: clusters are the largest subtrees of `lbvh`, and above them is `binned-sah`.

use super::*;
use crate::build::lbvh::{self, Lbvh, MOST_GROWTH};
use crate::build::testing::{any_boxes, same_everywhere};
use crate::bvh::{Limits, tree_hash, validate};
use crate::cost::{SahParams, sah};
use crate::refine::open_leaves;
use crate::scene::Scene;
use proptest::prelude::*;

fn scene(name: &str) -> Vec<Aabb> {
    Scene::load(name).unwrap().boxes()
}

fn checked(boxes: &[Aabb], params: &Hlbvh) -> Bvh {
    let bvh = build(boxes, params, &mut ()).unwrap();
    validate(&bvh, boxes, &Limits { max_leaf: params.max_leaf, ..Limits::default() }).unwrap();
    bvh
}

fn text(bvh: &Bvh, index: usize) -> String {
    match bvh.children(index) {
        none if none.is_empty() => {
            let mut ids = bvh.leaf_triangles(index).to_vec();
            ids.sort_unstable();
            format!("{ids:?}")
        }
        two => format!("({} {})", text(bvh, two.start), text(bvh, two.start + 1)),
    }
}

/// The triangles below a node.
fn triangles(bvh: &Bvh, index: usize) -> usize {
    match bvh.children(index) {
        none if none.is_empty() => bvh.nodes[index].count(),
        two => two.map(|child| triangles(bvh, child)).sum(),
    }
}

/// The largest subtrees of at most `most` triangles that hang together, but where they may be leaves, left to right.
fn clusters(bvh: &Bvh, index: usize, params: &Hlbvh, found: &mut Vec<usize>) {
    if hangs_together(bvh, index, params) {
        found.push(index);
    } else {
        bvh.children(index).for_each(|child| clusters(bvh, child, params, found));
    }
}

fn hangs_together(bvh: &Bvh, index: usize, params: &Hlbvh) -> bool {
    let count = triangles(bvh, index);
    let as_leaf = |index: usize| bvh.nodes[index].aabb.surface_area() * triangles(bvh, index) as f64;
    count <= params.max_leaf
        || count <= params.cluster
            && bvh.children(index).all(|child| hangs_together(bvh, child, params))
            && as_leaf(index) <= MOST_GROWTH * bvh.children(index).map(as_leaf).sum::<f64>()
}

/// A subtree as a tree.
fn subtree(bvh: &Bvh, index: usize) -> Bvh {
    let mut nodes = vec![bvh.nodes[index]];
    let mut at = 0;
    while at < nodes.len() {
        if !nodes[at].is_leaf() {
            let children = nodes[at].range();
            nodes[at] = Node::inner(nodes[at].aabb, nodes.len(), 2);
            nodes.extend_from_slice(&bvh.nodes[children]);
        }
        at += 1;
    }
    Bvh { nodes, triangle_ids: bvh.triangle_ids.clone(), arity: 2 }
}

/// By definition.
fn literal(boxes: &[Aabb], params: &Hlbvh) -> String {
    let whole = lbvh::build(boxes, &Lbvh { max_leaf: 1 }, &mut ()).unwrap();
    let mut found = Vec::new();
    clusters(&whole, 0, params, &mut found);
    let roots: Vec<Aabb> = found.iter().map(|&index| whole.nodes[index].aabb).collect();
    let texts: Vec<String> =
        found.iter().map(|&index| text(&open_leaves(&subtree(&whole, index), params.max_leaf), 0)).collect();
    let above = binned_sah::build(&roots, &BinnedSah { max_leaf: 1, bins: params.bins }, &mut ()).unwrap();
    put_in(&above, 0, &texts)
}

/// A tree with `texts` for its leaves.
fn put_in(bvh: &Bvh, index: usize, texts: &[String]) -> String {
    match bvh.children(index) {
        none if none.is_empty() => texts[bvh.leaf_triangles(index)[0] as usize].clone(),
        two => format!("({} {})", put_in(bvh, two.start, texts), put_in(bvh, two.start + 1, texts)),
    }
}

fn check(boxes: &[Aabb]) {
    let default = Hlbvh::default();
    for (max_leaf, cluster, bins) in
        [(1, 1, 32), (4, 1, 32), (1, 16, 4), (4, 32, 32), (2, 64, 16), (64, 8, 32), (4, 256, 32)]
    {
        let params = Hlbvh { max_leaf, cluster, bins };
        assert_eq!(text(&checked(boxes, &params), 0), literal(boxes, &params), "{params:?}");
    }
    // Small parts make the same clusters.
    for part in [1, 100] {
        let bvh = build_with(boxes, &default, Simd::detect(), part, &mut ()).unwrap();
        assert_eq!(tree_hash(&bvh), tree_hash(&checked(boxes, &default)));
    }
}

#[test]
fn scenes_are_clustered_below_and_split_by_cost_above() {
    for name in ["gen:soup:3000", "gen:coincident:3000", "gen:nested:1000", "gen:stadium:3000", "thesis:small"] {
        check(&scene(name));
    }
}

#[test]
fn costs_lie_between_lbvh_and_binned_sah_and_rise_with_the_clusters() {
    let cost = |bvh: &Bvh| sah(bvh, SahParams::default()).unwrap();
    for name in ["gen:spheres:20000", "gen:terrain:20000", "thesis:med"] {
        let boxes = scene(name);
        let of = |cluster| cost(&checked(&boxes, &Hlbvh { cluster, ..Hlbvh::default() }));
        let costs = [
            cost(&binned_sah::build(&boxes, &BinnedSah::default(), &mut ()).unwrap()),
            of(8),
            of(64),
            of(256),
            cost(&lbvh::build(&boxes, &Lbvh::default(), &mut ()).unwrap()),
        ];
        assert!(costs.is_sorted_by(|a, b| a < b), "{name}: {costs:?}");
    }
}

#[test]
fn the_same_tree_and_work_at_every_level_and_on_any_number_of_threads() {
    let boxes = scene("gen:spheres:60000");
    let (_, work) = same_everywhere(|simd, work| build_with(&boxes, &Hlbvh::default(), simd, PART, work));
    // One merge less than triangles in each cluster, and clusters in bins.
    let clusters = 60_000 - work.get(Work::Merges);
    assert!((60_000 / 32..60_000 / 8).contains(&clusters), "{clusters}");
    assert!(work.get(Work::Binned) > clusters);
}

#[test]
fn parameters_out_of_range_and_stops_are_errors() {
    let boxes = scene("gen:soup:3000");
    let default = Hlbvh::default();
    for params in [
        Hlbvh { max_leaf: 0, ..default },
        Hlbvh { max_leaf: 65, ..default },
        Hlbvh { cluster: 0, ..default },
        Hlbvh { cluster: 257, ..default },
        Hlbvh { bins: 1, ..default },
        Hlbvh { bins: 257, ..default },
    ] {
        assert!(matches!(build(&boxes, &params, &mut ()), Err(BuildError::Parameter(_))), "{params:?}");
    }
    // Before the clusters; above them.
    for calls in [1, 2] {
        let stopped = build(&boxes, &default, &mut Calls(calls));
        assert_eq!(stopped.unwrap_err(), BuildError::Stopped(Unfinished { pending: vec![3000] }));
    }
}

/// Goes on until it has been asked so often.
struct Calls(usize);

impl Probe for Calls {
    fn go_on(&mut self, _: u64) -> bool {
        self.0 -= 1;
        self.0 > 0
    }
}

proptest! {
    #[test]
    fn any_boxes_are_clustered_below_and_split_by_cost_above(boxes in any_boxes(1..=300)) {
        check(&boxes);
    }
}
