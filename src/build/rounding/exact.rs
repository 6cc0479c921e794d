//! Costs compared without rounding.
//!
//! An extent is a difference of two f32, the product of two extents a sum of four products of two f32, and each of these is an f64
//! as it is: 48 bits, and no exponent that f64 lacks. Times a whole number it is a sum of two f64. All of them together are added as an
//! expansion, a sum of f64 that do not overlap, whose greatest term has the sign of the whole (Shewchuk, "Adaptive Precision
//! Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997, section 2).

use super::Candidate;
use crate::geom::Aabb;
use std::cmp::Ordering;

/// The order of two costs, exactly.
pub fn compare(a: &Candidate, b: &Candidate) -> Ordering {
    let mut difference = Expansion::default();
    for (candidate, sign) in [(a, 1.0), (b, -1.0)] {
        for (aabb, weight) in &candidate.parts {
            add_area(&mut difference, aabb, sign * f64::from(*weight));
        }
    }
    difference.sign()
}

/// Adds half of `weight` times the surface area.
fn add_area(sum: &mut Expansion, aabb: &Aabb, weight: f64) {
    if aabb.is_empty() || weight == 0.0 {
        return;
    }
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        for (x, sign_x) in [(aabb.max[i], 1.0), (aabb.min[i], -1.0)] {
            for (y, sign_y) in [(aabb.max[j], 1.0), (aabb.min[j], -1.0)] {
                let product = f64::from(x) * f64::from(y);
                let whole = product * weight * sign_x * sign_y;
                sum.add(whole);
                sum.add((product * sign_x * sign_y).mul_add(weight, -whole));
            }
        }
    }
}

/// A sum of f64 that do not overlap, the least first.
#[derive(Debug, Default)]
struct Expansion(Vec<f64>);

impl Expansion {
    /// Adds a number (Shewchuk's Grow-Expansion), and leaves zeros out.
    fn add(&mut self, x: f64) {
        let mut carried = x;
        let mut kept = 0;
        for i in 0..self.0.len() {
            let (sum, lost) = two_sum(carried, self.0[i]);
            carried = sum;
            if lost != 0.0 {
                self.0[kept] = lost;
                kept += 1;
            }
        }
        self.0.truncate(kept);
        if carried != 0.0 {
            self.0.push(carried);
        }
    }

    /// The sign, as an order against 0.
    fn sign(&self) -> Ordering {
        self.0.last().map_or(Ordering::Equal, |greatest| greatest.total_cmp(&0.0))
    }
}

/// A sum and what its rounding lost (Knuth's TwoSum).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use proptest::prelude::*;

    /// Twice the cost in integers, of corners that are whole numbers.
    fn by_integers(candidate: &Candidate) -> i128 {
        let area = |(aabb, weight): &(Aabb, u32)| {
            let e = [0, 1, 2].map(|axis| aabb.max[axis] as i128 - aabb.min[axis] as i128);
            if aabb.is_empty() { 0 } else { (e[0] * e[1] + e[1] * e[2] + e[2] * e[0]) * i128::from(*weight) }
        };
        candidate.parts.iter().map(area).sum()
    }

    proptest! {
        #[test]
        fn as_in_integers_at_any_scale(
            corners in prop::collection::vec((-(1_i64 << 40)..1 << 40, -4_i64..4), 24),
            weights in prop::array::uniform4(0_u32..1 << 24), scale in -90_i32..40, alike: bool,
        ) {
            let corners: Vec<f32> = corners.iter().map(|c| if alike { c.1 as f32 } else { c.0 as f32 }).collect();
            let aabb = |k: usize| {
                let [a, b] = [0, 3].map(|i| Vec3::from_slice(&corners[6 * k + i..]));
                Aabb::new(a.min(b), a.max(b))
            };
            let candidate = |k: usize| Candidate { parts: [(aabb(k), weights[k]), (aabb(k + 1), weights[k + 1])] };
            let (a, b) = (candidate(0), candidate(2));
            let scaled = |c: &Candidate| {
                let by = 2f32.powi(scale);
                Candidate { parts: c.parts.map(|(b, n)| (Aabb::new(b.min * by, b.max * by), n)) }
            };
            let expected = by_integers(&a).cmp(&by_integers(&b));
            prop_assert_eq!(compare(&a, &b), expected);
            prop_assert_eq!(compare(&scaled(&a), &scaled(&b)), expected);
            prop_assert_eq!(compare(&a, &a), Ordering::Equal);
        }
    }

    #[test]
    fn the_least_and_the_greatest_numbers() {
        let cube = |side: f32| Candidate::of_one(Aabb::new(Vec3::ZERO, Vec3::splat(side)));
        let least = f32::from_bits(1);
        assert_eq!(compare(&cube(least), &cube(0.0)), Ordering::Greater);
        assert_eq!(compare(&cube(f32::MAX), &cube(f32::MAX.next_down())), Ordering::Greater);
        // 1e38 and the least number in one extent: 290 bits apart.
        let from = |low: f32| Candidate::of_one(Aabb::new(Vec3::new(low, 0.0, 0.0), Vec3::new(1e38, 1.0, 1.0)));
        assert_eq!(compare(&from(-least), &from(0.0)), Ordering::Greater);
        assert_eq!(from(-least).double(), from(0.0).double());
    }
}
