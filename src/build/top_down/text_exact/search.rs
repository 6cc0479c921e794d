//! The three axes of the recurrence together, for one node after another: two planes or more.

use super::cells::Cells;
use super::cuts::{ByPlanes, INADMISSIBLE, LastAxis, heads, no_way, relax};
use super::{Choice, Plane, Triangle};
use crate::build::{ChildCost, Probe, Work};
use crate::geom::Aabb;

/// The tables of a search for fewer than `K` planes; only their memory outlives a node.
#[derive(Default)]
pub struct Search<const K: usize> {
    /// Boxes of the slabs of everything along one axis.
    x: Vec<Aabb>,
    y: Vec<Aabb>,
    /// `xy[i][j]`, `xz[i][k]`, `yz[j][k]`: boxes of the columns of cells.
    xy: Vec<Aabb>,
    xz: Vec<Aabb>,
    yz: Vec<Aabb>,
    /// `layer[j][k]`: boxes of what is beyond x-plane i, while i falls.
    layer: Vec<Aabb>,
    /// Triangles by x slab: those of slab i are `by_x[x_start[i]..x_start[i + 1]]`.
    by_x: Vec<u32>,
    x_start: Vec<u32>,
    /// What is beyond the plane below each x slab.
    beyond_x: Vec<BeyondX<K>>,
    x_terms: Vec<i64>,
    states: Vec<State<K>>,
    y_terms: Vec<i64>,
    /// Boxes of a row of slabs, and those of them that hold a triangle.
    row: Vec<Aabb>,
    packed: Vec<Aabb>,
    last: LastAxis<K>,
}

/// A run of a table.
#[derive(Clone, Copy, Default)]
struct Run {
    first: u32,
    len: u32,
}

impl Run {
    fn new(first: usize, len: usize) -> Self {
        Self { first: first as u32, len: len as u32 }
    }

    fn range(self) -> std::ops::Range<usize> {
        let first = self.first as usize;
        first..first + self.len as usize
    }
}

/// What is left beyond an x plane, from x slab i on.
#[derive(Clone, Copy)]
struct BeyondX<const K: usize> {
    /// Terms of x slabs i … i, i … i + 1 and so on.
    terms: Run,
    /// Least cost of cutting off all x slabs before, by planes used.
    before: ByPlanes<K>,
    /// Least cost of what is left, by planes left.
    after: ByPlanes<K>,
    /// One state for each of its y slabs that hold a triangle; none where they cannot matter.
    states: Run,
}

/// What is left beyond an x plane and a y plane.
#[derive(Clone, Copy)]
struct State<const K: usize> {
    /// Its first y slab.
    slab: u32,
    /// Terms of the y slabs of this state, of this one and the next, and so on.
    terms: Run,
    /// Least cost of cutting off all that is not left, by planes used.
    before: ByPlanes<K>,
    /// Least cost of what is left, by planes left: of z only, and then of y as well.
    after: ByPlanes<K>,
}

/// What is the same in all of a node's search.
#[derive(Clone, Copy)]
pub struct Node<'a> {
    /// Its triangles.
    pub triangles: &'a [Triangle],
    /// Their cells.
    pub cells: &'a Cells,
    /// Its children's cost.
    pub cost: ChildCost,
}

impl<const K: usize> Search<K> {
    /// The first of the cheapest choices of `choose` planes; an empty one where none is admissible, `None` when the
    /// probe asked to stop. The node's columns must be there.
    pub fn run<P: Probe>(&mut self, node: &Node, choose: usize, probe: &mut P) -> Option<Choice> {
        let mut choice = Choice::new();
        if self.least(node, choose, probe)? < INADMISSIBLE {
            self.walk(node, choose, &mut choice, probe);
        }
        Some(choice)
    }

