//! Refinement: from a tree to a tree.

mod collapse;

pub use collapse::collapse;
