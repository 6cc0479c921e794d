//! Boxes for tests of the engines that search for centres: clumps, extremes, and shapes made to tie.

use crate::geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;

/// The box around a point with these half extents.
fn around(centre: Vec3, half: Vec3) -> Aabb {
    Aabb::new(centre - half, centre + half)
}

/// Dense clumps of small boxes far from each other, and large boxes whose centres fall anywhere: merged clusters' centres
/// land in the middle of others.
pub fn clumps(most: usize) -> impl Strategy<Value = Vec<Aabb>> {
    let coordinate = || prop_oneof![-1.0f32..1.0, (-8i8..8).prop_map(|i| f32::from(i) / 8.0)];
    let point = move || (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let scale = prop_oneof![4 => Just(0.01f32), 2 => Just(1.0), 1 => Just(100.0)];
    let aabb = (0u8..5, scale, point(), point()).prop_map(|(clump, scale, offset, half)| {
        let clump = Vec3::new(f32::from(clump), f32::from(clump % 2) * 3.0, 0.0);
        around(clump + offset * scale, half.abs() * scale)
    });
    proptest::collection::vec(aabb, 2..most)
}

/// Coordinates from the smallest to the largest numbers there are, of both signs.
pub fn extremes(n: impl Into<proptest::collection::SizeRange>) -> impl Strategy<Value = Vec<Aabb>> {
    let number = || {
        let magnitude = prop_oneof![
            (-40i32..=40).prop_map(|e| 2f32.powi(e)),
            Just(0.0),
            Just(1e19),
            Just(f32::MAX),
            Just(f32::MIN_POSITIVE),
            Just(1e-45),
            (1.0f32..2.0).prop_map(|x| x * 1e19),
            1.0f32..1.000_001,
        ];
        (magnitude, any::<bool>()).prop_map(|(x, negative)| if negative { -x } else { x })
    };
    let point = move || (number(), number(), number()).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let aabb = (point(), point(), any::<bool>()).prop_map(|(a, b, flat)| Aabb::around([a, if flat { a } else { b }]));
    proptest::collection::vec(aabb, n)
}

/// Scenes made to tie, by name.
pub fn hand_made() -> Vec<(&'static str, Vec<Aabb>)> {
    let line = |n: usize, step: Vec3| (0..n).map(move |i| around(step * i as f32, Vec3::splat(0.25)));
    let plane = |axis: usize| {
        (0..20 * 20).map(move |i| {
            let mut p = [(i / 20) as f32, (i % 20) as f32, 0.0];
            p.rotate_right(axis);
            around(p.into(), Vec3::splat(0.5))
        })
    };
    // All points with these integer coordinates, in any order and with any sign, are equally far from the origin.
    let sphere = || {
        let signed = |[x, y, z]: [f32; 3]| {
            [-1.0, 1.0].into_iter().flat_map(move |i| {
                [-1.0, 1.0].into_iter().flat_map(move |j| [-1.0, 1.0].map(|k| Vec3::new(x * i, y * j, z * k)))
            })
        };
        let orders = [[5, 3, 1], [5, 1, 3], [3, 5, 1], [3, 1, 5], [1, 5, 3], [1, 3, 5]];
        orders.into_iter().flat_map(move |o| signed(o.map(|x| x as f32)))
    };
    let dust = Vec3::splat(0.125);
    let around_one = std::iter::once(Vec3::ZERO).chain(sphere()).map(|p| around(p, dust));
    let around_crowd = (0..5).map(|_| Vec3::ZERO).chain(sphere()).chain(sphere()).map(|p| around(p, dust));
    let far_off = sphere().map(|p| around(p + Vec3::new(4096.0, -4096.0, 8192.0), dust));
    let concentric = (0..200).map(|i| around(Vec3::ONE, Vec3::splat(1.0 + (i * 7 % 50) as f32)));
    let two_places = (0..300).map(|i| around(Vec3::splat((i % 2) as f32), Vec3::splat(0.5 + (i % 3) as f32)));
    let pairs = (0..300).map(|i| around(Vec3::new((i / 2 * 37 % 150) as f32, 0.0, (i % 4 / 2) as f32), dust));
    let powers = (-60..60).map(|e| around(Vec3::splat(2f32.powi(e)), Vec3::ZERO));
    let both_zeros = (0..40).map(|i| {
        let zero = if i % 2 == 0 { 0.0 } else { -0.0 };
        around(Vec3::new(zero, (i / 4) as f32, zero), Vec3::ZERO)
    });
    vec![
        ("line along x", line(300, Vec3::X).collect()),
        ("line along y", line(300, Vec3::Y).collect()),
        ("line along z", line(300, Vec3::Z * 0.1).collect()),
        ("diagonal", line(300, Vec3::ONE).collect()),
        ("plane across z", plane(0).collect()),
        ("plane across x", plane(1).collect()),
        ("plane across y", plane(2).collect()),
        ("sphere around a point", around_one.collect()),
        ("twice a sphere around a crowd", around_crowd.collect()),
        ("sphere far from the origin", far_off.collect()),
        ("concentric", concentric.collect()),
        ("two places", two_places.collect()),
        ("pairs in rows", pairs.collect()),
        ("powers of two", powers.collect()),
        ("zeros of both signs", both_zeros.collect()),
    ]
}
