//! The search, one body for every width and every set of instructions.

use super::filter::FilterRay;
use super::layout::{BLOCK, Block, LEAF, WideBvh, WideNode};
use super::pack::Pack;
#[cfg(any(test, not(target_arch = "x86_64")))]
use super::pack::Portable;
use crate::geom::{Hit, Ray, Triangle, WatertightRay};
use crate::simd::Simd;
use crate::trace::closest::{Goal, accepted, improve};
use crate::trace::probe::TraceProbe;
use crate::trace::scratch::{OpenNode, Scratch};
use crate::trace::slab::{ABSOLUTE, RELATIVE, Slabs, pad_up};

/// How triangles are tested.
pub(in crate::trace) trait Leaves {
    /// Whether every hit goes through the f64 test.
    const WATERTIGHT: bool;
}

/// A ray prepared for the boxes of `W` children.
pub(super) struct Boxes<P> {
    origin: [P; 3],
    inverse: [P; 3],
    /// Which of the two planes of each axis is met first.
    near: [usize; 3],
    t_min: P,
}

impl<P> Boxes<P> {
    #[inline(always)]
    pub(super) fn new<const W: usize>(slabs: &Slabs, ray: &Ray) -> Self
    where
        P: Pack<W>,
    {
        let (o, i) = (slabs.origin, slabs.inverse);
        Self {
            origin: [P::splat(o.x), P::splat(o.y), P::splat(o.z)],
            inverse: [P::splat(i.x), P::splat(i.y), P::splat(i.z)],
            near: <[bool; 3]>::from(slabs.negative).map(usize::from),
            t_min: P::splat(ray.t_min),
        }
    }

    /// Where the ray crosses one plane of every child.
    #[inline(always)]
    fn plane<const W: usize>(&self, node: &WideNode<W>, axis: usize, side: usize) -> P
    where
        P: Pack<W>,
    {
        P::load(&node.bounds[axis][side]).minus(self.origin[axis]).times(self.inverse[axis])
    }

    /// The children met before `limit`, a bit each, and where they are entered.
    #[inline(always)]
    pub(super) fn met<const W: usize>(&self, node: &WideNode<W>, limit: P) -> (u32, P)
    where
        P: Pack<W>,
    {
        let [sx, sy, sz] = self.near;
        let (near_x, far_x) = (self.plane(node, 0, sx), self.plane(node, 0, 1 - sx));
        let (near_y, far_y) = (self.plane(node, 1, sy), self.plane(node, 1, 1 - sy));
        let (near_z, far_z) = (self.plane(node, 2, sz), self.plane(node, 2, 1 - sz));
        let entry = near_z.greater(near_y.greater(near_x.greater(P::splat(f32::NEG_INFINITY))));
        let exit = far_z.lesser(far_y.lesser(far_x.lesser(P::splat(f32::INFINITY))));
        // The greater of both is `pad_up`, whatever the sign.
        let padded = exit.times(P::splat(1.0 + RELATIVE)).greater(exit.times(P::splat(1.0 - RELATIVE)));
        let exit = padded.plus(P::splat(ABSOLUTE));
        (entry.at_most(exit) & self.t_min.at_most(exit) & entry.at_most(limit), entry)
    }
}

#[inline(always)]
fn search<const W: usize, P: Pack<W>, Q: Pack<BLOCK>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Option<Hit> {
    let boxes = Boxes::<P>::new(slabs, ray);
    let filter = FilterRay::new(ray, &wide.bounds);
    let mut exact: Option<WatertightRay> = None;
    if scratch.open.len() < wide.most_open {
        scratch.open.resize(wide.most_open, OpenNode { entry: 0.0, node: 0 });
    }
    let open = &mut scratch.open[..];
    let mut top = 0;
    let mut best: Option<Hit> = None;
    // Nodes entered at exactly the best t stay open: they may hold a lower id.
    let mut limit = pad_up(ray.t_max);
    let mut at = 0u32;
    loop {
        probe.node();
        if at & LEAF == 0 {
            let node = &wide.nodes[at as usize];
            (0..node.count).for_each(|_| probe.box_test());
            let (mut met, entry) = boxes.met(node, P::splat(limit));
            if met != 0 {
                let first = met.trailing_zeros() as usize;
                met &= met - 1;
                if met == 0 {
                    at = node.child[first];
                    continue;
                }
                let mut entries = [0.0; W];
                entry.store(&mut entries);
                // The nearest is entered next; of the others, the nearest comes to the top. Among equals the first.
                let mut next = OpenNode { entry: entries[first], node: node.child[first] };
                let start = top;
                while met != 0 {
                    let lane = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let mut other = OpenNode { entry: entries[lane], node: node.child[lane] };
                    if other.entry < next.entry {
                        std::mem::swap(&mut other, &mut next);
                    }
                    let mut i = top;
                    while i > start && open[i - 1].entry < other.entry {
                        open[i] = open[i - 1];
                        i -= 1;
                    }
                    open[i] = other;
                    top += 1;
                }
                at = next.node;
                continue;
            }
        } else {
            let mut index = (at & !LEAF) as usize;
            loop {
                let block = &wide.blocks[index];
                (0..block.count).for_each(|_| probe.triangle_test());
                let better = if L::WATERTIGHT {
                    watertight::<Q>(block, ray, slabs, &filter, &mut exact, &mut best)
                } else {
                    fast::<Q>(block, ray, &mut best)
                };
                if better {
                    if G::FIRST_IS_ENOUGH {
                        return best;
                    }
                    limit = best.map_or(limit, |b| pad_up(b.t));
                }
                if !block.more {
                    break;
                }
                index += 1;
            }
        }
        loop {
            if top == 0 {
                return best;
            }
            top -= 1;
            if open[top].entry <= limit {
                at = open[top].node;
                break;
            }
        }
    }
}

