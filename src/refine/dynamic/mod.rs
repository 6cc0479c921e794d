//! A binary tree that can be changed: subtrees taken out and put in elsewhere, boxes kept tight.
//!
//! Siblings stand next to each other in one cache line, so whoever looks at a node has its sibling, too. Boxes are those of the
//! tree scaled by a power of two, so that the root's largest extent is about 1: nothing of any size is rounded, areas can be
//! taken in f32, and scenes of all sizes get the same tree.

mod passes;
mod slot;

pub(super) use passes::{Passes, Tally, Visit};
pub(super) use slot::{NONE, ROOT, Wide};

use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use crate::refine::bottom_up::{bottom_up, unite};
use glam::Vec3;
use slot::{LEAF, Slot};

/// What leaves would make of a subtree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sum {
    /// Its triangles; one more than a leaf may hold where they are more.
    triangles: u32,
    /// Its least cost (of half areas) where it is small enough for a leaf or is one, else 0.
    cost: f64,
    /// By how much a leaf in its place is cheaper than an inner node over its children at their least costs; 0 where it is not.
    bonus: f64,
}

/// The tree, with its SAH as it will be when [`super::open_leaves`] has turned subtrees into leaves. That is a sum over inner
/// nodes, each with its area less its bonus, so changes of it are local.
pub(super) struct Dynamic<'a> {
    input: &'a Bvh,
    slots: Vec<Slot>,
    sums: Vec<Sum>,
    max_leaf: u32,
}

/// A move that was made: what takes it back.
pub(super) struct Moved {
    /// What the cost of the tree, in half areas, has lost.
    pub gain: f64,
    /// Where the subtree stood beside its sibling, which now stands there.
    pub old: u32,
    /// Where it stands now.
    pub now: u32,
}

impl<'a> Dynamic<'a> {
    /// The same tree, of which leaves of at most `max_leaf` triangles will be made. None where the input is no binary tree of
    /// at least three leaves, or has 2³⁰ nodes or more.
    pub fn new(input: &'a Bvh, max_leaf: usize) -> Option<Self> {
        let inner = input.nodes.iter().filter(|node| !node.is_leaf());
        if input.nodes.len() < 5 || input.nodes.len() >= 1 << 30 || !inner.clone().all(|node| node.count() == 2) {
            return None;
        }
        let extent = input.root().aabb.extent().max_element();
        let scale = if extent > 0.0 { libm::exp2(-f64::from(libm::ilogb(extent))) } else { 1.0 };
        let scaled = |v: Vec3| (v.as_dvec3() * scale).as_vec3().to_array();
        let mut slots = vec![Slot::EMPTY; input.nodes.len() + 1];
        // The nodes' slots, in the order of the nodes: children stand behind their parents.
        let mut slot_of = vec![ROOT; input.nodes.len()];
        let mut free = 2;
        for (index, node) in input.nodes.iter().enumerate() {
            let slot = slot_of[index];
            let link = if node.is_leaf() { index as u32 | LEAF } else { free };
            let Slot { parent, .. } = slots[slot as usize];
            slots[slot as usize] = Slot { min: scaled(node.aabb.min), parent, max: scaled(node.aabb.max), link };
            for child in input.children(index) {
                slot_of[child] = free;
                slots[free as usize].parent = slot;
                free += 1;
            }
        }
        let sums = vec![Sum::default(); slots.len()];
        let mut tree = Self { input, slots, sums, max_leaf: max_leaf.clamp(1, 1 << 20) as u32 };
        let mut sums = std::mem::take(&mut tree.sums);
        let pair = |slot: u32| tree.at(slot).pair().map_or(0..0, |pair| pair as usize..pair as usize + 2);
        // Pairs stand behind their parents so far. Slot 1 is not looked at: it holds a leaf without triangles.
        bottom_up(
            &mut sums,
            1,
            |slot, _| pair(slot as u32),
            |slot, own, below| {
                if slot != 1 {
                    own[0] = tree.sum_over(slot as u32, below);
                }
            },
        );
        tree.sums = sums;
        Some(tree)
    }

