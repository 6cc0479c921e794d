//! The layout that the wide kernels walk: nodes that hold their children's boxes side by side, triangles in blocks of four.

use super::node::Node;
use super::order::orders;
use super::pages::{self, HugePages};
use crate::bvh::{Bvh, NodeKind};
use crate::geom::{Aabb, Triangle};
use crate::refine::collapse_by_leaf_cost;
use crate::trace::slab::reach;
use glam::Vec3;

/// Triangles of a block.
pub(in crate::trace) const BLOCK: usize = 4;

/// What a block costs, a node's boxes being one. Anything from 0.3 to 1 gives nearly the same trees: a leaf of four for one of two
/// is always worth it.
const BLOCK_COST: f64 = 0.6;

/// Marks a child that is a leaf; the rest is its first block.
pub(super) const LEAF: u32 = 1 << 31;

/// A child that is not there.
pub(super) const NONE: u32 = u32::MAX;

/// Most triangles that the collapse of a binary tree may put into a leaf: those of one block.
const MAX_LEAF: usize = BLOCK;

/// A node: the boxes of at most `W` children.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct WideNode<const W: usize> {
    /// By axis, then minimum and maximum, then child. Children that are not there have empty boxes, which no ray enters.
    pub(super) bounds: [[[f32; W]; 2]; 3],
    /// Index of a node, or [`LEAF`] and that of a block; [`NONE`].
    pub(super) child: [u32; W],
    /// For each octant of directions, the children from near to far ([`super::order`]).
    pub(super) order: [u32; 8],
}

/// At most four triangles of a leaf.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(in crate::trace) struct Block {
    /// By vertex, then axis, then triangle.
    pub vertices: [[[f32; BLOCK]; 3]; 3],
    pub ids: [u32; BLOCK],
    /// How many triangles there are.
    pub count: u32,
    /// Whether the next block belongs to the same leaf.
    pub more: bool,
}

impl Block {
    const EMPTY: Self = Self { vertices: [[[0.0; BLOCK]; 3]; 3], ids: [u32::MAX; BLOCK], count: 0, more: false };

    /// One of its triangles, as it is in the scene.
    #[inline(always)]
    pub fn triangle(&self, lane: usize) -> Triangle {
        let [a, b, c] = &self.vertices;
        Triangle::new(
            Vec3::new(a[0][lane], a[1][lane], a[2][lane]),
            Vec3::new(b[0][lane], b[1][lane], b[2][lane]),
            Vec3::new(c[0][lane], c[1][lane], c[2][lane]),
        )
    }
}

/// A tree as the wide kernels walk it, of nodes that keep their children's boxes in f32 or otherwise.
#[derive(Clone, Debug)]
pub struct WideBvh<const W: usize, N = WideNode<W>> {
    pub(super) nodes: pages::Vec<N>,
    pub(super) blocks: pages::Vec<Block>,
    /// The greatest |coordinate| of the root's box.
    pub(super) reach: f32,
    /// The most entries that a search has open at once, with room for all children of a node behind them.
    pub(super) most_open: usize,
}

impl<const W: usize> WideBvh<W> {
    /// Lays `bvh` out. A binary tree is collapsed to arity `W` by cost first, a node of more than `W` children is divided;
    /// others are taken as they are. Leaves without triangles go.
    ///
    /// # Panics
    /// On a triangle id beyond `triangles`.
    pub fn new(bvh: &Bvh, triangles: &[Triangle]) -> Self {
        let collapsed;
        let bvh = if bvh.arity <= 2 {
            collapsed =
                collapse_by_leaf_cost(bvh, W, MAX_LEAF, |triangles| BLOCK_COST * triangles.div_ceil(BLOCK) as f64);
            &collapsed
        } else {
            bvh
        };
        let (nodes, blocks) = (pages::Vec::new_in(HugePages), pages::Vec::new_in(HugePages));
        let mut wide = Self { nodes, blocks, reach: reach(&bvh.root().aabb), most_open: 0 };
        // What stands below each node still to be made: nodes of the tree, side by side; and its depth.
        let mut pending: Vec<(usize, Vec<usize>, usize)> = Vec::new();
        let top = match bvh.nodes[0].kind() {
            NodeKind::Leaf(_) => vec![0],
            NodeKind::Inner(children) => children.collect(),
        };
        wide.nodes.push(WideNode::EMPTY);
        pending.push((0, top, 1));
        while let Some((place, below, depth)) = pending.pop() {
            wide.most_open = wide.most_open.max(depth * (W - 1) + 1 + W);
            let mut node = WideNode::EMPTY;
            // More than there is room for: neighbours share a child.
            let together = below.len().div_ceil(W);
            for group in below.chunks(together.max(1)) {
                let child = match group {
                    [one] => match bvh.nodes[*one].kind() {
                        NodeKind::Leaf(slots) if slots.is_empty() => continue,
                        NodeKind::Leaf(slots) => LEAF | wide.push_leaf(&bvh.triangle_ids[slots], triangles),
                        NodeKind::Inner(children) => wide.push_node(&mut pending, children.collect(), depth + 1),
                    },
                    several => wide.push_node(&mut pending, several.to_vec(), depth + 1),
                };
                let aabb = Aabb::union_of(group.iter().map(|&n| &bvh.nodes[n].aabb));
                node.put(child, &aabb);
            }
            node.order = orders(&node.bounds);
            wide.nodes[place] = node;
        }
        wide
    }

