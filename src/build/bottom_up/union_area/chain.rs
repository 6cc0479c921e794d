//! Merging within one part of the clusters, by chains of nearest neighbours, while the others stand still.

use super::order::Live;
use super::quad::{Entry, LANES, NOBODY};
use super::tree::{Effort, Nearest, Stack, Tree};

/// Memory of one thread: a part of the clusters while it is worked on.
#[derive(Debug, Default)]
pub(super) struct Part {
    tree: Tree,
    handles: Vec<u32>,
    /// Clusters whose chain of nearest neighbours leads out of the part.
    blocked: Vec<bool>,
    /// The chain: positions, each with the distance to the next.
    chain: Vec<(u32, Nearest)>,
    stack: Stack,
}

/// What became of a part.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// The clusters that are left.
    pub live: Vec<Live>,
    /// The merges, in order; the k-th one's handle is `next + k`.
    pub merges: Vec<[u32; 2]>,
    /// The work.
    pub effort: Effort,
    /// Stopped on request.
    pub stopped: bool,
}

impl Part {
    /// Merges all mutually nearest clusters of the part `part` of 4^level positions, as long as there are any.
    pub fn merge_all(
        &mut self,
        whole: &Tree,
        clusters: &[Live],
        level: usize,
        part: usize,
        next: u32,
        mut go_on: impl FnMut(u64) -> bool,
    ) -> Outcome {
        let span = 1 << (2 * level);
        let mine = &clusters[part * span..((part + 1) * span).min(clusters.len())];
        self.tree.copy_part(whole, level, part, mine.len());
        self.handles.clear();
        self.handles.extend(mine.iter().map(|c| c.handle));
        self.blocked.clear();
        self.blocked.resize(mine.len(), false);
        let mut out = Outcome::default();
        let mut told = 0;
        for start in 0..mine.len() {
            if self.blocked[start] || self.handles[start] == NOBODY {
                continue;
            }
            self.chain.clear();
            self.chain.push((start as u32, Nearest::NONE));
            while let Some(&(at, bound)) = self.chain.last() {
                let at = at as usize;
                let own = self.tree.get(at);
                let before = self.chain.len().checked_sub(2).map(|k| self.chain[k]);
                let mut best = bound;
                if let Some((to, link)) = before {
                    let back = Nearest { distance: link.distance, id: self.tree.id(to as usize), at: to };
                    if best.is_after(back.distance, back.id) {
                        best = back;
                    }
                }
                out.effort.searches += 1;
                self.tree.nearest::<false>(&own.inner, 0, at, &mut best, &mut self.stack, &mut out.effort);
                if before.is_some_and(|(to, _)| to == best.at) {
                    let to = best.at as usize;
                    let other = self.tree.get(to);
                    let mut nearer = best;
                    whole.nearest::<true>(&own.inner, level, part, &mut nearer, &mut self.stack, &mut out.effort);
                    if nearer == best {
                        nearer.id = own.id;
                        let key = nearer;
                        whole.nearest::<true>(&other.inner, level, part, &mut nearer, &mut self.stack, &mut out.effort);
                        if nearer == key { nearer = best } else { nearer.id = NOBODY };
                    }
                    if nearer != best {
                        for &(at, _) in &self.chain {
                            self.blocked[at as usize] = true;
                        }
                        break;
                    }
                    let (a, b) = (self.handles[at], self.handles[to]);
                    out.merges.push(if own.id < other.id { [a, b] } else { [b, a] });
                    let merged = Entry { inner: own.inner.union(&other.inner), id: own.id.min(other.id) };
                    self.tree.set(at, &Entry::VACANT);
                    self.tree.set(to, &merged);
                    self.handles[at] = NOBODY;
                    self.handles[to] = next + out.merges.len() as u32 - 1;
                    self.chain.pop();
                    self.chain.pop();
                    match self.chain.last_mut() {
                        None => self.chain.push((to as u32, Nearest::NONE)),
                        Some((last, bound)) => {
                            let distance = self.tree.get(*last as usize).inner.union(&merged.inner).surface_area();
                            let key = Nearest { distance, id: merged.id, at: to as u32 };
                            let same = bound.distance == distance && bound.id == merged.id;
                            *bound = key;
                            if same {
                                self.chain.push((to as u32, Nearest::NONE));
                            }
                        }
                    }
                } else if best.id == NOBODY || self.blocked[best.at as usize] {
                    for &(at, _) in &self.chain {
                        self.blocked[at as usize] = true;
                    }
                    break;
                } else {
                    self.chain.last_mut().expect("not empty").1 = best;
                    self.chain.push((best.at, Nearest::NONE));
                }
                if out.effort.searches % 64 == 0 {
                    if !go_on(out.effort.quads * LANES as u64 - told) {
                        out.stopped = true;
                        return out;
                    }
                    told = out.effort.quads * LANES as u64;
                }
            }
        }
        out.live.extend(self.handles.iter().enumerate().filter(|(_, h)| **h != NOBODY).map(|(at, &handle)| {
            let entry = self.tree.get(at);
            Live { aabb: entry.inner, id: entry.id, handle }
        }));
        out
    }
}
