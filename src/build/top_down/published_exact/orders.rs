//! The triangles in three sorted orders, one per axis, kept sorted while nodes are split.
//!
//! Sorting happens once for the whole build: radix sort by the lower coordinate, which is stable, so that equal keys
//! stay in the order of ids. A node owns the same range of slots in all three orders; splitting it moves its children's
//! triangles together in each, stably.

use crate::geom::Aabb;
use std::ops::Range;

/// Triangle ids by slot, sorted by (lower coordinate, id) within every node's range.
pub struct Orders {
    axes: [Vec<u32>; 3],
    /// Child that a triangle goes to, by id; only meaningful while its node is split.
    child: Vec<u8>,
    moved: Vec<u32>,
}

impl Orders {
    /// All triangles as one range.
    pub fn new(boxes: &[Aabb]) -> Self {
        let n = boxes.len();
        let mut radix = Radix { from: Vec::with_capacity(n), to: vec![(0, 0); n] };
        let axes = [0, 1, 2].map(|axis| {
            radix.from.clear();
            radix.from.extend((0u32..).zip(boxes).map(|(id, b)| (rising_key(b.min[axis]), id)));
            radix.sort();
            radix.from.iter().map(|&(_, id)| id).collect()
        });
        Self { axes, child: vec![0; n], moved: vec![0; n] }
    }

    /// The ids in `slots`, in the order of `axis`.
    pub fn sorted(&self, axis: usize, slots: Range<usize>) -> &[u32] {
        &self.axes[axis][slots]
    }

    /// Splits the node that owns the slots from `start` on into children that each take a run of the order of `axis`;
    /// the runs end at `ends`, counted from `start`. Afterwards every child owns its slots in all three orders.
    pub fn split(&mut self, axis: usize, start: usize, ends: &[usize]) {
        let n = ends[ends.len() - 1];
        let mut begin = 0;
        for (child, &end) in (0..).zip(ends) {
            for &id in &self.axes[axis][start + begin..start + end] {
                self.child[id as usize] = child;
            }
            begin = end;
        }
        for other in (0..3).filter(|&a| a != axis) {
            let mut next = [0; 8];
            next[1..ends.len()].copy_from_slice(&ends[..ends.len() - 1]);
            let order = &mut self.axes[other][start..start + n];
            let moved = &mut self.moved[..n];
            for &id in &*order {
                let at = &mut next[usize::from(self.child[id as usize] & 7)];
                moved[*at] = id;
                *at += 1;
            }
            order.copy_from_slice(moved);
        }
    }
}

/// An integer that rises with `x`; the same for both zeros, which compare as equal.
fn rising_key(x: f32) -> u32 {
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// Least significant digit first: every pass is stable, and so is the whole.
struct Radix {
    from: Vec<(u32, u32)>,
    to: Vec<(u32, u32)>,
}

impl Radix {
    const DIGIT_BITS: u32 = 11;

    /// Sorts `from` by key.
    fn sort(&mut self) {
        const VALUES: usize = 1 << Radix::DIGIT_BITS;
        let digit = |key: u32, pass: usize| (key >> (pass as u32 * Self::DIGIT_BITS)) as usize % VALUES;
        let mut counts = [[0u32; VALUES]; 3];
        for &(key, _) in &self.from {
            for (pass, counts) in counts.iter_mut().enumerate() {
                counts[digit(key, pass)] += 1;
            }
        }
        for (pass, counts) in counts.iter_mut().enumerate() {
            let mut total = 0;
            for count in counts.iter_mut() {
                total += std::mem::replace(count, total);
            }
            for &(key, id) in &self.from {
                let at = &mut counts[digit(key, pass)];
                self.to[*at as usize] = (key, id);
                *at += 1;
            }
            std::mem::swap(&mut self.from, &mut self.to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::testing::any_boxes;
    use glam::Vec3;
    use ordered_float::OrderedFloat;
    use proptest::prelude::*;

    fn sorted(boxes: &[Aabb], axis: usize, mut ids: Vec<u32>) -> Vec<u32> {
        ids.sort_by_key(|&t| (OrderedFloat(boxes[t as usize].min[axis]), t));
        ids
    }

    proptest! {
        #[test]
        fn orders_stay_sorted_when_nodes_are_split(
            boxes in any_boxes(8..=90),
            axis in 0usize..3,
            cuts in proptest::collection::btree_set(1usize..8, 1..7),
        ) {
            let n = boxes.len();
            let mut orders = Orders::new(&boxes);
            let all: Vec<u32> = (0..n as u32).collect();
            let by_axis = sorted(&boxes, axis, all.clone());
            for a in 0..3 {
                prop_assert_eq!(orders.sorted(a, 0..n), sorted(&boxes, a, all.clone()));
            }
            let ends: Vec<usize> = cuts.into_iter().chain([n]).collect();
            orders.split(axis, 0, &ends);
            let mut begin = 0;
            for end in ends {
                for a in 0..3 {
                    let expected = sorted(&boxes, a, by_axis[begin..end].to_vec());
                    prop_assert_eq!(orders.sorted(a, begin..end), expected);
                }
                begin = end;
            }
        }
    }

    #[test]
    fn keys_rise_with_the_coordinate_and_both_zeros_are_equal() {
        let rising = [f32::MIN, -1.5, -1.0, -1e-40, 0.0, 1e-40, 1.0, 1.5, f32::MAX];
        assert!(rising.windows(2).all(|w| rising_key(w[0]) < rising_key(w[1])));
        assert_eq!(rising_key(0.0), rising_key(-0.0));
        let point = |x| Aabb::new(Vec3::splat(x), Vec3::ONE);
        let orders = Orders::new(&[point(0.0), point(-0.0), point(-1.0), point(0.0)]);
        assert_eq!(orders.sorted(1, 0..4), [2, 0, 1, 3]);
    }
}
