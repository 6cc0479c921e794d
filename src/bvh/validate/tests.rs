//! Valid trees pass; a tree broken on purpose shows the violation that was made, and garbage does not panic.

use super::*;
use crate::bvh::Node;
use crate::bvh::testing::{Random, boxes, median_split, random_tree, soup, tighten};
use glam::Vec3;

const N: usize = 60;

fn scene() -> Vec<Aabb> {
    boxes(&soup(1, N, 0.1))
}

/// A sound tree, changed by `spoil`, then checked.
fn spoilt(spoil: impl FnOnce(&mut Bvh)) -> Vec<Violation> {
    let boxes = scene();
    let mut bvh = median_split(&boxes, 4);
    assert!(validate(&bvh, &boxes, &Limits::default()).is_ok());
    spoil(&mut bvh);
    match validate(&bvh, &boxes, &Limits::default()) {
        Ok(_) => Vec::new(),
        Err(violations) => violations.first,
    }
}

fn first_leaf(bvh: &Bvh) -> usize {
    bvh.nodes.iter().position(Node::is_leaf).expect("every tree has a leaf")
}

#[test]
fn sound_trees_of_every_arity_pass() {
    for seed in 0..40 {
        let arity = 2 + seed as usize % 7;
        let boxes = boxes(&soup(seed, 1 + seed as usize * 7, 0.3));
        let bvh = random_tree(seed, &boxes, arity, 4);
        for q8 in [false, true] {
            let coverage = validate(&bvh, &boxes, &Limits { max_leaf: 4, q8, ..Limits::default() }).unwrap();
            assert_eq!(coverage, Coverage { references: boxes.len(), ..Coverage::default() });
        }
    }
}

#[test]
fn a_tree_without_nodes_has_no_root() {
    assert_eq!(spoilt(|bvh| bvh.nodes.clear()), [Violation::NoRoot]);
}

#[test]
fn broken_references_are_found() {
    let seen = spoilt(|bvh| bvh.nodes[0].tagged_count = 0);
    assert_eq!(seen[0], Violation::NoChildren(0));
    let seen = spoilt(|bvh| bvh.nodes[0].first = 0);
    assert_eq!(seen[0], Violation::ChildNotBehind(0));
    let seen = spoilt(|bvh| bvh.nodes[3].first = 1);
    assert!(seen.contains(&Violation::ChildNotBehind(3)), "{seen:?}");
    let seen = spoilt(|bvh| bvh.nodes[0].first = bvh.nodes.len() as u32 - 1);
    assert_eq!(seen[0], Violation::ChildrenOutOfBounds(0));
    let seen = spoilt(|bvh| bvh.nodes[0].first = u32::MAX);
    assert_eq!(seen[0], Violation::ChildrenOutOfBounds(0));
    let seen = spoilt(|bvh| bvh.nodes.push(Node::leaf(Aabb::EMPTY, 0, 0)));
    assert_eq!(seen, [Violation::Orphan(bvh_len() - 1)]);
    let (child, seen) = {
        let mut child = 0;
        let seen = spoilt(|bvh| {
            child = bvh.children(1).start;
            bvh.nodes[2].first = child as u32;
        });
        (child, seen)
    };
    assert!(seen.contains(&Violation::Shared { child, parent: 2 }), "{seen:?}");
    assert!(seen.iter().any(|v| matches!(v, Violation::Orphan(_))), "{seen:?}");
}

/// Nodes of the sound tree with one more behind.
fn bvh_len() -> usize {
    median_split(&scene(), 4).nodes.len() + 1
}

#[test]
fn limits_are_kept() {
    let boxes = scene();
    let bvh = random_tree(7, &boxes, 8, 6);
    let wide = bvh.nodes.iter().position(|n| !n.is_leaf() && n.count() > 2).unwrap();
    let full = (0..bvh.nodes.len()).find(|&i| bvh.nodes[i].is_leaf() && bvh.nodes[i].count() > 4).unwrap();
    let seen = validate(&bvh, &boxes, &Limits::default()).unwrap_err();
    assert_eq!(
        seen.first[0],
        Violation::TooManyTriangles { leaf: full, triangles: bvh.nodes[full].count(), max_leaf: 4 }
    );
    let narrow = Bvh { arity: 2, ..bvh };
    let limits = Limits { max_leaf: 6, q8: false, ..Limits::default() };
    let seen = validate(&narrow, &boxes, &limits).unwrap_err();
    assert_eq!(
        seen.first[0],
        Violation::TooManyChildren { node: wide, children: narrow.nodes[wide].count(), arity: 2 }
    );
}

