//! From one search for candidates to the next: clusters merge until half are gone.
//!
//! A pair of clusters, of which one has the other as a candidate, merges when no other pair of either has a lesser key:
//! in rounds, each of which merges all such pairs at once, or by a heap of every cluster's best pair. A round looks at
//! all clusters; it pays where it merges a good part of them. The heap looks only at those near the merge. It takes
//! over when a round has merged few, as in a row of growing boxes, of which each waits for the one before.
//!
//! A merged box is no smaller than its parts, so a pair's key does not fall when its clusters merge with others (but for
//! the hash of equal areas): what a heap remembers of a pair is a lower bound, as far as order matters.

use super::candidates::NONE;
use super::{Cluster, Effort, Key};
use crate::build::bottom_up::merges::Merges;
use crate::build::{BuildError, Probe};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A round that merges fewer than one in so many clusters is the last.
const WORTHWHILE: usize = 16;

/// Clusters that a thread takes at a time.
const CHUNK: usize = 512;

/// Merges by the heap between two looks at the budget.
const BATCH: usize = 1 << 10;

/// Clusters with their candidates.
pub(super) struct Phase {
    clusters: Vec<Cluster>,
    /// `neighbours` entries a cluster, the rest [`NONE`].
    lists: Vec<u32>,
    neighbours: usize,
}

/// A cluster's best candidate.
#[derive(Clone, Copy, Debug)]
struct Best {
    key: Key,
    other: u32,
}

const NOBODY: Best = Best { key: Key(f64::INFINITY, u64::MAX), other: NONE };

impl Phase {
    pub fn new(clusters: Vec<Cluster>, lists: Vec<u32>, neighbours: usize) -> Self {
        Self { clusters, lists, neighbours }
    }

    /// Merges until at most half of the clusters are left, and returns them.
    pub fn halve<P: Probe>(
        mut self,
        merges: &mut Merges,
        effort: &mut Effort,
        probe: &mut P,
    ) -> Result<Vec<Cluster>, BuildError> {
        let goal = self.clusters.len() / 2;
        let mut best: Vec<Best> = (0..self.clusters.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|i| self.best(i, self.list(i).iter().copied()))
            .collect();
        loop {
            let before = self.clusters.len();
            effort.distances += (before * self.neighbours) as u64;
            effort.tell(before, probe)?;
            best = self.round(&best, merges);
            let merged = before - self.clusters.len();
            effort.merges += merged as u64;
            if self.clusters.len() <= goal {
                return Ok(self.clusters);
            }
            if merged * WORTHWHILE < before {
                return self.one_by_one(&best, goal, merges, effort, probe);
            }
        }
    }

    fn list(&self, index: usize) -> &[u32] {
        &self.lists[index * self.neighbours..(index + 1) * self.neighbours]
    }

    fn best(&self, index: usize, others: impl Iterator<Item = u32>) -> Best {
        let cluster = &self.clusters[index];
        others.filter(|&other| other != NONE).fold(NOBODY, |best, other| {
            let key = cluster.key(&self.clusters[other as usize]);
            if key < best.key { Best { key, other } } else { best }
        })
    }

    /// Merges all pairs that no other pair of either precedes; returns the best candidates of what is there then.
    fn round(&mut self, best: &[Best], merges: &mut Merges) -> Vec<Best> {
        // A candidate may not know of the cluster that has it as its best.
        let mut chosen = best.to_vec();
        for (index, Best { key, other }) in (0u32..).zip(best) {
            if let Some(theirs) = chosen.get_mut(*other as usize).filter(|theirs| *key < theirs.key) {
                *theirs = Best { key: *key, other: index };
            }
        }
        let partner = |index: u32| {
            let other = chosen[index as usize].other;
            chosen.get(other as usize).is_some_and(|theirs| theirs.other == index).then_some(other)
        };
        // The first of a pair stays in its place.
        let mut clusters = Vec::with_capacity(self.clusters.len());
        let mut parts = Vec::with_capacity(self.clusters.len());
        let mut places = vec![NONE; self.clusters.len()];
        for (index, cluster) in (0u32..).zip(&self.clusters) {
            let other = partner(index);
            if let Some(first) = other.filter(|&other| other < index) {
                places[index as usize] = places[first as usize];
                continue;
            }
            places[index as usize] = clusters.len() as u32;
            let second = other.map(|other| &self.clusters[other as usize]);
            clusters.push(second.map_or(*cluster, |second| cluster.merge(second, merges)));
            parts.push([index, other.unwrap_or(NONE)]);
        }
        let old = std::mem::take(&mut self.lists);
        self.clusters = clusters;
        self.lists = vec![NONE; self.clusters.len() * self.neighbours];
        let k = self.neighbours;
        let clusters = &self.clusters;
        let new = self.lists.par_chunks_exact_mut(k).zip(&parts).enumerate().with_min_len(CHUNK);
        new.map_init(Vec::new, |known, (index, (list, parts))| {
            known.clear();
            for &part in parts.iter().filter(|&&part| part != NONE) {
                let others = &old[part as usize * k..(part as usize + 1) * k];
                let others = others.iter().filter(|&&other| other != NONE).map(|&other| places[other as usize]);
                add(known, clusters, index as u32, others);
            }
            keep_best(known, list)
        })
        .collect()
    }

