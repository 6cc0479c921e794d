//! The search tree, complete, four-ary, without pointers; and the search for the nearest cluster in it.
//!
//! **Bound.** The union of the query with *any* cluster below an entry contains [min(q.lo, greatest lo), max(q.hi, least
//! hi)], computed by the operations that compute the union of two boxes, and areas are monotone: its area bounds
//! their distances from below, rounding included. With the smallest id below, (area, id) bounds their keys: without the
//! id, all clusters inside the query would tie and be visited.
//!
//! **Two steps.** Half areas of all four entries of a quad come first, in f32 and at once; what they leave undecided,
//! near ties above all, f64 decides. See [`Limits`].

use super::order::Live;
use super::quad::{Entry, LANES, NOBODY, Quad, Query};
use crate::geom::Aabb;

/// Levels that 2³¹ positions need.
const MOST_LEVELS: usize = 16;

/// A complete four-ary tree over positions 0, 1, … Level 0 holds the clusters, four to a quad; entry `e` of level l + 1
/// stands for quad `e` of level l. The top level is one quad.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    /// Level after level.
    quads: Vec<Quad>,
    /// Where each level starts in `quads`.
    starts: [u32; MOST_LEVELS],
    height: usize,
    /// Half areas below this can be told apart in f32.
    trusted: f64,
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

    /// The nearer of two.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        if self.is_after(other.distance, other.id) { other } else { self }
    }
}

/// Work of searches.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    /// Searches.
    pub searches: u64,
    /// Quads looked at.
    pub quads: u64,
    /// Bounds computed in f64.
    pub bounds: u64,
    /// Distances computed in f64.
    pub pairs: u64,
}

impl Effort {
    /// What a budget goes by: entries looked at.
    pub fn steps(&self) -> u64 {
        self.quads * LANES as u64
    }
}

/// What a half area in f32 tells of a distance d: above `most`, it belongs to a greater one; below `least`, to a smaller.
///
/// On the way to a half area f32 rounds extents, a sum, two products and a sum, 2⁻²⁴ each at most, or half the least
/// denormal number: together less than 2⁻²¹ of it and 10⁻⁴⁴. The margins are wider. Nothing overflows on
/// the way to a half area below 2¹²⁶ but an extent alone, so trees of greater extents are not trusted at all.
#[derive(Clone, Copy, Debug)]
struct Limits {
    most: f32,
    least: f32,
}

impl Limits {
    #[inline(always)]
    fn of(distance: f64, trusted: f64) -> Self {
        const MARGIN: f64 = 1.0 / (1 << 19) as f64;
        const LEAST_MARGIN: f64 = 1e-42;
        let half = 0.5 * distance;
        if half < trusted {
            let most = half * (1.0 + MARGIN) + LEAST_MARGIN;
            Self { most: most as f32, least: (half * (1.0 - MARGIN) - LEAST_MARGIN) as f32 }
        } else {
            Self { most: f32::INFINITY, least: f32::NEG_INFINITY }
        }
    }

    /// The greatest half area that f32 can tell from others, in a tree over `boxes`.
    fn trusted(boxes: &[Aabb]) -> f64 {
        let extent = Aabb::union_of(boxes).extent().max_element();
        if extent < f64::from(f32::MAX / 2.0) { f64::from(f32::MAX / 4.0) } else { 0.0 }
    }
}

/// An entry that a search may have to look into.
#[derive(Clone, Copy, Debug, Default)]
struct Pending {
    /// Half area of its bound.
    half: f32,
    /// Smallest id below.
    id: u32,
    /// The quad it stands for.
    quad: u32,
    /// That quad's level.
    level: u32,
}

/// Memory of a search, to be used again. Each level adds three entries at most: of four, one is looked into at once.
#[derive(Clone, Debug, Default)]
pub(super) struct Stack([[Pending; LANES - 1]; MOST_LEVELS]);

impl Tree {
    /// A tree for clusters of `boxes`.
    pub fn new(boxes: &[Aabb]) -> Self {
        Self { trusted: Limits::trusted(boxes), ..Self::default() }
    }

    /// Gives the levels their places for `positions` positions.
    fn lay_out(&mut self, positions: usize) {
        self.height = 0;
        let (mut start, mut quads) = (0, positions);
        while self.height == 0 || quads > 1 {
            quads = quads.div_ceil(LANES);
            self.starts[self.height] = start as u32;
            self.height += 1;
            start += quads;
        }
        self.quads.clear();
        self.quads.reserve_exact(start);
    }

    /// Puts `clusters` at positions 0, 1, …
    pub fn fill(&mut self, clusters: &[Live]) {
        self.lay_out(clusters.len());
        let entry = |c: &Live| Entry { inner: c.aabb, id: c.id };
        self.quads.extend(clusters.chunks(LANES).map(|four| Quad::of(four.iter().map(entry))));
        for level in 1..self.height {
            let below = self.starts[level - 1] as usize..self.starts[level] as usize;
            for first in below.clone().step_by(LANES) {
                let four = first..(first + LANES).min(below.end);
                let quad = Quad::of(self.quads[four].iter().map(Quad::summary));
                self.quads.push(quad);
            }
        }
    }

