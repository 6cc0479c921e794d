//! Boxes that provoke ties: equal keys, equal costs, equal distances, wherever an order must decide.

use bvh_lab::geom::Aabb;
use glam::Vec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use std::ops::RangeInclusive;

type Boxes = BoxedStrategy<Vec<Aabb>>;

fn point(range: impl Strategy<Value = f32> + Clone) -> impl Strategy<Value = Vec3> + Clone {
    (range.clone(), range.clone(), range).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn boxes_of(corner: impl Strategy<Value = Vec3> + Clone + 'static, n: RangeInclusive<usize>) -> Boxes {
    vec((corner.clone(), corner).prop_map(|(a, b)| Aabb::around([a, b])), n).boxed()
}

fn whole(range: RangeInclusive<i8>) -> impl Strategy<Value = f32> + Clone {
    range.prop_map(f32::from)
}

/// Every family of ties by name, `n` boxes each.
pub fn families(n: RangeInclusive<usize>) -> Vec<(&'static str, Boxes)> {
    let grid = point(whole(-2..=2));
    let flat = (whole(0..=4), whole(0..=4)).prop_map(|(x, y)| Vec3::new(x, y, 1.0));
    let line = whole(0..=9).prop_map(|x| Vec3::new(x, 2.0, -1.0));
    let sign = prop_oneof![Just(1.0f32), Just(-1.0)];
    let power = (sign, -30i32..=30).prop_map(|(s, e)| s * 2f32.powi(e));
    let half_extent = point(whole(0..=3));
    let around_one_centre = half_extent.prop_map(|h| Aabb::new(-h, h));
    // One corner each, equal edges: rows of equal boxes.
    let unit = point(whole(0..=3)).prop_map(|p| Aabb::new(p, p + Vec3::ONE));
    let nested = (0u8..40).prop_map(|i| Aabb::new(Vec3::splat(-f32::from(i)), Vec3::splat(f32::from(i))));
    let tiny = (point(-1.0f32..1.0), point(-1.0f32..1.0), prop_oneof![Just(1e-6f32), Just(1.0), Just(1e6)])
        .prop_map(|(a, b, scale)| Aabb::around([a * scale, b * scale]));
    let pool = vec((point(-1.0f32..1.0), point(0.0f32..0.5)).prop_map(|(p, e)| Aabb::new(p, p + e)), 1..=5);
    let copies =
        (pool, vec(any::<Index>(), n.clone())).prop_map(|(pool, at)| at.iter().map(|i| *i.get(&pool)).collect());
    let zeros = point(prop_oneof![Just(0.0f32), Just(-0.0), Just(1.0)]);
    vec![
        ("integer grid", boxes_of(grid, n.clone())),
        ("flat scene", boxes_of(flat, n.clone())),
        ("one line", boxes_of(line, n.clone())),
        ("powers of two", boxes_of(point(power), n.clone())),
        ("all centres equal", vec(around_one_centre, n.clone()).boxed()),
        ("unit boxes on a grid", vec(unit, n.clone()).boxed()),
        ("nested", vec(nested, n.clone()).boxed()),
        ("mixed scales", vec(tiny, n.clone()).boxed()),
        ("duplicates", copies.boxed()),
        ("both zeros", boxes_of(zeros, n.clone())),
        ("scattered", boxes_of(point(-1.0f32..1.0), n)),
    ]
}
