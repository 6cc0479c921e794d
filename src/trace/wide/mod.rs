//! Kernels `bvh4` and `bvh8`: four or eight boxes at a time, four triangles at a time, near children first.
//!
//! The answer is that of kernel `scalar`, bit for bit, and for the same reason (see `closest.rs`): boxes are tested by the
//! same arithmetic, lane by lane, so the test stays conservative and monotone; a triangle counts by the same f64 test, four at
//! a time, and within its own box, where that could make a difference (`watertight.rs`). Kernels `bvh4-fast` and `bvh8-fast` have
//! Möller–Trumbore in f32 instead, as most renderers do.
//!
//! Many rays at once are quicker than one after another: two are on their way at a time (`search.rs`). Trees larger than caches are on
//! huge pages (`pages.rs`), and where a ray goes next is fetched while the other has its turn. Fetching alone, on small pages, brought nothing.
//!
//! A binary tree is collapsed for what these kernels do: a leaf costs by its blocks of four triangles, not by its triangles
//! (`layout.rs`). Children are entered in an order that is kept with the node (`order.rs`).
//!
//! Kernels `bvh8-q8` and `bvh8-q16` walk the same tree with its boxes in 8 or 16 bits a coordinate, rounded outwards (`quantised.rs`).
//!
//! Rays for which f32 distances would over- or underflow, and those that count hits behind their origin, go to `scalar`'s f64
//! boxes, through the tree that the layout was made from.

mod gather;
mod instructions;
mod layout;
mod leaf;
mod node;
mod order;
mod pack;
mod pack64;
mod pages;
mod quantised;
mod search;
mod watertight;

#[cfg(test)]
mod tests;

pub use layout::WideBvh;

pub(super) use gather::wide_all_hits;
pub(super) use leaf::{Fast, Leaves, Watertight};
pub(super) use quantised::GridNode;
pub(super) use search::{OutOfRange, wide_hit, wide_hits};