    /// Takes over the part of `whole` that its entry `entry` of level `span` stands for, of `positions` positions.
    pub fn copy_part(&mut self, whole: &Self, span: usize, entry: usize, positions: usize) {
        self.trusted = whole.trusted;
        self.lay_out(positions);
        for level in 0..self.height {
            let start = whole.starts[level] as usize + (entry << (2 * (span - 1 - level)));
            let quads = positions.div_ceil(LANES << (2 * level));
            self.quads.extend_from_slice(&whole.quads[start..start + quads]);
        }
    }

    /// Number of levels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The cluster at position `at`.
    #[inline(always)]
    pub fn get(&self, at: usize) -> Entry {
        self.quads[at / LANES].get(at % LANES)
    }

    /// The id of the cluster at position `at`.
    #[inline(always)]
    pub fn id(&self, at: usize) -> u32 {
        self.quads[at / LANES].id(at % LANES)
    }

    /// Replaces the cluster at position `at`, and puts in order what stands for it.
    pub fn set(&mut self, at: usize, cluster: &Entry) {
        let mut index = at;
        let mut entry = *cluster;
        for start in &self.starts[..self.height] {
            let quad = &mut self.quads[*start as usize + index / LANES];
            let before = quad.summary();
            quad.set(index % LANES, &entry);
            entry = quad.summary();
            if entry == before {
                break;
            }
            index /= LANES;
        }
    }

    /// Searches all but what entry `own` of level `level` stands for; `best` becomes the cluster nearest to `query` if that
    /// is nearer than `best` was. With `ANY`, the first one met that is.
    ///
    /// It goes up from `own`: what stands beside it is near in most cases, and the bounds of all else are above it.
    #[inline(always)]
    pub fn nearest<const ANY: bool>(
        &self,
        query: &Aabb,
        level: usize,
        own: usize,
        best: &mut Nearest,
        stack: &mut Stack,
        effort: &mut Effort,
    ) {
        let stack = stack.0.as_flattened_mut();
        let wide = Query::new(query);
        let mut limits = Limits::of(best.distance, self.trusted);
        let mut own = own;
        for from in level..self.height {
            let (mut level, mut index, mut skip) = (from, own / LANES, 1 << (own % LANES));
            own = index;
            let mut top = 0;
            loop {
                let quad = &self.quads[self.starts[level] as usize + index];
                effort.quads += 1;
                let (halves, mut near) = quad.within(&wide, limits.most);
                near &= !skip;
                skip = 0;
                let bottom = top;
                while near != 0 {
                    let lane = near.trailing_zeros() as usize;
                    near &= near - 1;
                    let at = (index * LANES + lane) as u32;
                    if level > 0 {
                        let half = halves[lane];
                        let pending = Pending { half, id: quad.id(lane), quad: at, level: level as u32 - 1 };
                        insert(stack, bottom, &mut top, pending);
                        continue;
                    }
                    effort.pairs += 1;
                    let cluster = quad.get(lane);
                    let distance = query.union(&cluster.inner).surface_area();
                    if best.is_after(distance, cluster.id) {
                        *best = Nearest { distance, id: cluster.id, at };
                        if ANY {
                            return;
                        }
                        limits = Limits::of(distance, self.trusted);
                    }
                }
                while top > 0 && !self.is_worth(&stack[top - 1], query, &limits, best, effort) {
                    top -= 1;
                }
                if top == 0 {
                    break;
                }
                top -= 1;
                (level, index) = (stack[top].level as usize, stack[top].quad as usize);
            }
        }
    }

    /// Whether something nearer than `best` can be below an entry.
    #[inline(always)]
    fn is_worth(&self, entry: &Pending, query: &Aabb, limits: &Limits, best: &Nearest, effort: &mut Effort) -> bool {
        if entry.half < limits.least || entry.half > limits.most {
            return entry.half < limits.least;
        }
        effort.bounds += 1;
        let index = entry.quad as usize;
        let inner = self.quads[self.starts[entry.level as usize + 1] as usize + index / LANES].get(index % LANES).inner;
        best.is_after(query.union(&inner).surface_area(), entry.id)
    }
}

/// Puts an entry on the stack such that, from `bottom` on, the nearest is on top.
#[inline(always)]
fn insert(stack: &mut [Pending], bottom: usize, top: &mut usize, entry: Pending) {
    let mut at = *top;
    while at > bottom && (stack[at - 1].half, stack[at - 1].id) < (entry.half, entry.id) {
        stack[at] = stack[at - 1];
        at -= 1;
    }
    stack[at] = entry;
    *top += 1;
}
