//! `top-down`, preset `text`, engine `literal`: every combination of planes out of all three axes.
//!
//! Source: Beick 2014, "Construction Algorithms", as its words say ("seven of 75"). A node of more than four triangles
//! offers P evenly spaced planes per axis of its box. Every choice of arity − 1 of all 3P is evaluated: in index order
//! (x planes, then y, then z) each plane takes what lies below it of what is left, and the rest is the last child. The
//! cost is Σ SA(child); every child must hold a triangle; the lexicographically first of the cheapest wins. When no
//! choice separates, one plane fewer is tried, and so on; when not even one plane does, the list is halved by id.
//!
//! What combinations with a common prefix have in common (the triangles left, the boxes of the slabs between planes of
//! one axis) is computed once for them, and kept while planes that separate nothing leave the same triangles; each combination is evaluated and counted on its own, inadmissible ones too.
//!
//! Deviation: "centre < plane" is decided as (centre − min)·(P + 1) < (i + 1)·extent, which is the same inequality
//! without the rounding of the plane's position, so that moving a scene, where its coordinates stay exact, changes
//! no split.

use super::Text;
use crate::build::{BuildError, CHILD_COST_SCALE_BITS, ChildCost, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;

/// The term of a child without triangles: more than any admissible sum, and eight of them still fit an i64.
const INADMISSIBLE: i64 = 1 << (CHILD_COST_SCALE_BITS + 1);

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
    let mut order: Vec<u32> = (0..n as u32).collect();
    let mut nodes = vec![Node::leaf(Aabb::EMPTY, 0, 0)];
    let mut pending = vec![(0, 0..n)];
    let mut splitter = Splitter { boxes, params, levels: [const { Level::EMPTY }; 3], probe };
    while let Some((node, slots)) = pending.pop() {
        let ids = &mut order[slots.clone()];
        let aabb = Aabb::union_of(ids.iter().map(|&t| &boxes[t as usize]));
        splitter.probe.add(Work::BoxUnions, ids.len() as u64);
        if ids.len() <= MAX_LEAF {
            nodes[node] = Node::leaf(aabb, slots.start, ids.len());
            continue;
        }
        let Some(sizes) = splitter.split(ids, &aabb) else {
            let sizes = pending.iter().map(|(_, slots)| slots.len()).chain([slots.len()]);
            return Err(BuildError::Stopped(Unfinished { pending: sizes.collect() }));
        };
        let first = nodes.len();
        nodes[node] = Node::inner(aabb, first, sizes.len());
        nodes.resize(first + sizes.len(), Node::leaf(Aabb::EMPTY, 0, 0));
        let mut start = slots.start;
        for (k, size) in sizes.iter().enumerate() {
            pending.push((first + k, start..start + size));
            start += size;
        }
        let lined_up = pending.len() - sizes.len();
        pending[lined_up..].reverse();
    }
    Ok(Bvh { nodes, triangle_ids: order, arity: params.arity })
}

/// Splits one node after another, with the same tables.
struct Splitter<'a, P> {
    boxes: &'a [Aabb],
    params: &'a Text,
    levels: [Level; 3],
    probe: &'a mut P,
}

impl<P: Probe> Splitter<'_, P> {
    /// Reorders `ids` (rising, and rising within each child afterwards) and returns the children's sizes; `None` when
    /// the probe asked to stop.
    fn split(&mut self, ids: &mut [u32], aabb: &Aabb) -> Option<Vec<usize>> {
        let Text { arity, planes } = *self.params;
        let item = |&t: &u32| {
            let triangle = self.boxes[t as usize];
            Item { aabb: triangle, bins: bins(&triangle, aabb, planes) }
        };
        let triangles: Vec<Item> = ids.iter().map(item).collect();
        for choose in (1..arity).rev() {
            let mut search = Search {
                node: NodeTriangles { triangles: &triangles, planes, cost: ChildCost::new(aabb, arity) },
                best_cost: INADMISSIBLE,
                best: [0; MAX_PLANES],
                chosen: [0; MAX_PLANES],
                steps: 0,
                fillings: 0,
                probe: self.probe,
            };
            self.levels.iter_mut().for_each(|level| level.filled = Filled::NEVER);
            self.levels[0].items.clear();
            self.levels[0].items.extend(0..ids.len() as u32);
            search.fill(&mut self.levels[0], 0, 0, choose);
            search.axis(0, &mut self.levels, Chosen { depth: 0, left: choose, sum: 0 })?;
            let (best_cost, chosen) = (search.best_cost, search.best);
            if best_cost < INADMISSIBLE {
                self.probe.add(Work::Fallbacks, u64::from(choose + 1 < arity));
                return Some(partition(ids, &triangles, &chosen[..choose], planes));
            }
        }
        self.probe.add(Work::Fallbacks, 1);
        Some(vec![ids.len() / 2, ids.len() - ids.len() / 2])
    }
}

