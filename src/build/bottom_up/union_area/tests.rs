//! Both engines against the scan of all pairs, where ties are many and where they are not; against each other where the scan
//! would take too long; their search against a scan, and their work.

use super::order::Live;
use super::quad::Entry;
use super::tree::{Effort, Nearest, Stack, Tree};
use super::{FIRST_SPAN, build, heap, merges_spanning};
use crate::build::bottom_up::all_pairs_literal::{self, Distance};
use crate::build::testing::{any_boxes, on_a_grid, scattered};
use crate::build::{Brake, BuildError, Counters, MAX_LEAF, Probe, Work};
use crate::bvh::{Bvh, Limits, TreeHash, tree_hash, validate};
use crate::geom::Aabb;
use crate::scene::Scene;
use crate::scene::families::FAMILIES;
use glam::Vec3;
use proptest::prelude::*;

fn literal(boxes: &[Aabb]) -> TreeHash {
    tree_hash(&all_pairs_literal::build(boxes, Distance::UnionArea, &mut ()).unwrap())
}

/// The trees of both engines, with parts of different sizes, are one: its hash.
/// [`build`] with parts of 4^`span` clusters in the first phase.
fn build_spanning<P: Probe>(boxes: &[Aabb], span: usize, probe: &mut P) -> Result<Bvh, BuildError> {
    Ok(merges_spanning(boxes, span, probe)?.into_tree(boxes, MAX_LEAF))
}

fn exact(boxes: &[Aabb]) -> TreeHash {
    let bvh = build(boxes, &mut ()).unwrap();
    assert!(validate(&bvh, boxes, &Limits::default()).is_ok());
    let hash = tree_hash(&bvh);
    for span in [1, 2, 4] {
        assert_eq!(tree_hash(&build_spanning(boxes, span, &mut ()).unwrap()), hash, "parts of 4^{span}");
    }
    assert_eq!(tree_hash(&heap::build(boxes, &mut ()).unwrap()), hash, "heap");
    hash
}

fn counted(boxes: &[Aabb]) -> Counters {
    let mut counters = Counters::default();
    build(boxes, &mut counters).unwrap();
    counters
}

fn scaled(boxes: &[Aabb], by: Vec3) -> Vec<Aabb> {
    boxes.iter().map(|b| Aabb::new(b.min * by, b.max * by)).collect()
}

/// Boxes that provoke ties and extremes: flat scenes, equal centres, copies, scales at both ends of f32.
fn provoking() -> impl Strategy<Value = Vec<Aabb>> {
    let flat = (any_boxes(1..=50), 0usize..7).prop_map(|(boxes, axes)| {
        let keep = |axis: usize| if axes >> axis & 1 == 1 { 1.0 } else { 0.0 };
        scaled(&boxes, Vec3::new(keep(0), keep(1), keep(2)))
    });
    let centred = on_a_grid(1..=50).prop_map(|boxes| {
        let half = |b: &Aabb| b.max - b.min;
        boxes.iter().map(|b| Aabb::new(-half(b), half(b))).collect()
    });
    let copies = (any_boxes(1..=12), 2usize..6).prop_map(|(boxes, times)| boxes.repeat(times));
    let nested = proptest::collection::vec(-60i32..60, 1..50)
        .prop_map(|e| e.iter().map(|&e| Aabb::new(Vec3::ZERO, Vec3::splat(f32::exp2(e as f32)))).collect());
    let extreme =
        (any_boxes(1..=50), prop_oneof![Just(1e38), Just(1e18), Just(1e-20), Just(1e-38), Just(1e-44)], 0usize..8)
            .prop_map(|(boxes, scale, axes)| {
                let by = |axis: usize| if axes >> axis & 1 == 1 { 1.0 } else { scale };
                scaled(&boxes, Vec3::new(by(0), by(1), by(2)))
            });
    prop_oneof![any_boxes(1..=70), on_a_grid(30..=70), flat, centred, copies, nested, extreme]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn the_literal_tree(boxes in provoking()) {
        prop_assert_eq!(exact(&boxes), literal(&boxes));
    }

    #[test]
    fn the_nearest_of_a_scan(boxes in provoking(), gone in proptest::collection::vec(0usize..70, 0..40)) {
        let live: Vec<Live> = (0u32..).zip(&boxes).map(|(id, &aabb)| Live { aabb, id: id ^ 5, handle: id }).collect();
        let mut tree = Tree::new(&boxes);
        tree.fill(&live);
        let mut kept = vec![true; boxes.len()];
        for at in gone.into_iter().filter(|&at| at < boxes.len()) {
            kept[at] = false;
            tree.set(at, &Entry::VACANT);
        }
        let mut stack = Stack::default();
        for (at, own) in live.iter().enumerate() {
            let mut best = Nearest::NONE;
            tree.nearest::<false>(&own.aabb, 0, at, &mut best, &mut stack, &mut Effort::default());
            let others = live.iter().enumerate().filter(|(other, _)| *other != at && kept[*other]);
            let scanned = others.map(|(other, c)| Nearest {
                distance: own.aabb.union(&c.aabb).surface_area(),
                id: c.id,
                at: other as u32,
            });
            let least = scanned.min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.id.cmp(&b.id)));
            prop_assert_eq!(best, least.unwrap_or(Nearest::NONE));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn more_than_one_part_and_batch(boxes in prop_oneof![scattered(600..900), on_a_grid(600..900)]) {
        prop_assert_eq!(exact(&boxes), tree_hash(&build_spanning(&boxes, 16, &mut ()).unwrap()));
    }
}

