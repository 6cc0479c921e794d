//! The thesis' top-down construction: exhaustive search over several splits at once.
//!
//! Source: Beick 2014, "Construction Algorithms", in two readings: what its program did (`published`, split positions
//! at evenly spaced ranks of one axis) and what its text says (`text`, evenly spaced planes of all three axes mixed).

mod arithmetic;
mod least_sum;
pub mod one_axis;
pub mod published_decisions;
pub mod published_exact;
pub mod published_literal;
mod published_tree;
pub mod text_exact;
pub mod text_literal;

pub use arithmetic::Costs;

use super::BuildError;

/// Parameters of the reading `published`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Published {
    /// Children per inner node: 2, 4 or 8.
    pub arity: usize,
    /// Candidate positions per axis before small nodes halve it; the thesis has 200/arity.
    pub candidates: usize,
    /// Whether nodes of 5 to 7 triangles at arity 8 follow rule Q8, as the original did; otherwise such a node has one
    /// child per triangle.
    pub q8: bool,
}

impl Published {
    /// The thesis' own parameters at `arity`.
    pub const fn at_arity(arity: usize) -> Self {
        Self { arity, candidates: 200 / arity, q8: true }
    }

    /// Refuses what no engine can work with.
    ///
    /// # Errors
    /// An arity below 2 or above 8, or fewer candidates than children.
    pub fn check(&self) -> Result<(), BuildError> {
        if !(2..=8).contains(&self.arity) {
            return Err(BuildError::Arity(self.arity));
        }
        if self.candidates < self.arity {
            let message = format!("{} candidates cannot split into {} children", self.candidates, self.arity);
            return Err(BuildError::Parameter(message));
        }
        Ok(())
    }

    /// Distance in ranks between neighbouring candidates in a node of `n` triangles: ⌊n/D⌋, D halved until that is
    /// not 0.
    ///
    /// Where D was halved below the arity although `n` is not, every rank is a candidate: that cannot happen with the
    /// thesis' 200/arity, but keeps the arity limit with other numbers.
    pub fn stride(&self, n: usize) -> usize {
        let mut d = self.candidates;
        while n < d {
            d /= 2;
        }
        let stride = n / d.max(1);
        if (n - 1) / stride + 1 < self.arity { 1 } else { stride }
    }

    /// Number of candidates per axis in a node of `n` triangles: stride, 2·stride, … below n.
    pub fn positions(&self, n: usize) -> usize {
        (n - 1) / self.stride(n)
    }

    /// Combinations in a node of `n` triangles in closed form: 3·C(positions, arity − 1).
    pub fn combinations(&self, n: usize) -> u64 {
        3 * binomial(self.positions(n), self.arity - 1)
    }
}

/// Parameters of the reading `text`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text {
    /// Children per inner node: 2, 4 or 8.
    pub arity: usize,
    /// Candidate planes per axis; the thesis has 200/arity.
    pub planes: usize,
}

impl Text {
    /// The thesis' own parameters at `arity`.
    pub const fn at_arity(arity: usize) -> Self {
        Self { arity, planes: 200 / arity }
    }

    /// Combinations of a node at which `planes_used` planes were admissible at last: C(3P, arity − 1) and, after each
    /// failure, the choices of one plane fewer.
    pub fn combinations(&self, planes_used: usize) -> u64 {
        (planes_used.max(1)..self.arity).map(|r| binomial(3 * self.planes, r)).sum()
    }
}

/// Binomial coefficient C(n, k), saturating at `u64::MAX`.
pub fn binomial(n: usize, k: usize) -> u64 {
    if k > n {
        return 0;
    }
    let mut c: u128 = 1;
    for i in 0..k.min(n - k) as u128 {
        // Exact: c is C(n, i) here, and C(n, i)·(n − i) is a multiple of i + 1.
        c = c * (n as u128 - i) / (i + 1);
        if c > u128::from(u64::MAX) {
            return u64::MAX;
        }
    }
    c as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binomials_of_the_thesis() {
        assert_eq!(binomial(75, 7), 1_984_829_850);
        assert_eq!(binomial(150, 3), 551_300);
        assert_eq!(binomial(300, 1), 300);
        assert_eq!((binomial(5, 7), binomial(7, 7), binomial(7, 0)), (0, 1, 1));
        assert_eq!(binomial(1000, 500), u64::MAX);
    }

    #[test]
    fn candidates_follow_the_specification() {
        for arity in [2, 4, 8] {
            let p = Published::at_arity(arity);
            assert_eq!(p.candidates, [100, 50, 25][arity.ilog2() as usize - 1]);
            for n in p.candidates..5000 {
                let m = p.positions(n);
                assert!(m >= p.candidates - 1 && m <= 2 * p.candidates - 2, "{arity} {n} {m}");
            }
        }
        let p = Published::at_arity(8);
        // Small nodes: D halves to 12, 6 and 3.
        assert_eq!([5, 8, 11, 12, 23, 24].map(|n| p.stride(n)), [1, 1, 1, 1, 1, 2]);
        assert_eq!([5, 6, 7].map(|n| p.combinations(n)), [0, 0, 0]);
        assert_eq!(p.combinations(8), 3);
    }
}
