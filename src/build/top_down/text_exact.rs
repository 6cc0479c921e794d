//! `top-down`, preset `text`, engine `exact`: the choice of planes that the literal search finds, by dynamic programming.
//!
//! Source: Beick 2014, "Construction Algorithms", as its words say; the tree is that of [`super::text_literal`].
//!
//! **State.** Planes apply in index order (x, then y, then z), each taking what lies below it of what is left. So what
//! is left depends only on the last plane used on each axis: nothing below x-plane i, y-plane j, z-plane k. Children are
//! x slabs of everything, then y slabs of what is beyond i, then z slabs of what is beyond (i, j), then the rest.
//!
//! **Recurrence.** With `left` planes to go on some axis, the least cost is that of going on to the next axis, or the
//! least over the next plane p of this axis of term(slab up to p) + cost(beyond p, left − 1); with none left it is the
//! term of what is left. An empty child makes a choice inadmissible. Terms are integers, so sums are exact ([`ChildCost`]).
//!
//! **Planes dropped.** Of planes of one axis between which no triangle's centre lies, only the first can be in the answer:
//! with two of them a child is empty, and a later one can be exchanged for the first, which makes the choice smaller in
//! the lexicographic order and leaves its children as they are. A plane below or above all centres cuts off an empty
//! child or leaves one. This holds for the node and again for every state, so a grid has at most n slabs an axis.
//!
//! **Pruning.** The least cost G of getting to a state (i, j) with u planes comes first; it needs no z. With the cost U
//! of some choice known, a state is left out where G plus a lower bound of what follows exceeds U. Whatever costs exactly U
//! stays, so every optimal choice stays.
//!
//! **Ties.** From the front, the walk takes the lowest plane of the axis from which the least cost is still reached, and
//! the next axis only where there is none. A choice that goes on with a plane of this axis precedes all that do not,
//! so this is the lexicographically first of the cheapest.
//!
//! No deviation from the literal engine.

mod cells;
mod cuts;
mod search;
mod single;

use super::Text;
use crate::build::{BuildError, ChildCost, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use cells::Cells;
use search::{Node as SearchNode, Search};
use single::Single;

/// Builds the tree over `boxes`, one per triangle.
///
/// # Errors
/// Boxes that [`check_boxes`] refuses, an arity below 2 or above 8, a number of planes outside 1 … 255, or the
/// probe's stop.
pub fn build<P: Probe>(boxes: &[Aabb], params: &Text, probe: &mut P) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    if !(2..=8).contains(&params.arity) {
        return Err(BuildError::Arity(params.arity));
    }
    if !(1..=255).contains(&params.planes) {
        return Err(BuildError::Parameter(format!("{} planes per axis: use 1 to 255", params.planes)));
    }
    let n = boxes.len();
    let mut triangles: Vec<Triangle> = boxes.iter().zip(0..).map(|(&aabb, id)| Triangle { aabb, id }).collect();
    let mut scratch = triangles.clone();
    let mut cells = Cells::new(params.planes);
    let mut search = Searches::default();
    probe.add(Work::BoxUnions, n as u64);
    let root = Aabb::union_of(boxes);
    let mut nodes = vec![Node::leaf(root, 0, n)];
    let mut pending = vec![(0, 0..n)];
    while let Some((node, slots)) = pending.pop() {
        let n = slots.len();
        let aabb = nodes[node].aabb;
        if n <= MAX_LEAF {
            nodes[node] = Node::leaf(aabb, slots.start, n);
            continue;
        }
        let here = &mut triangles[slots.clone()];
        cells.fill(here, &aabb);
        let Some(choice) = search.run(here, &cells, &aabb, params.arity, probe) else {
            let sizes = pending.iter().map(|(_, slots)| slots.len()).chain([n]);
            return Err(BuildError::Stopped(Unfinished { pending: sizes.collect() }));
        };
        probe.add(Work::Fallbacks, u64::from(choice.len() + 1 < params.arity));
        probe.add(Work::BoxUnions, n as u64);
        let children = partition(here, &mut scratch[..n], &cells, &choice);
        let first = nodes.len();
        nodes[node] = Node::inner(aabb, first, children.len());
        let mut start = slots.start;
        let lined_up = pending.len();
        for (k, child) in children.iter().enumerate() {
            nodes.push(Node::leaf(child.aabb, start, child.size));
            pending.push((first + k, start..start + child.size));
            start += child.size;
        }
        pending[lined_up..].reverse();
    }
    Ok(Bvh { nodes, triangle_ids: triangles.iter().map(|t| t.id).collect(), arity: params.arity })
}