    /// Merges the pair of least key, again and again.
    fn one_by_one<P: Probe>(
        mut self,
        best: &[Best],
        goal: usize,
        merges: &mut Merges,
        effort: &mut Effort,
        probe: &mut P,
    ) -> Result<Vec<Cluster>, BuildError> {
        let mut heap: BinaryHeap<Next> =
            (0u32..).zip(best).filter(|(_, b)| b.other != NONE).map(|(index, &best)| Next { index, best }).collect();
        // Where each cluster is now; one that has not merged into another is where it was.
        let mut places: Vec<u32> = (0..self.clusters.len() as u32).collect();
        // The best that the heap knows of: other entries are out of date.
        let mut current: Vec<u32> = best.iter().map(|b| b.other).collect();
        let mut known = Vec::new();
        let mut left = self.clusters.len();
        while left > goal {
            let Some(Next { index, best }) = heap.pop() else { break };
            let other = best.other;
            if places[index as usize] != index || current[index as usize] != other {
                continue;
            }
            known.clear();
            let mut parts = [index, NONE];
            if places[other as usize] == other
                && self.clusters[index as usize].key(&self.clusters[other as usize]) == best.key
            {
                self.clusters[index as usize] =
                    self.clusters[index as usize].merge(&self.clusters[other as usize], merges);
                places[other as usize] = index;
                parts[1] = other;
                left -= 1;
                effort.merges += 1;
                if effort.merges as usize >= BATCH {
                    effort.tell(left, probe)?;
                }
            }
            for part in parts.into_iter().filter(|&part| part != NONE) {
                let others = self.list(part as usize).iter().filter(|&&other| other != NONE);
                add(&mut known, &self.clusters, index, others.map(|&other| place(&mut places, other)));
            }
            effort.distances += known.len() as u64;
            let k = self.neighbours;
            let best = keep_best(&mut known, &mut self.lists[index as usize * k..(index as usize + 1) * k]);
            current[index as usize] = best.other;
            if best.other != NONE {
                heap.push(Next { index, best });
            }
        }
        let here = |index: &usize| places[*index] as usize == *index;
        Ok((0..self.clusters.len()).filter(here).map(|index| self.clusters[index]).collect())
    }
}

/// Where `index` has merged into, looked up quicker next time.
fn place(places: &mut [u32], mut index: u32) -> u32 {
    while places[index as usize] != index {
        places[index as usize] = places[places[index as usize] as usize];
        index = places[index as usize];
    }
    index
}

/// Adds candidates of cluster `index` that are not known yet.
fn add(known: &mut Vec<Best>, clusters: &[Cluster], index: u32, others: impl Iterator<Item = u32>) {
    for other in others {
        if other != index && known.iter().all(|k| k.other != other) {
            known.push(Best { key: clusters[index as usize].key(&clusters[other as usize]), other });
        }
    }
}

/// Writes the best of `known` to `list`, as many as there is room for, and returns the first of all.
fn keep_best(known: &mut [Best], list: &mut [u32]) -> Best {
    let order = |a: &Best, b: &Best| a.key.partial_cmp(&b.key).unwrap_or(Ordering::Equal);
    if known.len() > list.len() {
        known.select_nth_unstable_by(list.len() - 1, order);
    }
    let kept = &known[..known.len().min(list.len())];
    list.fill(NONE);
    list.iter_mut().zip(kept).for_each(|(entry, best)| *entry = best.other);
    kept.iter().copied().min_by(order).unwrap_or(NOBODY)
}

/// An entry of the heap, which has the least on top.
struct Next {
    index: u32,
    best: Best,
}

impl Ord for Next {
    fn cmp(&self, other: &Self) -> Ordering {
        let (Key(area, hash), Key(its_area, its_hash)) = (self.best.key, other.best.key);
        its_area.total_cmp(&area).then(its_hash.cmp(&hash)).then(other.index.cmp(&self.index))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Next {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Next {}
