//! The three axes of the recurrence together, for one node after another.

use super::Triangle;
use super::cells::Cells;
use super::cuts::{ByPlanes, INADMISSIBLE, LastAxis, NO_WAY, heads, relax};
use crate::build::{ChildCost, Probe, Work};
use crate::geom::Aabb;
use arrayvec::ArrayVec;

/// A plane of the answer: it lies right above `slab`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    pub axis: usize,
    pub slab: usize,
}

/// The planes of the answer; none where nothing separates the node.
#[derive(Clone, Debug, Default)]
pub struct Choice {
    pub planes: ArrayVec<Plane, 7>,
}

/// The tables of the search; only their memory outlives a node.
#[derive(Default)]
pub struct Search {
    /// Boxes of the slabs of everything along x.
    x: Vec<Aabb>,
    /// `xy[i][j]`, `xz[i][k]`, `yz[j][k]`: boxes of the columns of cells.
    xy: Vec<Aabb>,
    xz: Vec<Aabb>,
    yz: Vec<Aabb>,
    /// `layer[j][k]`: boxes of what is beyond x-plane i, while i falls.
    layer: Vec<Aabb>,
    /// Triangles by x slab: those of slab i are `by_x[x_start[i]..x_start[i + 1]]`.
    by_x: Vec<u32>,
    x_start: Vec<u32>,
    /// Per x slab i, what is beyond the plane below it.
    beyond_x: Vec<BeyondX>,
    /// Terms of x slabs i … i + k from `x_terms[x_rows[i]]` on.
    x_terms: Vec<i64>,
    x_rows: Vec<(u32, u32)>,
    states: Vec<State>,
    y_terms: Vec<i64>,
    /// Boxes of one row of slabs, with and without the empty ones.
    row: Vec<Aabb>,
    packed: Vec<Aabb>,
    /// The boxes of y slabs beyond each x plane, packed.
    y_slabs: Vec<Aabb>,
    last: LastAxis,
}

/// What is left beyond an x plane: its y slabs that hold a triangle are states.
#[derive(Clone, Copy)]
struct BeyondX {
    /// Least cost of cutting off all x slabs before, by planes used.
    before: ByPlanes,
    /// Least cost of what is left, by planes left.
    after: ByPlanes,
    /// Its states.
    first_state: u32,
    states: u32,
}

/// What is left beyond an x plane and a y plane.
#[derive(Clone, Copy)]
struct State {
    /// Its first y slab, as the cells count.
    slab: u32,
    /// Where the terms of its y slabs begin, and how many there are.
    terms: (u32, u32),
    /// Least cost of cutting off all that is not left, by planes used.
    before: ByPlanes,
    /// Least cost of what is left, by planes left: of z only, and then of y as well.
    after: ByPlanes,
}

/// What is the same in all of a node's search.
#[derive(Clone, Copy)]
struct Node<'a> {
    triangles: &'a [Triangle],
    cells: &'a Cells,
    cost: ChildCost,
}

impl Search {
    /// The choice for a node with box `aabb`; `None` when the probe asked to stop.
    pub fn run<P: Probe>(
        &mut self,
        triangles: &[Triangle],
        cells: &Cells,
        aabb: &Aabb,
        arity: usize,
        probe: &mut P,
    ) -> Option<Choice> {
        let node = Node { triangles, cells, cost: ChildCost::new(aabb, arity) };
        let candidates = cells.slabs.iter().sum::<usize>() - 3;
        let mut filled = false;
        for choose in (1..=candidates.min(arity - 1)).rev() {
            if !std::mem::replace(&mut filled, true) {
                self.fill(&node, probe);
            }
            let mut choice = Choice::default();
            let least = self.least(&node, choose, probe)?;
            if least < INADMISSIBLE {
                self.walk(&node, choose, &mut choice, probe);
                return Some(choice);
            }
        }
        probe.go_on(1).then(Choice::default)
    }