    /// All slots but the root's; slot 1 is none.
    pub fn all_but_root(&self) -> std::ops::Range<u32> {
        2..self.slots.len() as u32
    }

    /// What stands in a slot.
    #[inline(always)]
    pub fn at(&self, slot: u32) -> &Slot {
        &self.slots[slot as usize]
    }

    /// The box of the parent of a slot that is not the root's.
    #[inline(always)]
    pub fn above(&self, slot: u32) -> Wide {
        self.at(self.at(slot).parent).wide()
    }

    /// The cost of the tree, in half areas, without what its triangles cost in leaves of the input.
    pub fn cost(&self) -> f64 {
        let slots = (0..self.slots.len() as u32).filter(|&slot| slot != 1 && self.at(slot).pair().is_some());
        slots.map(|slot| self.own_cost(slot)).sum()
    }

    /// What an inner node adds to the cost.
    fn own_cost(&self, slot: u32) -> f64 {
        self.at(slot).wide().exact_half_area() - self.sums[slot as usize].bonus
    }

    /// The sum of a subtree from those of its children.
    fn sum(&self, slot: u32) -> Sum {
        let pair = self.at(slot).pair().map_or(0..0, |pair| pair as usize..pair as usize + 2);
        self.sum_over(slot, &self.sums[pair])
    }

    /// The same, of children with these sums.
    fn sum_over(&self, slot: u32, below: &[Sum]) -> Sum {
        let area = self.at(slot).wide().exact_half_area();
        let [left, right] = below else {
            let leaf = (self.at(slot).link & !LEAF) as usize;
            let triangles = self.input.nodes[leaf].count();
            let (triangles, cost) = (self.at_most_too_many(triangles), area * triangles as f64);
            return Sum { triangles, cost, bonus: 0.0 };
        };
        let triangles = self.at_most_too_many((left.triangles + right.triangles) as usize);
        if triangles > self.max_leaf {
            return Sum { triangles, cost: 0.0, bonus: 0.0 };
        }
        let open = area + (left.cost + right.cost);
        let cost = open.min(area * f64::from(triangles));
        Sum { triangles, cost, bonus: open - cost }
    }

    /// So many triangles, or one more than a leaf may hold: then further up nothing changes with their number.
    fn at_most_too_many(&self, triangles: usize) -> u32 {
        triangles.min(self.max_leaf as usize + 1) as u32
    }

    /// Puts a subtree into a slot, below whatever is there, and tells its children.
    fn put(&mut self, slot: u32, (content, sum): (Slot, Sum)) {
        let parent = self.slots[slot as usize].parent;
        self.slots[slot as usize] = Slot { parent, ..content };
        self.sums[slot as usize] = sum;
        if let Some(pair) = content.pair() {
            self.slots[pair as usize].parent = slot;
            self.slots[pair as usize + 1].parent = slot;
        }
    }

    /// The subtree in a slot.
    fn take(&self, slot: u32) -> (Slot, Sum) {
        (*self.at(slot), self.sums[slot as usize])
    }

    /// Makes the boxes and sums of `slot` and of what is above it right, up to the first that are so already. What the cost of
    /// the tree loses.
    fn tighten(&mut self, mut slot: u32) -> f64 {
        let mut lost = 0.0;
        while slot != NONE {
            let pair = self.at(slot).pair().expect("only inner nodes are above others");
            let (before, was, sum) = (self.own_cost(slot), self.at(slot).wide(), self.sums[slot as usize]);
            let now = self.at(pair).wide().union(&self.at(pair + 1).wide());
            self.slots[slot as usize].set_box(&now);
            self.sums[slot as usize] = self.sum(slot);
            if was == now && sum == self.sums[slot as usize] {
                break;
            }
            lost += before - self.own_cost(slot);
            slot = self.at(slot).parent;
        }
        lost
    }

