//! What is done at a leaf: its triangles tested four at a time.

use super::filter::{FilterRay, Sides};
use super::layout::{BLOCK, Block, WideBvh};
use super::pack::Pack;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::trace::closest::{Closest, Goal, accepted, improve};
use crate::trace::slab::{Slabs, pad_up};
use arrayvec::ArrayVec;

/// How triangles are tested.
pub(in crate::trace) trait Leaves {
    /// Whether every hit is that of the f64 test.
    const WATERTIGHT: bool;

    /// The greatest coordinates, of scene and ray, that the test is for.
    const REACH: f32;

    /// Prepares for a ray.
    fn new() -> Self;

    /// Tests the triangles of a block of `wide`, and keeps the better hit. `search.limit` falls where it may.
    fn test<const W: usize, Q: Pack<BLOCK>, G: Goal>(&mut self, wide: &WideBvh<W>, block: usize, search: &mut Search);

    /// Makes the best hit of what was found.
    fn settle<const W: usize>(&mut self, wide: &WideBvh<W>, search: &mut Search);
}

/// A ray, and what is known of its hit.
pub(in crate::trace) struct Search<'a> {
    pub ray: &'a Ray,
    pub slabs: &'a Slabs,
    pub best: Option<Hit>,
    /// Nothing that is entered beyond it can be better.
    pub limit: f32,
    /// Whether a hit was found that is enough.
    pub done: bool,
}

impl Search<'_> {
    #[inline(always)]
    fn offer<G: Goal>(&mut self, triangle: u32, t: Option<f32>) {
        if improve(&mut self.best, triangle, t) {
            self.limit = self.limit.min(self.best.map_or(self.limit, |best| pad_up(best.t)));
            self.done |= G::FIRST_IS_ENOUGH;
        }
    }
}

/// The watertight test in f64, of what the f32 filter lets pass.
///
/// Where f32 is sure of the hit, and of bounds on its t, the upper one holds back the search at once, and the f64 test waits:
/// until the end, when most of those that wait are known to be farther than another.
pub(in crate::trace) struct Watertight {
    /// Both prepared when first needed: many rays come to no leaf.
    filter: Option<FilterRay>,
    exact: Option<WatertightRay>,
    waiting: ArrayVec<Waiting, 8>,
}

/// A triangle that is hit, at a t that is not known to the last bit yet.
#[derive(Clone, Copy)]
struct Waiting {
    block: u32,
    lane: u32,
    /// No greater than its t.
    least: f32,
    /// Whether t is known so well that it need not be held to the triangle's own box.
    well: bool,
}

/// Whether what f64 can be off by is less than a rounding of the f32 `t`, with `doubt` twice what f32 can be off by: 2²⁸ times more.
#[inline(always)]
fn well_known(t: f32, doubt: f32) -> bool {
    t.abs() * 16.0 >= doubt && t.abs() <= f32::MAX
}

impl Watertight {
    #[inline(never)]
    fn test_exactly<const W: usize, G: Goal>(
        &mut self,
        wide: &WideBvh<W>,
        block: usize,
        lane: usize,
        search: &mut Search,
    ) {
        let block = &wide.blocks[block];
        let test = self.exact(search);
        let t = accepted(test, *search.slabs, search.ray, &block.triangle(lane));
        search.offer::<G>(block.ids[lane], t);
    }

    /// What comes of `candidates`. Not part of the loop, whose registers it would take.
    #[inline(always)]
    fn look_closer<const W: usize, Q: Pack<BLOCK>, G: Goal>(
        &mut self,
        wide: &WideBvh<W>,
        index: usize,
        sides: &Sides<Q>,
        mut candidates: u32,
        search: &mut Search,
    ) {
        let block = &wide.blocks[index];
        let bounds = self.filter.as_ref().expect("sides come from it").bounds(sides);
        let (mut least, mut most) = ([0.0; BLOCK], [0.0; BLOCK]);
        bounds.least.store(&mut least);
        bounds.most.store(&mut most);
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let (least, most) = (least[lane], most[lane]);
            if bounds.sure >> lane & 1 == 1 {
                if least > search.limit || most < search.ray.t_min {
                    continue;
                }
                if least >= search.ray.t_min && most <= search.ray.t_max.min(f32::MAX) {
                    if G::FIRST_IS_ENOUGH {
                        search.best = Some(Hit { triangle: block.ids[lane], t: most });
                        search.done = true;
                        return;
                    }
                    if self.waiting.is_full() {
                        self.settle_all(wide, search);
                    }
                    self.waiting.push(Waiting {
                        block: index as u32,
                        lane: lane as u32,
                        least,
                        well: well_known(least, most - least),
                    });
                    search.limit = search.limit.min(pad_up(most));
                    continue;
                }
                // Too near an end of the ray's interval for f32 to tell, as the triangle is that a ray has just left.
                let t = self.exact(search).meets_surely(&block.triangle(lane));
                if well_known(t, most - least) {
                    let t = (t >= search.ray.t_min && t <= search.ray.t_max).then_some(t);
                    search.offer::<G>(block.ids[lane], t);
                    if search.done {
                        return;
                    }
                    continue;
                }
            }
            self.test_exactly::<W, G>(wide, index, lane, search);
        }
    }

    #[inline(never)]
    fn settle_all<const W: usize>(&mut self, wide: &WideBvh<W>, search: &mut Search) {
        while let Some(Waiting { block, lane, least, well }) = self.waiting.pop() {
            if least > search.limit {
                continue;
            }
            if well {
                let block = &wide.blocks[block as usize];
                let t = self.exact(search).meets_surely(&block.triangle(lane as usize));
                search.offer::<Closest>(block.ids[lane as usize], Some(t));
            } else {
                self.test_exactly::<W, Closest>(wide, block as usize, lane as usize, search);
            }
        }
    }

    #[inline(always)]
    fn exact(&mut self, search: &Search) -> &WatertightRay {
        match &mut self.exact {
            Some(test) => test,
            none => none.insert(WatertightRay::new(search.ray)),
        }
    }
}

