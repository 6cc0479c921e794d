//! The nearest neighbour of every cluster in a row.

use super::clusters::{CHUNK, Cluster, each};
use crate::build::morton::at_each_level;
use crate::geom::Aabb;
use crate::simd::Simd;
use std::ops::Range;

/// Clusters that vector instructions work on side by side.
const LANES: usize = 16;

/// Clusters whose distances are kept before the nearest are chosen.
const TILE: usize = 256;

/// How nearest neighbours are looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    radius: usize,
    /// What extents are multiplied by before they are multiplied with each other in f32; `None` where they are taken in f64.
    scale: Option<f32>,
    simd: Simd,
}

/// Numbers that distances are computed in.
trait Real:
    Copy + PartialOrd + std::ops::Add<Output = Self> + std::ops::Sub<Output = Self> + std::ops::Mul<Output = Self>
{
    const INFINITE: Self;
    fn from_f32(x: f32) -> Self;
}

impl Real for f32 {
    const INFINITE: Self = Self::INFINITY;
    #[inline(always)]
    fn from_f32(x: f32) -> Self {
        x
    }
}

impl Real for f64 {
    const INFINITE: Self = Self::INFINITY;
    #[inline(always)]
    fn from_f32(x: f32) -> Self {
        x.into()
    }
}

impl Search {
    /// For clusters within the box `around`.
    pub fn new(around: &Aabb, radius: usize, simd: Simd) -> Self {
        let extent = (around.max - around.min).max_element();
        let scale = extent.is_finite().then(|| {
            // The widest extent becomes 2⁶² to 2⁶³: three products of two are below 2¹²⁸.
            let exponent = if extent > 0.0 { f64::from(extent).log2().floor() as i32 } else { 0 };
            2f32.powi((62 - exponent).min(127))
        });
        Self { radius, scale, simd }
    }

    /// Writes how many steps it is to the nearest neighbour of each cluster, negative if it stands before. There are at least two.
    /// Returns how many pairs there are.
    pub fn nearest(&self, clusters: &[Cluster], nearest: &mut Vec<i16>) -> u64 {
        nearest.clear();
        nearest.resize(clusters.len(), 0);
        let tasks: Vec<_> = nearest.chunks_mut(CHUNK).zip((0..).step_by(CHUNK)).collect();
        each(tasks, |(out, first)| match self.scale {
            Some(scale) => nearest_f32(self.simd, clusters, first, self.radius, scale, out),
            None => nearest_f64(self.simd, clusters, first, self.radius, 1.0, out),
        });
        let reach = self.radius.min(clusters.len() - 1);
        (reach * clusters.len() - reach * (reach + 1) / 2) as u64
    }
}

at_each_level! {
    fn nearest_f32(clusters: &[Cluster], first: usize, radius: usize, scale: f32, out: &mut [i16]) = nearest_body
}

at_each_level! {
    fn nearest_f64(clusters: &[Cluster], first: usize, radius: usize, scale: f64, out: &mut [i16]) = nearest_body
}

/// Boxes of a tile and of what its clusters have in reach, one array a coordinate.
struct Window {
    bounds: [[f32; WINDOW]; 6],
    places: [u32; WINDOW],
}

/// A tile with what it has in reach on either side.
const WINDOW: usize = TILE + 2 * super::MOST_RADIUS + LANES;

impl Window {
    /// Fills `to` with the clusters from index `first`; beyond the last there are boxes that hold all of space.
    #[inline(always)]
    fn fill(&mut self, to: Range<usize>, clusters: &[Cluster], first: usize) {
        let known = &clusters[first..clusters.len().min(first + to.len())];
        for (at, cluster) in to.clone().zip(known) {
            for (bounds, bound) in self.bounds.iter_mut().zip(cluster.bounds()) {
                bounds[at] = bound;
            }
            self.places[at] = cluster.place;
        }
        for (axis, bounds) in self.bounds.iter_mut().enumerate() {
            bounds[to.start + known.len()..to.end].fill(if axis < 3 { f32::NEG_INFINITY } else { f32::INFINITY });
        }
    }

    /// The six coordinates of [`LANES`] clusters.
    #[inline(always)]
    fn load(&self, at: usize) -> [&[f32; LANES]; 6] {
        self.bounds.each_ref().map(|bounds| bounds[at..at + LANES].try_into().expect("as many as asked for"))
    }
}