    /// Boxes of slabs and columns, and the order by x slab.
    pub fn fill<P: Probe>(&mut self, node: &Node, probe: &mut P) {
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
        self.y.clear();
        self.y.extend(self.yz.chunks_exact(sz).map(Aabb::union_of));
        probe.add(Work::BoxUnions, (3 * node.triangles.len() + sx * sy + sy * sz) as u64);
    }

    /// The cost of the cheapest admissible choice of `choose` planes.
    fn least<P: Probe>(&mut self, node: &Node, choose: usize, probe: &mut P) -> Option<i64> {
        let sx = self.x.len();
        let mut best = peel(&self.x, choose, &node.cost, probe).min(peel(&self.y, choose, &node.cost, probe));
        best = best.min(INADMISSIBLE - 1);
        self.cut_x(node, choose, &mut best, probe);
        if choose < self.y.len() {
            best = best.min(self.last.cut(&self.y, choose, best, &node.cost, probe)[choose]);
        }
        self.cut_y(node, choose, &mut best, probe);
        self.faces(node, choose, &mut best, probe);
        if !probe.go_on((self.states.len() + sx) as u64) {
            return None;
        }
        if choose > 2 {
            self.inside(node, choose, &mut best, probe)?;
        }
        // Back from the last plane to the first.
        for i in (0..sx).rev() {
            let BeyondX { states, terms, mut after, .. } = self.beyond_x[i];
            if states.len > 0 {
                self.back_y(states, probe);
                after = self.states[states.range().start].after;
            }
            for (term, beyond) in self.x_terms[terms.range()].iter().zip(&self.beyond_x[i + 1..]) {
                relax(&mut after, *term, &beyond.after);
            }
            probe.add(Work::DpSteps, u64::from(terms.len) * (K as u64 - 1));
            self.beyond_x[i].after = after;
        }
        Some(self.beyond_x[0].after[choose])
    }

    /// Costs of x slabs, of getting beyond each x plane, and of what is left there.
    fn cut_x<P: Probe>(&mut self, node: &Node, choose: usize, best: &mut i64, probe: &mut P) {
        let sx = self.x.len();
        let nowhere = BeyondX { terms: Run::default(), before: no_way(), after: no_way(), states: Run::default() };
        self.beyond_x.clear();
        self.beyond_x.resize(sx, nowhere);
        self.beyond_x[0].before[0] = 0;
        let mut rest = Aabb::EMPTY;
        for (slab, here) in self.x.iter().zip(&mut self.beyond_x).rev() {
            rest = rest.union(slab);
            here.after[0] = node.cost.term(&rest, 1);
        }
        probe.add(Work::BoxUnions, sx as u64);
        probe.add(Work::ChildCosts, sx as u64);
        self.x_terms.clear();
        for i in 0..sx {
            let (here, beyond) = self.beyond_x[i..].split_first_mut().expect("slab i");
            *best = (*best).min(here.before[choose] + here.after[0]);
            let Some(budget) = budget(&here.before, choose, *best) else { continue };
            let row = self.x_terms.len();
            let found = heads(&self.x[i..], budget, &node.cost, &mut self.x_terms, probe);
            here.terms = Run::new(row, found);
            for (term, beyond) in self.x_terms[row..].iter().zip(beyond) {
                relax(&mut beyond.before, *term, &here.before);
            }
            probe.add(Work::DpSteps, (found * (K - 1)) as u64);
        }
    }

