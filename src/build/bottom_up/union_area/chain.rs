//! What is mutually nearest within one part of the clusters, found by chains of nearest neighbours and merged at once.
//!
//! A chain begins anywhere and goes on from each cluster to its nearest. Keys fall along it, so it ends: at two clusters
//! nearest to each other, which merge, or at a cluster whose nearest is not in the part. By reducibility a merge takes
//! away nobody's nearest but that of the cluster just before the two, where the chain goes on.
//!
//! A cluster whose nearest stands outside the part is *blocked*, and so is one whose nearest is blocked: outside nothing
//! moves and inside nothing comes nearer, so neither merges in this phase. A chain that meets a blocked cluster is blocked
//! as a whole. Whether something outside is nearer is asked only of two that are nearest to each other inside: a
//! cluster that has more distant neighbours inside goes on with the chain, blocked or not, and is found out when its turn
//! comes.

use super::super::merges::Merges;
use super::order::Live;
use super::quad::{Entry, NOBODY};
use super::tree::{Effort, Nearest, Stack, Tree};

/// Where a phase takes place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    /// The search tree over all clusters as the phase begins.
    pub tree: &'a Tree,
    /// The clusters, in the order of its positions.
    pub clusters: &'a [Live],
    /// Levels that a part spans.
    pub span: usize,
    /// The handle after the last one in use.
    pub next: u32,
}

impl Place<'_> {
    /// Number of parts.
    pub fn parts(&self) -> usize {
        self.clusters.len().div_ceil(1 << (2 * self.span))
    }

    /// Positions of part `part`.
    fn positions(&self, part: usize) -> std::ops::Range<usize> {
        let size = 1 << (2 * self.span);
        part * size..((part + 1) * size).min(self.clusters.len())
    }
}

/// One part while it is worked on, and what became of it.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Its work.
    pub effort: Effort,
    /// Whether it stopped before it was done.
    pub stopped: bool,
    tree: Tree,
    /// By position; [`NOBODY`] where the cluster has merged into another.
    handles: Vec<u32>,
    blocked: Vec<bool>,
    chain: Vec<Link>,
    /// Pairs that merged; the k-th made handle `next + k`.
    merges: Vec<[u32; 2]>,
    stack: Stack,
}

/// A cluster of a chain.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Its position.
    at: u32,
    /// Its nearest, once the chain goes on from here; before, any other that is known, where its search can start.
    nearest: Nearest,
}

/// Searches between two looks at the budget.
const SEARCHES_BETWEEN_LOOKS: u64 = 256;

impl Part {
    /// Merges all that is mutually nearest in part `part`, until nothing is. `go_on` is told the steps and may stop it.
    pub fn merge_all(&mut self, place: &Place, part: usize, mut go_on: impl FnMut(u64) -> bool) {
        let mine = &place.clusters[place.positions(part)];
        self.effort = Effort::default();
        self.stopped = false;
        self.tree.copy_part(place.tree, place.span, part, mine.len());
        self.handles.clear();
        self.handles.extend(mine.iter().map(|c| c.handle));
        self.blocked.clear();
        self.blocked.resize(mine.len(), false);
        self.merges.clear();
        let mut told = Effort::default();
        for start in 0..mine.len() {
            if self.blocked[start] || self.handles[start] == NOBODY {
                continue;
            }
            self.chain.clear();
            self.chain.push(Link { at: start as u32, nearest: Nearest::NONE });
            while self.step(place, part) {
                if self.effort.searches - told.searches >= SEARCHES_BETWEEN_LOOKS {
                    if !go_on(self.effort.steps() - told.steps()) {
                        self.stopped = true;
                        return;
                    }
                    told = self.effort;
                }
            }
        }
        // The stop comes too late if everything has merged.
        go_on(self.effort.steps() - told.steps());
    }

    /// Searches the nearest of the chain's last cluster, and merges it or lengthens the chain. `false` when the chain is
    /// blocked.
    #[inline(always)]
    fn step(&mut self, place: &Place, part: usize) -> bool {
        let last = self.chain.len() - 1;
        let Link { at, nearest: mut best } = self.chain[last];
        let own = self.tree.get(at as usize);
        let before = last.checked_sub(1).map(|k| self.chain[k]);
        if let Some(before) = before {
            let distance = before.nearest.distance;
            best = best.or(Nearest { distance, id: self.tree.id(before.at as usize), at: before.at });
        }
        self.effort.searches += 1;
        self.tree.nearest::<false>(&own.inner, 0, at as usize, &mut best, &mut self.stack, &mut self.effort);
        if best.id == NOBODY || self.blocked[best.at as usize] {
            return self.block();
        }
        self.chain[last].nearest = best;
        if before.is_none_or(|before| before.at != best.at) {
            self.chain.push(Link { at: best.at, nearest: Nearest::NONE });
            return true;
        }
        let other = self.tree.get(best.at as usize);
        if self.nearer_outside(place, part, &own, best.distance, other.id)
            || self.nearer_outside(place, part, &other, best.distance, own.id)
        {
            return self.block();
        }
        self.merge(place.next, [(at, own), (best.at, other)]);
        true
    }

    /// Marks the whole chain; it ends here.
    #[cold]
    fn block(&mut self) -> bool {
        for link in &self.chain {
            self.blocked[link.at as usize] = true;
        }
        false
    }

    /// Whether a cluster outside the part has a smaller key with `cluster` than (distance, id).
    #[inline(always)]
    fn nearer_outside(&mut self, place: &Place, part: usize, cluster: &Entry, distance: f64, id: u32) -> bool {
        let inside = Nearest { distance, id, at: 0 };
        let mut best = inside;
        place.tree.nearest::<true>(&cluster.inner, place.span, part, &mut best, &mut self.stack, &mut self.effort);
        best != inside
    }

    /// Merges the chain's last two clusters, given with their positions, and goes on where the chain came from.
    fn merge(&mut self, next: u32, [(from, a), (to, b)]: [(u32, Entry); 2]) {
        let handles = [self.handles[from as usize], self.handles[to as usize]];
        let made = next + self.merges.len() as u32;
        self.merges.push(if a.id < b.id { handles } else { [handles[1], handles[0]] });
        let merged = Entry { inner: a.inner.union(&b.inner), id: a.id.min(b.id) };
        self.tree.set(from as usize, &Entry::VACANT);
        self.tree.set(to as usize, &merged);
        self.handles[from as usize] = NOBODY;
        self.handles[to as usize] = made;
        self.chain.truncate(self.chain.len() - 2);
        let Some(link) = self.chain.last_mut() else {
            self.chain.push(Link { at: to, nearest: Nearest::NONE });
            return;
        };
        // Nothing is nearer to the one before than its nearest was: what is as near as that need not be searched.
        let distance = self.tree.get(link.at as usize).inner.union(&merged.inner).surface_area();
        self.effort.pairs += 1;
        let known = Nearest { distance, id: merged.id, at: to };
        let as_near = !known.is_after(link.nearest.distance, link.nearest.id);
        link.nearest = known;
        if as_near {
            self.chain.push(Link { at: to, nearest: Nearest::NONE });
        }
    }

    /// Records the merges, and adds the clusters that are left to `left`, in their order.
    pub fn move_into(&self, merges: &mut Merges, next: u32, left: &mut Vec<Live>) {
        let first = merges.append(next, &self.merges);
        left.extend(self.handles.iter().enumerate().filter(|(_, h)| **h != NOBODY).map(|(at, &handle)| {
            let entry = self.tree.get(at);
            let handle = if handle < next { handle } else { handle - next + first };
            Live { aabb: entry.inner, id: entry.id, handle }
        }));
    }
}
