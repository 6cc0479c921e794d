//! The best division of a grid by cuts from side to side: a program over all boxes of cells.
//!
//! *Recurrence.* f(B, 1) is the estimated cost of what is in a box of cells B as one subtree, area(B) · e(triangles). f(B, k)
//! is the least of f(B, 1) and of f(L, i) + f(R, k − i) over all planes between two slabs of an axis, which cut B into L and
//! R, and 0 < i < k: the least cost of B in at most k parts. Where cuts become nodes, area(B) is added to those. With
//! [`Nodes::FirstCut`] f(B, 1) is the least of the estimate and of f(B, 2), so that every box of cells counts as the best binary
//! tree that cuts between cells can make.
//!
//! *Order.* Intervals of an axis are numbered by length, and boxes by the intervals of x, y and z. A part of a box has a lower
//! number than the box, so one pass upwards sees parts before wholes. Boxes with the same triangles are one state, the
//! smallest of them. A pass downwards finds which states are reached, and in how many parts at most they are asked for:
//! every cut on the way takes one part away.

use super::bounds::Group;
use super::{Nodes, estimate};

/// The most slabs of an axis: 46,656 boxes.
pub const MOST_SLABS: usize = 8;

/// No box.
const NONE: u32 = u32::MAX;

/// The program's tables for at most `K` parts; only their memory outlives a node.
pub(super) struct Guillotine<const K: usize> {
    nodes: Nodes,
    /// Slabs of each axis.
    slabs: [usize; 3],
    /// Of each axis, the intervals: the first slab and the number of slabs.
    intervals: [Vec<(u8, u8)>; 3],
    /// Of each axis, the number of the first interval of each length.
    first: [[u32; MOST_SLABS + 1]; 3],
    /// What is in each box.
    boxes: Vec<Group>,
    /// The smallest box with the same triangles; none without triangles.
    same: Vec<u32>,
    /// The most parts that a state is asked for; 0 where it is not reached.
    parts: Vec<u8>,
    /// f(B, k) at k − 1; what is beyond `parts` means nothing.
    costs: Vec<[f64; K]>,
    /// Transitions so far.
    pub steps: u64,
}

/// A box of cells: of each axis, the first slab and the number of slabs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cells {
    pub low: [usize; 3],
    pub len: [usize; 3],
}

/// A box by number, and the numbers of its intervals.
#[derive(Clone, Copy)]
struct Place {
    number: usize,
    interval: [usize; 3],
}

impl<const K: usize> Guillotine<K> {
    /// For parts that become such nodes.
    pub fn new(nodes: Nodes) -> Self {
        Self {
            nodes,
            slabs: [0; 3],
            intervals: Default::default(),
            first: Default::default(),
            boxes: Vec::new(),
            same: Vec::new(),
            parts: Vec::new(),
            costs: Vec::new(),
            steps: 0,
        }
    }

    /// Makes room for a grid of at most [`MOST_SLABS`] slabs an axis, without triangles.
    pub fn begin(&mut self, slabs: [usize; 3]) {
        self.slabs = slabs;
        for ((intervals, first), slabs) in self.intervals.iter_mut().zip(&mut self.first).zip(slabs) {
            intervals.clear();
            for (len, first) in first.iter_mut().enumerate().take(slabs + 1).skip(1) {
                *first = intervals.len() as u32;
                intervals.extend((0..=slabs - len).map(|low| (low as u8, len as u8)));
            }
        }
        let boxes = self.intervals.iter().map(Vec::len).product();
        // Only cells need to be emptied; the other boxes are united from them.
        self.boxes.resize(boxes, Group::EMPTY);
        self.same.resize(boxes, NONE);
        self.parts.clear();
        self.parts.resize(boxes, 0);
        self.costs.resize(boxes.max(self.costs.len()), [0.0; K]);
        for x in 0..slabs[0] {
            for y in 0..slabs[1] {
                let from = self.cell_number([x, y, 0]);
                self.boxes[from..from + slabs[2]].fill(Group::EMPTY);
            }
        }
    }