    /// Boxes of slabs and columns, and the order by x slab.
    fn fill<P: Probe>(&mut self, node: &Node, probe: &mut P) {
        let [sx, sy, sz] = node.cells.slabs;
        for (grid, len) in [(&mut self.xy, sx * sy), (&mut self.xz, sx * sz), (&mut self.yz, sy * sz)] {
            grid.clear();
            grid.resize(len, Aabb::EMPTY);
        }
        self.x_start.clear();
        self.x_start.resize(sx + 1, 0);
        for (triangle, cell) in node.triangles.iter().zip(node.cells.of_triangles()) {
            let [i, j, k, _] = cell.map(usize::from);
            let add = |aabb: &mut Aabb| *aabb = aabb.union(&triangle.aabb);
            add(&mut self.xy[i * sy + j]);
            add(&mut self.xz[i * sz + k]);
            add(&mut self.yz[j * sz + k]);
            self.x_start[i] += 1;
        }
        let mut end = 0;
        for start in &mut self.x_start {
            end += *start;
            *start = end;
        }
        self.by_x.resize(node.triangles.len(), 0);
        for (index, cell) in node.cells.of_triangles().iter().enumerate().rev() {
            let start = &mut self.x_start[usize::from(cell[0])];
            *start -= 1;
            self.by_x[*start as usize] = index as u32;
        }
        self.x.clear();
        self.x.extend(self.xy.chunks_exact(sy).map(Aabb::union_of));
        probe.add(Work::BoxUnions, (3 * node.triangles.len() + sx * sy) as u64);
    }

    /// The cost of the cheapest admissible choice of `choose` planes.
    fn least<P: Probe>(&mut self, node: &Node, choose: usize, probe: &mut P) -> Option<i64> {
        let [sx, sy, sz] = node.cells.slabs;
        let mut best = INADMISSIBLE - 1;
        self.cut_x(node, choose, probe);
        self.cut_y(node, choose, &mut best, probe);
        // Of what no x plane cut, or no y plane.
        self.row.clear();
        self.row.resize(sz, Aabb::EMPTY);
        let mut slab = sy;
        for state in (0..self.beyond_x[0].states).rev() {
            let until = self.states[state as usize].slab as usize;
            while slab > until {
                slab -= 1;
                unite(&mut self.row, &self.yz[slab * sz..][..sz], probe);
            }
            self.cut_z(node, state as usize, choose, &mut best, probe);
        }
        self.row.fill(Aabb::EMPTY);
        for i in (1..sx).rev() {
            unite(&mut self.row, &self.xz[i * sz..][..sz], probe);
            let state = self.beyond_x[i].first_state as usize;
            self.cut_z(node, state, choose, &mut best, probe);
        }
        if !probe.go_on((sx * sy * sz) as u64) {
            return None;
        }
        if choose > 2 {
            self.inside(node, choose, &mut best, probe)?;
        }
        // Back from the last plane to the first.
        for i in (0..sx).rev() {
            let BeyondX { first_state, states, .. } = self.beyond_x[i];
            self.back_y(first_state as usize..(first_state + states) as usize, choose, probe);
            let mut after = self.states[first_state as usize].after;
            let (row, len) = self.x_rows[i];
            let terms = &self.x_terms[row as usize..][..len as usize];
            for (term, beyond) in terms.iter().zip(&self.beyond_x[i + 1..]) {
                relax(&mut after, *term, &beyond.after, choose);
            }
            probe.add(Work::DpSteps, u64::from(len) * choose as u64);
            self.beyond_x[i].after = after;
        }
        Some(self.beyond_x[0].after[choose])
    }

    /// The states cut by planes of all three axes.
    fn inside<P: Probe>(&mut self, node: &Node, choose: usize, best: &mut i64, probe: &mut P) -> Option<()> {
        let [sx, sy, sz] = node.cells.slabs;
        self.layer.clear();
        self.layer.resize(sy * sz, Aabb::EMPTY);
        let mut filled = sx;
        for i in (1..sx).rev() {
            let BeyondX { first_state, states, .. } = self.beyond_x[i];
            let states = first_state as usize..(first_state + states) as usize;
            let is_open = |s: &usize| (2..choose).any(|used| self.states[*s].before[used] <= *best);
            let Some(lowest) = states.clone().skip(1).find(is_open) else { continue };
            let (from, to) = (self.x_start[i] as usize, self.x_start[filled] as usize);
            filled = i;
            for &index in &self.by_x[from..to] {
                let [_, j, k, _] = node.cells.of_triangles()[index as usize].map(usize::from);
                let column = &mut self.layer[j * sz + k];
                *column = column.union(&node.triangles[index as usize].aabb);
            }
            probe.add(Work::BoxUnions, (to - from) as u64);
            self.row.fill(Aabb::EMPTY);
            let mut slab = sy;
            for state in (lowest..states.end).rev() {
                let until = self.states[state].slab as usize;
                while slab > until {
                    slab -= 1;
                    unite(&mut self.row, &self.layer[slab * sz..][..sz], probe);
                }
                self.cut_z(node, state, choose, best, probe);
            }
            if !probe.go_on((states.len() * sz) as u64) {
                return None;
            }
        }
        Some(())
    }