#[test]
fn every_family_has_the_literal_tree() {
    for family in FAMILIES {
        for n in [5, 64, 65, 300] {
            let boxes = Scene::load(&format!("gen:{}:{n}", family.name)).unwrap().boxes();
            assert_eq!(exact(&boxes), literal(&boxes), "{} {n}", family.name);
        }
    }
    let boxes = Scene::load("thesis:tiny").unwrap().boxes();
    assert_eq!(exact(&boxes), literal(&boxes));
}

#[test]
fn heap_and_parts_agree_on_larger_scenes() {
    let families = FAMILIES.iter().map(|family| format!("gen:{}:6000:7", family.name));
    for scene in families.chain(["thesis:small", "thesis:med"].map(String::from)) {
        exact(&Scene::load(&scene).unwrap().boxes());
    }
}

#[test]
#[ignore = "minutes: every family and thesis scene at the sizes the study uses"]
fn heap_and_parts_agree_on_large_scenes() {
    let families = FAMILIES.iter().map(|family| format!("gen:{}:200000", family.name));
    for scene in families.chain(["thesis:large", "thesis:huge"].map(String::from)) {
        exact(&Scene::load(&scene).unwrap().boxes());
    }
    let small = Scene::load("thesis:small").unwrap().boxes();
    assert_eq!(exact(&small), literal(&small));
}

#[test]
fn neither_tree_nor_counts_depend_on_threads() {
    for family in ["spheres", "slivers", "coincident"] {
        let boxes = Scene::load(&format!("gen:{family}:100000")).unwrap().boxes();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut counters = Counters::default();
                let bvh = build(&boxes, &mut counters).unwrap();
                (tree_hash(&bvh), counters)
            })
        };
        let one = with(1);
        assert_eq!(one, with(2), "{family}");
        assert_eq!(one, with(7), "{family}");
    }
}

#[test]
fn searches_are_few_where_the_smallest_id_is_everybodys_nearest() {
    let n = 30_000;
    let point = |x: f32| Aabb::new(Vec3::new(x, 0.0, 0.0), Vec3::new(x, 0.0, 0.0));
    let line: Vec<Aabb> = (0..n).map(|i| point((i * 7919 % n) as f32)).collect();
    let points = vec![point(1.0); n];
    let families = ["coincident", "nested", "grid"].map(|f| Scene::load(&format!("gen:{f}:{n}")).unwrap().boxes());
    for boxes in families.iter().chain([&line, &points]) {
        let counters = counted(boxes);
        let (searches, visits) = (counters.get(Work::NearestSearches), counters.get(Work::SearchVisits));
        assert!(searches < 5 * n as u64, "{searches} searches");
        assert!(visits < 200 * searches, "{visits} visits");
    }
}

