//! The search, one body for every width and every set of instructions.

#[cfg(test)]
use super::instructions::Plain;
use super::instructions::{Baseline, Best, Instructions};
use super::layout::{LEAF, WideBvh};
use super::leaf::{Leaves, Search};
use super::node::{Node, Side};
use super::order::Push;
use super::pack::Pack;
use crate::geom::{Hit, Ray};
use crate::simd::Simd;
use crate::trace::closest::Goal;
use crate::trace::hits::HitRecord;
use crate::trace::probe::TraceProbe;
use crate::trace::scratch::{Scratch, Stack};
use crate::trace::slab::{ABSOLUTE, Slabs, pad_up};
use std::marker::PhantomData;

/// Along which axes the ray falls, a bit each.
#[inline(always)]
pub(super) fn octant(slabs: &Slabs) -> usize {
    slabs.negative.bitmask() as usize % 8
}

/// A ray prepared for the boxes of `W` children.
pub(super) struct Boxes<P> {
    origin: [P; 3],
    inverse: [P; 3],
    padded: [P; 3],
    /// Which of the two planes of each axis is met first, and which last.
    near: [Side; 3],
    far: [Side; 3],
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
            near: [0, 1, 2].map(|axis| if octant(slabs) >> axis & 1 == 1 { Side::Upper } else { Side::Lower }),
            far: [0, 1, 2].map(|axis| if octant(slabs) >> axis & 1 == 1 { Side::Lower } else { Side::Upper }),
            t_min: P::splat(ray.t_min),
        }
    }

    /// Where the ray, within its own interval up to `limit`, enters and leaves the children's boxes: those are met that it
    /// enters before it leaves them.
    #[inline(always)]
    pub(super) fn interval<const W: usize, N: Node<W>>(&self, node: &N, limit: P) -> (P, P)
    where
        P: Pack<W>,
    {
        let plane = |axis: usize, side: Side, inverse: &[P; 3]| {
            node.planes::<P>(axis, side).minus(self.origin[axis]).times(inverse[axis])
        };
        let near = |axis: usize| plane(axis, self.near[axis], &self.inverse);
        let far = |axis: usize| plane(axis, self.far[axis], &self.padded);
        let entry = near(2).greater(near(1).greater(near(0).greater(self.t_min)));
        let exit = far(2).lesser(far(1).lesser(far(0).lesser(node.ends())));
        (entry, exit.plus(P::splat(ABSOLUTE)).lesser(limit))
    }
}

/// A ray on its way through the tree.
struct Flight<'a, const W: usize, I: Instructions<W>, G, L> {
    /// Which ray it is, of many.
    place: usize,
    search: Search<'a>,
    boxes: Boxes<I::Children>,
    octant: usize,
    leaves: L,
    /// The node or leaf to look at next.
    at: u32,
    /// How much is on the stack.
    top: usize,
    goal: PhantomData<G>,
}

impl<'a, const W: usize, I: Instructions<W>, G: Goal, L: Leaves> Flight<'a, W, I, G, L> {
    /// Room for a ray, any one.
    #[inline(always)]
    fn idle(ray: &'a Ray) -> Self {
        Self {
            place: 0,
            boxes: Boxes::new(&Slabs::IDLE, ray),
            octant: 0,
            leaves: L::new::<G>(ray),
            search: Search { ray, best: None, limit: 0.0, done: false },
            at: 0,
            top: 0,
            goal: PhantomData,
        }
    }

    /// Prepares `ray` at the root.
    #[inline(always)]
    fn start<N>(&mut self, wide: &WideBvh<W, N>, ray: &'a Ray) -> Result<(), OutOfRange> {
        let slabs = Slabs::within(ray, wide.reach, L::REACH).ok_or(OutOfRange)?;
        self.boxes = Boxes::new(&slabs, ray);
        self.octant = octant(&slabs);
        self.leaves = L::new::<G>(ray);
        // Nodes entered at exactly the best t stay open: they may hold a lower id.
        self.search = Search { ray, best: None, limit: pad_up(ray.t_max), done: false };
        self.at = 0;
        self.top = 0;
        Ok(())
    }

