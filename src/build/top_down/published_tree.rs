//! The tree of `top-down published`: from one node to its children, whoever chooses the splits.
//!
//! Source: Beick 2014, "Construction Algorithms", as its program did it: one array of triangle ids that every node permutes
//! in place, nodes taken depth first from left to right, and rule Q8 where no choice exists.

use super::Published;
use crate::build::{BuildError, MAX_LEAF, Probe, Unfinished, Work, check_boxes};
use crate::bvh::{Bvh, Node};
use crate::geom::Aabb;
use ordered_float::OrderedFloat;

/// Splits of the widest node.
pub(super) const MAX_SPLITS: usize = 7;

/// Where a node of more than four triangles is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Choice {
    /// The axis whose order the children divide.
    pub axis: usize,
    /// Split positions, counted in strides; the first arity − 1 are used.
    pub positions: [usize; MAX_SPLITS],
}

/// How a search ended.
pub(super) enum Search {
    Best(Choice),
    /// There are too few positions for any choice.
    None,
    Stopped,
}

/// The node that a search is about.
pub(super) struct Splitting<'a> {
    pub boxes: &'a [Aabb],
    pub params: &'a Published,
    /// The node's box.
    pub aabb: Aabb,
    /// Its triangles, in no order that matters.
    pub ids: &'a mut [u32],
}

impl Splitting<'_> {
    /// Puts the triangles in the order of one axis.
    pub fn sort(&mut self, axis: usize) {
        sort(self.boxes, self.ids, axis);
    }
}

fn sort(boxes: &[Aabb], ids: &mut [u32], axis: usize) {
    ids.sort_unstable_by_key(|&t| (OrderedFloat(boxes[t as usize].min[axis]), t));
}

/// Builds the tree over `boxes` whose nodes are cut where `search` says.
pub(super) fn grow<P: Probe>(
    boxes: &[Aabb],
    params: &Published,
    probe: &mut P,
    search: impl FnMut(Splitting, &mut P) -> Search,
) -> Result<Bvh, BuildError> {
    check_boxes(boxes)?;
    params.check()?;
    let mut builder = Builder {
        boxes,
        params,
        order: (0..boxes.len() as u32).collect(),
        nodes: vec![Node::leaf(Aabb::EMPTY, 0, 0)],
        pending: vec![Pending { node: 0, start: 0, n: boxes.len() }],
        search,
        probe,
    };
    while let Some(next) = builder.pending.pop() {
        builder.node(next)?;
    }
    Ok(Bvh { nodes: builder.nodes, triangle_ids: builder.order, arity: params.arity })
}

/// A node that waits for its box and its children.
#[derive(Clone, Copy)]
struct Pending {
    node: usize,
    start: usize,
    n: usize,
}

struct Builder<'a, P, S> {
    boxes: &'a [Aabb],
    params: &'a Published,
    /// Triangle ids by slot, permuted in place; leaves read their slots when the whole build is over.
    order: Vec<u32>,
    nodes: Vec<Node>,
    pending: Vec<Pending>,
    search: S,
    probe: &'a mut P,
}

impl<P: Probe, S: FnMut(Splitting, &mut P) -> Search> Builder<'_, P, S> {
    fn node(&mut self, p: Pending) -> Result<(), BuildError> {
        let Pending { node, start, n } = p;
        let slots = start..start + n;
        let aabb = Aabb::union_of(self.order[slots.clone()].iter().map(|&t| &self.boxes[t as usize]));
        self.probe.add(Work::BoxUnions, n as u64);
        if n <= MAX_LEAF {
            self.nodes[node] = Node::leaf(aabb, start, n);
            return Ok(());
        }
        let (boxes, params) = (self.boxes, self.params);
        let splitting = Splitting { boxes, params, aabb, ids: &mut self.order[slots.clone()] };
        match (self.search)(splitting, self.probe) {
            Search::Stopped => Err(self.stopped(n)),
            Search::Best(choice) => {
                sort(boxes, &mut self.order[slots], choice.axis);
                let stride = params.stride(n);
                let ends = choice.positions[..params.arity - 1].iter().map(|p| p * stride).chain([n]);
                let mut from = 0;
                let children: Vec<_> = ends.map(|to| (std::mem::replace(&mut from, to), to)).collect();
                self.split(node, aabb, children.len(), |k, first| {
                    let (from, to) = children[k];
                    Pending { node: first + k, start: start + from, n: to - from }
                });
                Ok(())
            }
            Search::None => {
                self.without_combination(node, aabb, start, n);
                Ok(())
            }
        }
    }

    /// Makes `count` children of `node` and lines them up, the leftmost next.
    fn split(&mut self, node: usize, aabb: Aabb, count: usize, child: impl Fn(usize, usize) -> Pending) {
        let first = self.nodes.len();
        self.nodes[node] = Node::inner(aabb, first, count);
        self.nodes.resize(first + count, Node::leaf(Aabb::EMPTY, 0, 0));
        self.pending.extend((0..count).rev().map(|k| child(k, first)));
    }

    /// Nodes of 5 to 7 triangles at arity 8: rule Q8 of the specification, or one child per triangle.
    fn without_combination(&mut self, node: usize, aabb: Aabb, start: usize, n: usize) {
        if self.params.q8 {
            self.probe.add(if start == 0 { Work::Q8AtStart } else { Work::Q8Nodes }, 1);
        }
        if !self.params.q8 || start == 0 {
            self.split(node, aabb, n, |k, first| Pending { node: first + k, start: start + k, n: 1 });
            return;
        }
        // The original left split positions of −1 in place: seven children without triangles, whose boxes are those of
        // the triangles at their first slots, and an eighth that reaches one slot back into its left neighbour.
        let first = self.nodes.len();
        self.nodes[node] = Node::inner(aabb, first, 8);
        for k in 0..7 {
            let slot = if k == 0 { start } else { start - 1 };
            let aabb = self.boxes[self.order[slot] as usize];
            self.nodes.push(Node::leaf(aabb, start, 0));
        }
        self.nodes.push(Node::leaf(Aabb::EMPTY, 0, 0));
        self.pending.push(Pending { node: first + 7, start: start - 1, n: n + 1 });
    }

    fn stopped(&self, current: usize) -> BuildError {
        let pending = self.pending.iter().map(|p| p.n).chain([current]).collect();
        BuildError::Stopped(Unfinished { pending })
    }
}
