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
    let mut sets =
        Sets { boxes: [Lanes::EMPTY; 1 << SMALL], costs: [0.0; 1 << SMALL], splits: [0; 1 << SMALL], costed: 0 };
    for (i, one) in references.iter().enumerate() {
        sets.boxes[1 << i] = *one;
        sets.costs[1 << i] = one.half_area();
    }
    // Subsets before sets. Every call is for one set, so that nothing of it is left to decide at run time.
    sets.settle::<0b0011, N>(max_leaf);
    sets.settle::<0b0101, N>(max_leaf);
    sets.settle::<0b0110, N>(max_leaf);
    sets.settle::<0b0111, N>(max_leaf);
    sets.settle::<0b1001, N>(max_leaf);
    sets.settle::<0b1010, N>(max_leaf);
    sets.settle::<0b1011, N>(max_leaf);
    sets.settle::<0b1100, N>(max_leaf);
    sets.settle::<0b1101, N>(max_leaf);
    sets.settle::<0b1110, N>(max_leaf);
    sets.settle::<0b1111, N>(max_leaf);

    let mut order = [0; SMALL + 1];
    let mut pending = [(0, 0); SMALL];
    pending[0] = (index, (1usize << N) - 1);
    let (mut height, mut taken) = (1, 0);
    while height > 0 {
        height -= 1;
        let (index, set) = pending[height % SMALL];
        let (aabb, split) = (sets.boxes[set % (1 << SMALL)].aabb(), sets.splits[set % (1 << SMALL)]);
        if split == 0 {
            let first = taken;
            for (i, reference) in references.iter().enumerate() {
                // What does not belong here is overwritten by the next that does.
                order[taken % (SMALL + 1)] = reference.tag();
                taken += set >> i & 1;
            }
            nodes[index] = Node::leaf(aabb, slot + first, taken - first);
        } else {
            let first = nodes.len();
            nodes[index] = Node::inner(aabb, first, 2);
            nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
            pending[height % SMALL] = (first + 1, set ^ split);
            pending[(height + 1) % SMALL] = (first, split);
            height += 2;
        }
    }
    ids.copy_from_slice(&order[..N]);
    sets.costed
}

/// What is known of each set of references.
struct Sets {
    boxes: [Lanes; 1 << SMALL],
    /// Half area times triangles of the leaves, and half areas of the inner nodes, of the best subtree.
    costs: [f32; 1 << SMALL],
    /// The side with the first reference; 0 where the set is a leaf.
    splits: [usize; 1 << SMALL],
    costed: u64,
}

impl Sets {
    /// Finds the best subtree of a set of two or more references, all subsets being settled.
    #[inline(always)]
    fn settle<const SET: usize, const N: usize>(&mut self, max_leaf: usize) {
        if SET >= 1 << N {
            return;
        }
        let first = SET & SET.wrapping_neg();
        let rest = SET ^ first;
        self.boxes[SET] = self.boxes[rest].union(&self.boxes[first]);
        let area = self.boxes[SET].half_area();
        let (mut best, mut split) = (f32::INFINITY, 0);
        for other in 1..=rest {
            if other & !rest == 0 {
                self.costed += 1;
                let cost = self.costs[SET ^ other] + self.costs[other];
                let cheaper = cost < best;
                best = if cheaper { cost } else { best };
                split = if cheaper { SET ^ other } else { split };
            }
        }
        let count = SET.count_ones();
        let (as_leaf, open) = (area * count as f32, area + best);
        let closes = (count as usize <= max_leaf) & (as_leaf <= open);
        self.costs[SET] = if closes { as_leaf } else { open };
        self.splits[SET] = if closes { 0 } else { split };
    }
}
