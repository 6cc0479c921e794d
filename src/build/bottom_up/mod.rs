//! The thesis' bottom-up construction: agglomerative clustering without any shortcut.
//!
//! Source: Beick 2014, "Construction Algorithms", inspired by Walter et al. 2008. Every triangle starts as a cluster, two
//! clusters merge at each step until one is left; which two is what the three readings differ in:
//! `published` (a chain of nearest neighbours with a stale distance), `text` (the globally closest pair by box centres)
//! and `walter` (the globally closest pair by the area of the union, as the cited paper has it).

pub mod agglo_kd;
pub mod all_pairs_literal;
pub mod centres_exact;
pub mod chain_exact;
pub mod chain_literal;
mod clusters;
pub(super) mod merges;
mod nearest_centres;
#[cfg(test)]
mod testing;
pub mod union_area;
