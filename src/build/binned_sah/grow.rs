//! From an open node to its subtree.

use super::bins::{Bins, Grid, Plane};
use super::lanes::{Lanes, Span, Survey};
use super::parting::{Cut, Parted, RUN, Whole, written};
use super::small::{self, SMALL};
use super::{WIDEST, few};
use crate::bvh::Node;
use crate::geom::Aabb;
use crate::simd::Simd;
use arrayvec::ArrayVec;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// A node of which the references, the box and the bins are known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its place among the nodes.
    pub node: usize,
    /// Its references: so many, from there on.
    pub start: usize,
    pub count: usize,
    /// In which of the two arrays they are.
    pub in_second: bool,
    pub aabb: Lanes,
    /// Where their centres may be.
    span: Span,
    grid: Grid,
}

/// A node that is to be divided.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    pub place: Place,
    plane: Plane,
}

/// References in two arrays that take turns, and the slots of the leaves: a part of each.
pub(super) struct Part<'a> {
    /// Index of the first reference and of the first slot of this part.
    pub start: usize,
    /// Written in the one array or the other, as each [`Place`] says.
    pub arrays: [&'a mut [MaybeUninit<Lanes>]; 2],
    pub ids: &'a mut [u32],
}

impl Part<'_> {
    /// The references of a node, where they are and where they go to, and their slots.
    #[inline(always)]
    fn of(&mut self, place: &Place) -> (&[Lanes], &mut [MaybeUninit<Lanes>], &mut [u32]) {
        let range = place.start - self.start..place.start - self.start + place.count;
        let [first, second] = &mut self.arrays;
        let (first, second) = (&mut first[range.clone()], &mut second[range.clone()]);
        let ids = &mut self.ids[range];
        let (from, to) = if place.in_second { (second, first) } else { (first, second) };
        // SAFETY: `Grower::root` has them in the first array; `Cut::pass` has written all of a node's to the other one.
        (unsafe { written(from) }, to, ids)
    }
}

/// Work done.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// References put into bins.
    pub binned: u64,
    /// Splits of which the cost was taken.
    pub costs: u64,
}

impl Tally {
    /// Adds further work.
    pub fn add(&mut self, more: &Self) {
        self.binned += more.binned;
        self.costs += more.costs;
    }
}

/// What one thread, or all of them together, grow subtrees with.
pub(super) struct Grower {
    simd: Simd,
    max_leaf: usize,
    bins: usize,
    /// The bins of the two children; one more for each further thread that helps to fill them.
    shares: Vec<Box<Bins>>,
    stack: Vec<Open>,
    pub tally: Tally,
}

/// The axis of a plane between the earlier and the later half of references with the same centre.
const BY_INDEX: usize = 3;

/// Below so many references a node is divided by one thread.
pub(super) const SHARED: usize = 1 << 15;

impl Grower {
    /// With so many threads to fill bins.
    pub fn new(simd: Simd, max_leaf: usize, bins: usize, threads: usize) -> Self {
        let shares = (0..threads).map(|_| Bins::new()).collect();
        Self { simd, max_leaf, bins, shares, stack: Vec::new(), tally: Tally::default() }
    }

    /// The root over all references of `part`, which are in the first array; a leaf, if it needs no dividing.
    ///
    /// # Safety
    /// They have been written there.
    pub unsafe fn root(&mut self, part: &mut Part, survey: &Survey, nodes: &mut Vec<Node>) -> Option<Open> {
        let (count, simd) = (part.ids.len(), self.simd);
        let Survey { aabb, span, .. } = *survey;
        let grid = Grid::over(&span, self.bins_for(count), count >= WIDEST);
        let run = if count >= SHARED { count.div_ceil(self.shares.len()) } else { count };
        // SAFETY: the caller's.
        let references = unsafe { written(part.arrays[0]) };
        let runs = references.par_chunks(run).zip(self.shares.par_iter_mut());
        runs.for_each(|(run, bins)| fill_with(simd, bins, 0, &grid, run));
        let (all, more) = self.shares.split_first_mut().expect("one share at least");
        more.iter().take(count.div_ceil(run) - 1).for_each(|share| all.merge(share, 0, grid.bins()));
        self.tally.binned += count as u64;

        nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
        let root = Place { node: 0, start: 0, count, in_second: false, aabb, span, grid };
        self.settle(0, root, part, nodes)
    }

