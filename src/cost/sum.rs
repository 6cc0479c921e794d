//! Sums of many f64 whose error does not grow with their number.

/// A running sum with compensation: Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen",
/// ZAMM 54 (1974). For terms of one sign the relative error is about two roundings, however many there are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    /// Adds one term.
    #[inline(always)]
    pub(super) fn add(&mut self, term: f64) {
        let total = self.sum + term;
        // What the addition rounded away, exactly: from the smaller of the two.
        self.lost += if self.sum.abs() >= term.abs() { (self.sum - total) + term } else { (term - total) + self.sum };
        self.sum = total;
    }

    /// The sum so far.
    pub(super) fn value(self) -> f64 {
        self.sum + self.lost
    }
}

impl FromIterator<f64> for Sum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> Self {
        let mut sum = Self::default();
        terms.into_iter().for_each(|t| sum.add(t));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_million_equal_terms() {
        // Hard case 15; a plain sum is off by more than this asks for.
        let n = 10_000_000;
        let sum = (0..n).map(|_| 0.1).collect::<Sum>().value();
        assert!((sum / (0.1 * f64::from(n)) - 1.0).abs() < 1e-15, "{sum}");
        let plain: f64 = (0..n).map(|_| 0.1).sum();
        assert!((plain / (0.1 * f64::from(n)) - 1.0).abs() > 1e-12);
    }

    #[test]
    fn large_and_small_in_any_order() {
        assert_eq!([1.0, 1e100, 1.0, -1e100].into_iter().collect::<Sum>().value(), 2.0);
        assert_eq!([1e100, 1.0, 1.0, -1e100].into_iter().collect::<Sum>().value(), 2.0);
        assert_eq!(Sum::default().value(), 0.0);
    }
}