#[test]
fn broken_leaves_are_found() {
    let mut leaf = 0;
    let seen = spoilt(|bvh| {
        leaf = first_leaf(bvh);
        bvh.nodes[leaf].first = bvh.triangle_ids.len() as u32;
    });
    assert_eq!(seen[0], Violation::SlotsOutOfBounds(leaf));
    assert!(seen.iter().any(|v| matches!(v, Violation::Missing(_))), "{seen:?}");

    let seen = spoilt(|bvh| bvh.nodes[leaf] = Node::leaf(Aabb::EMPTY, 0, 0));
    assert_eq!(seen.iter().filter(|v| **v == Violation::EmptyLeaf(leaf)).count(), 1, "{seen:?}");

    let seen = spoilt(|bvh| bvh.triangle_ids[5] = N as u32);
    assert!(seen.iter().any(|v| matches!(v, Violation::UnknownTriangle { triangle, .. } if *triangle == N as u32)));

    // One triangle twice and another not at all.
    let (mut kept, mut lost) = (0, 0);
    let seen = spoilt(|bvh| {
        (kept, lost) = (bvh.triangle_ids[0], bvh.triangle_ids[1]);
        bvh.triangle_ids[1] = kept;
    });
    assert!(seen.iter().any(|v| matches!(v, Violation::Repeated { triangle, .. } if *triangle == kept)));
    assert!(seen.contains(&Violation::Missing(lost as usize)), "{seen:?}");

    // Leaves that claim everything over and over are counted, not walked.
    let all = scene();
    let greedy = Bvh {
        nodes: (0..100)
            .map(|i| if i == 0 { Node::inner(Aabb::EMPTY, 1, 99) } else { Node::leaf(Aabb::EMPTY, 0, N) })
            .collect(),
        triangle_ids: (0..N as u32).collect(),
        arity: 99,
    };
    let seen = validate(&greedy, &all, &Limits { max_leaf: N, q8: true, ..Limits::default() }).unwrap_err();
    assert_eq!(seen.first, [Violation::SlotsClaimed { claimed: 99 * N, slots: N }]);
}

#[test]
fn boxes_must_be_tight_to_the_last_bit() {
    let nodes = median_split(&scene(), 4).nodes.len();
    for node in 0..nodes {
        for q8 in [false, true] {
            for (step, axis) in [(1, 0), (-1, 1), (1, 2)] {
                let all = scene();
                let mut bvh = median_split(&all, 4);
                let old = bvh.nodes[node].aabb.max[axis];
                bvh.nodes[node].aabb.max[axis] = f32::from_bits(old.to_bits().wrapping_add_signed(step));
                let seen = validate(&bvh, &all, &Limits { max_leaf: 4, q8, ..Limits::default() }).unwrap_err().first;
                assert!(seen.contains(&Violation::LooseBox(node)), "{node} {seen:?}");
            }
        }
    }
    let seen = spoilt(|bvh| bvh.nodes[0].aabb.min.x = f32::NAN);
    assert_eq!(seen, [Violation::LooseBox(0)]);
}

#[test]
fn the_message_is_one_line_and_counts_what_it_leaves_out() {
    let all = scene();
    let mut bvh = median_split(&all, 4);
    bvh.nodes.iter_mut().for_each(|n| n.aabb = Aabb::EMPTY);
    let violations = validate(&bvh, &all, &Limits::default()).unwrap_err();
    assert_eq!(violations.first.len(), Violations::KEPT);
    // Inner boxes agree with each other: only the leaves do not agree with their triangles.
    let leaves = bvh.nodes.iter().filter(|n| n.is_leaf()).count();
    assert_eq!(violations.total, leaves);
    let line = violations.to_string();
    assert!(line.contains(&format!("of {leaves} violations")) && !line.contains('\n'), "{line}");
}

/// Builds as rule Q8 does it, with random splits where the rule does not apply. Returns the tree and the number of nodes
/// that the rule made.
fn q8_tree(seed: u64, boxes: &[Aabb]) -> (Bvh, usize) {
    let mut random = Random(seed);
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
    let mut made = 0;
    let mut stack = vec![(0, 0, boxes.len())];
    while let Some((index, start, n)) = stack.pop() {
        let aabb = Aabb::union_of(order[start..start + n].iter().map(|&t| &boxes[t as usize]));
        if n <= 4 {
            nodes[index] = Node::leaf(aabb, start, n);
            continue;
        }
        for i in (1..n).rev() {
            order.swap(start + i, start + random.below(i + 1));
        }
        let first = nodes.len();
        if n >= 8 || start == 0 {
            let degree = n.min(8);
            nodes[index] = Node::inner(aabb, first, degree);
            let mut cuts = vec![0, n];
            while cuts.len() < degree + 1 {
                let cut = 1 + random.below(n - 1);
                if !cuts.contains(&cut) {
                    cuts.push(cut);
                }
            }
            cuts.sort_unstable();
            nodes.resize(first + degree, nodes[0]);
            for (child, cut) in cuts.windows(2).enumerate().rev() {
                stack.push((first + child, start + cut[0], cut[1] - cut[0]));
            }
        } else {
            made += 1;
            nodes[index] = Node::inner(aabb, first, 8);
            nodes.push(Node::leaf(boxes[order[start] as usize], 0, 0));
            let neighbour = boxes[order[start - 1] as usize];
            nodes.extend([Node::leaf(neighbour, 0, 0); 6]);
            nodes.push(nodes[0]);
            stack.push((first + 7, start - 1, n + 1));
        }
    }
    let bvh = Bvh { nodes, triangle_ids: order, arity: 8 };
    (bvh, made)
}

