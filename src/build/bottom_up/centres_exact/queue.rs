//! The heap of nearest neighbours, with the entries of the triangles apart.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

/// The handle of nothing.
pub(super) const NONE: u32 = u32::MAX;

/// What a cluster is nearest to, or a lower bound of it.
///
/// Compared by distance, then ids, then handles: a total order, so that the least entry is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Entry {
    /// Bits of the squared distance: those of numbers that are not negative are ordered as the numbers are.
    distance: u64,
    /// Smaller and larger id of the pair; both 0, before all pairs, where there is none.
    pub ids: [u32; 2],
    /// Handle of the cluster.
    pub owner: u32,
    /// Handle of the one it is nearest to, or [`NONE`].
    pub partner: u32,
}

impl Entry {
    /// Nothing is nearer to `owner` than this squared distance.
    pub fn bound(distance: f64, owner: u32) -> Self {
        Self { distance: distance.to_bits(), ids: [0, 0], owner, partner: NONE }
    }

    /// `owner` and `partner`, with ids a and b, are so far apart.
    pub fn pair(distance: f64, [a, b]: [u32; 2], owner: u32, partner: u32) -> Self {
        Self { distance: distance.to_bits(), ids: [a.min(b), a.max(b)], owner, partner }
    }

    /// The squared distance.
    pub fn distance(&self) -> f64 {
        f64::from_bits(self.distance)
    }
}

/// Entries, the least first.
///
/// Most owners are gone before their entries come up, and a heap of all would mostly be moving those about, in memory
/// too large for caches. So the heap has only those up to a horizon. When it is used up, the rest is gone through: those
/// whose owners are gone leave, the nearest quarter of the others comes into the heap.
#[derive(Debug)]
pub(super) struct Queue {
    /// Those of the triangles, which only ever leave. The least is the last.
    triangles: Vec<Entry>,
    heap: BinaryHeap<Reverse<Entry>>,
    /// The last that belongs in the heap.
    horizon: Entry,
    later: Vec<Entry>,
}

impl Queue {
    /// One entry for each triangle.
    pub fn new(mut triangles: Vec<Entry>) -> Self {
        triangles.sort_unstable_by_key(|&entry| Reverse(entry));
        Self { triangles, heap: BinaryHeap::new(), horizon: Entry::bound(0.0, 0), later: Vec::new() }
    }

    /// The least entry whose owner is `alive`; those before it are dropped.
    pub fn least(&mut self, alive: &[bool]) -> Option<Entry> {
        let gone = |entry: &Entry| !alive[entry.owner as usize];
        loop {
            while self.triangles.last().is_some_and(gone) {
                self.triangles.pop();
            }
            while self.heap.peek().is_some_and(|Reverse(entry)| gone(entry)) {
                self.heap.pop();
            }
            let heap = self.heap.peek().map(|&Reverse(entry)| entry);
            let least = self.triangles.last().copied().into_iter().chain(heap).min();
            if self.later.is_empty() || least.is_some_and(|least| least <= self.horizon) {
                return least;
            }
            self.later.retain(|entry| !gone(entry));
            let nearest = self.later.len().div_ceil(4);
            if nearest > 0 {
                self.horizon = *self.later.select_nth_unstable(nearest - 1).1;
                self.heap.extend(self.later.drain(..nearest).map(Reverse));
            }
        }
    }

    /// Puts `entry` in the place of `least`, which [`Self::least`] just returned.
    pub fn replace(&mut self, least: Entry, entry: Entry) {
        if self.triangles.last() == Some(&least) {
            self.triangles.pop();
        } else if let Some(mut top) = self.heap.peek_mut() {
            if entry <= self.horizon {
                *top = Reverse(entry);
                return;
            }
            PeekMut::pop(top);
        }
        if entry <= self.horizon {
            self.heap.push(Reverse(entry));
        } else {
            self.later.push(entry);
        }
    }
}