#[test]
fn large_boxes_over_small_ones_are_searched_quickly() {
    for (family, most) in [("spheres", 60), ("stadium", 60), ("hairball", 110), ("slivers", 200)] {
        let counters = counted(&Scene::load(&format!("gen:{family}:20000")).unwrap().boxes());
        let visits = counters.get(Work::SearchVisits) / counters.get(Work::NearestSearches);
        assert!(visits < most, "{family}: {visits} visits a search");
    }
}

#[test]
fn what_is_counted() {
    let boxes = Scene::load("gen:soup:5000").unwrap().boxes();
    let parts = counted(&boxes);
    let mut in_order = Counters::default();
    heap::build(&boxes, &mut in_order).unwrap();
    for c in [parts, in_order] {
        let n = boxes.len() as u64;
        assert_eq!(c.get(Work::Merges), n - 1);
        assert!(c.get(Work::NearestSearches) >= 2 * (n - 1));
        assert!(c.get(Work::PairDistances) >= c.get(Work::NearestSearches) / 2);
        assert!(c.get(Work::BoxUnions) >= c.get(Work::SearchVisits) + c.get(Work::PairDistances) + n - 1);
    }
    // No triangle's search can do with less than a look at its own quad.
    assert!(parts.get(Work::SearchVisits) >= 4 * parts.get(Work::NearestSearches));
    let one = &boxes[..1];
    assert_eq!(counted(one), Counters::default());
}

#[test]
fn two_pairs_far_apart_by_hand() {
    let at = |x: f32| Aabb::new(Vec3::splat(x), Vec3::splat(x + 1.0));
    // Nearest of 0: 2; of 1: 3. The pair (0, 2) comes first, then (1, 3), and one leaf holds all four; the fifth apart.
    let bvh = build(&[at(0.0), at(10.0), at(1.5), at(12.0), at(30.0)], &mut ()).unwrap();
    let leaves: Vec<Vec<u32>> = bvh.children(0).map(|c| bvh.leaf_triangles(c).to_vec()).collect();
    assert_eq!(leaves, [vec![0, 2, 1, 3], vec![4]]);
}

#[test]
fn an_extent_beyond_f32_hides_nobody() {
    let bar = |half: f32, side: f32| Aabb::new(Vec3::new(0.0, -half, 0.0), Vec3::new(side, half, side));
    let far = bar(3e38, 1e30);
    // The thin bar at position 4 is nearer than the one at position 1, but 6·10³⁸ long: infinite in f32.
    let boxes = [bar(1e38, 1e-10), bar(1e38, 1e-9), far, far, bar(3e38, 1e-10)];
    let live: Vec<Live> = (0u32..).zip(&boxes).map(|(id, &aabb)| Live { aabb, id, handle: id }).collect();
    let mut tree = Tree::new(&boxes);
    tree.fill(&live);
    let mut best = Nearest::NONE;
    tree.nearest::<false>(&boxes[0], 0, 0, &mut best, &mut Stack::default(), &mut Effort::default());
    assert_eq!(best.at, 4);
}

#[test]
fn refused_boxes_and_spent_budgets() {
    let hollow = [Aabb::EMPTY];
    assert_eq!(build(&[], &mut ()), Err(BuildError::NoTriangles));
    assert_eq!(build(&hollow, &mut ()), Err(BuildError::InvalidBox(0)));
    assert_eq!(heap::build(&hollow, &mut ()), Err(BuildError::InvalidBox(0)));
    let boxes = Scene::load("gen:soup:20000").unwrap().boxes();
    let left = |built: Result<_, BuildError>| match built {
        Err(BuildError::Stopped(left)) => left.pending[0],
        other => panic!("a deadline in the past stops the build, not {:?}", other.map(|_: crate::bvh::Bvh| ())),
    };
    let late = || Brake::new(Some(std::time::Instant::now()));
    let in_parts = left(build(&boxes, &mut late()));
    assert!((2..20_000).contains(&in_parts), "{in_parts}");
    // A part that is everything looks at the clock itself.
    let in_one = left(build_spanning(&boxes, FIRST_SPAN + 2, &mut late()));
    assert!((15_000..20_000).contains(&in_one), "{in_one}");
    assert_eq!(left(heap::build(&boxes, &mut late())), 20_000);
}