    /// Grows everything below `open`.
    pub fn grow(&mut self, open: Open, part: &mut Part, nodes: &mut Vec<Node>) {
        let mut stack = std::mem::take(&mut self.stack);
        stack.push(open);
        while let Some(open) = stack.pop() {
            // The right one waits.
            stack.extend(self.divide(open, part, nodes).into_iter().rev());
        }
        self.stack = stack;
    }

    /// Parts the references of a node, fills the bins of its children and settles them. Returns those that are to be divided
    /// further, left before right.
    pub fn divide(&mut self, open: Open, part: &mut Part, nodes: &mut Vec<Node>) -> ArrayVec<Open, 2> {
        #[cfg(target_arch = "x86_64")]
        if self.simd >= Simd::Avx2 {
            // SAFETY: `Simd` says that the processor has AVX2.
            return unsafe { self.divide_avx2(&open, part, nodes) };
        }
        // SAFETY: without AVX.
        unsafe { self.divide_by::<false>(&open, part, nodes) }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn divide_avx2(&mut self, open: &Open, part: &mut Part, nodes: &mut Vec<Node>) -> ArrayVec<Open, 2> {
        // SAFETY: AVX2 includes AVX.
        unsafe { self.divide_by::<true>(open, part, nodes) }
    }

    /// Bins of a node: few for few references.
    #[inline(always)]
    fn bins_for(&self, count: usize) -> usize {
        self.bins.min(few(count))
    }

    /// [`Self::divide`].
    ///
    /// # Safety
    /// `WIDE` only where the processor has AVX.
    #[inline(always)]
    unsafe fn divide_by<const WIDE: bool>(
        &mut self,
        open: &Open,
        part: &mut Part,
        nodes: &mut Vec<Node>,
    ) -> ArrayVec<Open, 2> {
        let (place, plane) = (&open.place, &open.plane);
        let first = nodes.len();
        nodes[place.node] = Node::inner(place.aabb.aabb(), first, 2);
        nodes.extend([Node::leaf(Aabb::EMPTY, 0, 0); 2]);

        let counts = [plane.left, place.count - plane.left];
        let by_index = plane.axis == BY_INDEX;
        let spans = if by_index { [place.span; 2] } else { place.grid.cut(&place.span, plane.axis, plane.bin as f32) };
        let spans = [spans[0].within(&plane.boxes[0]), spans[1].within(&plane.boxes[1])];
        let grids = [0, 1].map(|side| {
            let binned = counts[side] > SMALL && !by_index;
            binned.then(|| Grid::over(&spans[side], self.bins_for(counts[side]), counts[side] >= WIDEST))
        });
        let (from, to, _) = part.of(place);
        if by_index {
            to.iter_mut().zip(from).for_each(|(to, reference)| {
                to.write(*reference);
            });
        } else {
            let cut = Cut { side_of: place.grid.side_of(plane.axis, plane.bin), grids };
            self.tally.binned += counts.iter().filter(|&&n| n > SMALL).sum::<usize>() as u64;
            if self.shares.len() > 1 && place.count >= SHARED {
                self.pass_shared(from, to, plane.left, &cut);
            } else {
                let to = Whole::new(to, plane.left);
                // SAFETY: the caller's.
                unsafe { cut.pass::<WIDE>(from, to, &mut self.shares[0]) };
            }
        }
        let in_second = !place.in_second;
        let starts = [place.start, place.start + plane.left];
        let mut children = ArrayVec::new();
        for side in [0, 1] {
            let child = Place {
                node: first + side,
                start: starts[side],
                count: counts[side],
                in_second,
                aabb: plane.boxes[side],
                span: spans[side],
                grid: grids[side].unwrap_or(Grid::NONE),
            };
            children.extend(self.settle(side, child, part, nodes));
        }
        children
    }

    /// Makes a node a leaf, or a small subtree, or opens it with the best plane of its bins.
    #[inline(always)]
    fn settle(&mut self, side: usize, mut place: Place, part: &mut Part, nodes: &mut Vec<Node>) -> Option<Open> {
        let (references, _, ids) = part.of(&place);
        let Place { node, start, count, .. } = place;
        let m = self.max_leaf;
        if count <= SMALL {
            self.tally.costs += match *references {
                [a] => small::write(&[a], m, node, start, ids, nodes),
                [a, b] => small::write(&[a, b], m, node, start, ids, nodes),
                [a, b, c] => small::write(&[a, b, c], m, node, start, ids, nodes),
                [a, b, c, d] => small::write(&[a, b, c, d], m, node, start, ids, nodes),
                _ => 0,
            };
            return None;
        }
        self.tally.costs += 3 * (place.grid.bins() as u64 - 1);
        let mut best = self.shares[0].best(side, place.grid.bins(), count);
        if best.is_none() {
            place.span = Span::around(references);
            place.grid = Grid::over(&place.span, self.bins_for(count), count >= WIDEST);
            fill_with(self.simd, &mut self.shares[0], side, &place.grid, references);
            self.tally.binned += count as u64;
            self.tally.costs += 3 * (place.grid.bins() as u64 - 1);
            best = self.shares[0].best(side, place.grid.bins(), count);
        }
        let plane = best.unwrap_or_else(|| {
            let left = count / 2;
            let boxes = [&references[..left], &references[left..]]
                .map(|half| half.iter().fold(Lanes::EMPTY, |all, one| all.union(one)));
            let cost = boxes[0].half_area() * left as f32 + boxes[1].half_area() * (count - left) as f32;
            self.tally.costs += 1;
            Plane { cost, axis: BY_INDEX, bin: 0, left, boxes }
        });
        let area = place.aabb.half_area();
        if count <= m && area * count as f32 <= area + plane.cost {
            ids.iter_mut().zip(references).for_each(|(id, reference)| *id = reference.tag());
            nodes[node] = Node::leaf(place.aabb.aabb(), start, count);
            return None;
        }
        Some(Open { place, plane })
    }

    /// [`Cut::pass`] by all threads, each with its own run of references.
    fn pass_shared(&mut self, from: &[Lanes], to: &mut [MaybeUninit<Lanes>], left: usize, cut: &Cut) {
        let simd = self.simd;
        let run = from.len().div_ceil(self.shares.len());
        let lefts: Vec<usize> = from.par_chunks(run).map(|run| cut.lefts(run)).collect();
        let (mut left, mut right) = to.split_at_mut(left);
        let mut runs = Vec::with_capacity(lefts.len());
        for ((run, n), bins) in from.chunks(run).zip(lefts).zip(&mut self.shares) {
            let (this_left, more_left) = left.split_at_mut(n);
            let (this_right, more_right) = right.split_at_mut(run.len() - n);
            (left, right) = (more_left, more_right);
            runs.push((run, Parted::new([this_left, this_right]), bins));
        }
        let used = runs.len();
        runs.into_par_iter().for_each(|(from, to, bins)| {
            cut.pass_with(simd, from, to, bins);
        });
        let (all, more) = self.shares.split_first_mut().expect("one share at least");
        for share in &more[..used - 1] {
            (0..2).for_each(|side| all.merge(share, side, cut.grids[side].as_ref().map_or(0, Grid::bins)));
        }
    }
}

/// Fills the bins of a node from nothing.
///
/// # Safety
/// `WIDE` only where the processor has AVX.
#[inline(always)]
unsafe fn fill<const WIDE: bool>(bins: &mut Bins, side: usize, grid: &Grid, references: &[Lanes]) {
    bins.clear(side, grid.bins(), true);
    for run in references.chunks(RUN) {
        // SAFETY: the caller's.
        unsafe { bins.add::<WIDE>(side, grid, run, true) };
    }
    bins.merge_others(side, grid.bins());
}

fn fill_with(simd: Simd, bins: &mut Bins, side: usize, grid: &Grid, references: &[Lanes]) {
    #[cfg(target_arch = "x86_64")]
    if simd >= Simd::Avx2 {
        // SAFETY: `Simd` says that the processor has AVX2.
        return unsafe { fill_avx2(bins, side, grid, references) };
    }
    // SAFETY: without AVX.
    unsafe { fill::<false>(bins, side, grid, references) };
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn fill_avx2(bins: &mut Bins, side: usize, grid: &Grid, references: &[Lanes]) {
    // SAFETY: AVX2 includes AVX.
    unsafe { fill::<true>(bins, side, grid, references) };
}
