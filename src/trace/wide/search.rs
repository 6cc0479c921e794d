//! The search, one body for every width and every set of instructions.

use super::layout::{BLOCK, LEAF, NONE, WideBvh, WideNode};
use super::leaf::{Leaves, Search};
#[cfg(target_arch = "x86_64")]
use super::order::ByPermutation;
use super::order::{ByEach, Push};
use super::pack::Pack;
#[cfg(any(test, not(target_arch = "x86_64")))]
use super::pack::Portable;
use crate::geom::{Hit, Ray};
use crate::simd::Simd;
use crate::trace::closest::Goal;
use crate::trace::probe::TraceProbe;
use crate::trace::scratch::Scratch;
use crate::trace::slab::{ABSOLUTE, Slabs, pad_up};

/// Along which axes the ray falls, a bit each.
#[inline(always)]
fn octant(slabs: &Slabs) -> usize {
    slabs.negative.bitmask() as usize % 8
}

/// A ray prepared for the boxes of `W` children.
pub(super) struct Boxes<P> {
    origin: [P; 3],
    inverse: [P; 3],
    padded: [P; 3],
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
        let each = |v: glam::Vec3A| [P::splat(v.x), P::splat(v.y), P::splat(v.z)];
        Self {
            origin: each(slabs.origin),
            inverse: each(slabs.inverse),
            padded: each(slabs.padded),
            near: [0, 1, 2].map(|axis| octant(slabs) >> axis & 1),
            t_min: P::splat(ray.t_min),
        }
    }

    /// Where the ray, within its own interval up to `limit`, enters and leaves the children's boxes: those are met that it
    /// enters before it leaves them.
    #[inline(always)]
    pub(super) fn interval<const W: usize>(&self, node: &WideNode<W>, limit: P) -> (P, P)
    where
        P: Pack<W>,
    {
        let plane = |axis: usize, side: usize, inverse: &[P; 3]| {
            P::load(&node.bounds[axis][side]).minus(self.origin[axis]).times(inverse[axis])
        };
        let near = |axis: usize| plane(axis, self.near[axis], &self.inverse);
        let far = |axis: usize| plane(axis, 1 - self.near[axis], &self.padded);
        let entry = near(2).greater(near(1).greater(near(0).greater(self.t_min)));
        let exit = far(2).lesser(far(1).lesser(far(0).lesser(P::splat(f32::INFINITY))));
        (entry, exit.plus(P::splat(ABSOLUTE)).lesser(limit))
    }
}

#[inline(always)]
fn search<const W: usize, P: Pack<W>, O: Push<W, P>, Q: Pack<BLOCK>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange> {
    let slabs = &Slabs::within(ray, wide.reach, L::REACH).ok_or(OutOfRange)?;
    let boxes = Boxes::<P>::new(slabs, ray);
    let octant = octant(slabs);
    let mut leaves = L::new();
    // Nodes entered at exactly the best t stay open: they may hold a lower id.
    let mut search = Search { ray, slabs, best: None, limit: pad_up(ray.t_max), done: false };
    if scratch.entries.len() < wide.most_open {
        scratch.entries.resize(wide.most_open, 0.0);
        scratch.names.resize(wide.most_open, 0);
    }
    let (entries, names) = (&mut scratch.entries[..], &mut scratch.names[..]);
    let mut top = 0;
    let mut at = 0u32;
    loop {
        probe.node();
        if at & LEAF == 0 {
            // SAFETY: children that are no leaves are places in `nodes`, see `WideBvh::new`.
            let node = unsafe { wide.nodes.get_unchecked(at as usize) };
            (0..node.count()).for_each(|_| probe.box_test());
            let (entry, exit) = boxes.interval(node, P::splat(search.limit));
            let order = node.order[octant];
            // SAFETY: `most_open` has room for all children of a node behind what a search has open.
            let (entries, names) = unsafe {
                (
                    &mut *entries.as_mut_ptr().add(top).cast::<[f32; W]>(),
                    &mut *names.as_mut_ptr().add(top).cast::<[u32; W]>(),
                )
            };
            let (pushed, nearest) = O::push(entry, exit, &node.child, order, entries, names);
            top += pushed;
            if nearest != NONE {
                at = nearest;
                continue;
            }
        } else {
            let mut index = (at & !LEAF) as usize;
            loop {
                let block = &wide.blocks[index];
                (0..block.count).for_each(|_| probe.triangle_test());
                leaves.test::<W, Q, G>(wide, index, &mut search);
                if search.done {
                    return Ok(search.best);
                }
                if !block.more {
                    break;
                }
                index += 1;
            }
        }
        loop {
            if top == 0 {
                leaves.settle(wide, &mut search);
                return Ok(search.best);
            }
            top -= 1;
            if entries[top] <= search.limit {
                at = names[top];
                break;
            }
        }
    }
}

