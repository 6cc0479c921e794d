//! What a finished tree is worth and looks like: walks the tree, never changes it.

mod clip;
mod epo;
mod lcv;
mod sah;
mod stats;
mod sum;

pub use epo::epo;
pub use lcv::{LeafCounts, leaf_counts};
pub use sah::{SahParams, sah};
pub use stats::{TreeStats, stats};