    /// Looks at one node or leaf; whether the search is at its end then.
    #[inline(always)]
    fn step<N: Node<W>, Pr: TraceProbe>(&mut self, wide: &WideBvh<W, N>, stack: &mut Stack, probe: &mut Pr) -> bool {
        probe.node();
        if self.at & LEAF == 0 {
            if let Some(nearest) = self.node(wide, stack, probe) {
                self.go_on(wide, nearest);
                return false;
            }
        } else {
            self.leaf(wide, probe);
            if self.search.done {
                return true;
            }
        }
        while self.top > 0 {
            self.top -= 1;
            if stack.entries[self.top] <= self.search.limit {
                self.go_on(wide, stack.names[self.top]);
                return false;
            }
        }
        true
    }

    #[inline(always)]
    fn go_on<N>(&mut self, wide: &WideBvh<W, N>, next: u32) {
        self.at = next;
        wide.fetch(next);
    }

    /// Looks at the node where the search is: children that are met go on the stack, the nearest is returned.
    #[inline(always)]
    fn node<N: Node<W>, Pr: TraceProbe>(
        &mut self,
        wide: &WideBvh<W, N>,
        stack: &mut Stack,
        probe: &mut Pr,
    ) -> Option<u32> {
        // SAFETY: children that are no leaves are places in `nodes`, see `WideBvh::new`.
        let node = unsafe { wide.nodes.get_unchecked(self.at as usize) };
        (0..node.count()).for_each(|_| probe.box_test());
        let (entry, exit) = self.boxes.interval(node, I::Children::splat(self.search.limit));
        // SAFETY: `most_open` has room for all children of a node behind what a search has open.
        let (entries, names) = unsafe { stack.room_behind(self.top) };
        let (pushed, nearest) = I::Order::push(
            entry,
            exit,
            node.child(),
            node.order()[self.octant % 8],
            G::FIRST_IS_ENOUGH,
            entries,
            names,
        )?;
        self.top += pushed;
        Some(nearest)
    }

    /// Looks at the leaf where the search is.
    #[inline(always)]
    fn leaf<N, Pr: TraceProbe>(&mut self, wide: &WideBvh<W, N>, probe: &mut Pr) {
        let mut index = (self.at & !LEAF) as usize;
        loop {
            let block = &wide.blocks[index];
            (0..block.count).for_each(|_| probe.triangle_test());
            self.leaves.test::<I::Four, I::Four64, G>(block, &mut self.search);
            if self.search.done || !block.more {
                return;
            }
            index += 1;
        }
    }
}

#[inline(always)]
fn search<const W: usize, I: Instructions<W>, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange> {
    let mut flight = Flight::<W, I, G, L>::idle(ray);
    flight.start(wide, ray)?;
    let [mut stack] = scratch.stacks(wide.most_open);
    while !flight.step(wide, &mut stack, probe) {}
    Ok(flight.search.best)
}

/// The answers to `rays`, those of [`search`], and which rays are [`OutOfRange`].
///
/// Two rays are on their way at once: while one waits for memory, or for the end of a chain of instructions that each need
/// the last one's result, the processor goes on with the other.
#[inline(always)]
fn search_all<const W: usize, I: Instructions<W>, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    rays: &[Ray],
    answers: &mut [HitRecord],
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Vec<usize> {
    let mut out_of_range = Vec::new();
    let Some(first) = rays.first() else { return out_of_range };
    let [mut stack, mut other_stack] = scratch.stacks(wide.most_open);
    let [mut flight, mut other] = [(); 2].map(|()| Flight::<W, I, G, L>::idle(first));
    let mut waiting = Waiting { rays, next: 0, out_of_range: &mut out_of_range };
    let mut flying = [waiting.start(&mut flight, wide), waiting.start(&mut other, wide)];
    while flying == [true, true] {
        // Twice the same in words, not in a loop: so the compiler knows where each of the two is.
        if flight.step(wide, &mut stack, probe) {
            answers[flight.place] = flight.search.best.into();
            flying[0] = waiting.start(&mut flight, wide);
        }
        if other.step(wide, &mut other_stack, probe) {
            answers[other.place] = other.search.best.into();
            flying[1] = waiting.start(&mut other, wide);
        }
    }
    for (flying, mut flight, mut stack) in [(flying[0], flight, stack), (flying[1], other, other_stack)] {
        if flying {
            while !flight.step(wide, &mut stack, probe) {}
            answers[flight.place] = flight.search.best.into();
        }
    }
    out_of_range
}