/// Sorts `ids` stably by child and returns the children's sizes.
fn partition(ids: &mut [u32], triangles: &[Item], chosen: &[usize], planes: usize) -> Vec<usize> {
    let child = |item: &Item| {
        let below = |&plane: &usize| usize::from(item.bins[plane / planes]) <= plane % planes;
        chosen.iter().position(below).unwrap_or(chosen.len())
    };
    let mut sizes = vec![0; chosen.len() + 1];
    let mut keyed: Vec<(usize, u32)> = triangles.iter().map(child).zip(ids.iter().copied()).collect();
    keyed.sort_by_key(|&(child, _)| child);
    for (slot, (child, id)) in ids.iter_mut().zip(keyed) {
        *slot = id;
        sizes[child] += 1;
    }
    sizes
}

/// Planes chosen in the widest node.
const MAX_PLANES: usize = 7;

/// A triangle within its node.
#[derive(Clone, Copy)]
struct Item {
    aabb: Aabb,
    /// Per axis, how many planes its centre is not below; it is below plane i when its bin is at most i.
    bins: [u8; 3],
}

fn bins(triangle: &Aabb, node: &Aabb, planes: usize) -> [u8; 3] {
    let offset = (triangle.centre() - node.min.as_dvec3()) * (planes + 1) as f64;
    let extent = node.extent();
    let below = |axis: usize, i: usize| offset[axis] < (i + 1) as f64 * extent[axis];
    [0, 1, 2].map(|axis| (0..planes).filter(|&i| !below(axis, i)).count() as u8)
}

/// What is left of a node when the planes of an axis come to be chosen, cut into slabs along that axis.
struct Level {
    /// What is left, as indices into the node's triangles.
    items: Vec<u32>,
    /// Boxes of the slabs; only those in `occupied` mean anything.
    slabs: Vec<Aabb>,
    /// Slabs that hold a triangle, rising.
    occupied: Vec<usize>,
    /// `cost[a·(P+2) + b]`: the child made of slabs a … b − 1.
    cost: Vec<i64>,
    /// `rest[a]`: the child made of slabs a … P.
    rest: Vec<i64>,
    /// What the tables were filled for.
    filled: Filled,
}

/// What a level holds: enough to see that it would be filled with the same again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Filled {
    /// Number of this filling; no two fillings of a node have the same.
    version: u64,
    /// Filling of the level before it that its triangles were taken from.
    from: u64,
    /// How many were taken. Planes of one axis leave nested sets, so as many of the same are the same.
    items: usize,
    /// Whether all rows of `cost` are there, or only the first.
    all_rows: bool,
}

impl Filled {
    const NEVER: Self = Self { version: 0, from: 0, items: usize::MAX, all_rows: false };
}

impl Level {
    const EMPTY: Self = Self {
        items: Vec::new(),
        slabs: Vec::new(),
        occupied: Vec::new(),
        cost: Vec::new(),
        rest: Vec::new(),
        filled: Filled::NEVER,
    };

