//! One round over the whole row: who has chosen each other merges, and the row closes up.

use super::clusters::{CHUNK, Cluster, each};
use super::merges::{Coming, Known, Merges};
use rayon::prelude::*;
use std::mem::MaybeUninit;
use std::ops::Range;

/// Clusters that are sorted out before boxes are moved.
const TILE: usize = 512;

/// The place of the cluster that the one at `place` merges with; its own if it does not.
#[inline(always)]
fn partner(nearest: &[u32], place: u32) -> u32 {
    let other = nearest[place as usize];
    if nearest[other as usize] == place { other } else { place }
}

/// Merges all that have chosen each other. The row that is left comes into `next`. Returns the number of merges.
pub(super) fn merge(clusters: &[Cluster], nearest: &[u32], next: &mut Vec<Cluster>, merges: &mut Merges) -> usize {
    let n = clusters.len();
    let chunks: Vec<_> = (0..n).step_by(CHUNK).map(|from| from..(from + CHUNK).min(n)).collect();
    let pairs = |chunk: &Range<usize>| {
        let (mut lefts, mut rights) = (0, 0);
        for place in chunk.start as u32..chunk.end as u32 {
            let other = partner(nearest, place);
            lefts += usize::from(other > place);
            rights += usize::from(other < place);
        }
        (lefts, rights)
    };
    let counts: Vec<(usize, usize)> =
        if chunks.len() < 2 { chunks.iter().map(pairs).collect() } else { chunks.par_iter().map(pairs).collect() };
    let merged: usize = counts.iter().map(|count| count.0).sum();
    next.clear();
    next.reserve(n - merged);
    merges.add(merged, |known, mut coming| {
        let mut places = &mut next.spare_capacity_mut()[..n - merged];
        let mut tasks = Vec::with_capacity(chunks.len());
        for (chunk, (lefts, rights)) in chunks.into_iter().zip(counts) {
            let places = places.split_off_mut(..chunk.len() - rights).expect("all but the right ones of pairs stay");
            tasks.push((chunk, places, coming.split_off(lefts)));
        }
        each(tasks, |(chunk, places, coming)| merge_chunk(clusters, nearest, chunk, known, places, coming));
    });
    // SAFETY: the chunks have all places between them, and each writes all of its own or panics.
    unsafe { next.set_len(n - merged) };
    merged
}

/// The part of [`merge`] whose clusters, or left ones of pairs, are in `chunk`.
fn merge_chunk(
    clusters: &[Cluster],
    nearest: &[u32],
    chunk: Range<usize>,
    known: Known,
    places: &mut [MaybeUninit<Cluster>],
    mut coming: Coming,
) {
    let mut kept = [(0, 0); TILE];
    let mut pairs = [0; TILE];
    let (mut place, mut index) = (0, 0);
    for start in chunk.clone().step_by(TILE) {
        // Two lists first, without branches that depend on what they hold; boxes then.
        let (mut keeps, mut lefts) = (0, 0);
        for from in start as u32..chunk.end.min(start + TILE) as u32 {
            let other = partner(nearest, from);
            kept[keeps] = (from, other);
            pairs[lefts] = keeps;
            lefts += usize::from(other > from);
            keeps += usize::from(other >= from);
        }
        let places = &mut places[place..place + keeps];
        for (place, &(from, _)) in places.iter_mut().zip(&kept) {
            place.write(clusters[from as usize]);
        }
        for &at in &pairs[..lefts] {
            let (left, right) = (&clusters[kept[at].0 as usize], &clusters[kept[at].1 as usize]);
            places[at].write(known.merge(&mut coming, index, [left, right]));
            index += 1;
        }
        place += keeps;
    }
    assert!((place, index) == (places.len(), coming.len()), "clusters or merges were miscounted");
}