impl Leaves for Watertight {
    const WATERTIGHT: bool = true;
    const REACH: f32 = Slabs::LIMIT;

    #[inline(always)]
    fn new() -> Self {
        Self { filter: None, exact: None, waiting: ArrayVec::new_const() }
    }

    #[inline(always)]
    fn test<const W: usize, Q: Pack<BLOCK>, G: Goal>(&mut self, wide: &WideBvh<W>, index: usize, search: &mut Search) {
        let filter = match &mut self.filter {
            Some(filter) => filter,
            none => none.insert(FilterRay::new(search.ray, search.slabs, wide.reach)),
        };
        let block = &wide.blocks[index];
        let sides = filter.sides::<Q>(block);
        let candidates = sides.candidates(block);
        if candidates != 0 {
            self.look_closer::<W, Q, G>(wide, index, &sides, candidates, search);
        }
    }

    #[inline(always)]
    fn settle<const W: usize>(&mut self, wide: &WideBvh<W>, search: &mut Search) {
        if !self.waiting.is_empty() {
            self.settle_all(wide, search);
        }
    }
}

/// Möller–Trumbore in f32, which ends there.
pub(in crate::trace) struct Fast;

impl Leaves for Fast {
    const WATERTIGHT: bool = false;
    // What overflows has no sign to pass a triangle by.
    const REACH: f32 = Slabs::PRODUCT_LIMIT;

    #[inline(always)]
    fn new() -> Self {
        Self
    }

    #[inline(always)]
    fn test<const W: usize, Q: Pack<BLOCK>, G: Goal>(&mut self, wide: &WideBvh<W>, index: usize, search: &mut Search) {
        let block = &wide.blocks[index];
        fast::<Q>(block, search.ray, |id, t| search.offer::<G>(id, t));
    }

    #[inline(always)]
    fn settle<const W: usize>(&mut self, _: &WideBvh<W>, _: &mut Search) {}
}

/// Möller–Trumbore in f32, four at a time: `hit` gets ids and t.
#[inline(always)]
fn fast<Q: Pack<BLOCK>>(block: &Block, ray: &Ray, mut hit: impl FnMut(u32, Option<f32>)) {
    let a = Three::<Q>::vertex(block, 0);
    let (d, o) = (Three::<Q>::splat(ray.direction), Three::<Q>::splat(ray.origin));
    let e1 = Three::<Q>::vertex(block, 1).minus(a);
    let e2 = Three::<Q>::vertex(block, 2).minus(a);
    let s = o.minus(a);
    let p = d.cross(e2);
    let q = s.cross(e1);
    let (det, u, v, t) = (e1.dot(p), s.dot(p), d.dot(q), e2.dot(q));
    // Most lanes fail by sign: u, v and det − u − v are of one sign inside. The few others are divided one by one.
    let zero = Q::splat(0.0);
    let w = det.minus(u).minus(v);
    let (least, greatest) = (u.lesser(v).lesser(w), u.greater(v).greater(w));
    let beside = least.below(zero) & zero.below(greatest);
    let mut inside = !beside & ((1 << block.count) - 1);
    if inside == 0 {
        return;
    }
    let mut lanes = [[0.0; BLOCK]; 4];
    det.store(&mut lanes[0]);
    u.store(&mut lanes[1]);
    v.store(&mut lanes[2]);
    t.store(&mut lanes[3]);
    while inside != 0 {
        let lane = inside.trailing_zeros() as usize;
        inside &= inside - 1;
        let [det, u, v, t] = lanes.map(|l| l[lane]);
        if !Triangle::F32_DETERMINANTS.contains(&det.abs()) {
            hit(block.ids[lane], block.triangle(lane).intersect(ray).filter(|t| t.is_finite()));
            continue;
        }
        let inverse = 1.0 / det;
        let (u, v, t) = (u * inverse, v * inverse, t * inverse);
        if (0.0..=1.0).contains(&u) && v >= 0.0 && u + v <= 1.0 && t >= ray.t_min && t <= ray.t_max && t.is_finite() {
            hit(block.ids[lane], Some(t));
        }
    }
}

/// Four vectors.
#[derive(Clone, Copy)]
struct Three<Q> {
    x: Q,
    y: Q,
    z: Q,
}

impl<Q: Pack<BLOCK>> Three<Q> {
    #[inline(always)]
    fn vertex(block: &Block, vertex: usize) -> Self {
        let [x, y, z] = &block.vertices[vertex];
        Self { x: Q::load(x), y: Q::load(y), z: Q::load(z) }
    }
    #[inline(always)]
    fn splat(v: glam::Vec3) -> Self {
        Self { x: Q::splat(v.x), y: Q::splat(v.y), z: Q::splat(v.z) }
    }
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self { x: self.x.minus(other.x), y: self.y.minus(other.y), z: self.z.minus(other.z) }
    }
    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Self {
            x: self.y.times(other.z).minus(other.y.times(self.z)),
            y: self.z.times(other.x).minus(other.z.times(self.x)),
            z: self.x.times(other.y).minus(other.x.times(self.y)),
        }
    }
    #[inline(always)]
    fn dot(self, other: Self) -> Q {
        self.x.times(other.x).plus(self.y.times(other.y)).plus(self.z.times(other.z))
    }
}
