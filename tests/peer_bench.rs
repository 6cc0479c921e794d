//! The parts of the peer benchmark that decide what is a tree and what is a hit, held to cases that they must refuse. The
//! benchmark itself needs other libraries; these parts do not.

#[path = "../benches/peers/agreement.rs"]
mod agreement;
#[path = "../benches/peers/tree.rs"]
mod tree;

use agreement::{Difference, compare, compare_occlusion};
use bvh_lab::bvh::{Bvh, Limits, Node, tree_hash, validate};
use bvh_lab::geom::{Aabb, Ray, Triangle};
use bvh_lab::trace::HitRecord;
use glam::Vec3;
use tree::{Opened, PeerTree, covers};

#[test]
fn a_foreign_tree_is_read_with_its_loose_boxes_counted() {
    let cube = |x: f32| Aabb::new(Vec3::splat(x), Vec3::splat(x + 1.0));
    let boxes = [cube(0.0), cube(2.0), cube(4.0)];
    // Heap order: node 1 over 3 and 4, whose box is too wide; triangle ids backwards.
    let tree = PeerTree::convert(0usize, |node| match node {
        0 => Opened::Inner(Aabb::union_of(&boxes), 1, 2),
        1 => Opened::Inner(cube(0.0).union(&cube(9.0)), 3, 4),
        2 => Opened::Leaf(boxes[2], vec![2]),
        3 => Opened::Leaf(boxes[1], vec![1]),
        _ => Opened::Leaf(boxes[0], vec![0, 0]),
    });
    assert_eq!(tree.loose, 1);
    assert_eq!(validate(&tree.bvh, &boxes, &Limits::default()).map(|c| c.references), Ok(3));
    let first = tree.bvh.children(0).start;
    assert_eq!(tree.bvh.nodes[first].aabb, boxes[0].union(&boxes[1]));
    let own = PeerTree::own(tree.bvh.clone());
    assert_eq!((own.loose, tree_hash(&own.bvh)), (0, tree_hash(&tree.bvh)));
}

#[test]
fn a_triangle_that_sticks_out_of_its_leaves_is_found() {
    let triangles = [Triangle::new(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y), Triangle::new(Vec3::ZERO, Vec3::X, Vec3::X)];
    let boxes = triangles.map(|t| t.aabb());
    let halves = |right: f32, ids: Vec<u32>| {
        let left = Aabb::new(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0));
        let right = Aabb::new(Vec3::X, Vec3::new(right, 0.5, 0.0));
        let nodes = vec![Node::inner(left.union(&right), 1, 2), Node::leaf(left, 0, 1), Node::leaf(right, 1, 1)];
        Bvh { nodes, triangle_ids: ids, arity: 2 }
    };
    // The second triangle has no area and may be left out.
    assert_eq!(covers(&halves(2.0, vec![0, 0]), &triangles, &boxes), Ok(2));
    assert!(covers(&halves(1.9, vec![0, 0]), &triangles, &boxes).unwrap_err().contains("triangle 0"));
    assert!(covers(&halves(2.0, vec![0, 1]), &triangles, &boxes).unwrap_err().contains("triangle 0"));
    assert!(covers(&halves(2.0, vec![0, 7]), &triangles, &boxes).unwrap_err().contains("triangle 7"));
}

#[test]
fn shadow_rays_are_answered_by_yes_or_no() {
    let hits = [0, 7, u32::MAX, u32::MAX].map(|triangle| HitRecord { triangle, t: 0.0 });
    let others = [3, u32::MAX, u32::MAX, 0].map(|triangle| HitRecord { triangle, t: 1.0 });
    assert_eq!(compare_occlusion(&hits, &hits), Difference::default());
    assert_eq!(compare_occlusion(&hits, &others), Difference { at_edges: 0, elsewhere: 2 });
}

#[test]
fn other_answers_are_found_and_those_at_edges_told_apart() {
    let behind = |z: f32| Triangle::new(Vec3::new(-1.0, -1.0, z), Vec3::new(3.0, -1.0, z), Vec3::new(-1.0, 3.0, z));
    let triangles = [behind(-1.0), behind(-2.0)];
    let towards = |x: f32, y: f32| Ray::new(Vec3::new(x, y, 0.0), Vec3::NEG_Z);
    let first = HitRecord { triangle: 0, t: 1.0 };
    let second = HitRecord { triangle: 1, t: 2.0 };
    let check =
        |ray: Ray, expected: HitRecord, found: HitRecord| compare(&triangles, &[ray], &[expected], &[found], 4.0);
    let none = Difference::default();
    let (edge, elsewhere) = (Difference { at_edges: 1, ..none }, Difference { elsewhere: 1, ..none });
    assert_eq!(check(towards(0.0, 0.0), first, first), none);
    assert_eq!(check(towards(0.0, 0.0), first, HitRecord { triangle: 1, t: 1.00005 }), none);
    assert_eq!(check(towards(0.0, 0.0), first, HitRecord { t: 1.001, ..first }), elsewhere);
    assert_eq!(check(towards(0.0, 0.0), first, HitRecord::MISS), elsewhere);
    assert_eq!(check(towards(0.0, 0.0), HitRecord::MISS, second), elsewhere);
    assert_eq!(check(towards(-1.0, 0.0), first, second), edge);
    assert_eq!(check(towards(-0.9999, 0.0), second, first), edge);
    assert_eq!(check(towards(-0.9, 0.0), second, first), elsewhere);
    assert_eq!(check(towards(9.0, 9.0), HitRecord::MISS, HitRecord::MISS), none);
}