    /// Costs of y slabs beyond each x plane, of getting beyond each of their y planes, and of what is left there.
    fn cut_y<P: Probe>(&mut self, node: &Node, choose: usize, best: &mut i64, probe: &mut P) {
        let [sx, sy, _] = node.cells.slabs;
        self.row.clear();
        self.row.resize(sy, Aabb::EMPTY);
        self.states.clear();
        self.y_terms.clear();
        for i in (0..sx).rev() {
            unite(&mut self.row, &self.xy[i * sy..][..sy], probe);
            if budget(&self.beyond_x[i].before, choose, *best).is_none() {
                continue;
            }
            let first_state = self.states.len();
            self.packed.clear();
            for (slab, aabb) in self.row.iter().enumerate().filter(|(_, b)| !b.is_empty()) {
                self.packed.push(*aabb);
                let (before, after) = (no_way(), no_way());
                self.states.push(State { slab: slab as u32, terms: Run::default(), before, after });
            }
            let slabs = self.packed.len();
            self.beyond_x[i].states = Run::new(first_state, slabs);
            self.states[first_state].before = self.beyond_x[i].before;
            let mut rest = Aabb::EMPTY;
            for (state, slab) in self.states[first_state..].iter_mut().zip(&self.packed).rev() {
                rest = rest.union(slab);
                state.after[0] = node.cost.term(&rest, 1);
            }
            probe.add(Work::BoxUnions, slabs as u64);
            probe.add(Work::ChildCosts, slabs as u64);
            for q in 0..slabs {
                let (here, beyond) = self.states[first_state + q..].split_first_mut().expect("state q");
                *best = (*best).min(here.before[choose] + here.after[0]);
                let Some(budget) = budget(&here.before, choose, *best) else { continue };
                let row = self.y_terms.len();
                let found = heads(&self.packed[q..], budget, &node.cost, &mut self.y_terms, probe);
                here.terms = Run::new(row, found);
                for (term, beyond) in self.y_terms[row..].iter().zip(beyond) {
                    relax(&mut beyond.before, *term, &here.before);
                }
                probe.add(Work::DpSteps, (found * (K - 1)) as u64);
            }
        }
    }

    /// The states that no x plane leads to, or no y plane.
    fn faces<P: Probe>(&mut self, node: &Node, choose: usize, best: &mut i64, probe: &mut P) {
        let [sx, sy, sz] = node.cells.slabs;
        self.row.clear();
        self.row.resize(sz, Aabb::EMPTY);
        let mut slab = sy;
        for state in self.beyond_x[0].states.range().rev() {
            let until = self.states[state].slab as usize;
            while slab > until {
                slab -= 1;
                unite(&mut self.row, &self.yz[slab * sz..][..sz], probe);
            }
            self.cut_z(node, state, choose, best, probe);
        }
        self.row.fill(Aabb::EMPTY);
        for i in (1..sx).rev() {
            unite(&mut self.row, &self.xz[i * sz..][..sz], probe);
            if let Some(state) = self.beyond_x[i].states.range().next() {
                self.cut_z(node, state, choose, best, probe);
            }
        }
    }