    /// Costs of x slabs, and of getting beyond each x plane.
    fn cut_x<P: Probe>(&mut self, node: &Node, choose: usize, probe: &mut P) {
        let sx = self.x.len();
        let nowhere = BeyondX { before: NO_WAY, after: NO_WAY, first_state: 0, states: 0 };
        self.beyond_x.clear();
        self.beyond_x.resize(sx, nowhere);
        self.beyond_x[0].before[0] = 0;
        self.x_terms.clear();
        self.x_rows.clear();
        for i in 0..sx {
            let row = self.x_terms.len();
            let found = heads(&self.x[i..], INADMISSIBLE, &node.cost, &mut self.x_terms, probe);
            self.x_rows.push((row as u32, found as u32));
            let (here, beyond) = self.beyond_x[i..].split_first_mut().expect("slab i");
            for (term, beyond) in self.x_terms[row..].iter().zip(beyond) {
                relax(&mut beyond.before, *term, &here.before, choose);
            }
            probe.add(Work::DpSteps, (found * choose) as u64);
        }
    }

    /// Costs of y slabs beyond each x plane, of getting beyond each of their y planes, and of what is left there.
    fn cut_y<P: Probe>(&mut self, node: &Node, choose: usize, best: &mut i64, probe: &mut P) {
        let [sx, sy, _] = node.cells.slabs;
        self.row.clear();
        self.row.resize(sy, Aabb::EMPTY);
        self.states.clear();
        self.y_terms.clear();
        // States stand in the order of i, which is not the order in which their boxes are found.
        self.y_slabs.clear();
        let mut ranges: ArrayVec<(usize, usize), 256> = ArrayVec::new();
        for i in (0..sx).rev() {
            unite(&mut self.row, &self.xy[i * sy..][..sy], probe);
            let start = self.y_slabs.len();
            self.y_slabs.extend(self.row.iter().filter(|b| !b.is_empty()));
            ranges.push((start, self.y_slabs.len()));
        }
        ranges.reverse();
        self.row.fill(Aabb::EMPTY);
        for i in 0..sx {
            let (from, to) = ranges[i];
            let slabs = &self.y_slabs[from..to];
            let first_state = self.states.len();
            self.beyond_x[i].first_state = first_state as u32;
            self.beyond_x[i].states = slabs.len() as u32;
            // Which y slabs these are: those that some column beyond the plane has.
            let holds = |j: &usize| (i..sx).any(|x| !self.xy[x * sy + j].is_empty());
            for slab in (0..sy).filter(holds) {
                self.states.push(State { slab: slab as u32, terms: (0, 0), before: NO_WAY, after: NO_WAY });
            }
            self.states[first_state].before = self.beyond_x[i].before;
            let mut rest = Aabb::EMPTY;
            for (state, slab) in self.states[first_state..].iter_mut().zip(slabs).rev() {
                rest = rest.union(slab);
                state.after[0] = node.cost.term(&rest, 1);
            }
            probe.add(Work::BoxUnions, slabs.len() as u64);
            probe.add(Work::ChildCosts, slabs.len() as u64);
            for q in 0..slabs.len() {
                let row = self.y_terms.len();
                let (here, beyond) = self.states[first_state + q..].split_first_mut().expect("state q");
                let least = here.before.iter().min().expect("eight");
                *best = (*best).min(here.before[choose] + here.after[0]);
                if *least > *best {
                    continue;
                }
                let found = heads(&slabs[q..], *best - least, &node.cost, &mut self.y_terms, probe);
                here.terms = (row as u32, found as u32);
                for (term, beyond) in self.y_terms[row..].iter().zip(beyond) {
                    relax(&mut beyond.before, *term, &here.before, choose);
                }
                probe.add(Work::DpSteps, (found * choose) as u64);
            }
        }
    }

