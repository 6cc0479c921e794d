//! Where in a pixel and on a light a ray goes: a low-discrepancy sequence, the same on every machine and for any number of
//! threads.
//!
//! The (0,2)-sequence of Sobol' (1967), Owen-scrambled and shuffled by hashing (Burley, "Practical Hash-based Owen
//! Scrambling", JCGT 9(4), 2020): every pair of dimensions is stratified in itself, and pairs are independent of each other.

/// The samples of one ray through one pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampler {
    pixel: u32,
    index: u32,
}

impl Sampler {
    /// The first sample of pixel (`x`, `y`).
    #[inline]
    pub(super) fn of_pixel(x: u32, y: u32) -> Self {
        Self { pixel: hash(x ^ hash(y)), index: 0 }
    }

    /// The `index`-th sample of the same pixel.
    #[inline]
    pub(super) fn at(self, index: u32) -> Self {
        Self { index, ..self }
    }

    /// The `number`-th choice along the ray's way.
    #[inline]
    pub(super) fn choice(self, number: u32) -> Choice {
        Choice { seed: hash(self.pixel ^ hash(number)), index: self.index }
    }
}

/// One choice of a sample, in two dimensions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    seed: u32,
    index: u32,
}

impl Choice {
    /// Two numbers of [0, 1).
    #[inline]
    pub(super) fn pair(self) -> [f32; 2] {
        let Self { seed, index } = self;
        let index = scramble(index, seed);
        [scramble(index.reverse_bits(), hash(seed ^ 1)), scramble(second_dimension(index), hash(seed ^ 2))].map(unit)
    }
}

/// The second dimension of Sobol's sequence as a fraction of 2³². Its matrix is Pascal's triangle modulo 2: bit i of the
/// reversed result is the sum of those bits j of the index whose number has all the ones of i, which the steps of a butterfly
/// add up.
fn second_dimension(index: u32) -> u32 {
    let mut sum = index;
    for (shift, mask) in [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff), (16, 0x0000_ffff)] {
        sum ^= (sum >> shift) & mask;
    }
    sum.reverse_bits()
}

/// Owen scrambling by the Laine–Karras hash, in which a bit depends on higher ones alone.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

/// A hash of 32 bits to 32 (a multiplicative mixer with full avalanche).
fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_add(0x9e37_79b9).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// The upper 24 bits as a fraction.
fn unit(x: u32) -> f32 {
    (x >> 8) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_dimensions_is_stratified() {
        // A (0,2)-sequence: of the first 16 points, one lies in each cell of 16 × 1, 8 × 2, 4 × 4, 2 × 8 and 1 × 16.
        for (x, y, number) in [(0, 0, 0), (17, 4, 1), (799, 599, 7)] {
            let points: Vec<_> = (0..16).map(|i| Sampler::of_pixel(x, y).at(i).choice(number).pair()).collect();
            for columns in [1, 2, 4, 8, 16] {
                let rows = 16 / columns;
                let mut cells: Vec<_> = points
                    .iter()
                    .map(|[u, v]| (u * columns as f32) as usize * rows + (v * rows as f32) as usize)
                    .collect();
                cells.sort_unstable();
                assert_eq!(cells, (0..16).collect::<Vec<_>>(), "{columns}");
            }
        }
    }

    #[test]
    fn the_second_dimension_is_that_of_its_direction_numbers() {
        // Kollig and Keller 2002: each is the one before, added to itself shifted by one.
        let by_directions = |index: u32| {
            let (mut sum, mut direction) = (0, 1_u32 << 31);
            for bit in 0..32 {
                sum ^= if index >> bit & 1 == 1 { direction } else { 0 };
                direction ^= direction >> 1;
            }
            sum
        };
        for index in (0..3000).chain((0..32).map(|bit| u32::MAX >> bit)) {
            assert_eq!(second_dimension(index), by_directions(index), "{index}");
        }
    }

    #[test]
    fn pixels_and_pairs_differ() {
        let pair = |x, y, number| Sampler::of_pixel(x, y).choice(number).pair();
        let first = pair(3, 4, 0);
        assert_ne!(first, pair(4, 3, 0));
        assert_ne!(first, pair(3, 4, 1));
        assert!(
            (0..1000).all(|i| Sampler::of_pixel(i, 1).at(i).choice(i).pair().iter().all(|u| (0.0..1.0).contains(u)))
        );
    }
}
