//! All hits of a ray by the wide layout: see `trace/gather.rs` for what they are.
//!
//! Boxes and candidates are tested as many at a time as by the search for the closest hit; with every triangle tested in the end
//! by the same test, the hits are the same for every width and every set of instructions.

use super::instructions::{Baseline, Best, Instructions};
use super::layout::{BLOCK, LEAF, WideBvh};
use super::leaf::Leaves;
use super::node::Node;
use super::pack::Pack;
use super::search::Boxes;
use super::watertight;
use crate::geom::{Hit, Ray, WatertightRay};
use crate::simd::Simd;
use crate::trace::closest::{Closest, accepted};
use crate::trace::probe::TraceProbe;
use crate::trace::scratch::{OpenNode, Scratch};
use crate::trace::slab::{Slabs, pad_up};

/// Adds every hit to `hits`, in the order of the layout, a triangle as often as it stands in leaves.
#[inline(always)]
fn gather<const W: usize, I: Instructions<W>, N: Node<W>, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) {
    let boxes = Boxes::<I::Children>::new(slabs, ray);
    let exact = WatertightRay::new(ray);
    let limit = I::Children::splat(pad_up(ray.t_max));
    let open = &mut scratch.open;
    open.clear();
    open.push(OpenNode { entry: f32::NEG_INFINITY, node: 0 });
    while let Some(OpenNode { node: at, .. }) = open.pop() {
        probe.node();
        if at & LEAF == 0 {
            let node = &wide.nodes[at as usize];
            (0..node.count()).for_each(|_| probe.box_test());
            let (entry, exit) = boxes.interval(node, limit);
            let mut met = entry.at_most(exit);
            while met != 0 {
                open.push(OpenNode { entry: f32::NEG_INFINITY, node: node.child()[met.trailing_zeros() as usize] });
                met &= met - 1;
            }
            continue;
        }
        let mut index = (at & !LEAF) as usize;
        loop {
            let block = &wide.blocks[index];
            (0..block.count).for_each(|_| probe.triangle_test());
            let (mut lanes, surely, known) = if L::WATERTIGHT {
                let found = watertight::test::<I::Four, I::Four64, Closest>(&exact, ray, block);
                (found.surely | found.held | found.perhaps, found.surely, found.t)
            } else {
                ((1 << block.count) - 1, 0, [0.0; BLOCK])
            };
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize % BLOCK;
                lanes &= lanes - 1;
                let t = if surely >> lane & 1 == 1 {
                    Some(known[lane])
                } else if L::WATERTIGHT {
                    accepted(&exact, *slabs, ray, &block.triangle(lane))
                } else {
                    block.triangle(lane).intersect(ray).filter(|t| t.is_finite())
                };
                hits.extend(t.map(|t| Hit { triangle: block.ids[lane], t }));
            }
            if !block.more {
                break;
            }
            index += 1;
        }
    }
}

/// Every hit, by the instructions of `level`.
pub(in crate::trace) fn wide_all_hits<const W: usize, N: Node<W>, L: Leaves, Pr: TraceProbe>(
    level: Simd,
    wide: &WideBvh<W, N>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) where
    Baseline: Instructions<W>,
    Best: Instructions<W>,
{
    if level >= Simd::Avx2 {
        // SAFETY: the level says that AVX2 is there.
        unsafe { gather_best::<W, N, L, Pr>(wide, ray, slabs, scratch, probe, hits) }
    } else {
        gather::<W, Baseline, N, L, Pr>(wide, ray, slabs, scratch, probe, hits);
    }
}

/// # Safety
/// On x86-64 the processor is of level [`Simd::Avx2`].
#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt"))]
unsafe fn gather_best<const W: usize, N: Node<W>, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) where
    Best: Instructions<W>,
{
    gather::<W, Best, N, L, Pr>(wide, ray, slabs, scratch, probe, hits);
}