    /// Whether `above` may be `slot` or one of its ancestors. Among more than a thousand boxes inside that of `above`, each
    /// inside the next, nobody looks for it.
    fn may_be_above(&self, above: u32, mut slot: u32) -> bool {
        const MOST_STEPS: usize = 1000;
        let within = self.at(above).wide();
        for _ in 0..MOST_STEPS {
            // Boxes grow upwards: beyond the box of `above` it cannot come.
            if slot == NONE || !within.contains(&self.at(slot).wide()) {
                return false;
            }
            if slot == above {
                return true;
            }
            slot = self.at(slot).parent;
        }
        true
    }

    /// Takes the subtree `from` out and puts it in beside `to`, with a new parent in the slot `to`. None where that is no move:
    /// `to` is (or may be) part of the subtree, its parent or its sibling, or `from` is the root.
    pub fn reinsert(&mut self, from: u32, to: u32) -> Option<Moved> {
        let parent = self.at(from).parent;
        if from == ROOT || to == parent || to == from ^ 1 || self.may_be_above(from, to) {
            return None;
        }
        let pair = from & !1;
        let (taken, sibling) = (self.take(from), self.take(from ^ 1));
        let mut gain = self.own_cost(parent);
        self.put(parent, sibling);
        gain += self.tighten(self.at(parent).parent);
        gain += self.insert(taken, to, pair, from & 1);
        Some(Moved { gain, old: parent, now: from })
    }

    /// Puts `taken` in beside what stands at `to`, both into the free pair, itself at `side`. What the cost loses.
    fn insert(&mut self, taken: (Slot, Sum), to: u32, pair: u32, side: u32) -> f64 {
        let beside = self.take(to);
        self.slots[pair as usize].parent = to;
        self.slots[pair as usize + 1].parent = to;
        self.put(pair + side, taken);
        self.put(pair + (side ^ 1), beside);
        let both = taken.0.wide().union(&beside.0.wide());
        let slot = &mut self.slots[to as usize];
        slot.set_box(&both);
        slot.link = pair;
        let above = slot.parent;
        self.sums[to as usize] = self.sum(to);
        let own = self.own_cost(to);
        self.tighten(above) - own
    }

    /// Swaps two subtrees, of which neither is part of the other. What the cost loses.
    pub fn swap(&mut self, a: u32, b: u32) -> f64 {
        let (at_a, at_b) = (self.take(a), self.take(b));
        self.put(a, at_b);
        self.put(b, at_a);
        self.tighten(self.at(b).parent) + self.tighten(self.at(a).parent)
    }

    /// Gives the treelet below `root`, which consists of `pairs` over `parts`, another shape: `splits` of sets of parts, each
    /// with the set on its left, those above before those below. Leaves it as it is where that is not cheaper. What the
    /// cost loses.
    pub fn reshape(&mut self, root: u32, pairs: &[u32], parts: &[u32], splits: &[[u8; 2]]) -> f64 {
        let old: Vec<_> =
            std::iter::once(root).chain(pairs.iter().flat_map(|&p| [p, p + 1])).map(|s| (s, self.take(s))).collect();
        let contents: Vec<_> = parts.iter().map(|&part| self.take(part)).collect();
        let inner: Vec<u32> = old.iter().map(|o| o.0).filter(|slot| !parts.contains(slot)).collect();
        let mut gain: f64 = inner.iter().map(|&slot| self.own_cost(slot)).sum();
        // The slot of every set that was met.
        let mut places = vec![(splits[0][0], root)];
        for (&[set, left], &pair) in splits.iter().zip(pairs) {
            let slot = places.iter().find(|place| place.0 == set).expect("those above come first").1;
            let (_, sum) = self.take(slot);
            let parent = Slot { link: pair, ..*self.at(slot) };
            self.put(slot, (parent, sum));
            for (side, slot) in [(left, pair), (set & !left, pair + 1)] {
                if side.is_power_of_two() {
                    self.put(slot, contents[side.trailing_zeros() as usize]);
                } else {
                    places.push((side, slot));
                }
            }
        }
        for &(_, slot) in places.iter().rev() {
            let pair = self.at(slot).pair().expect("a set of two parts or more");
            let wide = self.at(pair).wide().union(&self.at(pair + 1).wide());
            self.slots[slot as usize].set_box(&wide);
            self.sums[slot as usize] = self.sum(slot);
            gain -= self.own_cost(slot);
        }
        let above = self.at(root).parent;
        gain += self.tighten(above);
        if gain <= 0.0 {
            for (slot, content) in old {
                self.put(slot, content);
            }
            self.tighten(above);
            return 0.0;
        }
        gain
    }

