//! All hits of a ray by the wide layout: see `trace/gather.rs` for what they are.
//!
//! Boxes and candidates are tested as many at a time as by the search for the closest hit; with every triangle tested in the end
//! by the same test, the hits are the same for every width and every set of instructions.

use super::layout::{BLOCK, LEAF, WideBvh};
use super::leaf::Leaves;
use super::node::Node;
use super::pack::Pack;
#[cfg(not(target_arch = "x86_64"))]
use super::pack::Portable;
#[cfg(target_arch = "x86_64")]
use super::pack::{Avx, Sse, TwoSse};
use super::pack64::Pack64;
#[cfg(not(target_arch = "x86_64"))]
use super::pack64::Portable64;
#[cfg(target_arch = "x86_64")]
use super::pack64::{Avx64, TwoSse64};
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
fn gather<const W: usize, N: Node<W>, P: Pack<W>, Q: Pack<BLOCK>, D: Pack64, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<W, N>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) {
    let boxes = Boxes::<P>::new(slabs, ray);
    let exact = WatertightRay::new(ray);
    let limit = P::splat(pad_up(ray.t_max));
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
                let found = watertight::test::<Q, D, Closest>(&exact, ray, block);
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

/// Four boxes at a time.
pub(in crate::trace) fn all_by_four<L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<4>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) {
    #[cfg(target_arch = "x86_64")]
    gather::<4, _, Sse, Sse, TwoSse64, L, Pr>(wide, ray, slabs, scratch, probe, hits);
    #[cfg(not(target_arch = "x86_64"))]
    gather::<4, _, Portable<4>, Portable<4>, Portable64, L, Pr>(wide, ray, slabs, scratch, probe, hits);
}

/// Eight boxes at a time, by the instructions of `level`.
pub(in crate::trace) fn all_by_eight<N: Node<8>, L: Leaves, Pr: TraceProbe>(
    level: Simd,
    wide: &WideBvh<8, N>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) {
    #[cfg(target_arch = "x86_64")]
    if level >= Simd::Avx2 {
        // SAFETY: the level says that AVX2 is there.
        unsafe { all_by_avx2::<N, L, Pr>(wide, ray, slabs, scratch, probe, hits) }
    } else {
        gather::<8, N, TwoSse, Sse, TwoSse64, L, Pr>(wide, ray, slabs, scratch, probe, hits);
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = level;
        gather::<8, N, Portable<8>, Portable<4>, Portable64, L, Pr>(wide, ray, slabs, scratch, probe, hits);
    }
}

/// # Safety
/// The processor has AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn all_by_avx2<N: Node<8>, L: Leaves, Pr: TraceProbe>(
    wide: &WideBvh<8, N>,
    ray: &Ray,
    slabs: &Slabs,
    scratch: &mut Scratch,
    probe: &mut Pr,
    hits: &mut Vec<Hit>,
) {
    gather::<8, N, Avx, Sse, Avx64, L, Pr>(wide, ray, slabs, scratch, probe, hits);
}
