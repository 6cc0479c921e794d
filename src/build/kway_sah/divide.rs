//! From the triangles of a node to its parts.

use super::bounds::{Bounds, Reference};
use super::few::{FEW, Few};
use super::guillotine::{Cells, Guillotine};
use super::slabs::{Run, Slabs};
use super::{Cuts, KwaySah};

/// Runs of each axis between which planes are looked for.
pub const RUNS: usize = 32;

/// What one thread divides nodes with.
pub(super) struct Divider<const K: usize> {
    params: KwaySah,
    slabs: Slabs,
    grid: Guillotine<K>,
    few: Few<K>,
    runs: [Vec<Run>; 3],
    /// The run of each triangle on each axis.
    run_of: Vec<[u8; 3]>,
    order: Vec<(f64, u32)>,
    starts: Vec<usize>,
    boxes: Vec<Cells>,
    moved: Vec<Reference>,
    /// The parts of the last node: boxes and counts.
    pub parts: Vec<(Bounds, usize)>,
    /// The tree of cuts, a whole before its parts: whether each is cut.
    pub is_cut: Vec<bool>,
    bounds: Vec<Bounds>,
    /// References put into runs and cells so far.
    pub binned: u64,
}

impl<const K: usize> Divider<K> {
    pub fn new(params: &KwaySah) -> Self {
        let cut_cost = if params.binary { 1.0 } else { 0.0 };
        let mut grid = Guillotine::new(cut_cost);
        grid.deep = params.deep;
        grid.power = params.power;
        Self {
            params: *params,
            slabs: Slabs::default(),
            grid,
            few: Few::new(params.max_leaf),
            runs: Default::default(),
            run_of: Vec::new(),
            order: Vec::new(),
            starts: Vec::new(),
            boxes: Vec::new(),
            moved: Vec::new(),
            parts: Vec::new(),
            is_cut: Vec::new(),
            bounds: Vec::new(),
            binned: 0,
        }
    }

    /// Transitions so far.
    pub fn steps(&self) -> u64 {
        self.slabs.steps + self.grid.steps + self.few.steps
    }

    /// Divides a node, its triangles in the order of parts, or says that it is a leaf.
    pub fn divide(&mut self, references: &mut [Reference], area: f64) -> bool {
        let n = references.len();
        if n == 1 {
            return false;
        }
        if n <= FEW {
            let cut = self.few.divide(references, &mut self.bounds, &mut self.is_cut);
            if cut {
                self.part(references);
                return true;
            }
            return n > self.params.max_leaf && self.halve(references);
        }
        self.lay_runs(references);
        let cost = if self.params.cuts == Cuts::Slabs { self.slabs(references) } else { self.guillotine(references) };
        let Some(cost) = cost else { return n > self.params.max_leaf && self.halve(references) };
        if n <= self.params.max_leaf && area * n as f64 <= area + cost {
            return false;
        }
        self.part(references);
        true
    }

    /// Parts by order, of equal size: centres are all the same.
    fn halve(&mut self, references: &mut [Reference]) -> bool {
        let n = references.len();
        let parts = K.min(n);
        for (i, reference) in references.iter_mut().enumerate() {
            reference.cell = (i * parts / n) as u32;
        }
        self.bounds.clear();
        self.bounds.resize(parts, Bounds::EMPTY);
        for reference in references.iter() {
            let part = &mut self.bounds[reference.cell as usize];
            *part = part.union(&Bounds::of(&reference.aabb));
        }
        self.is_cut.clear();
        for _ in 1..parts {
            self.is_cut.extend([true, false]);
        }
        self.is_cut.push(false);
        self.part(references);
        true
    }

    /// Runs of the centres on each axis.
    fn lay_runs(&mut self, references: &[Reference]) {
        let n = references.len();
        self.run_of.clear();
        self.run_of.resize(n, [0; 3]);
        self.binned += n as u64;
        let (mut low, mut high) = (references[0].centre(), references[0].centre());
        for reference in references {
            let centre = reference.centre();
            (low, high) = (low.min(centre), high.max(centre));
        }
        let fine = if self.params.fitted { RUNS } else { self.bins(n) };
        for runs in &mut self.runs {
            runs.clear();
        }
        if n <= RUNS {
            for axis in 0..3 {
                self.order.clear();
                self.order.extend(references.iter().enumerate().map(|(i, r)| (r.centre()[axis], i as u32)));
                self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let mut last = f64::NAN;
                for &(centre, i) in &self.order {
                    if centre != last {
                        self.runs[axis].push(Run::EMPTY);
                        last = centre;
                    }
                    let index = self.runs[axis].len() - 1;
                    self.run_of[i as usize][axis] = index as u8;
                    let run = &mut self.runs[axis][index];
                    *run = Run { bounds: run.bounds.union(&Bounds::of(&references[i as usize].aabb)), count: run.count + 1 };
                }
            }
            return;
        }
        let extent = high - low;
        let scale = [0, 1, 2].map(|a| if extent[a] > 0.0 { fine as f64 / extent[a] } else { 0.0 });
        for axis in 0..3 {
            self.runs[axis].resize(fine, Run::EMPTY);
        }
        for (reference, run_of) in references.iter().zip(&mut self.run_of) {
            let from_low = reference.centre() - low;
            let bounds = Bounds::of(&reference.aabb);
            for axis in 0..3 {
                let run = ((from_low[axis] * scale[axis]) as usize).min(fine - 1);
                run_of[axis] = run as u8;
                let run = &mut self.runs[axis][run];
                *run = Run { bounds: run.bounds.union(&bounds), count: run.count + 1 };
            }
        }
    }

