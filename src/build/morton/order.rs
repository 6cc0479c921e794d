//! Boxes in Morton order, and how much the codes of neighbours have in common.

use super::codes::{Codes, Grid, codes};
use super::radix::sort;
use crate::build::BuildError;
use crate::geom::Aabb;
use crate::simd::Simd;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// Items that one task compares.
const CHUNK: usize = 1 << 14;

/// Runs of equal upper halves that are worth a radix sort.
const LONG: usize = 2048;

/// Boxes in the order of their codes, of those with the same code in the order of ids.
pub(in crate::build) struct Order {
    /// Ids of boxes.
    pub ids: Vec<u32>,
    /// For each place but the last, the level of the tree at which it and the next part: equal leading bits of
    /// their codes. In a run of m equal codes it is 64, and one more each time the run is halved, the first half with m/2.
    ///
    /// Between two places with the same level there is one with a smaller level: the least of any stretch is unique.
    pub levels: Vec<u8>,
    /// Around all boxes.
    pub around: Aabb,
    /// Keys moved by the sort.
    pub moved: u64,
}

impl Order {
    /// The order of `boxes`.
    ///
    /// # Errors
    /// Boxes that [`crate::build::check_boxes`] refuses.
    pub fn new(boxes: &[Aabb], simd: Simd) -> Result<Self, BuildError> {
        let (grid, around) = Grid::around(boxes, simd)?;
        let Codes { mut upper, lower } = codes(boxes, &grid, simd);
        let mut scratch = Vec::new();
        let mut moved = sort(&mut upper, &mut scratch);
        drop(scratch);
        let n = upper.len();
        let (mut ids, mut levels) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut tasks = Vec::with_capacity(n / CHUNK + 1);
        let mut items = &mut upper[..];
        let (mut id_rest, mut level_rest) = (&mut ids.spare_capacity_mut()[..n], &mut levels.spare_capacity_mut()[..n]);
        while !items.is_empty() {
            // No run goes on in the next task.
            let mut end = items.len().min(CHUNK);
            while end < items.len() && common(items[end - 1], items[end]) == 32 {
                end += 1;
            }
            let next = items.get(end).copied();
            let part = Part {
                items: items.split_off_mut(..end).expect("no more than there are"),
                next,
                ids: id_rest.split_off_mut(..end).expect("as many as items"),
                levels: level_rest.split_off_mut(..end).expect("as many as items"),
            };
            tasks.push(part);
        }
        moved += tasks.into_par_iter().map(|part| part.finish(&lower)).sum::<u64>();
        // SAFETY: the parts have all items between them, and each writes one id and one level an item.
        unsafe {
            ids.set_len(n);
            levels.set_len(n);
        }
        levels.pop();
        Ok(Self { ids, levels, around, moved })
    }
}

/// Equal leading bits of two items' upper halves.
#[inline(always)]
fn common(a: u64, b: u64) -> u32 {
    (((a ^ b) >> 32) as u32).leading_zeros()
}

/// A stretch of sorted items that ends with a run of equal upper halves.
struct Part<'a> {
    items: &'a mut [u64],
    next: Option<u64>,
    ids: &'a mut [MaybeUninit<u32>],
    levels: &'a mut [MaybeUninit<u8>],
}

impl Part<'_> {
    /// Sorts runs of equal upper halves by the lower ones, and writes all ids and levels. Returns the keys moved.
    fn finish(self, lower: &[u32]) -> u64 {
        let mut moved = 0;
        let n = self.items.len();
        let mut place = 0;
        while place < n {
            let item = self.items[place];
            // Nothing follows the very last item: its level is not read.
            let level = self.items.get(place + 1).copied().or(self.next).map_or(0, |next| common(item, next));
            if level < 32 || place + 1 == n {
                self.ids[place].write(item as u32);
                self.levels[place].write(level as u8);
                place += 1;
                continue;
            }
            let run = self.items[place..].iter().take_while(|&&other| common(item, other) == 32).count();
            let after = place + run;
            let outside = self.items.get(after).copied().or(self.next).map_or(0, |next| common(item, next));
            for item in &mut self.items[place..after] {
                *item = u64::from(lower[*item as u32 as usize]) << 32 | *item & 0xffff_ffff;
            }
            // Ids rise within the run, so both sorts order by (lower half, id).
            if run < LONG {
                self.items[place..after].sort_unstable();
                moved += run as u64;
            } else {
                let mut long = self.items[place..after].to_vec();
                moved += sort(&mut long, &mut Vec::new());
                self.items[place..after].copy_from_slice(&long);
            }
            let sorted = &self.items[place..after];
            write_run(sorted, outside as u8, &mut self.ids[place..after], &mut self.levels[place..after]);
            place = after;
        }
        moved
    }
}

/// Writes ids and levels of a run of equal upper halves, of which `sorted` has the lower halves; `outside` is the level
/// at its end.
fn write_run(sorted: &[u64], outside: u8, ids: &mut [MaybeUninit<u32>], levels: &mut [MaybeUninit<u8>]) {
    let mut first = 0;
    for same in sorted.chunk_by(|&a, &b| common(a, b) == 32) {
        let end = first + same.len();
        let ids = ids[first..end].iter_mut();
        ids.zip(same).for_each(|(id, &item)| {
            id.write(item as u32);
        });
        let level = sorted.get(end).map_or(outside, |&next| 32 + common(same[0], next) as u8);
        levels[end - 1].write(level);
        if same.len() > 1 {
            halve(&mut levels[first..end]);
        }
        first = end;
    }
}

/// Writes the levels between equal codes, one for each; the last one, that of the end, is left alone.
fn halve(levels: &mut [MaybeUninit<u8>]) {
    let mut stack = vec![(levels, 64)];
    while let Some((levels, depth)) = stack.pop() {
        if levels.len() > 1 {
            let (left, right) = levels.split_at_mut(levels.len() / 2);
            if let Some(level) = left.last_mut() {
                level.write(depth);
            }
            stack.extend([(left, depth + 1), (right, depth + 1)]);
        }
    }
}
