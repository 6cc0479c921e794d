//! A node of few triangles: the cheapest of all subtrees that cuts between centres can make.
//!
//! A set of triangles is a mask. F(S) is the cost of the best subtree over S, and g(S, k) that of S in at most k subtrees:
//! g(S, 1) = F(S); g(S, k) is the least of F(S) and of g(L, i) + g(R, k − i) over all cuts of S into L and R; and F(S) is the
//! leaf, area · triangles, where the leaf limit allows it, or the node, area + g(S, K), whichever is less. Both sides of a cut
//! are lower numbers than the whole, so one pass upwards fills the tables.

use super::bounds::{Bounds, Group, Reference};

/// The most triangles that are looked at as sets.
pub(super) const FEW: usize = 8;

/// The tables.
pub(super) struct Few<const K: usize> {
    max_leaf: usize,
    groups: [Group; 1 << FEW],
    /// g(S, k) at k − 1.
    costs: Box<[[f64; K]; 1 << FEW]>,
    /// The triangles below each change of the centre, axis by axis.
    below: Vec<u8>,
    /// Transitions so far.
    pub steps: u64,
}

impl<const K: usize> Few<K> {
    /// For leaves of at most so many triangles.
    pub fn new(max_leaf: usize) -> Self {
        let (groups, costs) = ([Group::EMPTY; 1 << FEW], Box::new([[0.0; K]; 1 << FEW]));
        Self { max_leaf, groups, costs, below: Vec::new(), steps: 0 }
    }

    /// Divides a node of at most [`FEW`] triangles: the part of each into its `cell`, the parts, and the tree of cuts as of
    /// [`super::guillotine::Guillotine::walk`]. False where nothing can be cut or a leaf is not above it.
    pub fn divide(&mut self, references: &mut [Reference], parts: &mut Vec<Group>, is_cut: &mut Vec<bool>) -> bool {
        let all = (1usize << references.len()) - 1;
        let least = self.solve(references);
        if least < f64::INFINITY {
            self.walk(all, least, references, parts, is_cut);
        }
        least < f64::INFINITY
    }

    /// g of all triangles, cut at least once; infinite where there is no cut or a leaf is not above it.
    fn solve(&mut self, references: &[Reference]) -> f64 {
        let all = (1usize << references.len()) - 1;
        self.find_cuts(references);
        for (i, reference) in references.iter().enumerate() {
            let bounds = Bounds::of(&reference.aabb);
            for rest in 0..1 << i {
                self.groups[1 << i | rest] = self.groups[rest];
                self.groups[1 << i | rest].add(&bounds);
            }
        }
        let mut reached = [false; 1 << FEW];
        reached[all] = true;
        for set in (1..=all).rev() {
            if reached[set] {
                each_cut(&self.below, set, |left, right| (reached[left], reached[right]) = (true, true));
            }
        }
        for set in (1..all).filter(|&set| reached[set]) {
            let best = self.in_parts(set);
            let (leaf, area) = self.leaf(set);
            let mut whole = leaf.min(area + best[K - 1]);
            if whole == f64::INFINITY {
                // Centres that are all the same, and too many for a leaf: about as much as a node over leaves of one.
                whole = area + area * f64::from(self.groups[set].count);
            }
            self.costs[set] = best.map(|cost| whole.min(cost));
        }
        let least = self.in_parts(all)[K - 1];
        let (leaf, area) = self.leaf(all);
        if leaf <= area + least { f64::INFINITY } else { least }
    }

    /// What a leaf over a set costs, infinite where the limit forbids it, and the area.
    fn leaf(&self, set: usize) -> (f64, f64) {
        let Group { bounds, count } = &self.groups[set];
        let area = bounds.area();
        (if *count as usize <= self.max_leaf { area * f64::from(*count) } else { f64::INFINITY }, area)
    }

    /// The least costs of a set in 2, 3 … at most `K` parts, at k − 1; infinite for one.
    fn in_parts(&mut self, set: usize) -> [f64; K] {
        let k = K.min(self.groups[set].count as usize);
        let (mut best, mut cuts) = ([f64::INFINITY; K], 0);
        each_cut(&self.below, set, |left, right| {
            cuts += 1;
            let (left, right) = (&self.costs[left], &self.costs[right]);
            for i in 0..k - 1 {
                for (best, right) in best[i + 1..k].iter_mut().zip(right) {
                    *best = best.min(left[i] + right);
                }
            }
        });
        self.steps += cuts * (k * (k - 1) / 2) as u64;
        let least = best[k - 1];
        best[k..].fill(least);
        best
    }

    fn walk(
        &self,
        all: usize,
        least: f64,
        references: &mut [Reference],
        parts: &mut Vec<Group>,
        is_cut: &mut Vec<bool>,
    ) {
        parts.clear();
        is_cut.clear();
        // More parts than triangles cost the same as one a triangle.
        let mut stack = vec![(all, K.min(references.len()))];
        while let Some((set, k)) = stack.pop() {
            let cost = if set == all { least } else { self.costs[set][k - 1] };
            let mut found = None;
            each_cut(&self.below, set, |left, right| {
                let costs = (1..k).map(|i| self.costs[left][i - 1] + self.costs[right][k - i - 1]);
                if found.is_none()
                    && let Some(i) = costs.zip(1..).find(|&(sum, _)| sum == cost).map(|(_, i)| i)
                {
                    found = Some([(right, k - i), (left, i)]);
                }
            });
            is_cut.push(found.is_some());
            if let Some(sides) = found {
                stack.extend(sides);
                continue;
            }
            for (i, reference) in references.iter_mut().enumerate() {
                if set >> i & 1 == 1 {
                    reference.cell = parts.len() as u32;
                }
            }
            parts.push(self.groups[set]);
        }
    }

    fn find_cuts(&mut self, references: &[Reference]) {
        self.below.clear();
        for axis in 0..3 {
            let mut order = [(0.0, 0); FEW];
            let order = &mut order[..references.len()];
            for (i, (place, reference)) in order.iter_mut().zip(references).enumerate() {
                *place = (reference.centre()[axis], i);
            }
            order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let mut below = 0;
            for pair in order.windows(2) {
                below |= 1 << pair[0].1;
                if pair[0].0 < pair[1].0 {
                    self.below.push(below);
                }
            }
        }
    }
}

/// Tells both sides of each cut of `set`.
#[inline(always)]
fn each_cut(below: &[u8], set: usize, mut tell: impl FnMut(usize, usize)) {
    let mut last = 0;
    for &below in below {
        let left = set & usize::from(below);
        if left != 0 && left != set && left != last {
            tell(left, set ^ left);
            last = left;
        }
    }
}
