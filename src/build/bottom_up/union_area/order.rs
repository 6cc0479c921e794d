//! The order of clusters in the search tree: by median splits.

use crate::geom::Aabb;

/// A live cluster between two phases.
#[derive(Clone, Copy, Debug)]
pub(super) struct Live {
    /// Its box.
    pub aabb: Aabb,
    /// Its smallest triangle.
    pub id: u32,
    /// What [`super::super::merges::Merges`] calls it.
    pub handle: u32,
}

/// Clusters below which sorting in parallel doesn't pay.
const ALONE: usize = 8192;

/// Coordinate `key` of a box: 0–2 its lower corner, 3–5 its upper.
#[inline(always)]
fn coordinate(aabb: &Aabb, key: usize) -> f32 {
    let [min, max] = [aabb.min.to_array(), aabb.max.to_array()];
    if key < 3 { min[key] } else { max[key - 3] }
}

/// Splits on the widest of the six coordinates, down to four clusters, such that every part is one node of a complete
/// four-ary tree or half of one.
pub(super) fn sort(clusters: &mut [Live]) {
    let capacity = clusters.len().next_power_of_two();
    split(clusters, capacity);
}

fn split(mut clusters: &mut [Live], mut capacity: usize) {
    loop {
        while capacity >= 2 * clusters.len() {
            capacity /= 2;
        }
        if capacity <= 4 {
            return;
        }
        let half = capacity / 2;
        let first = clusters[0].aabb;
        let (mut least, mut most) = (first, first);
        for c in &clusters[1..] {
            least = Aabb::new(least.min.min(c.aabb.min), least.max.min(c.aabb.max));
            most = Aabb::new(most.min.max(c.aabb.min), most.max.max(c.aabb.max));
        }
        let key = (0..6)
            .max_by(|&a, &b| {
                let width = |k| coordinate(&most, k) - coordinate(&least, k);
                width(a).total_cmp(&width(b))
            })
            .unwrap_or(0);
        match key {
            0 => clusters.select_nth_unstable_by(half, |a, b| compare(a.aabb.min.x, b.aabb.min.x)),
            1 => clusters.select_nth_unstable_by(half, |a, b| compare(a.aabb.min.y, b.aabb.min.y)),
            2 => clusters.select_nth_unstable_by(half, |a, b| compare(a.aabb.min.z, b.aabb.min.z)),
            3 => clusters.select_nth_unstable_by(half, |a, b| compare(a.aabb.max.x, b.aabb.max.x)),
            4 => clusters.select_nth_unstable_by(half, |a, b| compare(a.aabb.max.y, b.aabb.max.y)),
            _ => clusters.select_nth_unstable_by(half, |a, b| compare(a.aabb.max.z, b.aabb.max.z)),
        };
        let (a, b) = clusters.split_at_mut(half);
        capacity = half;
        if a.len() > ALONE {
            rayon::join(|| split(a, half), || split(b, half));
            return;
        }
        split(a, half);
        clusters = b;
    }
}

#[inline(always)]
fn compare(a: f32, b: f32) -> std::cmp::Ordering {
    a.partial_cmp(&b).unwrap_or(std::cmp::Ordering::Equal)
}