    fn bins(&self, n: usize) -> usize {
        if n < self.params.small { self.params.small_bins.min(self.params.bins) } else { self.params.bins }
    }

    /// Takes empty runs out and divides what is left into slabs; tells the slab of each run.
    fn slabs_of(&mut self, axis: usize, slabs: usize, slab_of: &mut [u32; 256]) -> (usize, f64) {
        let mut packed = [0usize; 256];
        let mut used = 0;
        let runs = &mut self.runs[axis];
        for i in 0..runs.len() {
            packed[i] = used;
            if runs[i].count > 0 {
                runs[used] = runs[i];
                used += 1;
            }
        }
        let len = runs.len();
        runs.truncate(used);
        let mut cost = 0.0;
        if used <= slabs && self.params.cuts == Cuts::Guillotine {
            self.starts.clear();
            self.starts.extend(0..used);
        } else {
            cost = self.slabs.divide(runs, slabs, &mut self.starts);
        }
        let mut slab = 0;
        let mut of_packed = [0u32; 256];
        for i in 0..used {
            if slab + 1 < self.starts.len() && self.starts[slab + 1] == i {
                slab += 1;
            }
            of_packed[i] = slab as u32;
        }
        for i in 0..len {
            slab_of[i] = of_packed[packed[i].min(used - 1)];
        }
        (self.starts.len(), cost)
    }

    fn slabs(&mut self, references: &mut [Reference]) -> Option<f64> {
        let mut best: Option<(f64, usize, usize, [u32; 256])> = None;
        for axis in 0..3 {
            let mut slab_of = [0; 256];
            let (slabs, cost) = self.slabs_of(axis, K, &mut slab_of);
            if slabs > 1 && best.as_ref().is_none_or(|b| cost < b.0) {
                best = Some((cost, axis, slabs, slab_of));
            }
        }
        let (cost, axis, slabs, slab_of) = best?;
        self.bounds.clear();
        self.bounds.resize(slabs, Bounds::EMPTY);
        for (reference, run_of) in references.iter_mut().zip(&self.run_of) {
            reference.cell = slab_of[usize::from(run_of[axis])];
            let part = &mut self.bounds[reference.cell as usize];
            *part = part.union(&Bounds::of(&reference.aabb));
        }
        self.is_cut.clear();
        for _ in 1..slabs {
            self.is_cut.extend([true, false]);
        }
        self.is_cut.push(false);
        Some(cost)
    }

    fn guillotine(&mut self, references: &mut [Reference]) -> Option<f64> {
        let bins = self.bins(references.len());
        let mut slab_of = [[0; 256]; 3];
        let mut slabs = [0; 3];
        for axis in 0..3 {
            slabs[axis] = self.slabs_of(axis, bins, &mut slab_of[axis]).0;
        }
        self.grid.begin(slabs);
        let cell_at = |grid: &Guillotine<K>, slab: [usize; 3]| grid.cell(slab);
        for (reference, run_of) in references.iter_mut().zip(&self.run_of) {
            let slab = [0, 1, 2].map(|a| slab_of[a][usize::from(run_of[a])] as usize);
            let at = cell_at(&self.grid, slab);
            reference.cell = (slab[0] << 16 | slab[1] << 8 | slab[2]) as u32;
            let cell = &mut self.grid.cells_mut()[at];
            *cell = Run { bounds: cell.bounds.union(&Bounds::of(&reference.aabb)), count: cell.count + 1 };
        }
        let cost = self.grid.solve()?;
        self.grid.walk(cost, &mut self.boxes, &mut self.is_cut);
        self.bounds.clear();
        let mut part_of = [[[0u8; 16]; 16]; 16];
        for (part, cells) in self.boxes.iter().enumerate() {
            self.bounds.push(self.grid.content(cells).bounds);
            for x in cells.low[0]..cells.low[0] + cells.len[0] {
                for y in cells.low[1]..cells.low[1] + cells.len[1] {
                    for z in cells.low[2]..cells.low[2] + cells.len[2] {
                        part_of[x][y][z] = part as u8;
                    }
                }
            }
        }
        for reference in references.iter_mut() {
            let c = reference.cell as usize;
            reference.cell = part_of[c >> 16][c >> 8 & 255][c & 255].into();
        }
        Some(cost)
    }

    /// Brings the triangles into the order of their parts, each part in the order in which they were.
    fn part(&mut self, references: &mut [Reference]) {
        self.parts.clear();
        self.parts.extend(self.bounds.iter().map(|&bounds| (bounds, 0)));
        for reference in references.iter() {
            self.parts[reference.cell as usize].1 += 1;
        }
        let mut at = 0;
        let mut next = [0; 16];
        for (next, part) in next.iter_mut().zip(&self.parts) {
            *next = at;
            at += part.1;
        }
        self.moved.resize(references.len().max(self.moved.len()), Reference::NONE);
        for reference in references.iter() {
            let to = &mut next[reference.cell as usize];
            self.moved[*to] = *reference;
            *to += 1;
        }
        references.copy_from_slice(&self.moved[..references.len()]);
    }
}
