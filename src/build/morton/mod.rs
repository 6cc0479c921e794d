//! Boxes along the Morton curve: what `lbvh` builds on, and where `ploc` looks for neighbours.
//!
//! Sources: Lauterbach et al. 2009, "Fast BVH Construction on GPUs", for the order; Karras 2012, "Maximizing Parallelism in
//! the Construction of BVHs, Octrees, and k-d Trees", for levels between neighbours.
//!
//! Codes have 63 bits, 21 an axis: at 10⁶ triangles in a corner a thousandth of the scene wide, 30 bits give whole groups
//! the same code. The price is small: keys are sorted by their upper half, and the lower half is asked for only
//! where upper halves are equal ([`Order`]).

mod codes;
mod levels;
mod order;
mod radix;
#[cfg(test)]
mod tests;

pub(super) use levels::at_each_level;
pub(super) use order::Order;
