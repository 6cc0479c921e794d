//! What happens to a binary tree after it was built: refinement, then collapse. Composed in this one place.

use crate::build::{BuildError, BuildOptions, MAX_LEAF, Probe, Unfinished, Work};
use crate::bvh::Bvh;
use crate::refine::{Collapse, Refinements, Watch};

/// How modern builders' trees get their arity unless told otherwise.
const DEFAULT_COLLAPSE: Collapse = Collapse::Optimal;

/// Builds, refines and collapses as `options` ask. `build` is told the most triangles that a leaf may hold; that is one
/// where steps follow: they move single triangles, and leaves are made last.
pub(super) fn refined<P: Probe>(
    options: &BuildOptions,
    probe: &mut P,
    build: impl FnOnce(usize, &mut P) -> Result<Bvh, BuildError>,
) -> Result<Bvh, BuildError> {
    let max_leaf = options.max_leaf.unwrap_or(MAX_LEAF);
    let collapse = options.collapse.unwrap_or(DEFAULT_COLLAPSE);
    let binary = if options.refine.is_empty() {
        build(max_leaf, probe)?
    } else {
        let built = build(1, probe)?;
        // The optimal collapse makes the leaves itself: wide nodes are worth more than binary ones, and want smaller leaves.
        let in_leaf = if options.arity > 2 && collapse == Collapse::Optimal { 1 } else { max_leaf };
        steps(&options.refine, built, in_leaf, probe)?
    };
    Ok(if options.arity == 2 { binary } else { collapse.apply(&binary, options.arity, max_leaf) })
}

/// Takes the steps; their work goes to the probe.
fn steps<P: Probe>(refine: &Refinements, built: Bvh, max_leaf: usize, probe: &mut P) -> Result<Bvh, BuildError> {
    let mut go_on = |steps| probe.go_on(steps);
    let mut watch = Watch::new(&mut go_on);
    let refined = refine.apply(built, max_leaf, &mut watch);
    let (searches, visits, moves, stopped) = (watch.searches, watch.visits, watch.moves, watch.stopped());
    probe.add(Work::PlaceSearches, searches);
    probe.add(Work::PlaceVisits, visits);
    probe.add(Work::Moves, moves);
    if stopped { Err(BuildError::Stopped(Unfinished::default())) } else { Ok(refined) }
}
