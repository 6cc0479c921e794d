//! How often rounded costs decide otherwise than exact ones: where to split, and what to merge.
//!
//! A decision is a choice of the least among costs that are sums of surface areas, each times a whole number. The same choice is
//! made in three arithmetics ([`Rounding`]): f32 throughout, f64 throughout, and without any rounding (`exact.rs`). Of equal costs
//! the first counts, so the order of the candidates is part of a method. Both methods here are plain ones, so that nothing but
//! arithmetic decides: `splits.rs`, every split of three sorted orders (sweep SAH), and `merges.rs`, the nearest cluster along a Morton curve
//! (PLOC).
//!
//! [`Flips`] asks the others about every decision of the exact one. What a tree is worth that was built by one of them throughout is
//! another question: each method builds by any choice.

mod exact;
mod merges;
mod splits;

use super::{BuildError, Probe};
use crate::bvh::Bvh;
use crate::geom::Aabb;
use std::cmp::Ordering;

/// What is decided by costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Where a node is divided.
    Splits,
    /// Which cluster is the nearest.
    Merges,
}

impl Decision {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Splits, Self::Merges];

    /// Its name in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Splits => "splits",
            Self::Merges => "merges",
        }
    }

    /// Builds over `boxes`, with every decision made by `choose`.
    ///
    /// # Errors
    /// Boxes that [`check_boxes`](super::check_boxes) refuses, or the probe's stop.
    pub fn build<P: Probe>(
        self,
        boxes: &[Aabb],
        choose: impl FnMut(&[Candidate]) -> usize,
        probe: &mut P,
    ) -> Result<Bvh, BuildError> {
        match self {
            Self::Splits => splits::build(boxes, choose, probe),
            Self::Merges => merges::build(boxes, choose, probe),
        }
    }
}

/// A cost: the areas of one or two boxes, each times a whole number below 2²⁴.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// What is added.
    pub parts: [(Aabb, u32); 2],
}

impl Candidate {
    /// The cost of one box.
    pub fn of_one(aabb: Aabb) -> Self {
        Self { parts: [(aabb, 1), (Aabb::EMPTY, 0)] }
    }

    /// In f32, every operation.
    pub fn single(&self) -> f32 {
        let [a, b] = self.parts.map(|(aabb, n)| aabb.surface_area_f32() * n as f32);
        a + b
    }

    /// In f64, every operation.
    pub fn double(&self) -> f64 {
        let [a, b] = self.parts.map(|(aabb, n)| aabb.surface_area() * f64::from(n));
        a + b
    }
}

/// In which numbers costs are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// f32 throughout.
    Single,
    /// f64 throughout.
    Double,
    /// None.
    Exact,
}

/// More than f64 costs of boxes without a denormal area can be off by, relative: fewer than ten roundings each.
const DOUBT: f64 = 1e-14;

impl Rounding {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Single, Self::Double, Self::Exact];

    /// Bits of its numbers; none where they are as many as it takes.
    pub const fn bits(self) -> Option<u32> {
        match self {
            Self::Single => Some(32),
            Self::Double => Some(64),
            Self::Exact => None,
        }
    }

    /// The place of the first of the least `candidates`.
    ///
    /// # Panics
    /// If there are none.
    pub fn least(self, candidates: &[Candidate]) -> usize {
        match self {
            Self::Single => first_least(candidates, Candidate::single, |a, b| a.1.total_cmp(&b.1)),
            Self::Double => first_least(candidates, Candidate::double, |a, b| a.1.total_cmp(&b.1)),
            Self::Exact => {
                first_least(candidates, Candidate::double, |a, b| match (a.1 - b.1).abs() > DOUBT * (a.1 + b.1) {
                    true => a.1.total_cmp(&b.1),
                    false => exact::compare(a.0, b.0),
                })
            }
        }
    }
}

fn first_least<C: Copy>(
    candidates: &[Candidate],
    cost: impl Fn(&Candidate) -> C,
    compare: impl Fn((&Candidate, C), (&Candidate, C)) -> Ordering,
) -> usize {
    let mut best = (0, cost(&candidates[0]));
    for (place, candidate) in candidates.iter().enumerate().skip(1) {
        let cost = cost(candidate);
        if compare((candidate, cost), (&candidates[best.0], best.1)).is_lt() {
            best = (place, cost);
        }
    }
    best.0
}

/// How often a rounding decides otherwise than exact costs on the same candidates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flips {
    /// Decisions among at least two candidates.
    pub compared: usize,
    /// Of these, decided otherwise.
    pub different: usize,
    /// The greatest excess of a choice's cost over the least, relative to that.
    pub largest_excess: f64,
}

impl Flips {
    /// Decides exactly, and notes what `rounding` would have decided.
    pub fn note(&mut self, rounding: Rounding, candidates: &[Candidate]) -> usize {
        let exact = Rounding::Exact.least(candidates);
        if candidates.len() > 1 {
            self.compared += 1;
            let rounded = rounding.least(candidates);
            if rounded != exact {
                self.different += 1;
                let [chosen, least] = [rounded, exact].map(|place| candidates[place].double());
                // Boxes without area cost nothing, and any of them is as good.
                if least > 0.0 {
                    self.largest_excess = self.largest_excess.max(chosen / least - 1.0);
                }
            }
        }
        exact
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn cost(x: f32, y: f32, z: f32) -> Candidate {
        Candidate::of_one(Aabb::new(Vec3::ZERO, Vec3::new(x, y, z)))
    }

    #[test]
    fn each_arithmetic_sees_what_it_can() {
        // f32 takes both products for 1; f64 tells them apart.
        let (one, more) = (cost(1.0, 1.0, 0.0), cost(1.0 - f32::EPSILON / 2.0, 1.0 + f32::EPSILON, 0.0));
        assert_eq!((one.single(), more.single()), (2.0, 2.0));
        assert_eq!(Rounding::ALL.map(|r| r.least(&[more, one])), [0, 1, 1]);
        // What is lost in an f64 extent, and in no exact one.
        let long = |low: f32| Candidate::of_one(Aabb::new(Vec3::new(low, 0.0, 0.0), Vec3::new(1e30, 1.0, 0.0)));
        let candidates = [long(-1.0), long(1.0)];
        assert_eq!(Rounding::ALL.map(|r| r.least(&candidates)), [0, 0, 1]);
        let mut flips = Flips::default();
        assert_eq!(flips.note(Rounding::Double, &candidates), 1);
        assert_eq!((flips.compared, flips.different), (1, 1));
        assert_eq!(flips.note(Rounding::Exact, &candidates), 1);
        assert_eq!((flips.compared, flips.different), (2, 1));
        assert_eq!(flips.note(Rounding::Single, &candidates[..1]), 0);
        assert_eq!(flips.compared, 2);
    }

    #[test]
    fn of_equal_costs_the_first_counts() {
        let candidates = [cost(2.0, 1.0, 1.0), cost(1.0, 2.0, 0.0), cost(2.0, 0.0, 1.0)];
        assert_eq!(Rounding::ALL.map(|r| r.least(&candidates)), [1, 1, 1]);
    }
}