    /// Costs of z slabs of a state whose z slabs stand in `row`, where they can matter.
    fn cut_z<P: Probe>(&mut self, node: &Node, state: usize, choose: usize, best: &mut i64, probe: &mut P) {
        let state = &mut self.states[state];
        let before = &state.before;
        let is_open = |used: &usize| before[*used] <= *best;
        let Some(least_used) = (0..choose).filter(is_open).min() else { return };
        self.packed.clear();
        self.packed.extend(self.row.iter().filter(|b| !b.is_empty()));
        let most = (choose - least_used).min(self.packed.len() - 1);
        let cheapest = before[choose - most..choose].iter().min();
        let Some(cheapest) = cheapest.filter(|c| **c <= *best) else { return };
        let costs = self.last.cut(&self.packed, most, *best - cheapest, &node.cost, probe);
        for left in 1..=most {
            state.after[left] = costs[left];
            *best = (*best).min(before[choose - left] + costs[left]);
        }
    }

    /// From the last state to the first: planes of y before those of z.
    fn back_y<P: Probe>(&mut self, states: std::ops::Range<usize>, choose: usize, probe: &mut P) {
        for state in states.rev() {
            let (here, beyond) = self.states[state..].split_first_mut().expect("a state");
            let (row, len) = here.terms;
            let terms = &self.y_terms[row as usize..][..len as usize];
            for (term, beyond) in terms.iter().zip(beyond) {
                relax(&mut here.after, *term, &beyond.after, choose);
            }
            probe.add(Work::DpSteps, u64::from(len) * choose as u64);
        }
    }

    /// The lexicographically first of the cheapest choices.
    fn walk<P: Probe>(&mut self, node: &Node, choose: usize, choice: &mut Choice, probe: &mut P) {
        let (mut left, mut i) = (choose, 0);
        let mut target = self.beyond_x[0].after[choose];
        while left > 0 {
            let (row, len) = self.x_rows[i];
            let terms = &self.x_terms[row as usize..][..len as usize];
            let reaches = |k: &usize| terms[*k] + self.beyond_x[i + k + 1].after[left - 1] == target;
            let Some(plane) = (0..terms.len()).find(reaches) else { break };
            choice.planes.push(Plane { axis: 0, slab: i + plane });
            (target, left, i) = (target - terms[plane], left - 1, i + plane + 1);
        }
        let mut state = self.beyond_x[i].first_state as usize;
        while left > 0 {
            let (row, len) = self.states[state].terms;
            let terms = &self.y_terms[row as usize..][..len as usize];
            let reaches = |k: &usize| terms[*k] + self.states[state + k + 1].after[left - 1] == target;
            let Some(plane) = (0..terms.len()).find(reaches) else { break };
            let slab = self.states[state + plane].slab as usize;
            choice.planes.push(Plane { axis: 1, slab });
            (target, left, state) = (target - terms[plane], left - 1, state + plane + 1);
        }
        if left == 0 {
            return;
        }
        // Whatever is left of the first y slab's row and beyond.
        let j = self.states[state].slab as usize;
        self.row.clear();
        self.row.resize(node.cells.slabs[2], Aabb::EMPTY);
        for (triangle, cell) in node.triangles.iter().zip(node.cells.of_triangles()) {
            if usize::from(cell[0]) >= i && usize::from(cell[1]) >= j {
                let slab = &mut self.row[usize::from(cell[2])];
                *slab = slab.union(&triangle.aabb);
            }
        }
        let slabs: Vec<usize> = (0..self.row.len()).filter(|k| !self.row[*k].is_empty()).collect();
        self.packed.clear();
        self.packed.extend(slabs.iter().map(|k| self.row[*k]));
        let push = |slab: usize| choice.planes.push(Plane { axis: 2, slab: slabs[slab] });
        self.last.walk(&self.packed, left, target, &node.cost, push, probe);
    }
}

/// Unites the boxes of `row` with those of `others`, one by one.
fn unite<P: Probe>(row: &mut [Aabb], others: &[Aabb], probe: &mut P) {
    for (aabb, other) in row.iter_mut().zip(others) {
        *aabb = aabb.union(other);
    }
    probe.add(Work::BoxUnions, others.len() as u64);
}
