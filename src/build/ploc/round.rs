//! One round over the whole row: who has chosen each other merges, and the row closes up.

use super::clusters::{CHUNK, Cluster, each};
use super::merges::{Coming, Known, Merges};
use crate::build::morton::at_each_level;
use crate::simd::Simd;
use std::mem::MaybeUninit;

/// Clusters that are moved before any of them merge.
const TILE: usize = 512;

/// The role of the right one of a pair, which goes; those that stay have the number of steps to whom they merge with, or 0.
const GOES: i16 = -1;

/// What a round needs besides the row; kept from round to round.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    roles: Vec<i16>,
    next: Vec<Cluster>,
}

/// Merges all that have chosen each other: `nearest` is the number of steps to whom each has chosen, `radius` at most. Returns the
/// number of merges.
pub(super) fn merge(
    simd: Simd,
    clusters: &mut Vec<Cluster>,
    nearest: &[i16],
    radius: usize,
    scratch: &mut Scratch,
    merges: &mut Merges,
) -> usize {
    let n = clusters.len();
    let Scratch { roles, next } = scratch;
    roles.clear();
    roles.resize(n, 0);
    let mut counts = vec![(0, 0); n.div_ceil(CHUNK)];
    let tasks: Vec<_> = roles.chunks_mut(CHUNK).zip(&mut counts).zip((0..).step_by(CHUNK)).collect();
    each(tasks, |((roles, count), start)| *count = find_roles(simd, nearest, start, radius, roles));
    let merged: usize = counts.iter().map(|count| count.0).sum();
    next.clear();
    next.reserve(n - merged);
    merges.add(merged, |known, mut coming| {
        let mut places = &mut next.spare_capacity_mut()[..n - merged];
        let mut tasks = Vec::with_capacity(counts.len());
        for ((start, roles), &(lefts, rights)) in (0..).step_by(CHUNK).zip(roles.chunks(CHUNK)).zip(&counts) {
            let places = places.split_off_mut(..roles.len() - rights).expect("all but the right ones of pairs stay");
            tasks.push((start, roles, places, coming.split_off(lefts)));
        }
        each(tasks, |(start, roles, places, coming)| merge_chunk(simd, clusters, start, roles, known, places, coming));
    });
    // SAFETY: the chunks have all places between them, and each writes all of its own or panics.
    unsafe { next.set_len(n - merged) };
    std::mem::swap(clusters, next);
    merged
}

at_each_level! {
    fn find_roles(nearest: &[i16], start: usize, radius: usize, roles: &mut [i16]) -> (usize, usize) = find_roles_body
}

/// Writes the roles, all 0 before, of the clusters from `start` on. Returns how many pairs have their left and right ones there.
#[inline(always)]
fn find_roles_body(nearest: &[i16], start: usize, radius: usize, roles: &mut [i16]) -> (usize, usize) {
    for (tile, roles) in roles.chunks_mut(TILE).enumerate() {
        let start = start + tile * TILE;
        let end = start + roles.len();
        // Distance by distance: next to each other are then numbers of the same kind.
        for steps in 1..=radius.min(nearest.len() - 1) {
            let k = steps as i16;
            let last = end.min(nearest.len() - steps).max(start);
            let pairs = nearest[start..last].iter().zip(&nearest[(start + steps).min(nearest.len())..]);
            for (role, (&own, &other)) in roles.iter_mut().zip(pairs) {
                *role = if (own == k) & (other == -k) { k } else { *role };
            }
            let first = start.max(steps).min(end);
            let pairs = nearest[first..end].iter().zip(&nearest[first.saturating_sub(steps)..]);
            for (role, (&own, &other)) in roles[first - start..].iter_mut().zip(pairs) {
                *role = if (own == -k) & (other == k) { GOES } else { *role };
            }
        }
    }
    let (mut lefts, mut rights) = (0, 0);
    for roles in roles.chunks(TILE) {
        // Narrow sums: more side by side.
        lefts += usize::from(roles.iter().map(|&role| u16::from(role > 0)).sum::<u16>());
        rights += usize::from(roles.iter().map(|&role| u16::from(role < 0)).sum::<u16>());
    }
    (lefts, rights)
}

at_each_level! {
    fn merge_chunk(
        clusters: &[Cluster],
        start: usize,
        roles: &[i16],
        known: Known,
        places: &mut [MaybeUninit<Cluster>],
        coming: Coming,
    ) = merge_chunk_body
}

/// The part of [`merge`] whose clusters, or left ones of pairs, are those from `start` on.
#[inline(always)]
fn merge_chunk_body(
    clusters: &[Cluster],
    start: usize,
    roles: &[i16],
    known: Known,
    places: &mut [MaybeUninit<Cluster>],
    mut coming: Coming,
) {
    let mut pairs = [(0, 0); TILE + 1];
    let (mut place, mut index) = (0, 0);
    for at in (0..roles.len()).step_by(TILE) {
        let end = roles.len().min(at + TILE);
        // All are moved first, without branches that depend on who stays; who goes is overwritten by the next.
        let mut lefts = 0;
        for from in at..end {
            let Some(to) = places.get_mut(place) else {
                // Those that are left go.
                break;
            };
            to.write(clusters[start + from]);
            pairs[lefts] = (place, from);
            lefts += usize::from(roles[from] > 0);
            place += usize::from(roles[from] >= 0);
        }
        for &(place, from) in &pairs[..lefts] {
            let left = start + from;
            let pair = [&clusters[left], &clusters[left + roles[from] as usize]];
            places[place].write(known.merge(&mut coming, index, pair));
            index += 1;
        }
    }
    assert!((place, index) == (places.len(), coming.len()), "clusters or merges were miscounted");
}