/// Rays not yet on their way.
struct Waiting<'a> {
    rays: &'a [Ray],
    next: usize,
    /// Those passed over.
    out_of_range: &'a mut Vec<usize>,
}

impl<'a> Waiting<'a> {
    /// Sends the next ray on its way, if there is one.
    #[inline(always)]
    fn start<const W: usize, I: Instructions<W>, G: Goal, L: Leaves, N>(
        &mut self,
        flight: &mut Flight<'a, W, I, G, L>,
        wide: &WideBvh<W, N>,
    ) -> bool {
        while let Some(ray) = self.rays.get(self.next) {
            flight.place = self.next;
            self.next += 1;
            if flight.start(wide, ray).is_ok() {
                return true;
            }
            self.out_of_range.push(flight.place);
        }
        false
    }
}

/// What there is to say of a ray that f32 cannot trace, or nothing can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::trace) struct OutOfRange;

/// The search by the instructions of `level`.
#[inline]
pub(in crate::trace) fn wide_hit<const W: usize, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    level: Simd,
    wide: &WideBvh<W, N>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange>
where
    Baseline: Instructions<W>,
    Best: Instructions<W>,
{
    if level >= Simd::Avx2 {
        // SAFETY: the level says that AVX2 is there.
        return unsafe { search_best::<W, N, G, L, Pr>(wide, ray, scratch, probe) };
    }
    search::<W, Baseline, N, G, L, Pr>(wide, ray, scratch, probe)
}

/// Many searches by the instructions of `level`: one answer a ray, in `answers`. Returns the places of rays that are
/// [`OutOfRange`] and have none.
pub(in crate::trace) fn wide_hits<const W: usize, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    level: Simd,
    wide: &WideBvh<W, N>,
    rays: &[Ray],
    answers: &mut [HitRecord],
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Vec<usize>
where
    Baseline: Instructions<W>,
    Best: Instructions<W>,
{
    if level >= Simd::Avx2 {
        // SAFETY: the level says that AVX2 is there.
        return unsafe { search_all_best::<W, N, G, L, Pr>(wide, rays, answers, scratch, probe) };
    }
    search_all::<W, Baseline, N, G, L, Pr>(wide, rays, answers, scratch, probe)
}

/// # Safety
/// On x86-64 the processor is of level [`Simd::Avx2`].
#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt"))]
unsafe fn search_best<const W: usize, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange>
where
    Best: Instructions<W>,
{
    search::<W, Best, N, G, L, Pr>(wide, ray, scratch, probe)
}

/// # Safety
/// On x86-64 the processor is of level [`Simd::Avx2`].
#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt"))]
unsafe fn search_all_best<const W: usize, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    rays: &[Ray],
    answers: &mut [HitRecord],
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Vec<usize>
where
    Best: Instructions<W>,
{
    search_all::<W, Best, N, G, L, Pr>(wide, rays, answers, scratch, probe)
}

/// The scalar twin, for tests.
#[cfg(test)]
pub(super) fn twin<const W: usize, N: Node<W>, G: Goal, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    ray: &Ray,
    scratch: &mut Scratch,
    probe: &mut Pr,
) -> Result<Option<Hit>, OutOfRange> {
    search::<W, Plain, N, G, L, Pr>(wide, ray, scratch, probe)
}
