//! The order of clusters in the search tree: by median splits. It decides how quick searches are, never what they find.

use super::quad::LANES;
use crate::geom::Aabb;
use std::cmp::Ordering;

/// A cluster between two phases.
#[derive(Clone, Copy, Debug)]
pub(super) struct Live {
    /// Its box.
    pub aabb: Aabb,
    /// Its smallest triangle.
    pub id: u32,
    /// What [`Merges`](super::Merges) calls it.
    pub handle: u32,
}

/// The clusters of single triangles.
pub(super) fn triangles(boxes: &[Aabb]) -> Vec<Live> {
    (0u32..).zip(boxes).map(|(id, &aabb)| Live { aabb, id, handle: id }).collect()
}

/// Clusters below which splitting in parallel doesn't pay.
const ALONE: usize = 4096;

/// Splits at the widest of the boxes' six coordinates, again and again, such that every node of a complete four-ary tree
/// over the order, down to its quads, is the outcome of two splits.
///
/// Boxes of different sizes at the same place differ in some coordinate, so that large and small ones part: a bound
/// over both would be as weak as that of the small ones.
pub(super) fn sort(clusters: &mut [Live]) {
    split(clusters, clusters.len().next_power_of_two());
}

/// Sorts what stands for at most `capacity`, a power of two.
///
/// It calls itself for one half and loops over the other, at most once for each halving of the capacity.
fn split(mut clusters: &mut [Live], mut capacity: usize) {
    loop {
        while capacity >= 2 * clusters.len() {
            capacity /= 2;
        }
        if capacity <= LANES {
            return;
        }
        capacity /= 2;
        // A power of two below the length: full on the left, the rest on the right.
        // Each its own function: a coordinate chosen at every comparison would cost as much as the comparison.
        match widest(clusters) {
            0 => clusters.select_nth_unstable_by(capacity, |a, b| compare(a.aabb.min.x, b.aabb.min.x)),
            1 => clusters.select_nth_unstable_by(capacity, |a, b| compare(a.aabb.min.y, b.aabb.min.y)),
            2 => clusters.select_nth_unstable_by(capacity, |a, b| compare(a.aabb.min.z, b.aabb.min.z)),
            3 => clusters.select_nth_unstable_by(capacity, |a, b| compare(a.aabb.max.x, b.aabb.max.x)),
            4 => clusters.select_nth_unstable_by(capacity, |a, b| compare(a.aabb.max.y, b.aabb.max.y)),
            _ => clusters.select_nth_unstable_by(capacity, |a, b| compare(a.aabb.max.z, b.aabb.max.z)),
        };
        let (left, right) = clusters.split_at_mut(capacity);
        if left.len() >= ALONE {
            rayon::join(|| split(left, capacity), || split(right, capacity));
            return;
        }
        split(left, capacity);
        clusters = right;
    }
}

/// The coordinate that differs most: 0–2 for x, y, z of the lower corners, 3–5 of the upper ones.
fn widest(clusters: &[Live]) -> usize {
    let first = clusters[0].aabb;
    let (mut least, mut most) = (first, first);
    for Live { aabb, .. } in clusters {
        least = Aabb::new(least.min.min(aabb.min), least.max.min(aabb.max));
        most = Aabb::new(most.min.max(aabb.min), most.max.max(aabb.max));
    }
    let widths = [(most.min - least.min).to_array(), (most.max - least.max).to_array()];
    let widths = widths.as_flattened();
    (1..widths.len()).fold(0, |best, k| if widths[k] > widths[best] { k } else { best })
}

/// The order of two finite numbers.
#[inline(always)]
fn compare(a: f32, b: f32) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal)
}