/// The f32 filter, then the f64 test for what passes it; whether `best` became better.
#[inline(always)]
fn watertight<Q: Pack<BLOCK>>(
    block: &Block,
    ray: &Ray,
    slabs: &Slabs,
    filter: &FilterRay,
    exact: &mut Option<WatertightRay>,
    best: &mut Option<Hit>,
) -> bool {
    let mut candidates = filter.candidates::<Q>(block);
    let mut better = false;
    while candidates != 0 {
        let lane = candidates.trailing_zeros() as usize;
        candidates &= candidates - 1;
        let test = exact.get_or_insert_with(|| WatertightRay::new(ray));
        let t = accepted(test, *slabs, ray, &block.triangle(lane));
        better |= improve(best, block.ids[lane], t);
    }
    better
}

/// Möller–Trumbore in f32, four at a time; whether `best` became better.
#[inline(always)]
fn fast<Q: Pack<BLOCK>>(block: &Block, ray: &Ray, best: &mut Option<Hit>) -> bool {
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
        return false;
    }
    let mut lanes = [[0.0; BLOCK]; 4];
    det.store(&mut lanes[0]);
    u.store(&mut lanes[1]);
    v.store(&mut lanes[2]);
    t.store(&mut lanes[3]);
    let mut better = false;
    while inside != 0 {
        let lane = inside.trailing_zeros() as usize;
        inside &= inside - 1;
        let [det, u, v, t] = lanes.map(|l| l[lane]);
        if !Triangle::F32_DETERMINANTS.contains(&det.abs()) {
            better |= improve(best, block.ids[lane], block.triangle(lane).intersect(ray).filter(|t| t.is_finite()));
            continue;
        }
        let inverse = 1.0 / det;
        let (u, v, t) = (u * inverse, v * inverse, t * inverse);
        if (0.0..=1.0).contains(&u) && v >= 0.0 && u + v <= 1.0 && t >= ray.t_min && t <= ray.t_max && t.is_finite() {
            better |= improve(best, block.ids[lane], Some(t));
        }
    }
    better
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

/// The search by the instructions of `level`.
#[inline]
pub(in crate::trace) fn wide_hit<const W: usize, G: Goal, L: Leaves, Pr: TraceProbe>(
    level: Simd,
    wide: &WideBvh<W>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Option<Hit>
where
    Instructions: For<W>,
{
    <Instructions as For<W>>::search::<G, L, Pr>(level, wide, ray, slabs, scratch, probe)
}

/// The sets of instructions that there are for a width.
pub(in crate::trace) struct Instructions;

/// A width that kernels are made for.
pub(in crate::trace) trait For<const W: usize> {
    /// The search, by `level`.
    fn search<G: Goal, L: Leaves, Pr: TraceProbe>(
        level: Simd,
        wide: &WideBvh<W>,
        ray: &Ray,
        slabs: &Slabs,
        scratch: &mut Scratch,
        probe: &mut Pr,
    ) -> Option<Hit>;
}

#[cfg(target_arch = "x86_64")]
use super::pack::{Avx, Sse, TwoSse};

impl For<4> for Instructions {
    #[inline]
    fn search<G: Goal, L: Leaves, Pr: TraceProbe>(
        _level: Simd,
        wide: &WideBvh<4>,
        ray: &Ray,
        slabs: &Slabs,
        scratch: &mut Scratch,
        probe: &mut Pr,
    ) -> Option<Hit> {
        #[cfg(target_arch = "x86_64")]
        return search::<4, Sse, Sse, G, L, Pr>(wide, ray, slabs, scratch, probe);
        #[cfg(not(target_arch = "x86_64"))]
        search::<4, Portable<4>, Portable<4>, G, L, Pr>(wide, ray, slabs, scratch, probe)
    }
}

impl For<8> for Instructions {
    #[inline]
    fn search<G: Goal, L: Leaves, Pr: TraceProbe>(
        level: Simd,
        wide: &WideBvh<8>,
        ray: &Ray,
        slabs: &Slabs,
        scratch: &mut Scratch,
        probe: &mut Pr,
    ) -> Option<Hit> {
        #[cfg(target_arch = "x86_64")]
        {
            if level >= Simd::Avx2 {
                // SAFETY: the level says that AVX2 is there.
                return unsafe { search_avx2::<G, L, Pr>(wide, ray, slabs, scratch, probe) };
            }
            search::<8, TwoSse, Sse, G, L, Pr>(wide, ray, slabs, scratch, probe)
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            let _ = level;
            search::<8, Portable<8>, Portable<4>, G, L, Pr>(wide, ray, slabs, scratch, probe)
        }
    }
}

/// # Safety
/// The processor has AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn search_avx2<G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<8>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Option<Hit> {
    search::<8, Avx, Sse, G, L, Pr>(wide, ray, slabs, scratch, probe)
}

/// The scalar twin, for tests.
#[cfg(test)]
pub(super) fn twin<const W: usize, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Option<Hit> {
    search::<W, Portable<W>, Portable<4>, G, L, Pr>(wide, ray, slabs, scratch, probe)
}
