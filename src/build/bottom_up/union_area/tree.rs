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
    /// Level 0 first.
    quads: Vec<Quad>,
    /// Where each level starts in `quads`.
    starts: [u32; MOST_LEVELS],
    height: usize,
}

/// Entries that a search has yet to look into, the nearest of each quad on top.
#[derive(Clone, Copy, Debug)]
struct Pending {
    /// Half area of its bound.
    half: f32,
    id: u32,
    /// The quad it stands for.
    quad: u32,
    /// That quad's level.
    level: u32,
}

/// Memory of a search, to be used again.
#[derive(Clone, Debug)]
pub(super) struct Stack([Pending; 3 * MOST_LEVELS]);

impl Default for Stack {
    fn default() -> Self {
        Self([Pending { half: 0.0, id: 0, quad: 0, level: 0 }; 3 * MOST_LEVELS])
    }
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

/// What f32 tells of a distance: half areas above `most` surely belong to greater ones, half areas below `least` to
/// smaller ones.
///
/// f32 rounds five times on the way to a half area and errs by less than 2⁻²⁰ of it, or by a denormal number; the
/// margins are wider than both. Where f32 could overflow it tells nothing.
#[derive(Clone, Copy, Debug)]
struct Limits {
    most: f32,
    least: f32,
}

impl Limits {
    #[inline(always)]
    fn of(distance: f64) -> Self {
        const TRUSTED: f64 = 3.0 * TRUSTED_EXTENT as f64 * TRUSTED_EXTENT as f64;
        const MARGIN: f64 = 1.0 / (1u64 << 19) as f64;
        let half = 0.5 * distance;
        if half < TRUSTED {
            let most = (half * (1.0 + MARGIN) + 1e-42) as f32;
            Self { most, least: (half * (1.0 - MARGIN) - 1e-42) as f32 }
        } else {
            Self { most: f32::INFINITY, least: f32::NEG_INFINITY }
        }
    }
}

impl Tree {
    /// Gives the levels their places for `positions` positions.
    fn lay_out(&mut self, positions: usize) {
        let mut quads = positions.div_ceil(LANES).max(1);
        let mut start = 0;
        self.height = 0;
        loop {
            self.starts[self.height] = start;
            self.height += 1;
            start += quads as u32;
            if quads == 1 {
                break;
            }
            quads = quads.div_ceil(LANES);
        }
        self.quads.clear();
        self.quads.reserve_exact(start as usize);
    }

    /// Puts clusters at positions 0, 1, … and everything above them in order.
    pub fn fill<C>(&mut self, clusters: &[C], entry: impl Fn(&C) -> Entry) {
        self.lay_out(clusters.len());
        let quad = |four: &[C]| {
            let mut quad = Quad::VACANT;
            four.iter().enumerate().for_each(|(lane, cluster)| quad.set(lane, &entry(cluster)));
            quad
        };
        self.quads.extend(clusters.chunks(LANES).map(quad));
        for level in 1..self.height {
            for below in (self.starts[level - 1]..self.starts[level]).step_by(LANES) {
                let mut quad = Quad::VACANT;
                for child in below..(below + LANES as u32).min(self.starts[level]) {
                    quad.set((child - below) as usize, &self.quads[child as usize].summary());
                }
                self.quads.push(quad);
            }
        }
    }

    /// Takes over the part of `whole` that its entry `root` of level `height` stands for; `positions` positions.
    pub fn copy_part(&mut self, whole: &Tree, height: usize, root: usize, positions: usize) {
        self.lay_out(positions);
        for level in 0..height {
            let span = 1 << (2 * (height - 1 - level));
            let start = whole.starts[level] as usize + root * span;
            let quads = positions.div_ceil(LANES << (2 * level));
            // A part that ends early has levels above its own top, of one quad each.
            if level < self.height {
                self.quads.extend_from_slice(&whole.quads[start..start + quads]);
            }
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

    /// Replaces the cluster at position `at`, and puts what stands for it in order.
    pub fn set(&mut self, at: usize, entry: &Entry) {
        let mut e = at;
        let mut entry = *entry;
        for &start in &self.starts[..self.height] {
            let quad = &mut self.quads[start as usize + e / LANES];
            if e != at && quad.get(e % LANES) == entry {
                break;
            }
            quad.set(e % LANES, &entry);
            entry = quad.summary();
            e /= LANES;
        }
    }

    /// Searches everything but entry `own` of level `level` for a cluster nearer to `query` than `best`; any one
    /// or the nearest.
    ///
    /// The search goes up from `own`: first what stands beside it, which is near in most cases, last the other end.
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
        let wide = Query::new(query);
        let mut limits = Limits::of(best.distance);
        let mut own = own;
        for up in level..self.height {
            let (mut level, mut quad, mut skip) = (up, own / LANES, 1u32 << (own % LANES));
            let mut top = 0;
            loop {
                let four = &self.quads[self.starts[level] as usize + quad];
                effort.quads += 1;
                let halves = four.half_areas(&wide);
                let mut near = !halves.cmpgt(Vec4::splat(limits.most)).bitmask() & 0xf & !skip;
                let halves = halves.to_array();
                skip = 0;
                if near != 0 && level == 0 {
                    while near != 0 {
                        let lane = near.trailing_zeros() as usize;
                        near &= near - 1;
                        effort.exact += 1;
                        let entry = four.get(lane);
                        let distance = query.union(&entry.inner).surface_area();
                        if best.is_after(distance, entry.id) {
                            *best = Nearest { distance, id: entry.id, at: (quad * LANES + lane) as u32 };
                            if ANY {
                                return;
                            }
                            limits = Limits::of(distance);
                        }
                    }
                } else {
                    let from = top;
                    while near != 0 {
                        let lane = near.trailing_zeros() as usize;
                        near &= near - 1;
                        let (half, id) = (halves[lane], four.id(lane));
                        let mut at = top;
                        while at > from && (stack.0[at - 1].half, stack.0[at - 1].id) < (half, id) {
                            stack.0[at] = stack.0[at - 1];
                            at -= 1;
                        }
                        stack.0[at] =
                            Pending { half, id, quad: (quad * LANES + lane) as u32, level: level as u32 - 1 };
                        top += 1;
                    }
                }
                loop {
                    if top == 0 {
                        break;
                    }
                    let next = &stack.0[top - 1];
                    let worth = next.half < limits.least || (!(next.half > limits.most) && {
                        effort.exact += 1;
                        let above = &self.quads[self.starts[next.level as usize + 1] as usize + next.quad as usize / LANES];
                        let inner = above.get(next.quad as usize % LANES).inner;
                        best.is_after(query.union(&inner).surface_area(), next.id)
                    });
                    if worth {
                        break;
                    }
                    top -= 1;
                }
                if top == 0 {
                    break;
                }
                top -= 1;
                (level, quad) = (stack.0[top].level as usize, stack.0[top].quad as usize);
            }
            own /= LANES;
        }
    }
}