/// What there is to say of a ray that f32 cannot trace, or nothing can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::trace) struct OutOfRange;

/// The search by the instructions of `level`.
#[inline]
pub(in crate::trace) fn wide_hit<const W: usize, G: Goal, L: Leaves, Pr: TraceProbe>(
    level: Simd,
    wide: &WideBvh<W>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange>
where
    Instructions: For<W>,
{
    <Instructions as For<W>>::search::<G, L, Pr>(level, wide, ray, scratch, probe)
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
        scratch: &mut Scratch,
        probe: &mut Pr,
    ) -> Result<Option<Hit>, OutOfRange>;
}

#[cfg(target_arch = "x86_64")]
use super::pack::{Avx, Sse, TwoSse};

impl For<4> for Instructions {
    #[inline]
    fn search<G: Goal, L: Leaves, Pr: TraceProbe>(
        level: Simd,
        wide: &WideBvh<4>,
        ray: &Ray,
        scratch: &mut Scratch,
        probe: &mut Pr,
    ) -> Result<Option<Hit>, OutOfRange> {
        #[cfg(target_arch = "x86_64")]
        {
            if level >= Simd::Avx2 {
                // SAFETY: the level says that AVX2 is there.
                return unsafe { search_avx2::<4, Sse, G, L, Pr>(wide, ray, scratch, probe) };
            }
            search::<4, Sse, ByEach, Sse, G, L, Pr>(wide, ray, scratch, probe)
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            let _ = level;
            search::<4, Portable<4>, ByEach, Portable<4>, G, L, Pr>(wide, ray, scratch, probe)
        }
    }
}

impl For<8> for Instructions {
    #[inline]
    fn search<G: Goal, L: Leaves, Pr: TraceProbe>(
        level: Simd,
        wide: &WideBvh<8>,
        ray: &Ray,
        scratch: &mut Scratch,
        probe: &mut Pr,
    ) -> Result<Option<Hit>, OutOfRange> {
        #[cfg(target_arch = "x86_64")]
        {
            if level >= Simd::Avx2 {
                // SAFETY: the level says that AVX2 is there.
                return unsafe { search_avx2::<8, Avx, G, L, Pr>(wide, ray, scratch, probe) };
            }
            search::<8, TwoSse, ByEach, Sse, G, L, Pr>(wide, ray, scratch, probe)
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            let _ = level;
            search::<8, Portable<8>, ByEach, Portable<4>, G, L, Pr>(wide, ray, scratch, probe)
        }
    }
}

/// # Safety
/// The processor is of level [`Simd::Avx2`].
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn search_avx2<const W: usize, P: Pack<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange>
where
    ByPermutation: Push<W, P>,
{
    search::<W, P, ByPermutation, Sse, G, L, Pr>(wide, ray, scratch, probe)
}

/// The scalar twin, for tests.
#[cfg(test)]
pub(super) fn twin<const W: usize, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange> {
    search::<W, Portable<W>, ByEach, Portable<4>, G, L, Pr>(wide, ray, scratch, probe)
}
