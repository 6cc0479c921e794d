//! What a subtree will cost before it is there.
//!
//! The paper takes each side of a split for a leaf: area times number. That is right for choosing among the splits of
//! one kind, which all have the same number. But a cut adds a reference, and by that measure it costs the whole side's
//! area, though in the tree it costs little more than the areas of its own two parts. So here a subtree over n
//! references in a box of area A costs about
//!
//! A · (1 + [`LEVEL`] · log₂ n) + the references' own areas,
//!
//! the first for the nodes above, of which each level has somewhat less to do with A than the one before, the second for
//! the leaves. A reference that is cut has its area replaced by those of both parts, times 1 + [`MORE_NODES`] / 2 for the
//! inner node that comes with one more leaf.
//!
//! Both constants are from trials with two scenes, a staircase with walls of few triangles and a teapot in a stadium: with
//! `LEVEL` from 1 to 3 and `MORE_NODES` from ½ to 2 the surface area heuristic changes by 1% at most.

use crate::geom::Aabb;

/// What a level of a subtree costs, in areas of its root.
const LEVEL: f64 = 2.0;

/// The area of the node that one more leaf makes necessary, in areas of that leaf.
const MORE_NODES: f64 = 1.3;

/// What the nodes of a subtree over `n` references will cost.
#[inline(always)]
pub(super) fn nodes(area: f64, n: usize) -> f64 {
    area * (1.0 + LEVEL * log2(n))
}

/// What the leaves, and nodes just above, save when `whole` is cut into `parts`; negative where they cost more.
#[inline(always)]
pub(super) fn saved(whole: &Aabb, parts: &[Aabb; 2]) -> f64 {
    whole.surface_area() - (parts[0].surface_area() + parts[1].surface_area()) * (1.0 + MORE_NODES / 2.0)
}

/// The logarithm, linear between powers of two, where it is exact; so it is the same on every machine. 0 for 0.
#[inline(always)]
fn log2(n: usize) -> f64 {
    let n = n.max(1);
    let whole = n.ilog2();
    f64::from(whole) + (n as f64 / (1u64 << whole) as f64 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn by_hand() {
        assert_eq!([0, 1, 2, 3, 4, 6, 1 << 20].map(log2), [0.0, 0.0, 1.0, 1.5, 2.0, 2.5, 20.0]);
        assert_eq!(nodes(3.0, 4), 15.0);
        let brick = |x| Aabb::new(Vec3::ZERO, Vec3::new(x, 1.0, 1.0));
        let saving = saved(&brick(2.0), &[brick(1.0), brick(1.0)]);
        assert!((saving - (10.0 - 12.0 * 1.65)).abs() < 1e-12);
    }
}
