//! What the tests of every step ask: that the tree stays valid and never costs more, and that hard cases end.

use super::{Watch, open_leaves};
use crate::bvh::testing::{boxes, median_split, random_tree, soup};
use crate::bvh::{Bvh, Limits, validate};
use crate::cost::{SahParams, sah};
use crate::geom::Aabb;
use glam::Vec3;
use proptest::prelude::*;

/// A step, as [`super::StepInfo`] has it.
pub type Apply = fn(&Bvh, usize, &mut Watch) -> Bvh;

/// The tree's SAH; 0 for one without area.
pub fn cost(bvh: &Bvh) -> f64 {
    sah(bvh, SahParams::default()).unwrap_or(0.0)
}

/// The step taken, by nobody who waits.
pub fn applied(step: Apply, bvh: &Bvh, max_leaf: usize) -> Bvh {
    step(bvh, max_leaf, &mut Watch::new(&mut |_| true))
}

/// Random and sensible trees stay valid, and with leaves by cost they cost no more than they did.
pub fn never_above_the_input(
    step: Apply,
    seed: u64,
    (n, size): (usize, f32),
    max_leaf: usize,
) -> Result<(), TestCaseError> {
    let boxes = boxes(&soup(seed, n, size));
    for bvh in [random_tree(seed, &boxes, 2, 1), median_split(&boxes, 1)] {
        let better = applied(step, &bvh, max_leaf);
        prop_assert!(validate(&better, &boxes, &Limits::default()).is_ok());
        let (old, new) = (cost(&open_leaves(&bvh, max_leaf)), cost(&open_leaves(&better, max_leaf)));
        prop_assert!(new <= old * (1.0 + 1e-12), "{new} {old}");
    }
    Ok(())
}

/// Boxes within boxes, boxes that are all the same or points, areas beyond f32, and the largest boxes there are.
pub fn hard_cases_end_soon(step: Apply) {
    let sizes = (0..3000).map(|i| 2f32.powf(60.0 - 120.0 * i as f32 / 3000.0));
    let nested: Vec<_> = sizes.map(|size| Aabb::new(Vec3::splat(-size), Vec3::splat(size))).collect();
    let coincident = vec![Aabb::new(Vec3::ZERO, Vec3::ONE); 3000];
    let points = vec![Aabb::new(Vec3::ONE, Vec3::ONE); 100];
    let huge = boxes(&soup(7, 200, 0.3)).iter().map(|b| Aabb::new(b.min * 1e19, b.max * 1e19)).collect();
    let whole = [Aabb::new(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX)); 5].into();
    for boxes in [nested, coincident, points, huge, whole] {
        for bvh in [median_split(&boxes, 1), random_tree(3, &boxes, 2, 1)] {
            let better = open_leaves(&applied(step, &bvh, 4), 4);
            assert!(validate(&better, &boxes, &Limits::default()).is_ok());
            assert!(cost(&better) <= cost(&open_leaves(&bvh, 4)) * (1.0 + 1e-12));
        }
    }
}