#[test]
fn rule_q8_is_exempt_where_it_must_be_and_nowhere_else() {
    const Q8: Limits = Limits { max_leaf: 4, q8: true, spatial: false };
    let mut all_told = Coverage::default();
    for seed in 0..200 {
        let boxes = boxes(&soup(seed, 5 + seed as usize, 0.1));
        let (bvh, made) = q8_tree(seed, &boxes);
        let coverage = validate(&bvh, &boxes, &Q8).unwrap();
        assert_eq!(coverage.q8_nodes, made);
        assert_eq!(coverage.empty_leaves, 7 * made);
        // By definition: some leaf holds the triangle and no box on the path to it fails to contain it.
        let mut parent = vec![None; bvh.nodes.len()];
        (0..bvh.nodes.len()).for_each(|i| bvh.children(i).for_each(|c| parent[c] = Some(i)));
        let path = |leaf| std::iter::successors(Some(leaf), |&i| parent[i]);
        let tree = &bvh;
        let holders = |t: usize| (0..tree.nodes.len()).filter(move |&i| tree.leaf_triangles(i).contains(&(t as u32)));
        let duplicated = (0..boxes.len()).filter(|&t| holders(t).count() > 1).count();
        let hidden = (0..boxes.len())
            .filter(|&t| !holders(t).any(|leaf| path(leaf).all(|i| bvh.nodes[i].aabb.contains(&boxes[t]))))
            .count();
        assert_eq!((coverage.duplicated, coverage.hidden), (duplicated, hidden));
        all_told.duplicated += duplicated;
        all_told.hidden += hidden;
        all_told.q8_nodes += made;
        if made > 0 {
            assert!(validate(&bvh, &boxes, &Limits::default()).is_err());
            let q8_node = (0..bvh.nodes.len())
                .find(|&i| !bvh.nodes[i].is_leaf() && bvh.nodes[bvh.children(i).start].count() == 0)
                .unwrap();
            let mut loose = bvh.clone();
            loose.nodes[q8_node].aabb.max.x += 1.0;
            let seen = validate(&loose, &boxes, &Q8).unwrap_err().first;
            assert!(seen.contains(&Violation::LooseBox(q8_node)), "{seen:?}");
        }
    }
    assert!(all_told.q8_nodes > 100 && all_told.duplicated > 100 && all_told.hidden > 10, "{all_told:?}");
}

#[test]
fn under_q8_a_lost_or_twice_held_triangle_is_still_one_too_many() {
    let all = scene();
    let mut bvh = median_split(&all, 4);
    let leaf = (0..bvh.nodes.len()).find(|&i| bvh.nodes[i].is_leaf() && bvh.nodes[i].count() > 1).unwrap();
    let slot = bvh.nodes[leaf].range().start;
    let lost = bvh.triangle_ids[slot + 1];
    bvh.triangle_ids[slot + 1] = bvh.triangle_ids[slot];
    tighten(&mut bvh, &all);
    let seen = validate(&bvh, &all, &Limits { max_leaf: 4, q8: true, ..Limits::default() }).unwrap_err().first;
    let triangle = bvh.triangle_ids[slot];
    assert_eq!(seen, [Violation::Repeated { leaf, triangle }, Violation::Missing(lost as usize)]);
    let mut empty = median_split(&all, 4);
    empty.nodes[leaf].tagged_count = super::super::LEAF;
    let seen = validate(&empty, &all, &Limits { max_leaf: 4, q8: true, ..Limits::default() }).unwrap_err().first;
    assert!(seen.contains(&Violation::EmptyLeaf(leaf)), "{seen:?}");
}

