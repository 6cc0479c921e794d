//! From the triangles of a node to its parts.

use super::bounds::{Bounds, Group, Reference};
use super::few::{FEW, Few};
use super::guillotine::{Cells, Guillotine, MOST_SLABS};
use super::runs::Runs;
use super::slabs::Slabs;
use super::{COARSE, Cuts, KwaySah, Nodes};

/// What one thread divides nodes with, into at most `K` parts.
pub(super) struct Divider<const K: usize> {
    params: KwaySah,
    runs: Runs,
    slabs: Slabs,
    grid: Guillotine<K>,
    few: Few<K>,
    pairs: Few<2>,
    /// Parts as boxes of cells.
    boxes: Vec<(Cells, Group)>,
    /// The part of each cell.
    part_of: Vec<u8>,
    moved: Vec<Reference>,
    /// The parts of the node that was divided last.
    pub parts: Vec<Group>,
    /// The tree of cuts, a whole before its parts: whether each is cut.
    pub is_cut: Vec<bool>,
    /// References put into runs so far.
    pub binned: u64,
}

impl<const K: usize> Divider<K> {
    /// Before the first node.
    pub fn new(params: &KwaySah) -> Self {
        Self {
            params: *params,
            runs: Runs::default(),
            slabs: Slabs::default(),
            grid: Guillotine::new(params.nodes),
            few: Few::new(params.max_leaf),
            pairs: Few::new(params.max_leaf),
            boxes: Vec::new(),
            part_of: Vec::new(),
            moved: Vec::new(),
            parts: Vec::new(),
            is_cut: Vec::new(),
            binned: 0,
        }
    }

    /// Transitions of all programs so far.
    pub fn steps(&self) -> u64 {
        self.slabs.steps + self.grid.steps + self.few.steps + self.pairs.steps
    }

    /// Whether the parts of a node are its children.
    pub fn is_wide(&self) -> bool {
        self.params.nodes == Nodes::Parts
    }

    /// Divides a node of some area and brings its triangles into the order of parts; false where it is to be a leaf.
    pub fn divide(&mut self, references: &mut [Reference], area: f64) -> bool {
        let n = references.len();
        let limited = n > self.params.max_leaf;
        let divided = if n <= FEW {
            let (parts, is_cut) = (&mut self.parts, &mut self.is_cut);
            match self.params.nodes {
                Nodes::Parts => self.few.divide(references, parts, is_cut),
                Nodes::Cuts | Nodes::FirstCut => self.pairs.divide(references, parts, is_cut),
            }
        } else {
            self.binned += n as u64;
            self.runs.lay(references, self.params.runs);
            let cost = match self.params.cuts {
                Cuts::Guillotine => self.guillotine(references),
                Cuts::Slabs => self.one_axis(references),
            };
            cost.is_some_and(|cost| limited || area * n as f64 > area + cost)
        };
        if !divided && limited {
            self.by_order(references);
        }
        if divided || limited {
            self.part(references);
        }
        divided || limited
    }

    /// Parts of equal size in the order of the triangles: their centres are all the same.
    fn by_order(&mut self, references: &mut [Reference]) {
        let n = references.len();
        let parts = if self.params.nodes == Nodes::Parts { K.min(n) } else { 2 };
        self.parts.clear();
        self.parts.resize(parts, Group::EMPTY);
        for (i, reference) in references.iter_mut().enumerate() {
            reference.cell = (i * parts / n) as u32;
            self.parts[reference.cell as usize].add(&Bounds::of(&reference.aabb));
        }
        self.cut_one_by_one();
    }

    /// The tree of cuts that takes one part away at a time.
    fn cut_one_by_one(&mut self) {
        self.is_cut.clear();
        (1..self.parts.len()).for_each(|_| self.is_cut.extend([true, false]));
        self.is_cut.push(false);
    }

    /// Parts between parallel planes on the axis where they cost least. Of equals the lowest axis.
    fn one_axis(&mut self, references: &mut [Reference]) -> Option<f64> {
        let on = |axis| (axis, self.runs.slabs(axis, K, &mut self.slabs));
        let found = [0, 1, 2].map(on).into_iter().filter(|(_, (_, parts, _))| *parts > 1);
        let (axis, (slab_of, parts, cost)) = found.min_by(|a, b| a.1.2.total_cmp(&b.1.2))?;
        self.parts.clear();
        self.parts.resize(parts, Group::EMPTY);
        for (reference, of) in references.iter_mut().zip(self.runs.of_references()) {
            reference.cell = slab_of[usize::from(of[axis])].into();
            self.parts[reference.cell as usize].add(&Bounds::of(&reference.aabb));
        }
        self.cut_one_by_one();
        Some(cost)
    }

    /// Parts of the best division of a grid, whose planes are those of the best slabs of each axis.
    fn guillotine(&mut self, references: &mut [Reference]) -> Option<f64> {
        let most = if references.len() < COARSE { self.params.bins.min(4) } else { self.params.bins };
        let of_axes = [0, 1, 2].map(|axis| self.runs.slabs(axis, most.min(MOST_SLABS), &mut self.slabs));
        let slabs = of_axes.each_ref().map(|of_axis| of_axis.1);
        self.grid.begin(slabs);
        let number = |slab: [usize; 3]| (slab[0] * slabs[1] + slab[1]) * slabs[2] + slab[2];
        for (reference, of) in references.iter_mut().zip(self.runs.of_references()) {
            let slab = [0, 1, 2].map(|axis| usize::from(of_axes[axis].0[usize::from(of[axis])]));
            reference.cell = number(slab) as u32;
            self.grid.cell(slab).add(&Bounds::of(&reference.aabb));
        }
        let cost = self.grid.solve()?;
        self.grid.walk(cost, &mut self.boxes, &mut self.is_cut);
        self.parts.clear();
        self.part_of.resize(slabs.iter().product(), 0);
        for (part, (Cells { low, len }, group)) in self.boxes.iter().enumerate() {
            self.parts.push(*group);
            for x in low[0]..low[0] + len[0] {
                for y in low[1]..low[1] + len[1] {
                    let from = number([x, y, low[2]]);
                    self.part_of[from..from + len[2]].fill(part as u8);
                }
            }
        }
        for reference in references {
            reference.cell = self.part_of[reference.cell as usize].into();
        }
        Some(cost)
    }

    /// Brings the triangles into the order of their parts, each part in the order in which they were.
    fn part(&mut self, references: &mut [Reference]) {
        let mut next = [0; K];
        let mut at = 0;
        for (next, part) in next.iter_mut().zip(&self.parts) {
            *next = at;
            at += part.count as usize;
        }
        self.moved.resize(references.len().max(self.moved.len()), Reference::NONE);
        for reference in &*references {
            let to = &mut next[reference.cell as usize];
            self.moved[*to] = *reference;
            *to += 1;
        }
        references.copy_from_slice(&self.moved[..references.len()]);
    }
}