    /// Takes a move back, if nothing was moved since.
    pub fn take_back(&mut self, moved: &Moved) {
        let Moved { old, now, .. } = *moved;
        let to = self.at(now).parent;
        let (taken, beside) = (self.take(now), self.take(now ^ 1));
        self.put(to, beside);
        self.tighten(self.at(to).parent);
        self.insert(taken, old, now & !1, now & 1);
    }

    /// The tree as others know it, in depth-first order, with the input's leaves.
    pub fn finish(&self) -> Bvh {
        let mut nodes: Vec<Node> = Vec::with_capacity(self.input.nodes.len());
        let mut triangle_ids = Vec::with_capacity(self.input.triangle_ids.len());
        nodes.push(*self.input.root());
        let mut pending = vec![(0, ROOT)];
        while let Some((place, slot)) = pending.pop() {
            let link = self.at(slot).link;
            if link & LEAF != 0 {
                let leaf = (link & !LEAF) as usize;
                let ids = self.input.leaf_triangles(leaf);
                nodes[place] = Node::leaf(self.input.nodes[leaf].aabb, triangle_ids.len(), ids.len());
                triangle_ids.extend_from_slice(ids);
            } else {
                let first = nodes.len();
                nodes[place] = Node::inner(Aabb::EMPTY, first, 2);
                nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);
                pending.extend([(first + 1, link + 1), (first, link)]);
            }
        }
        unite(&mut nodes, |leaf| leaf.aabb);
        Bvh { nodes, triangle_ids, arity: self.input.arity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::{boxes, random_tree, soup};
    use crate::bvh::{tree_hash, validate};

    #[test]
    fn a_slot_is_half_a_cache_line_and_its_areas_are_those_of_the_box() {
        assert_eq!(size_of::<Slot>(), 32);
        for (seed, size) in [(1, 0.5), (2, 1e19), (3, 1e-19)] {
            let boxes: Vec<_> =
                boxes(&soup(seed, 50, 0.5)).iter().map(|b| Aabb::new(b.min * size, b.max * size)).collect();
            let bvh = random_tree(seed, &boxes, 2, 1);
            let tree = Dynamic::new(&bvh, 1).unwrap();
            let extent = bvh.root().aabb.extent().max_element();
            let scaled = (tree.at(ROOT).wide().exact_half_area() / (0.5 * bvh.root().aabb.surface_area())).sqrt();
            assert!((0.5..2.0).contains(&(extent * scaled)));
            for slot in std::iter::once(ROOT).chain(tree.all_but_root()) {
                let wide = tree.at(slot).wide();
                let exact = wide.exact_half_area();
                assert!((f64::from(wide.half_area()) - exact).abs() <= 1e-6 * exact);
                assert!(slot == ROOT || tree.above(slot).contains(&wide));
            }
            assert_eq!(tree_hash(&tree.finish()), tree_hash(&bvh));
            assert!(validate(&tree.finish(), &boxes, &Default::default()).is_ok());
        }
    }

    #[test]
    fn no_tree_where_there_is_nothing_to_change() {
        let boxes = boxes(&soup(1, 9, 0.5));
        assert!(Dynamic::new(&random_tree(1, &boxes[..2], 2, 1), 1).is_none());
        assert!(Dynamic::new(&random_tree(1, &boxes[..3], 2, 1), 1).is_some());
        assert!(Dynamic::new(&random_tree(1, &boxes, 9, 1), 1).is_none());
        assert!(Dynamic::new(&Bvh { nodes: Vec::new(), triangle_ids: Vec::new(), arity: 2 }, 1).is_none());
    }
}
