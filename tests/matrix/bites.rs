//! Trees and answers broken on purpose: a matrix that lets them pass would let anything pass.

use crate::cases::{Case, Demand, SEED};
use crate::judge::{Tree, judge, trees};
use crate::rays::mixed;
use crate::scenes::overlapping;
use crate::variants::variants;
use bvh_lab::bvh::{Bvh, Node};
use bvh_lab::trace::KERNELS;
use glam::Vec3;

fn case() -> Case {
    let triangles = overlapping(SEED, 60);
    let rays = mixed(&triangles, SEED, 400);
    Case { row: 0, what: "broken on purpose".into(), triangles, rays, demand: Demand::Oracle }
}

fn sound(case: &Case) -> Tree {
    let binned = variants().filter(|(b, o)| b.id == "binned-sah" && o.arity == 4);
    trees(&case.triangles, &binned.collect::<Vec<_>>()).remove(0)
}

/// How many kernels are found out over a tree that `break_it` has been at.
fn found_out(break_it: impl Fn(&mut Bvh)) -> usize {
    let case = case();
    let mut tree = sound(&case);
    assert_eq!(judge(&case, std::slice::from_ref(&tree)).failures, Vec::<String>::new());
    break_it(&mut tree.bvh);
    let failures = judge(&case, &[tree]).failures;
    KERNELS.iter().filter(|info| failures.iter().any(|f| f.contains(&format!(": {} on ", info.id)))).count()
}

fn a_leaf(bvh: &Bvh) -> usize {
    bvh.nodes.iter().position(Node::is_leaf).unwrap()
}

/// The box of a leaf lacks a part of its triangles. Of the thesis' kernel all hits are found out, though its misses are excused.
#[test]
fn a_box_too_small_is_found_out() {
    let shrink = |bvh: &mut Bvh| {
        let leaf = a_leaf(bvh);
        let aabb = &mut bvh.nodes[leaf].aabb;
        aabb.max = aabb.min + (aabb.max - aabb.min) * Vec3::new(0.3, 1.0, 1.0);
    };
    assert_eq!(found_out(shrink), KERNELS.len());
}

#[test]
fn a_triangle_that_stands_in_no_leaf_is_found_out() {
    assert_eq!(found_out(|bvh| bvh.triangle_ids[0] = bvh.triangle_ids[1]), KERNELS.len());
}

#[test]
fn a_leaf_without_its_triangles_is_found_out() {
    let empty = |bvh: &mut Bvh| {
        let leaf = a_leaf(bvh);
        bvh.nodes[leaf] = Node::leaf(bvh.nodes[leaf].aabb, 0, 0);
    };
    assert_eq!(found_out(empty), KERNELS.len());
}

#[test]
fn what_a_case_demands_is_asked() {
    let mut wrong = 0;
    for demand in [Demand::NoMiss, Demand::NoHit, Demand::Pairs, Demand::Exactly(vec![None; 400])] {
        let case = Case { demand, ..case() };
        let tree = sound(&case);
        wrong += usize::from(!judge(&case, &[tree]).failures.is_empty());
    }
    assert_eq!(wrong, 4);
}
