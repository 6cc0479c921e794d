//! Figures of the smallest scene that any change of a tree or a traversal would move.

use crate::support::{STUDY, builds, traces};
use bvh_lab::build::{self, BuildOptions, Counters, Engine, Input, Work};
use bvh_lab::bvh::{Bvh, NodeKind};
use bvh_lab::rows::{Construction, Lighting};
use bvh_lab::scene::Scene;

/// Pixels of the thesis' pictures.
const PIXELS: f64 = 90_000.0;

#[test]
fn work_of_the_published_pictures() {
    use Construction::{BottomUp, TopDown};
    use Lighting::{Opacity, Primary, Reflection};
    // Entered nodes, box tests and triangle tests over the whole picture. Measured; the printed Table 5 has 4.85, 3.05,
    // 3.14, 5.39, 3.71 and 3.30 nodes a pixel for primary rays.
    let expected: [(Construction, usize, Lighting, [u64; 3]); 18] = [
        (TopDown, 2, Primary, [449_165, 808_488, 149_227]),
        (TopDown, 2, Reflection, [482_686, 875_530, 149_227]),
        (TopDown, 2, Opacity, [482_686, 875_530, 149_227]),
        (TopDown, 4, Primary, [282_284, 940_708, 109_885]),
        (TopDown, 4, Reflection, [316_266, 1_076_000, 110_044]),
        (TopDown, 4, Opacity, [315_805, 1_074_792, 109_885]),
        (TopDown, 8, Primary, [269_166, 1_662_808, 127_947]),
        (TopDown, 8, Reflection, [302_703, 1_931_040, 127_963]),
        (TopDown, 8, Opacity, [302_687, 1_930_976, 127_947]),
        (BottomUp, 2, Primary, [484_197, 878_620, 153_149]),
        (BottomUp, 2, Reflection, [517_718, 945_662, 153_149]),
        (BottomUp, 2, Opacity, [517_718, 945_662, 153_149]),
        (BottomUp, 4, Primary, [285_937, 947_555, 153_512]),
        (BottomUp, 4, Reflection, [319_458, 1_081_639, 153_512]),
        (BottomUp, 4, Opacity, [319_458, 1_081_639, 153_512]),
        (BottomUp, 8, Primary, [278_969, 1_234_136, 153_512]),
        (BottomUp, 8, Reflection, [312_490, 1_334_699, 153_512]),
        (BottomUp, 8, Opacity, [312_490, 1_334_699, 153_512]),
    ];
    let rows = traces(&STUDY);
    let found: Vec<_> = rows
        .iter()
        .map(|t| {
            let works = [t.nodes_per_pixel, t.box_tests_per_pixel, t.triangle_tests_per_pixel];
            let counts = works.map(|per_pixel| (per_pixel.unwrap() * PIXELS).round() as u64);
            (t.construction, t.arity, t.lighting, counts)
        })
        .collect();
    assert_eq!(found, expected, "{found:#?}");
    assert!(rows.iter().all(|t| (t.hit_fraction.unwrap() * PIXELS).round() == 33_521.0 && t.cut == Some(0)));
}

#[test]
fn the_published_trees() {
    let found: Vec<_> = builds(&STUDY)
        .into_iter()
        .map(|r| (r.construction.id(), r.arity, r.tree_hash.unwrap(), r.inner.unwrap(), r.leaves.unwrap()))
        .collect();
    let expected = [
        ("top-down", 2, "cd68d9faa4c24561053a299af5cb61d8", 208, 209),
        ("top-down", 4, "49c1eb454109dc1b553c2249d14f5a87", 102, 307),
        ("top-down", 8, "913bee2f79ab6702d92460a744c0d43d", 94, 659),
        ("bottom-up", 2, "302a88eb91566d916e1b1eeb0c263009", 193, 194),
        ("bottom-up", 4, "b90497d9d2f4afdbf2ae52c2f1d54144", 69, 194),
        ("bottom-up", 8, "a03e1750993d6d9c6c47e212b9036b3f", 37, 194),
    ];
    assert_eq!(found, expected.map(|(c, k, hash, inner, leaves)| (c, k, hash.to_owned(), inner, leaves)));
}

/// Triangles below every inner node.
fn sizes(bvh: &Bvh) -> Vec<u64> {
    let mut below = vec![0; bvh.nodes.len()];
    // Children stand behind their parents.
    for (i, node) in bvh.nodes.iter().enumerate().rev() {
        below[i] = match node.kind() {
            NodeKind::Leaf(slots) => slots.len() as u64,
            NodeKind::Inner(children) => below[children].iter().sum(),
        };
    }
    below.iter().zip(&bvh.nodes).filter(|(_, node)| !node.is_leaf()).map(|(&n, _)| n).collect()
}

/// Choices of a node of `n` triangles as the thesis' program counted them: 3 · C(m, arity − 1), m candidates in ranks.
fn choices(n: u64, arity: u64) -> u64 {
    let mut divisions = 200 / arity;
    while n / divisions == 0 {
        divisions /= 2;
    }
    let m = (n - 1) / (n / divisions);
    // Multiplied before it is divided, every quotient is whole.
    3 * (0..arity - 1).fold(1, |product, i| product * m.saturating_sub(i) / (i + 1))
}

#[test]
fn the_literal_search_tries_every_choice_of_the_closed_form() {
    assert_eq!([choices(5, 2), choices(1000, 4), choices(8, 8)], [12, 3 * 49 * 48 * 47 / 6, 3]);
    let boxes = Scene::load("thesis:tiny").unwrap().boxes();
    let builder = build::find("top-down").unwrap();
    for (arity, total) in [(2, 11_973), (4, 1_447_383), (8, 222_423_234)] {
        let options = BuildOptions { arity, q8: false, engine: Engine::Literal, ..BuildOptions::default() };
        let mut counters = Counters::default();
        let bvh = (builder.counted)(Input::of_boxes(&boxes), &options, &mut counters).unwrap();
        let sizes = sizes(&bvh);
        let sum = |of: fn(u64, u64) -> u64| sizes.iter().map(|&n| of(n, arity as u64)).sum::<u64>();
        assert_eq!(counters.get(Work::Combinations), sum(choices), "arity {arity}");
        assert_eq!(counters.get(Work::Combinations), total, "arity {arity}");
        assert_eq!(counters.get(Work::OriginalUnions), sum(|n, k| n * choices(n, k)), "arity {arity}");
    }
}
