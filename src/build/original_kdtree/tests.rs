//! The replay against the original's way, word by word: recursion and a list that is walked.

use super::*;
use crate::bvh::testing::Random;

/// Centres of every awkward kind: scattered, on a grid with many ties, coincident, in one rising line, far apart.
fn centres(kind: usize, n: usize) -> Vec<Vec3> {
    let mut random = Random(kind as u64);
    (0..n)
        .map(|i| match kind {
            0 => random.point(30.0),
            1 => (random.point(6.0)).floor(),
            2 => Vec3::ONE,
            3 => Vec3::splat(i as f32 * 0.5),
            4 => random.point(1e20),
            _ => random.point(1e-20),
        })
        .collect()
}

/// The original's way, word by word: recursion and a list that is walked.
struct Literal<'a> {
    tree: &'a OriginalKdTree,
    radius: f64,
    centre: Vec3,
    list: Vec<f64>,
    visited: u64,
    list_steps: u64,
}

impl Literal<'_> {
    fn visit(&mut self, at: u32) {
        let Some(&entry) = self.tree.entries.get(at as usize) else {
            return;
        };
        self.visited += 1;
        let d = entry.distance_squared(self.centre);
        if entry.live && d <= self.radius * self.radius {
            let passed = self.list.iter().take_while(|&&listed| listed < d).count();
            self.list_steps += passed as u64;
            self.list.insert(passed, d);
        }
        let axis = usize::from(entry.axis);
        let dx = f64::from(self.centre[axis]) - f64::from(entry.centre[axis]);
        let [left, right] = entry.children;
        let (near, far) = if dx < 0.0 { (left, right) } else { (right, left) };
        self.visit(near);
        if dx.abs() <= self.radius {
            self.visit(far);
        }
    }
}

#[test]
fn nearest_and_counts_equal_the_literal_ones_while_entries_come_and_go() {
    for kind in 0..6 {
        let mut random = Random(77);
        let mut tree = OriginalKdTree::new();
        let mut alive: Vec<(u32, Vec3)> = Vec::new();
        for (id, centre) in (0..).zip(centres(kind, 150)) {
            tree.insert(id, centre);
            alive.push((id, centre));
        }
        while alive.len() > 1 {
            let (id, centre) = alive[random.below(alive.len())];
            let brute = alive
                .iter()
                .filter(|(other, _)| *other != id)
                .map(|&(other, at)| Nearest {
                    id: other,
                    distance_squared: (at.as_dvec3() - centre.as_dvec3()).length_squared(),
                })
                .reduce(|a, b| if b.before(&a) { b } else { a });
            let before = tree.work();
            let found = tree.nearest(id, centre);
            assert_eq!(found, brute, "kind {kind}");
            let after = tree.work();
            let (mut visited, mut steps, mut listed, mut queries) = (0, 0, 0, 0);
            let mut radius = 10.0;
            loop {
                let mut literal = Literal { tree: &tree, radius, centre, list: Vec::new(), visited: 0, list_steps: 0 };
                literal.visit(0);
                queries += 1;
                visited += literal.visited;
                steps += literal.list_steps;
                listed += literal.list.len() as u64;
                // The first is the cluster itself.
                if literal.list.len() > 1 {
                    break;
                }
                radius *= 2.0;
            }
            assert_eq!(after.visited - before.visited, visited, "kind {kind}");
            assert_eq!(after.list_steps - before.list_steps, steps, "kind {kind}");
            assert_eq!(after.listed - before.listed, listed);
            assert_eq!(after.range_queries - before.range_queries, queries);
            // Merge the two, as the chain does; the smaller id lives on.
            let other = found.unwrap().id;
            let at = alive.iter().position(|a| a.0 == other).unwrap();
            let (_, other_centre) = alive.swap_remove(at);
            alive.retain(|a| a.0 != id);
            assert!(tree.remove(id, centre) && tree.remove(other, other_centre));
            assert!(!tree.remove(other, other_centre), "marked once only");
            let merged = (id.min(other), (centre + other_centre) * 0.5);
            tree.insert(merged.0, merged.1);
            alive.push(merged);
            assert_eq!(tree.len(), alive.len());
        }
        let (last, centre) = alive[0];
        assert_eq!(tree.nearest(last, centre), None);
    }
}

#[test]
fn steps_by_hand() {
    let mut tree = OriginalKdTree::new();
    assert!(tree.is_empty() && !tree.remove(0, Vec3::ZERO) && tree.nearest(0, Vec3::ZERO).is_none());
    // A rising line is a chain to the right: 0 + 1 + 2 + 3 nodes passed.
    for id in 0..4 {
        tree.insert(id, Vec3::splat(id as f32));
    }
    assert_eq!(tree.work().insert_steps, 6);
    // Everything is in range, met in rising order of distance: the second passes 1, the third 2, the fourth 3.
    assert_eq!(tree.nearest(0, Vec3::ZERO).map(|n| n.id), Some(1));
    let work = tree.work();
    assert_eq!((work.visited, work.listed, work.list_steps, work.range_queries), (4, 4, 6, 1));
    // From the other end every entry but those goes to the head of the list.
    assert_eq!(tree.nearest(3, Vec3::splat(3.0)).map(|n| n.id), Some(2));
    assert_eq!(tree.work().list_steps, 6);
    assert!(tree.remove(2, Vec3::splat(2.0)));
    assert_eq!(tree.work().find_steps, 3);
    // Marked, still visited, no longer listed.
    let before = tree.work();
    assert_eq!(tree.nearest(3, Vec3::splat(3.0)).map(|n| n.id), Some(1));
    let after = tree.work();
    assert_eq!((after.visited - before.visited, after.listed - before.listed), (4, 3));
    assert_eq!(after.steps(), after.visited + 6 + 6 + 3);
    // At distance 15 the second radius finds it.
    let mut far = OriginalKdTree::new();
    far.insert(0, Vec3::ZERO);
    far.insert(1, Vec3::X * 15.0);
    assert_eq!(far.nearest(0, Vec3::ZERO).map(|n| n.distance_squared), Some(225.0));
    assert_eq!(far.work().range_queries, 2);
    assert_eq!(far.nearest(0, Vec3::splat(f32::NAN)), None);
}

#[test]
fn rising_pairs_are_counted() {
    let mut random = Random(4);
    for n in (0..100).chain([257, 1000]) {
        let mut values: Vec<f64> = (0..n).map(|_| random.below(40) as f64).collect();
        let brute = (0..n).map(|i| (0..i).filter(|&j| values[j] < values[i]).count() as u64).sum::<u64>();
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        assert_eq!(count_rising_pairs(&mut values, &mut Vec::new()), brute);
        assert_eq!(values, sorted);
    }
}

#[test]
fn a_tree_as_deep_as_it_has_entries_needs_no_call_stack() {
    let mut tree = OriginalKdTree::new();
    for id in 0..20_000 {
        tree.insert(id, Vec3::ONE);
    }
    assert_eq!(tree.nearest(7, Vec3::ONE).map(|n| n.id), Some(0));
    assert_eq!(tree.work().visited, 20_000);
    assert_eq!(tree.work().list_steps, 0);
}
