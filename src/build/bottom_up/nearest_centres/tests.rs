//! Searches under insertion and deletion, against a list.

use super::{NEWEST, NearestCentres, Neighbour, distance_squared, twins};
use crate::build::bottom_up::testing::{clumps, extremes, hand_made};
use crate::build::testing::any_boxes;
use crate::geom::Aabb;
use crate::scene::families::FAMILIES;
use glam::DVec3;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// What a search must find, as (distance, id).
fn expected(live: &BTreeMap<u32, DVec3>, from: DVec3, own: bool, limit: f64) -> Option<(f64, u32)> {
    let others = live.iter().filter(|(_, centre)| !own || **centre != from);
    let keys = others.map(|(&id, &centre)| (distance_squared(from, centre), id)).filter(|key| key.0 <= limit);
    keys.min_by(|a, b| a.partial_cmp(b).unwrap())
}

/// Random insertions, deletions and searches; centres of new clusters lie between old ones, or on one.
fn exercise(boxes: &[Aabb], mut random: u64) -> Result<(), TestCaseError> {
    let mut next = |below: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % below
    };
    let centres: Vec<DVec3> = boxes.iter().map(Aabb::centre).collect();
    let (mut all, mut points) = NearestCentres::new(&centres);
    let mut live: BTreeMap<u32, DVec3> = (0..).zip(centres.iter().copied()).collect();
    let found = |n: Option<Neighbour>| n.map(|n| (n.distance, n.id));
    for _ in 0..3 * boxes.len() + 2 * NEWEST {
        let ids: Vec<u32> = live.keys().copied().collect();
        if ids.is_empty() {
            break;
        }
        let (a, b) = (ids[next(ids.len())], ids[next(ids.len())]);
        let limits = [f64::INFINITY, distance_squared(live[&a], live[&b]), 0.25, 0.0];
        for limit in limits {
            let n = all.within(live[&a], Some(points[a as usize]), limit);
            prop_assert_eq!(found(n), expected(&live, live[&a], true, limit));
        }
        prop_assert_eq!(
            found(all.nearest(live[&a], Some(points[a as usize]))),
            expected(&live, live[&a], true, f64::MAX)
        );
        let same: Vec<u32> =
            live.iter().filter(|(id, centre)| **id != a && **centre == live[&a]).map(|l| *l.0).collect();
        prop_assert_eq!(all.beside(points[a as usize], a), same.first().copied());
        // Two out of three times one goes, as in a clustering; the third time one comes back somewhere.
        let somewhere = [(live[&a] + live[&b]) * 0.5, live[&b], centres[next(centres.len())]][next(3)];
        let gone = (0..points.len() as u32).find(|id| !live.contains_key(id));
        if next(3) == 0
            && let Some(id) = gone
        {
            let nearest = all.nearest(somewhere, None);
            prop_assert_eq!(found(nearest), expected(&live, somewhere, false, f64::MAX));
            let twin = nearest.filter(|n| n.distance == 0.0).map(|n| n.point);
            points[id as usize] = all.insert(id, somewhere, twin);
            live.insert(id, somewhere);
        } else {
            all.remove(a, points[a as usize]);
            live.remove(&a);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn searches_find_what_a_list_finds(boxes in prop_oneof![any_boxes(1..=300), clumps(300), extremes(1..=300)], seed: u64) {
        exercise(&boxes, seed)?;
    }
}

#[test]
fn searches_find_what_a_list_finds_where_everything_ties() {
    for (name, boxes) in hand_made() {
        exercise(&boxes, 7).unwrap_or_else(|e| panic!("{name}: {e}"));
    }
    for family in FAMILIES {
        exercise(&family.generate(500, 1).boxes(), 7).unwrap_or_else(|e| panic!("{}: {e}", family.name));
    }
}

#[test]
fn twins_are_equal_centres_and_zeros_have_no_sign() {
    let centres = [[0.0, 1.0], [1.0, 0.0], [-0.0, 1.0], [1.0, -0.0], [2.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 5.0));
    assert_eq!(twins(&centres), [0, 1, 0, 1, 4]);
}