    /// The cell at these slabs.
    #[inline(always)]
    pub fn cell(&mut self, slab: [usize; 3]) -> &mut Group {
        let number = self.cell_number(slab);
        &mut self.boxes[number]
    }

    /// Intervals of one slab are numbered by that slab.
    #[inline(always)]
    fn cell_number(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.intervals[1].len() + y) * self.intervals[2].len() + z
    }

    /// Numbers between boxes that differ by one interval of an axis.
    fn strides(&self) -> [usize; 3] {
        let z = self.intervals[2].len();
        [self.intervals[1].len() * z, z, 1]
    }

    fn place(&self, number: usize) -> Place {
        let [x, y, _] = self.strides();
        Place { number, interval: [number / x, number % x / y, number % y] }
    }

    /// The box of a state.
    fn cells(&self, number: usize) -> Cells {
        let Place { interval, .. } = self.place(number);
        let intervals = [0, 1, 2].map(|axis| self.intervals[axis][interval[axis]]);
        Cells { low: intervals.map(|i| i.0.into()), len: intervals.map(|i| i.1.into()) }
    }

    /// Unites cells to all boxes and finds those that are the same.
    fn unite(&mut self) {
        let strides = self.strides();
        let [nx, ny, nz] = [0, 1, 2].map(|axis| self.intervals[axis].len());
        let mut number = 0;
        for x in 0..nx {
            for y in 0..ny {
                for z in 0..nz {
                    self.unite_one(&Place { number, interval: [x, y, z] }, &strides);
                    number += 1;
                }
            }
        }
    }

    #[inline(always)]
    fn unite_one(&mut self, place: &Place, strides: &[usize; 3]) {
        let Place { number, interval } = *place;
        let mut group = None;
        let mut same = number as u32;
        for axis in 0..3 {
            let (low, len) = self.intervals[axis][interval[axis]];
            if len == 1 {
                continue;
            }
            let base = number - interval[axis] * strides[axis];
            let shorter = (self.first[axis][usize::from(len) - 1] + u32::from(low)) as usize;
            let (without_last, without_first) = (base + shorter * strides[axis], base + (shorter + 1) * strides[axis]);
            let last = base + usize::from(low + len - 1) * strides[axis];
            let (head, last) = (&self.boxes[without_last], &self.boxes[last]);
            if group.is_none() {
                group = Some(head.and(last));
            }
            if last.count == 0 {
                same = self.same[without_last];
            } else if self.boxes[without_first].count == head.count + last.count {
                same = self.same[without_first];
            }
        }
        if let Some(group) = group {
            self.boxes[number] = group;
        }
        self.same[number] = if self.boxes[number].count == 0 { NONE } else { same };
    }

    /// Tells both states of every plane that cuts a state.
    #[inline(always)]
    fn each_cut(&self, place: &Place, strides: &[usize; 3], mut tell: impl FnMut(usize, usize)) {
        for (axis, stride) in strides.iter().enumerate() {
            let first = &self.first[axis];
            let (low, len) = self.intervals[axis][place.interval[axis]];
            let (low, len) = (usize::from(low), usize::from(len));
            let base = place.number - place.interval[axis] * stride;
            let mut last = NONE;
            for cut in 1..len {
                let left = self.same[base + (first[cut] as usize + low) * stride];
                // Behind an empty slab the cut is the same as before it.
                if left != last {
                    let right = self.same[base + (first[len - cut] as usize + low + cut) * stride];
                    tell(left as usize, right as usize);
                    last = left;
                }
            }
        }
    }

    /// The least cost of all cells in 2 to `K` parts, or of the two sides of the first cut; none where they cannot be cut.
    pub fn solve(&mut self) -> Option<f64> {
        self.unite();
        let root = self.same[self.boxes.len() - 1] as usize;
        self.reach(root);
        let (strides, nodes) = (self.strides(), self.nodes);
        let [_, ny, nz] = [0, 1, 2].map(|axis| self.intervals[axis].len());
        let mut place = Place { number: 0, interval: [0; 3] };
        loop {
            let Place { number, .. } = place;
            let parts = usize::from(self.parts[number]);
            if parts > 0 {
                let Group { bounds, count } = self.boxes[number];
                let area = bounds.area();
                let mut best = [f64::INFINITY; K];
                if parts > 1 {
                    let mut cuts = 0;
                    self.each_cut(&place, &strides, |left, right| {
                        cuts += 1;
                        join(&mut best, &self.costs[left], &self.costs[right], parts);
                    });
                    self.steps += cuts * (parts * (parts - 1) / 2) as u64;
                }
                if number == root {
                    let least = best[K - 1];
                    return (least < f64::INFINITY).then_some(least);
                }
                let cut = if nodes == Nodes::Parts { 0.0 } else { area };
                let mut whole = area * estimate(count);
                if nodes == Nodes::FirstCut {
                    whole = whole.min(best[K - 1] + cut);
                }
                self.costs[number] = best.map(|cost| whole.min(cost + cut));
            }
            place.number += 1;
            place.interval[2] += 1;
            if place.interval[2] == nz {
                place.interval = [place.interval[0], place.interval[1] + 1, 0];
                if place.interval[1] == ny {
                    place.interval = [place.interval[0] + 1, 0, 0];
                }
            }
        }
    }

    /// Finds in how many parts each state is asked for.
    fn reach(&mut self, root: usize) {
        let strides = self.strides();
        let mut parts = std::mem::take(&mut self.parts);
        parts[root] = K as u8;
        for number in (0..=root).rev() {
            if parts[number] < 2 {
                continue;
            }
            let left_over = if self.nodes == Nodes::FirstCut { K as u8 } else { parts[number] - 1 };
            self.each_cut(&self.place(number), &strides, |left, right| {
                parts[left] = parts[left].max(left_over);
                parts[right] = parts[right].max(left_over);
            });
        }
        self.parts = parts;
    }

    /// The parts of the cheapest division, in the order of cuts, and the tree of cuts, a whole before its parts: whether each
    /// is cut. Of equals the lowest axis, the lowest plane, the fewest parts on its lower side.
    pub fn walk(&self, least: f64, parts: &mut Vec<(Cells, Group)>, is_cut: &mut Vec<bool>) {
        let strides = self.strides();
        let root = self.same[self.boxes.len() - 1] as usize;
        parts.clear();
        is_cut.clear();
        let mut stack = vec![(root, K)];
        while let Some((number, k)) = stack.pop() {
            let group = self.boxes[number];
            let mut found = None;
            if k > 1 {
                let cut = if self.nodes == Nodes::Parts || number == root { 0.0 } else { group.bounds.area() };
                let cost = if number == root { least } else { self.costs[number][k - 1] };
                self.each_cut(&self.place(number), &strides, |left, right| {
                    let costs = (1..k).map(|i| self.costs[left][i - 1] + self.costs[right][k - i - 1] + cut);
                    if found.is_none()
                        && let Some(i) = costs.zip(1..).find(|&(sum, _)| sum == cost).map(|(_, i)| i)
                    {
                        found = Some([(right, k - i), (left, i)]);
                    }
                });
            }
            is_cut.push(found.is_some());
            match found {
                Some(sides) => stack.extend(sides),
                None => parts.push((self.cells(number), group)),
            }
        }
    }
}

/// Takes a cut into the least costs of a box in at most `parts` parts.
#[inline(always)]
fn join<const K: usize>(best: &mut [f64; K], left: &[f64; K], right: &[f64; K], parts: usize) {
    for (i, left) in left[..parts - 1].iter().enumerate() {
        for (best, right) in best[i + 1..].iter_mut().zip(right) {
            let cost = left + right;
            *best = if cost < *best { cost } else { *best };
        }
    }
}