/// Half areas of the unions of [`LANES`] pairs.
#[inline(always)]
fn distances<T: Real>(a: &[&[f32; LANES]; 6], b: &[&[f32; LANES]; 6], scale: T) -> [T; LANES] {
    let mut out = [T::INFINITE; LANES];
    // One loop over lanes without another inside, or they are not taken together.
    for lane in 0..LANES {
        let x = extent::<T>([a[0][lane], b[0][lane]], [a[3][lane], b[3][lane]]) * scale;
        let y = extent::<T>([a[1][lane], b[1][lane]], [a[4][lane], b[4][lane]]) * scale;
        let z = extent::<T>([a[2][lane], b[2][lane]], [a[5][lane], b[5][lane]]) * scale;
        out[lane] = x * y + y * z + z * x;
    }
    out
}

/// The edge length of a union on one axis.
#[inline(always)]
fn extent<T: Real>(low: [f32; 2], high: [f32; 2]) -> T {
    let low = if low[1] < low[0] { low[1] } else { low[0] };
    let high = if high[1] > high[0] { high[1] } else { high[0] };
    T::from_f32(high) - T::from_f32(low)
}

/// A tile stands behind as much as it has in reach before it. Row `k - 1` holds the distance from each of these clusters to the
/// k-th behind it.
#[inline(always)]
fn nearest_body<T: Real>(clusters: &[Cluster], first: usize, radius: usize, scale: T, out: &mut [i16]) {
    let head = radius.next_multiple_of(LANES);
    let length = head + TILE;
    let mut rows = vec![T::INFINITE; radius * length];
    let mut window = Window { bounds: [[0.0; WINDOW]; 6], places: [0; WINDOW] };
    for (tile, out) in out.chunks_mut(TILE).enumerate() {
        let start = first + tile * TILE;
        let end = head + out.len().next_multiple_of(LANES);
        // Before the very first cluster there is nothing, at an infinite distance.
        let filled = if start == 0 { head } else { 0 };
        window.fill(filled..end + radius, clusters, start + filled - head);
        // The tile before has computed what it shares with this one.
        let computed = if tile == 0 { filled } else { head };
        if tile > 0 {
            rows.chunks_exact_mut(length).for_each(|row| row.copy_within(TILE.., 0));
        }
        for at in (computed..end).step_by(LANES) {
            let a = window.load(at);
            for (k, row) in (1..).zip(rows.chunks_exact_mut(length)) {
                row[at..at + LANES].copy_from_slice(&distances(&a, &window.load(at + k), scale));
            }
        }
        for (block, out) in out.chunks_mut(LANES).enumerate() {
            let chosen = choose(&rows, length, &window, head + block * LANES);
            out.iter_mut().zip(chosen).for_each(|(to, steps)| *to = steps as i16);
        }
    }
}

/// For [`LANES`] clusters of a tile, how far behind (or before, if negative) the nearest is: of equally near ones, that with
/// the least xor of places.
#[inline(always)]
fn choose<T: Real>(rows: &[T], length: usize, window: &Window, at: usize) -> [i32; LANES] {
    let places =
        |at: usize| -> &[u32; LANES] { window.places[at..at + LANES].try_into().expect("as many as asked for") };
    let own = places(at);
    let mut least = [T::INFINITE; LANES];
    let mut apart = [0u32; LANES];
    let mut chosen = [0i32; LANES];
    for (k, row) in (1..).zip(rows.chunks_exact(length)) {
        let behind: &[T; LANES] = row[at..at + LANES].try_into().expect("as many as asked for");
        let before: &[T; LANES] = row[at - k..at - k + LANES].try_into().expect("as many as asked for");
        let (behind_places, before_places) = (places(at + k), places(at - k));
        for lane in 0..LANES {
            for (distance, other, step) in
                [(behind[lane], behind_places[lane], k as i32), (before[lane], before_places[lane], -(k as i32))]
            {
                let xor = own[lane] ^ other;
                let nearer = (distance < least[lane]) | ((distance == least[lane]) & (xor < apart[lane]));
                least[lane] = if nearer { distance } else { least[lane] };
                apart[lane] = if nearer { xor } else { apart[lane] };
                chosen[lane] = if nearer { step } else { chosen[lane] };
            }
        }
    }
    chosen
}
