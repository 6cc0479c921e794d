//! Random numbers whose values never change: a fixed generator and our own way from bits to numbers.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;
use std::f64::consts::TAU;

/// PCG XSL 128/64 (MCG) by O'Neill (2014), started from a seed by SplitMix64.
pub(super) struct Random(Pcg64Mcg);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        let (high, low) = (split_mix(seed, 1), split_mix(seed, 2));
        Self(Pcg64Mcg::new(u128::from(high) << 64 | u128::from(low)))
    }

    /// Uniform in 0 … 1, 1 excluded: the upper 53 bits.
    pub(super) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform between `low` and `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between `low` and `high`, uniform in the logarithm.
    pub(super) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.unit())
    }

    /// One of 0 … `count` − 1, each as likely up to 2⁻⁵³.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// A point of the cube from `low` to `high` on every axis.
    pub(super) fn in_cube(&mut self, low: f64, high: f64) -> DVec3 {
        let (x, y, z) = (self.between(low, high), self.between(low, high), self.between(low, high));
        DVec3::new(x, y, z)
    }

    /// A unit vector, uniform over directions.
    pub(super) fn direction(&mut self) -> DVec3 {
        let (z, turn) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * libm::cos(turn), r * libm::sin(turn), z)
    }
}

/// The `n`-th output of SplitMix64 (Steele, Lea, Flood 2014) started at `seed`.
fn split_mix(seed: u64, n: u64) -> u64 {
    let z = seed.wrapping_add(n.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_differ_and_repeat() {
        let draw = |seed| Random::new(seed).unit();
        assert_eq!(draw(1), draw(1));
        let mut first: Vec<_> = (0..100).map(|seed| draw(seed).to_bits()).collect();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), 100);
    }

    #[test]
    fn numbers_fill_their_ranges() {
        let mut random = Random::new(7);
        let draws: Vec<_> = (0..10_000).map(|_| random.unit()).collect();
        assert!(draws.iter().all(|x| (0.0..1.0).contains(x)));
        assert!((draws.iter().sum::<f64>() / 10_000.0 - 0.5).abs() < 0.01);
        let mut seen = [0; 7];
        (0..7000).for_each(|_| seen[random.below(7)] += 1);
        assert!(seen.iter().all(|&n| n > 800));
        assert!((0..1000).all(|_| (2.0..=32.0).contains(&random.log_between(2.0, 32.0))));
        let mean = (0..10_000).map(|_| random.direction()).sum::<DVec3>() / 10_000.0;
        assert!(mean.length() < 0.03);
        assert!((random.direction().length() - 1.0).abs() < 1e-12);
    }
}