    /// Fills the tables for planes of `axis`; the rows beyond the first only where more than one plane is `left`.
    ///
    /// A child's term changes only where a slab holds something, so the tables are filled run by run.
    fn fill<P: Probe>(&mut self, node: &NodeTriangles, axis: usize, left: usize, probe: &mut P) {
        let NodeTriangles { triangles, planes, cost } = node;
        let planes = *planes;
        self.slabs.resize(planes + 1, Aabb::EMPTY);
        self.occupied.clear();
        let mut mask = [0u64; 4];
        for &item in &self.items {
            let item = &triangles[item as usize];
            let bin = item.bins[axis];
            let (word, bit) = (usize::from(bin / 64), 1 << (bin % 64));
            let slab = &mut self.slabs[usize::from(bin)];
            *slab = if mask[word] & bit == 0 { item.aabb } else { slab.union(&item.aabb) };
            mask[word] |= bit;
        }
        probe.add(Work::BoxUnions, self.items.len() as u64);
        for (word, mut bits) in mask.into_iter().enumerate() {
            while bits != 0 {
                self.occupied.push(word * 64 + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
        let width = planes + 2;
        self.cost.resize(width * width, 0);
        let mut skip = 0;
        for a in 0..if left > 1 { planes + 1 } else { 1 } {
            // Slabs before a are cut off; if the last of them was empty, the row is the one before.
            if self.occupied.get(skip).is_some_and(|&bin| bin < a) {
                skip += 1;
            } else if a > 0 {
                self.cost.copy_within((a - 1) * width..a * width, a * width);
                continue;
            }
            let row = &mut self.cost[a * width..(a + 1) * width];
            let (mut from, mut child) = (0, Child::NONE);
            for &bin in &self.occupied[skip..] {
                row[from..=bin].fill(child.term);
                from = bin + 1;
                child.add(&self.slabs[bin], cost, probe);
            }
            row[from..].fill(child.term);
        }
        self.rest.resize(width, INADMISSIBLE);
        let (mut to, mut child) = (width, Child::NONE);
        for &bin in self.occupied.iter().rev() {
            self.rest[bin + 1..to].fill(child.term);
            to = bin + 1;
            child.add(&self.slabs[bin], cost, probe);
        }
        self.rest[..to].fill(child.term);
    }
}

/// A child that grows slab by slab, and its term.
struct Child {
    aabb: Aabb,
    term: i64,
}

impl Child {
    const NONE: Self = Self { aabb: Aabb::EMPTY, term: INADMISSIBLE };

    fn add<P: Probe>(&mut self, slab: &Aabb, cost: &ChildCost, probe: &mut P) {
        self.aabb = self.aabb.union(slab);
        self.term = cost.term(&self.aabb, 1);
        probe.add(Work::BoxUnions, 1);
        probe.add(Work::ChildCosts, 1);
    }
}

/// A prefix of a combination.
#[derive(Clone, Copy)]
struct Chosen {
    /// Planes in it.
    depth: usize,
    /// Planes still to choose, at least one.
    left: usize,
    /// Cost of the children cut off so far.
    sum: i64,
}

/// What all combinations of one node share.
struct NodeTriangles<'a> {
    triangles: &'a [Item],
    planes: usize,
    cost: ChildCost,
}

struct Search<'a, P> {
    node: NodeTriangles<'a>,
    best_cost: i64,
    best: [usize; MAX_PLANES],
    chosen: [usize; MAX_PLANES],
    /// Combinations since the probe was last asked.
    steps: u64,
    /// Fillings of levels so far.
    fillings: u64,
    probe: &'a mut P,
}

impl<P: Probe> Search<'_, P> {
    /// Continues the prefix `so_far` with planes of `axis` and the axes after it; `levels[0]` is filled with what is
    /// left. `None` when the probe asked to stop.
    fn axis(&mut self, axis: usize, levels: &mut [Level], so_far: Chosen) -> Option<()> {
        if !self.probe.go_on(std::mem::take(&mut self.steps)) {
            return None;
        }
        self.planes_from(0, axis, levels, so_far)
    }

    /// Fills `level` with what is left for `axis`, taken from the filling `from` of the level before it.
    fn fill(&mut self, level: &mut Level, axis: usize, from: u64, left: usize) {
        self.fillings += 1;
        level.filled = Filled { version: self.fillings, from, items: level.items.len(), all_rows: left > 1 };
        level.fill(&self.node, axis, left, self.probe);
    }

    /// Continues the prefix with plane `from` of `axis` or a later one.
    fn planes_from(&mut self, from: usize, axis: usize, levels: &mut [Level], so_far: Chosen) -> Option<()> {
        let Chosen { depth, left, sum } = so_far;
        let (planes, n) = (self.node.planes, self.node.triangles.len() as u64);
        let row = from * (planes + 2);
        if left == 1 {
            let level = &levels[0];
            let below = &level.cost[row + from + 1..row + planes + 1];
            let above = &level.rest[from + 1..planes + 1];
            for (k, (below, above)) in below.iter().zip(above).enumerate() {
                let total = sum + below + above;
                self.probe.add(Work::Combinations, 1);
                self.probe.add(Work::OriginalUnions, n);
                if total < self.best_cost {
                    self.best_cost = total;
                    self.chosen[depth] = axis * planes + from + k;
                    self.best = self.chosen;
                }
            }
            self.steps += (planes - from) as u64;
        } else {
            for plane in from..planes {
                self.chosen[depth] = axis * planes + plane;
                let sum = sum + levels[0].cost[row + plane + 1];
                self.planes_from(plane + 1, axis, levels, Chosen { depth: depth + 1, left: left - 1, sum })?;
            }
        }
        if let [level, next, ..] = levels {
            let triangles = self.node.triangles;
            let is_left = |&item: &u32| usize::from(triangles[item as usize].bins[axis]) >= from;
            let taken = level.items.iter().copied().filter(is_left);
            let Filled { from: before, items, all_rows, .. } = next.filled;
            if before != level.filled.version || items != taken.clone().count() || (left > 1 && !all_rows) {
                next.items.clear();
                next.items.extend(taken);
                self.fill(next, axis + 1, level.filled.version, left);
            }
            self.axis(axis + 1, &mut levels[1..], so_far)?;
        }
        Some(())
    }
}

#[cfg(test)]
mod tests;
