//! Rounds in which few merge, in time that goes with the merges and not with the row.
//!
//! The row becomes a linked list. Whom a cluster is nearest to can change only where one within its radius has merged or
//! gone, so only those search again, and only those can be part of a new pair: the same pairs as in [`super::round`].

use super::clusters::Cluster;
use super::merges::Merges;
use super::search::Search;

/// How much work there was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Effort {
    pub rounds: u64,
    pub pairs: u64,
}

/// Whether rounds over the whole row of `live` clusters are worth their while if one merges `merged` pairs: a merge makes
/// some 5 · radius clusters be looked at.
pub(super) fn few(merged: usize, live: usize, radius: usize) -> bool {
    merged * 8 * radius < live
}

/// A row in which clusters disappear one by one.
struct Row<'a> {
    clusters: &'a mut [Cluster],
    /// Places of neighbours; the number of clusters stands for both ends. Those of a cluster that is gone lead to where it was.
    before: Vec<u32>,
    behind: Vec<u32>,
    gone: Vec<bool>,
}

impl Row<'_> {
    fn new(clusters: &mut [Cluster]) -> Row<'_> {
        let end = clusters.len() as u32;
        let before = (0..end).map(|place| place.checked_sub(1).unwrap_or(end)).collect();
        Row { before, behind: (1..=end).collect(), gone: vec![false; clusters.len()], clusters }
    }

    fn end(&self) -> u32 {
        self.clusters.len() as u32
    }

    fn remove(&mut self, place: u32) {
        let (before, behind) = (self.before[place as usize], self.behind[place as usize]);
        if before != self.end() {
            self.behind[before as usize] = behind;
        }
        if behind != self.end() {
            self.before[behind as usize] = before;
        }
        self.gone[place as usize] = true;
    }

    /// Up to `most` clusters that follow `place` in the direction that `links` lead.
    fn walk<'b>(&'b self, links: &'b [u32], place: u32, most: usize) -> impl Iterator<Item = u32> + 'b {
        let next = move |&at: &u32| (at != self.end()).then(|| links[at as usize]);
        let there = move |&at: &u32| at != self.end() && !self.gone[at as usize];
        std::iter::successors(next(&place), next).filter(there).take(most)
    }
}

/// Goes on with rounds until one merges more than a few, or everything. The row that is left stays in `clusters`.
/// `go_on` is told of distances computed; rounds end when it says false.
pub(super) fn rounds(
    clusters: &mut Vec<Cluster>,
    search: &Search,
    radius: usize,
    merges: &mut Merges,
    mut go_on: impl FnMut(u64) -> bool,
) -> Effort {
    let mut found = Vec::new();
    let mut effort = Effort { rounds: 0, pairs: search.nearest(clusters, &mut found) };
    let mut nearest: Vec<u32> =
        (0u32..).zip(&found).map(|(own, &steps)| own.wrapping_add_signed(steps.into())).collect();
    let mut live = clusters.len();
    let mut row = Row::new(clusters);
    // Who has searched since the last round.
    let mut searched: Vec<u32> = (0..row.end()).collect();
    let (mut stretch, mut places) = (Vec::new(), Vec::new());
    while live > 1 {
        let chosen = |&place: &u32| {
            let other = nearest[place as usize];
            (nearest[other as usize] == place).then(|| (place.min(other), place.max(other)))
        };
        let mut pairs: Vec<(u32, u32)> = searched.iter().filter_map(chosen).collect();
        pairs.sort_unstable();
        pairs.dedup();
        merge(&mut row, &pairs, merges);
        live -= pairs.len();
        effort.rounds += 1;
        searched.clear();
        if live == 1 {
            break;
        }
        let so_far = effort.pairs;
        for &(left, right) in &pairs {
            // All within the radius of the new cluster or of the gap, and whom these have within theirs.
            places.clear();
            places.extend(row.walk(&row.before, left, 2 * radius));
            places.reverse();
            let first = places.len().saturating_sub(radius);
            places.extend([left].into_iter().filter(|&left| !row.gone[left as usize]));
            places.extend(row.walk(&row.behind, left, usize::MAX).take_while(|&place| place < right));
            let inner = places.len();
            places.extend(row.walk(&row.behind, right, 2 * radius));
            let last = places.len().min(inner + radius);
            stretch.clear();
            stretch.extend(places.iter().map(|&place| row.clusters[place as usize]));
            effort.pairs += search.nearest(&stretch, &mut found);
            for at in first..last {
                nearest[places[at] as usize] = places[at.wrapping_add_signed(found[at].into())];
            }
            searched.extend_from_slice(&places[first..last]);
        }
        if !go_on(effort.pairs - so_far) || !few(pairs.len(), live, radius) {
            break;
        }
    }
    let gone = row.gone;
    let mut place = 0;
    clusters.retain(|_| {
        place += 1;
        !gone[place - 1]
    });
    effort
}

/// Merges `pairs`, in rising order of left places.
fn merge(row: &mut Row, pairs: &[(u32, u32)], merges: &mut Merges) {
    merges.add(pairs.len(), |known, mut coming| {
        for (index, &(left, right)) in pairs.iter().enumerate() {
            let clusters = [&row.clusters[left as usize], &row.clusters[right as usize]];
            row.clusters[left as usize] = known.merge(&mut coming, index, clusters);
        }
    });
    pairs.iter().for_each(|&(_, right)| row.remove(right));
}
