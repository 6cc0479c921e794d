//! The search tree: complete, four-ary, without pointers, and the search for the nearest cluster in it.

use super::quad::{Entry, LANES, NOBODY, Quad, Query};
use crate::geom::Aabb;
use glam::Vec4;

/// Levels that 2³² positions can have.
const MOST_LEVELS: usize = 16;

/// A complete four-ary tree over positions 0, 1, … Level 0 holds the clusters, four to a quad; entry `e` of level
/// l + 1 stands for quad `e` of level l. The top level is one quad.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    levels: Vec<Vec<Quad>>,
}

/// The nearest cluster so far: the least key (distance, id).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearest {
    /// Surface area of the union.
    pub distance: f64,
    /// Its id.
    pub id: u32,
    /// Its position.
    pub at: u32,
}

impl Nearest {
    /// None yet.
    pub const NONE: Self = Self { distance: f64::INFINITY, id: NOBODY, at: 0 };

    /// Whether the key (distance, id) comes before this one's.
    #[inline(always)]
    pub fn is_after(&self, distance: f64, id: u32) -> bool {
        distance < self.distance || (distance == self.distance && id < self.id)
    }
}

/// Work of searches.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    /// Searches.
    pub searches: u64,
    /// Quads looked at.
    pub quads: u64,
    /// Entries whose exact distance or bound was computed.
    pub exact: u64,
    /// Of these, clusters.
    pub pairs: u64,
}

/// Whether half areas in f32 may be trusted: extents no greater than this.
const TRUSTED_EXTENT: f32 = (1u64 << 62) as f32;

/// The half area in f32 above which an entry is surely farther than `distance`.
///
/// f32 rounds five times on the way to a half area and errs by less than 2⁻²⁰ of it, or by a denormal number; the
/// margin is wider than both. Infinite, that is without effect, where f32 could overflow.
#[inline(always)]
fn limit(distance: f64) -> Vec4 {
    const MOST: f64 = 3.0 * TRUSTED_EXTENT as f64 * TRUSTED_EXTENT as f64;
    let half = 0.5 * distance;
    let limit = if half < MOST { (half * (1.0 + 1.0 / f64::from(1 << 19)) + 1e-42) as f32 } else { f32::INFINITY };
    Vec4::splat(limit)
}

impl Tree {
    /// Makes room for `positions` positions, all vacant.
    pub fn reset(&mut self, positions: usize) {
        let mut quads = positions.div_ceil(LANES).max(1);
        let mut level = 0;
        loop {
            if self.levels.len() == level {
                self.levels.push(Vec::new());
            }
            self.levels[level].clear();
            self.levels[level].resize(quads, Quad::VACANT);
            level += 1;
            if quads == 1 {
                break;
            }
            quads = quads.div_ceil(LANES);
        }
        self.levels.truncate(level);
    }

    /// Puts clusters at positions 0, 1, … and everything above them in order.
    pub fn fill(&mut self, clusters: impl ExactSizeIterator<Item = Entry>) {
        self.reset(clusters.len());
        for (at, entry) in clusters.enumerate() {
            self.levels[0][at / LANES].set(at % LANES, &entry);
        }
        for level in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(level);
            for (e, quad) in below[level - 1].iter().enumerate() {
                above[0][e / LANES].set(e % LANES, &quad.summary());
            }
        }
    }

    /// Takes over the part of `whole` that its entry `root` of level `level` stands for.
    pub fn copy_part(&mut self, whole: &Tree, level: usize, root: usize) {
        self.levels.resize_with(level.max(1), Vec::new);
        for (l, quads) in self.levels.iter_mut().enumerate() {
            let of = &whole.levels[l];
            let span = 1 << (2 * (level - 1 - l));
            quads.clear();
            quads.extend_from_slice(&of[root * span..((root + 1) * span).min(of.len())]);
        }
    }

    /// Number of levels.
    pub fn height(&self) -> usize {
        self.levels.len()
    }

    /// The cluster at position `at`.
    #[inline(always)]
    pub fn get(&self, at: usize) -> Entry {
        self.levels[0][at / LANES].get(at % LANES)
    }

    /// The id of the cluster at position `at`.
    #[inline(always)]
    pub fn id(&self, at: usize) -> u32 {
        self.levels[0][at / LANES].id(at % LANES)
    }

    /// Replaces the cluster at position `at`, and puts what stands for it in order.
    pub fn set(&mut self, at: usize, entry: &Entry) {
        let mut e = at;
        let mut entry = *entry;
        for level in &mut self.levels {
            let quad = &mut level[e / LANES];
            quad.set(e % LANES, &entry);
            entry = quad.summary();
            e /= LANES;
        }
    }

    /// Searches everything but entry `own` of level `level` for a cluster nearer to `query` than `best`.
    ///
    /// The search goes up from `own`: first what stands beside it, which is near in most cases, last the other end.
    #[inline(always)]
    pub fn nearest(&self, query: &Aabb, level: usize, own: usize, any: bool, best: &mut Nearest, effort: &mut Effort) {
        let wide = Query::new(query);
        let mut most = limit(best.distance);
        let mut own = own;
        for level in level..self.levels.len() {
            let mut stack = [(0u32, 0u32, 0.0f64, 0u32); 3 * MOST_LEVELS];
            let mut top = 0;
            let (mut l, mut q, mut skip) = (level, own / LANES, 1u32 << (own % LANES));
            loop {
                let quad = &self.levels[l][q];
                effort.quads += 1;
                let mut near = !quad.half_areas(&wide).cmpgt(most).bitmask() & 0xf & !skip;
                skip = 0;
                let from = top;
                while near != 0 {
                    let lane = near.trailing_zeros() as usize;
                    near &= near - 1;
                    effort.exact += 1;
                    let entry = quad.get(lane);
                    let distance = query.union(&entry.inner).surface_area();
                    if !best.is_after(distance, entry.id) {
                        continue;
                    }
                    if l == 0 {
                        effort.pairs += 1;
                        *best = Nearest { distance, id: entry.id, at: (q * LANES + lane) as u32 };
                        if any {
                            return;
                        }
                        most = limit(distance);
                    } else {
                        // The nearest on top.
                        let mut at = top;
                        while at > from && stack[at - 1].2 < distance {
                            stack[at] = stack[at - 1];
                            at -= 1;
                        }
                        stack[at] = (l as u32 - 1, (q * LANES + lane) as u32, distance, entry.id);
                        top += 1;
                    }
                }
                loop {
                    if top == 0 {
                        break;
                    }
                    top -= 1;
                    if best.is_after(stack[top].2, stack[top].3) {
                        (l, q) = (stack[top].0 as usize, stack[top].1 as usize);
                        top += 1;
                        break;
                    }
                }
                if top == 0 {
                    break;
                }
                top -= 1;
            }
            own /= LANES;
        }
    }
}
