//! Two engines, one tree: what rows of the same cell have to do with each other.
//!
//! The engines `exact` and `literal` share nothing but the cost of a child, and must return the same tree. Whichever is
//! measured second is held against the first by hash.

use crate::rows::{BuildRow, Status};

/// The finished row of the other engine about the very build that `row` is about.
pub(super) fn twin<'a>(known: &'a [BuildRow], row: &BuildRow) -> Option<&'a BuildRow> {
    fn cell(r: &BuildRow) -> (&str, &str, &str, &str, usize) {
        (&r.preset, &r.scene, &r.scene_hash, r.construction.id(), r.arity)
    }
    known.iter().find(|r| r.status == Status::Ok && cell(r) == cell(row) && r.engine != row.engine)
}

/// Checks that a build has the tree of its twin.
///
/// # Errors
/// One line that names both trees.
pub(super) fn same_tree(hash: &str, twin: &BuildRow) -> Result<(), String> {
    match twin.tree_hash.as_deref() {
        Some(theirs) if theirs == hash => Ok(()),
        theirs => {
            let theirs = theirs.unwrap_or("unknown");
            Err(format!("the tree is {hash}, but that of the {} engine is {theirs}", twin.engine))
        }
    }
}

/// The row of the same engine over the same triangles whose work is this row's own: a literal build of arity 4 or 8 from
/// the bottom up collapses the binary tree of arity 2, and the collapse counts nothing.
pub(super) fn same_work<'a>(known: &'a [BuildRow], row: &BuildRow) -> Option<&'a BuildRow> {
    use crate::rows::Construction::BottomUp;
    let same = |r: &&BuildRow| {
        (r.status, r.construction, r.arity) == (Status::Ok, BottomUp, 2)
            && (&r.preset, &r.scene, &r.scene_hash, &r.engine)
                == (&row.preset, &row.scene, &row.scene_hash, &row.engine)
    };
    let collapsed = row.construction == BottomUp && row.arity > 2 && row.engine == "literal";
    known.iter().find(same).filter(|_| collapsed)
}

/// Takes the counts of [`same_work`].
pub(super) fn copy_counts(from: &BuildRow, to: &mut BuildRow) {
    to.combinations = from.combinations;
    to.box_unions = from.box_unions;
    to.original_unions = from.original_unions;
    to.pair_distances = from.pair_distances;
    to.nearest_searches = from.nearest_searches;
    to.dp_steps = from.dp_steps;
    to.search_visits = from.search_visits;
}
