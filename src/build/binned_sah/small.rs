//! Subtrees over at most four references: the cheapest of all there are.

use super::lanes::Lanes;
use crate::bvh::Node;
use crate::geom::Aabb;

/// The most references that are looked at in every way.
pub(super) const SMALL: usize = 4;

/// Writes the cheapest subtree over `N` references to node `index` and behind the last node; its leaves take the slots
/// from `slot`, which `ids` stands for. Returns the number of splits costed.
///
/// A set of references is a mask. Its best subtree is a leaf, if the limit allows, or the cheapest of its splits, each
/// with the best subtrees of both sides. Of equals the leaf, then the first split by the mask of the side without the
/// first reference.
#[inline(always)]
pub(super) fn write<const N: usize>(
    references: &[Lanes; N],
    max_leaf: usize,
    index: usize,
    slot: usize,
    ids: &mut [u32],
    nodes: &mut Vec<Node>,
) -> u64 {
    const { assert!(1 <= N && N <= SMALL) };
    let mut boxes = [Lanes::EMPTY; 1 << SMALL];
    let mut costs = [0.0f32; 1 << SMALL];
    // The side with the first reference; 0 where the set is a leaf.
    let mut splits = [0usize; 1 << SMALL];
    let mut costed = 0;
    for set in 1usize..1 << N {
        let first = set & set.wrapping_neg();
        let rest = set ^ first;
        let one = &references[set.trailing_zeros() as usize];
        if rest == 0 {
            boxes[set] = *one;
            costs[set] = one.half_area();
            continue;
        }
        boxes[set] = boxes[rest].union(one);
        let area = boxes[set].half_area();
        let (mut best, mut split) = (f32::INFINITY, 0);
        for other in 1usize..=rest {
            if other & !rest == 0 {
                costed += 1;
                let cost = costs[set ^ other] + costs[other];
                if cost < best {
                    (best, split) = (cost, set ^ other);
                }
            }
        }
        let count = set.count_ones();
        let as_leaf = area * count as f32;
        let open = area + best;
        let closes = count as usize <= max_leaf && as_leaf <= open;
        (costs[set], splits[set]) = if closes { (as_leaf, 0) } else { (open, split) };
    }
    let mut pending = [(0, 0); SMALL];
    pending[0] = (index, (1usize << N) - 1);
    let (mut height, mut taken) = (1, 0);
    while height > 0 {
        height -= 1;
        let (index, set) = pending[height];
        let split = splits[set];
        if split == 0 {
            let first = taken;
            for (i, reference) in references.iter().enumerate() {
                if set >> i & 1 == 1 {
                    ids[taken] = reference.tag();
                    taken += 1;
                }
            }
            nodes[index] = Node::leaf(boxes[set].aabb(), slot + first, taken - first);
        } else {
            let first = nodes.len();
            nodes[index] = Node::inner(boxes[set].aabb(), first, 2);
            nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
            pending[height] = (first + 1, set ^ split);
            pending[height + 1] = (first, split);
            height += 2;
        }
    }
    costed
}
