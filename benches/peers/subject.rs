//! What the benchmark asks of a library: the one interface that every peer, and the laboratory itself, stands behind.

use crate::tree::PeerTree;
use bvh_lab::geom::{Ray, Triangle};
use bvh_lab::trace::{HitRecord, Query};

/// A library with one setting of its builder.
pub trait Subject: Sync {
    /// The library.
    fn library(&self) -> &'static str;

    /// Its version.
    fn version(&self) -> String;

    /// The setting, in the library's own words.
    fn preset(&self) -> String;

    /// Whether it can build with this many threads: one always means one, more only where the build shares its work.
    fn builds_with(&self, threads: usize) -> bool {
        threads == 1
    }

    /// Whether a triangle may stand in several leaves.
    fn spatial(&self) -> bool {
        false
    }

    /// Whether its trees are traced, or only built.
    fn traced(&self) -> bool {
        true
    }

    /// Brings the triangles into the form that the library takes them in. Not timed.
    fn prepare<'a>(&'a self, triangles: &'a [Triangle], threads: usize) -> Box<dyn Prepared + 'a>;

    /// What a row calls it.
    fn name(&self) -> String {
        format!("{} {}", self.library(), self.preset())
    }
}

/// Triangles in a library's own form.
pub trait Prepared {
    /// The whole build from triangles, boxes included: what is timed. It runs inside a rayon pool of as many threads
    /// as were asked for.
    ///
    /// # Errors
    /// One line where the library gave no tree.
    fn build(&self) -> Result<Box<dyn Built + '_>, String>;
}

/// A library's tree.
pub trait Built {
    /// The tree in the laboratory's terms; `None` where the library shows no tree, or not a binary one.
    fn tree(&self) -> Option<PeerTree>;

    /// Ways of tracing through it; none where it cannot be traced so.
    fn traversals(&self, _query: Query) -> Vec<&'static str> {
        Vec::new()
    }

    /// The closest hit of every ray, or whether there is one, by the traversal of this index, on the calling thread.
    fn trace(&self, _query: Query, _traversal: usize, _rays: &[Ray], _hits: &mut [HitRecord]) {}

    /// The same, with everything that does not depend on rays done beforehand: not timed, as a library's own layouts are not.
    fn tracer(&self, query: Query, traversal: usize) -> Box<dyn Fn(&[Ray], &mut [HitRecord]) + '_> {
        Box::new(move |rays, hits| self.trace(query, traversal, rays, hits))
    }
}