/// A triangle as it moves from slot to slot.
#[derive(Clone, Copy)]
struct Triangle {
    aabb: Aabb,
    id: u32,
}

/// A plane of the answer: it lies right above `slab`.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    slab: usize,
}

/// The planes of the answer, in index order.
type Choice = arrayvec::ArrayVec<Plane, 7>;

/// The searches for any number of planes. Three need fewer costs per state than seven.
#[derive(Default)]
struct Searches {
    single: Single,
    few: Search<4>,
    many: Search<8>,
}

impl Searches {
    /// The choice for a node with box `aabb`, without planes where nothing separates it; `None` when the probe asked to
    /// stop.
    fn run<P: Probe>(
        &mut self,
        triangles: &[Triangle],
        cells: &Cells,
        aabb: &Aabb,
        arity: usize,
        probe: &mut P,
    ) -> Option<Choice> {
        let node = SearchNode { triangles, cells, cost: ChildCost::new(aabb, arity) };
        // More planes than these leave a child empty in any case.
        let useful = cells.slabs.iter().sum::<usize>() - 3;
        let most = useful.min(arity - 1).min(triangles.len() - 1);
        if !probe.go_on(triangles.len() as u64) {
            return None;
        }
        for choose in (1..=most).rev() {
            let choice = match choose {
                4.. => {
                    if choose == most {
                        self.many.fill(&node, probe);
                    }
                    self.many.run(&node, choose, probe)?
                }
                2.. => {
                    if choose == most.min(3) {
                        self.few.fill(&node, probe);
                    }
                    self.few.run(&node, choose, probe)?
                }
                _ => self.single.run(triangles, cells, &node.cost, probe).into_iter().collect(),
            };
            if !choice.is_empty() {
                return Some(choice);
            }
        }
        Some(Choice::new())
    }
}

/// A child as the partition leaves it.
#[derive(Clone, Copy)]
struct Child {
    aabb: Aabb,
    size: usize,
}

impl Child {
    const NONE: Self = Self { aabb: Aabb::EMPTY, size: 0 };

    fn add(&mut self, triangle: &Triangle) {
        self.aabb = self.aabb.union(&triangle.aabb);
        self.size += 1;
    }
}

/// Children of the widest node.
type Children = arrayvec::ArrayVec<Child, 8>;

/// Sorts `triangles` stably by child; halves them where no plane was chosen.
fn partition(triangles: &mut [Triangle], scratch: &mut [Triangle], cells: &Cells, choice: &Choice) -> Children {
    if choice.is_empty() {
        let (a, b) = triangles.split_at(triangles.len() / 2);
        let child = |half: &[Triangle]| Child { aabb: Aabb::union_of(half.iter().map(|t| &t.aabb)), size: half.len() };
        return [child(a), child(b)].into_iter().collect();
    }
    // A plane's children come before those of the axes after it: the first plane above a triangle is a minimum.
    let last = choice.len() as u8;
    let mut child_of = [[last; 256]; 3];
    for (child, plane) in choice.iter().enumerate().rev() {
        child_of[plane.axis][..=plane.slab].fill(child as u8);
    }
    let child_of = |cell: &[u8; 4]| {
        let [x, y, z, _] = cell.map(usize::from);
        child_of[0][x].min(child_of[1][y]).min(child_of[2][z]) & 7
    };
    let mut children: Children = (0..=last).map(|_| Child::NONE).collect();
    let mut padded = [Child::NONE; 8];
    for (triangle, cell) in triangles.iter().zip(cells.of_triangles()) {
        padded[usize::from(child_of(cell))].add(triangle);
    }
    let mut next = [0; 8];
    let mut start = 0;
    for (k, child) in children.iter_mut().enumerate() {
        *child = padded[k];
        next[k] = start;
        start += child.size;
    }
    for (triangle, cell) in triangles.iter().zip(cells.of_triangles()) {
        let slot = &mut next[usize::from(child_of(cell))];
        scratch[*slot] = *triangle;
        *slot += 1;
    }
    triangles.copy_from_slice(scratch);
    children
}

#[cfg(test)]
mod tests;