    /// The states that planes of both x and y lead to.
    fn inside<P: Probe>(&mut self, node: &Node, choose: usize, best: &mut i64, probe: &mut P) -> Option<()> {
        let [sx, sy, sz] = node.cells.slabs;
        self.layer.clear();
        self.layer.resize(sy * sz, Aabb::EMPTY);
        let mut filled = sx;
        for i in (1..sx).rev() {
            let states = self.beyond_x[i].states.range();
            let is_open = |s: &usize| budget(&self.states[*s].before, choose, *best).is_some();
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

    /// Costs of z slabs of a state whose z slabs stand in `row`, where they can matter.
    fn cut_z<P: Probe>(&mut self, node: &Node, state: usize, choose: usize, best: &mut i64, probe: &mut P) {
        let State { before, after, .. } = &mut self.states[state];
        let Some(least_used) = (0..choose).find(|used| before[*used] <= *best) else { return };
        self.packed.clear();
        self.packed.extend(self.row.iter().filter(|b| !b.is_empty()));
        let most = (choose - least_used).min(self.packed.len() - 1);
        let Some(budget) = budget(&before[choose - most..], most, *best) else { return };
        let costs = self.last.cut(&self.packed, most, budget, &node.cost, probe);
        for left in 1..=most {
            after[left] = costs[left];
            *best = (*best).min(before[choose - left] + costs[left]);
        }
    }

    /// From the last state to the first: planes of y before those of z.
    fn back_y<P: Probe>(&mut self, states: Run, probe: &mut P) {
        for state in states.range().rev() {
            let (here, beyond) = self.states[state..].split_first_mut().expect("a state");
            for (term, beyond) in self.y_terms[here.terms.range()].iter().zip(beyond) {
                relax(&mut here.after, *term, &beyond.after);
            }
            probe.add(Work::DpSteps, u64::from(here.terms.len) * (K as u64 - 1));
        }
    }

    /// The lexicographically first of the cheapest choices.
    fn walk<P: Probe>(&mut self, node: &Node, choose: usize, choice: &mut Choice, probe: &mut P) {
        let (mut left, mut i) = (choose, 0);
        let mut target = self.beyond_x[0].after[choose];
        while left > 0 {
            let terms = &self.x_terms[self.beyond_x[i].terms.range()];
            let reaches = |k: &usize| terms[*k] + self.beyond_x[i + k + 1].after[left - 1] == target;
            let Some(plane) = (0..terms.len()).find(reaches) else { break };
            choice.push(Plane { axis: 0, slab: i + plane });
            (target, left, i) = (target - terms[plane], left - 1, i + plane + 1);
        }
        if left == 0 {
            return;
        }
        let mut state = self.beyond_x[i].states.range().start;
        while left > 0 {
            let terms = &self.y_terms[self.states[state].terms.range()];
            let reaches = |k: &usize| terms[*k] + self.states[state + k + 1].after[left - 1] == target;
            let Some(plane) = (0..terms.len()).find(reaches) else { break };
            choice.push(Plane { axis: 1, slab: self.states[state + plane].slab as usize });
            (target, left, state) = (target - terms[plane], left - 1, state + plane + 1);
        }
        if left == 0 {
            return;
        }
        let j = self.states[state].slab as usize;
        self.row.clear();
        self.row.resize(node.cells.slabs[2], Aabb::EMPTY);
        for (triangle, cell) in node.triangles.iter().zip(node.cells.of_triangles()) {
            if usize::from(cell[0]) >= i && usize::from(cell[1]) >= j {
                let slab = &mut self.row[usize::from(cell[2])];
                *slab = slab.union(&triangle.aabb);
                probe.add(Work::BoxUnions, 1);
            }
        }
        let slabs: Vec<usize> = (0..self.row.len()).filter(|k| !self.row[*k].is_empty()).collect();
        self.packed.clear();
        self.packed.extend(slabs.iter().map(|k| self.row[*k]));
        let push = |slab: usize| choice.push(Plane { axis: 2, slab: slabs[slab] });
        self.last.walk(&self.packed, left, target, &node.cost, push, probe);
    }
}

/// What may still be spent where a plane must follow, `before` having been spent already; `None` if that was too much
/// or no plane can follow.
fn budget(before: &[i64], choose: usize, best: i64) -> Option<i64> {
    let least = before[..choose].iter().min()?;
    (*least <= best).then(|| best - least)
}

/// The cost of some choice, to begin with: the first slabs one by one.
fn peel<P: Probe>(slabs: &[Aabb], choose: usize, cost: &ChildCost, probe: &mut P) -> i64 {
    if choose >= slabs.len() {
        return INADMISSIBLE;
    }
    probe.add(Work::BoxUnions, (slabs.len() - choose) as u64);
    probe.add(Work::ChildCosts, choose as u64 + 1);
    let (first, rest) = slabs.split_at(choose);
    first.iter().map(|slab| cost.term(slab, 1)).sum::<i64>() + cost.term(&Aabb::union_of(rest), 1)
}

/// Unites the boxes of `row` with those of `others`, one by one.
fn unite<P: Probe>(row: &mut [Aabb], others: &[Aabb], probe: &mut P) {
    for (aabb, other) in row.iter_mut().zip(others) {
        *aabb = aabb.union(other);
    }
    probe.add(Work::BoxUnions, others.len() as u64);
}