#[test]
fn garbage_never_panics() {
    let boxes = scene();
    let mut random = Random(3);
    for round in 0..2000 {
        let words = |random: &mut Random| match random.below(4) {
            0 => random.next() as u32,
            1 => random.below(4) as u32,
            _ => random.below(40) as u32,
        };
        let nodes = (0..random.below(30))
            .map(|_| Node {
                aabb: Aabb::new(random.point(1.0), Vec3::splat(f32::from_bits(random.next() as u32))),
                first: words(&mut random),
                tagged_count: words(&mut random) | if random.below(2) == 0 { 1 << 31 } else { 0 },
            })
            .collect();
        let garbage = Bvh {
            nodes,
            triangle_ids: (0..random.below(50)).map(|_| words(&mut random)).collect(),
            arity: words(&mut random) as usize,
        };
        let limits = Limits { max_leaf: random.below(10), q8: round % 2 == 0, spatial: round % 3 == 0 };
        assert!(validate(&garbage, &boxes, &limits).is_err());
        assert!(validate_parts(&garbage, &soup(1, N, 0.1), &boxes, &limits).is_err());
    }
}

/// A triangle over the unit square's lower half in two leaves, each with its part's box, and another one beside it.
fn parted() -> (Bvh, Vec<Triangle>, Vec<Aabb>) {
    let triangles = vec![
        Triangle::new(Vec3::ZERO, Vec3::X * 2.0, Vec3::Y),
        Triangle::new(Vec3::X, Vec3::X * 2.0, Vec3::X + Vec3::Y),
    ];
    let boxes = boxes(&triangles);
    let leaf = |x: f32, to: f32, high: f32, slot, n| {
        Node::leaf(Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(to, high, 0.0)), slot, n)
    };
    let nodes = vec![Node::inner(boxes[0], 1, 2), leaf(0.0, 1.0, 1.0, 0, 1), leaf(1.0, 2.0, 1.0, 1, 2)];
    (Bvh { nodes, triangle_ids: vec![0, 1, 0], arity: 2 }, triangles, boxes)
}

#[test]
fn parts_of_a_triangle_may_stand_in_several_leaves_only_with_spatial_splits() {
    const SPATIAL: Limits = Limits { max_leaf: 4, q8: false, spatial: true };
    let (bvh, triangles, boxes) = parted();
    let coverage = Coverage { references: 3, duplicated: 1, ..Coverage::default() };
    assert_eq!(validate_parts(&bvh, &triangles, &boxes, &SPATIAL), Ok(coverage));
    assert_eq!(validate(&bvh, &boxes, &SPATIAL), Ok(coverage));
    let seen = validate_parts(&bvh, &triangles, &boxes, &Limits::default()).unwrap_err().first;
    assert!(seen.contains(&Violation::Repeated { leaf: 2, triangle: 0 }), "{seen:?}");

    let broken = |spoil: fn(&mut Bvh)| {
        let mut bvh = bvh.clone();
        spoil(&mut bvh);
        let union = bvh.nodes[1].aabb.union(&bvh.nodes[2].aabb);
        bvh.nodes[0].aabb = union;
        let first = |checked: Result<Coverage, Violations>| checked.map_or_else(|v| v.first, |_| Vec::new());
        (first(validate_parts(&bvh, &triangles, &boxes, &SPATIAL)), first(validate(&bvh, &boxes, &SPATIAL)))
    };
    // A gap in the middle shows with the triangle alone, one at the edge also without.
    let (seen, by_boxes) = broken(|bvh| bvh.nodes[1].aabb.max.x = 0.99);
    assert_eq!((seen, by_boxes), (vec![Violation::Uncovered(0)], vec![]));
    let (seen, by_boxes) = broken(|bvh| bvh.nodes[1].aabb.min.x = 0.01);
    assert_eq!((seen, by_boxes), (vec![Violation::Uncovered(0)], vec![Violation::Uncovered(0)]));
    // Part of the triangle is above 0.5 at x < 1.
    let (seen, _) = broken(|bvh| bvh.nodes[1].aabb.max.y = 0.9);
    assert_eq!(seen, [Violation::Uncovered(0)]);
    // The right half has nothing of it above 0.5, but another triangle.
    let (seen, _) = broken(|bvh| bvh.nodes[2].aabb.max.y = 0.6);
    assert_eq!(seen, [Violation::Uncovered(1)]);
    // Boxes beyond the triangles are loose; one that stands once needs its whole box.
    let (seen, _) = broken(|bvh| bvh.nodes[1].aabb.min.x = -0.5);
    assert_eq!(seen, [Violation::LooseBox(1)]);
    let (seen, _) = broken(|bvh| bvh.nodes[1].aabb = Aabb::EMPTY);
    assert!(seen.contains(&Violation::LooseBox(1)) && seen.contains(&Violation::Uncovered(0)), "{seen:?}");
    let (seen, _) = broken(|bvh| bvh.triangle_ids[1] = 0);
    assert_eq!(seen, [Violation::Repeated { leaf: 2, triangle: 0 }, Violation::Missing(1)]);
    let (seen, _) = broken(|bvh| bvh.triangle_ids[0] = 1);
    assert!(seen.contains(&Violation::Uncovered(0)), "{seen:?}");
}