    fn push_node(&mut self, pending: &mut Vec<(usize, Vec<usize>, usize)>, below: Vec<usize>, depth: usize) -> u32 {
        let place = self.nodes.len();
        self.nodes.push(WideNode::EMPTY);
        pending.push((place, below, depth));
        u32::try_from(place).ok().filter(|p| p & LEAF == 0).expect("more than 2³¹ nodes")
    }

    fn push_leaf(&mut self, ids: &[u32], triangles: &[Triangle]) -> u32 {
        let first = self.blocks.len();
        for some in ids.chunks(BLOCK) {
            let mut block = Block { count: some.len() as u32, more: true, ..Block::EMPTY };
            for (lane, &id) in some.iter().enumerate() {
                block.ids[lane] = id;
                for (vertex, v) in triangles[id as usize].v.iter().enumerate() {
                    (0..3).for_each(|axis| block.vertices[vertex][axis][lane] = v[axis]);
                }
            }
            self.blocks.push(block);
        }
        self.blocks.last_mut().expect("a leaf with triangles").more = false;
        u32::try_from(first).ok().filter(|f| f & LEAF == 0).expect("more than 2³¹ blocks")
    }

    /// The same tree of other nodes.
    pub(in crate::trace) fn of_nodes<N>(self) -> WideBvh<W, N>
    where
        N: for<'a> From<&'a WideNode<W>>,
    {
        let Self { nodes: exact, blocks, reach, most_open } = self;
        let mut nodes = pages::Vec::with_capacity_in(exact.len(), HugePages);
        nodes.extend(exact.iter().map(N::from));
        WideBvh { nodes, blocks, reach, most_open }
    }
}

impl<const W: usize, N> WideBvh<W, N> {
    /// Tells the processor that the node or leaf `child` will be looked at soon.
    #[inline(always)]
    pub(super) fn fetch(&self, child: u32) {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            /// Bytes that are fetched at once.
            const LINE: usize = 64;
            let (nodes, blocks) = (self.nodes.as_ptr().cast::<i8>(), self.blocks.as_ptr().cast::<i8>());
            let index = (child & !LEAF) as usize;
            // Without a branch: whether it is a leaf is what the next step has to guess anyway.
            let (node, leaf) = (index * size_of::<N>(), index * size_of::<Block>());
            let start = if child & LEAF == 0 { nodes.wrapping_add(node) } else { blocks.wrapping_add(leaf) };
            for offset in (0..size_of::<N>().max(size_of::<Block>())).step_by(LINE) {
                // SAFETY: SSE is part of x86-64; nothing is read, so any address will do.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset)) };
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = child;
    }

    /// Bytes of nodes and blocks; the scene's triangles are not needed besides.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())
    }
}

impl<const W: usize> WideNode<W> {
    pub(super) const EMPTY: Self =
        Self { bounds: [[[f32::INFINITY; W], [f32::NEG_INFINITY; W]]; 3], child: [NONE; W], order: [0; 8] };

    fn put(&mut self, child: u32, aabb: &Aabb) {
        let lane = self.count();
        self.child[lane] = child;
        for axis in 0..3 {
            (self.bounds[axis][0][lane], self.bounds[axis][1][lane]) = (aabb.min[axis], aabb.max[axis]);
        }
    }
}
