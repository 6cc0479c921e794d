//! Radix sort of keys with their ids, least digit first.

use rayon::prelude::*;

/// Values of a digit.
const RADIX: usize = 256;

/// Digits of a key.
const DIGITS: usize = 4;

/// Fewer items are sorted by comparison.
const FEWEST: usize = 512;

/// Items that make it worth while to share a pass.
const SHARED: usize = 1 << 16;

/// How often each value of a digit occurs, or where items with it go.
type Counts = [u32; RADIX];

/// The value in the upper half of `item` of digit `digit`, 0 for the lowest.
#[inline(always)]
fn digit_of(item: u64, digit: usize) -> usize {
    (item >> (32 + 8 * digit)) as usize % RADIX
}

/// Sorts items with a key in the upper half and an id in the lower one, by key, then by id. They come in rising order of
/// ids. `scratch` is any memory.
///
/// Returns how many items were moved: digits that are the same everywhere are left out.
pub(super) fn sort(items: &mut Vec<u64>, scratch: &mut Vec<u64>) -> u64 {
    debug_assert!(items.windows(2).all(|w| (w[0] as u32) < w[1] as u32));
    let n = items.len();
    if n < FEWEST {
        items.sort_unstable();
        return n as u64;
    }
    // Passes keep the order of equal digits, so neither the number of parts nor that of threads shows in the outcome.
    let parts = if n < SHARED { 1 } else { rayon::current_num_threads().min(n / (SHARED / 4)) };
    let part = n.div_ceil(parts);
    let totals = histograms(items, part);
    scratch.clear();
    scratch.reserve(n);
    let mut moved = 0;
    for (digit, totals) in totals.iter().enumerate() {
        if totals.iter().any(|&count| count as usize == n) {
            continue;
        }
        let mut starts = starts(items, part, digit, totals);
        let target = Target(scratch.as_mut_ptr());
        let tasks = items.par_chunks(part).zip(&mut starts);
        tasks.for_each(|(items, starts)| scatter(items, digit, starts, target));
        // SAFETY: `starts` sends every item to a place of its own below n: all n are written.
        unsafe { scratch.set_len(n) };
        std::mem::swap(items, scratch);
        moved += n as u64;
    }
    moved
}

/// How often each value of each digit occurs.
fn histograms(items: &[u64], part: usize) -> [Counts; DIGITS] {
    let count = |items: &[u64]| {
        let mut counts = [[0; RADIX]; DIGITS];
        for &item in items {
            (0..DIGITS).for_each(|digit| counts[digit][digit_of(item, digit)] += 1);
        }
        counts
    };
    let parts = items.par_chunks(part).map(count);
    parts.reduce(
        || [[0; RADIX]; DIGITS],
        |mut a, b| {
            a.as_flattened_mut().iter_mut().zip(b.as_flattened()).for_each(|(a, b)| *a += b);
            a
        },
    )
}

/// For each part of the items, where its first item with each value of the digit goes.
fn starts(items: &[u64], part: usize, digit: usize, totals: &Counts) -> Vec<Counts> {
    let count = |items: &[u64]| {
        let mut counts = [0; RADIX];
        items.iter().for_each(|&item| counts[digit_of(item, digit)] += 1);
        counts
    };
    let mut parts: Vec<Counts> =
        if items.len() <= part { vec![*totals] } else { items.par_chunks(part).map(count).collect() };
    let mut next = 0;
    for value in 0..RADIX {
        for counts in &mut parts {
            next += std::mem::replace(&mut counts[value], next);
        }
    }
    parts
}

/// Where items go, from all threads.
#[derive(Clone, Copy)]
struct Target(*mut u64);

// SAFETY: tasks write to places of their own, and nobody reads before all are done.
unsafe impl Send for Target {}
// SAFETY: as above.
unsafe impl Sync for Target {}

#[inline]
fn scatter(items: &[u64], digit: usize, starts: &mut Counts, target: Target) {
    for &item in items {
        let place = &mut starts[digit_of(item, digit)];
        // SAFETY: counts of all parts and values before, and of this part's items before with the same value, lead to a
        // place below the number of items that no other item has; the target holds as many.
        unsafe { target.0.add(*place as usize).write(item) };
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::testing::Random;
    use proptest::prelude::*;

    fn check(keys: impl Iterator<Item = u32>) -> u64 {
        let mut items: Vec<u64> = keys.zip(0u64..).map(|(key, id)| u64::from(key) << 32 | id).collect();
        let mut expected = items.clone();
        expected.sort();
        let moved = sort(&mut items, &mut Vec::new());
        assert!(items == expected);
        moved
    }

    #[test]
    fn digits_that_are_all_equal_cost_nothing() {
        assert_eq!(check((0..1000).map(|_| 0x0102_0304)), 0);
        assert_eq!(check((0..1000).map(|i| 0x0102_0004 | (i % 7) << 8)), 1000);
        assert_eq!(check((0..1000).map(|i| (i % 3) << 24 | (i % 5))), 2000);
    }

    #[test]
    fn any_number_of_threads() {
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut random = Random(threads as u64);
            pool.install(|| check((0..2 * SHARED + 17).map(|_| random.next() as u32 & 0xff0f_3f01)));
        }
    }

    proptest! {
        #[test]
        fn equals_the_sort_of_the_standard_library(seed: u64, n in 0usize..3000, mask: u32) {
            let mut random = Random(seed);
            check((0..n).map(|_| random.next() as u32 & mask));
        }
    }
}
