//! What is done at a leaf: its triangles tested four at a time.

use super::layout::{BLOCK, Block};
use super::pack::Pack;
use super::pack64::Pack64;
use super::watertight;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::trace::closest::{Goal, accepted, held, improve};
use crate::trace::slab::{Slabs, pad_up};

/// How triangles are tested.
pub(in crate::trace) trait Leaves {
    /// Whether every hit is that of the f64 test.
    const WATERTIGHT: bool;

    /// The greatest coordinates, of scene and ray, that the test is for.
    const REACH: f32;

    /// Prepares for `ray`.
    fn new<G: Goal>(ray: &Ray) -> Self;

    /// Tests the triangles of a block, and keeps the better hit. `search.limit` falls where it may.
    fn test<Q: Pack<BLOCK>, D: Pack64, G: Goal>(&mut self, block: &Block, search: &mut Search);
}

/// A ray, and what is known of its hit.
pub(in crate::trace) struct Search<'a> {
    pub ray: &'a Ray,
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

/// The watertight test, in f64.
pub(in crate::trace) struct Watertight {
    /// Prepared when first needed where many rays come to no leaf.
    ray: Option<WatertightRay>,
}

#[cold]
#[inline(never)]
fn test_alone<G: Goal>(ray: &WatertightRay, block: &Block, lane: usize, search: &mut Search) {
    let t = accepted(ray, Slabs::of(search.ray), search.ray, &block.triangle(lane));
    search.offer::<G>(block.ids[lane], t);
}

impl Leaves for Watertight {
    const WATERTIGHT: bool = true;
    const REACH: f32 = Slabs::LIMIT;

    #[inline(always)]
    fn new<G: Goal>(ray: &Ray) -> Self {
        Self { ray: G::FIRST_IS_ENOUGH.then(|| WatertightRay::new(ray)) }
    }

    #[inline(always)]
    fn test<Q: Pack<BLOCK>, D: Pack64, G: Goal>(&mut self, block: &Block, search: &mut Search) {
        let ray = match &mut self.ray {
            Some(ray) => ray,
            none => none.insert(WatertightRay::new(search.ray)),
        };
        let found = watertight::test::<Q, D, G>(ray, search.ray, block);
        let mut lanes = found.surely | found.held | found.perhaps;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % BLOCK;
            lanes &= lanes - 1;
            if found.surely >> lane & 1 == 1 {
                search.offer::<G>(block.ids[lane], Some(found.t[lane]));
            } else if found.held >> lane & 1 == 1 {
                let t = held(found.t[lane], Slabs::of(search.ray), search.ray, &block.triangle(lane));
                search.offer::<G>(block.ids[lane], t);
            } else {
                test_alone::<G>(ray, block, lane, search);
            }
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
    fn new<G: Goal>(_: &Ray) -> Self {
        Self
    }

    #[inline(always)]
    fn test<Q: Pack<BLOCK>, D: Pack64, G: Goal>(&mut self, block: &Block, search: &mut Search) {
        fast::<Q>(block, search.ray, |id, t| search.offer::<G>(id, t));
    }
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
