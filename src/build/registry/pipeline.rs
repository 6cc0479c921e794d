//! What happens to a binary tree after it was built: refinement, then collapse. Composed in this one place.

use crate::build::{BuildError, BuildOptions, MAX_LEAF};
use crate::bvh::Bvh;
use crate::refine::Collapse;

/// How modern builders' trees get their arity unless told otherwise.
const DEFAULT_COLLAPSE: Collapse = Collapse::Optimal;

/// Builds, refines and collapses as `options` ask. `build` is told the most triangles that a leaf may hold; that is one
/// where steps follow: they move single triangles, and leaves are made last.
pub(super) fn refined(
    options: &BuildOptions,
    build: impl FnOnce(usize) -> Result<Bvh, BuildError>,
) -> Result<Bvh, BuildError> {
    let max_leaf = options.max_leaf.unwrap_or(MAX_LEAF);
    let binary = if options.refine.is_empty() { build(max_leaf)? } else { options.refine.apply(build(1)?, max_leaf) };
    let collapse = options.collapse.unwrap_or(DEFAULT_COLLAPSE);
    Ok(if options.arity == 2 { binary } else { collapse.apply(&binary, options.arity, max_leaf) })
}
