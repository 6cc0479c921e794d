//! Fits in log-log space: the exponent of a power law with its confidence interval, and one constant of proportion.
//!
//! Ordinary least squares on logarithms: errors are taken to be factors, alike over the whole range and independent of each
//! other. A row of times breaks the last assumption a little (caches change with the size, for all later sizes at once),
//! so the intervals are rather too narrow than too wide.

/// y = factor · x^exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PowerLaw {
    /// The exponent.
    pub exponent: f64,
    /// y at x = 1.
    pub factor: f64,
    /// Half the width of the exponent's 95 % confidence interval; none for two points.
    pub half_width: Option<f64>,
    /// How many points.
    pub points: usize,
    /// Least and greatest x.
    pub range: (f64, f64),
}

impl PowerLaw {
    /// The law through `points` (x, y), all above 0; `None` of fewer than two sizes.
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let logs: Vec<(f64, f64)> = usable(points).map(|(x, y)| (x.ln(), y.ln())).collect();
        let n = logs.len() as f64;
        let (mx, my) = (mean(logs.iter().map(|p| p.0)), mean(logs.iter().map(|p| p.1)));
        let sxx: f64 = logs.iter().map(|(x, _)| (x - mx).powi(2)).sum();
        if logs.len() < 2 || sxx < 1e-9 {
            return None;
        }
        let sxy: f64 = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum();
        let exponent = sxy / sxx;
        let residual: f64 = logs.iter().map(|(x, y)| (y - my - exponent * (x - mx)).powi(2)).sum();
        let half_width = (logs.len() > 2).then(|| student_t_975(logs.len() - 2) * (residual / (n - 2.0) / sxx).sqrt());
        let xs = || usable(points).map(|p| p.0);
        Some(Self {
            exponent,
            factor: (my - exponent * mx).exp(),
            half_width,
            points: logs.len(),
            range: (xs().fold(f64::INFINITY, f64::min), xs().fold(0.0, f64::max)),
        })
    }

    /// y at x.
    pub fn at(&self, x: f64) -> f64 {
        self.factor * x.powf(self.exponent)
    }
}

/// y = constant · x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Proportion {
    /// The geometric mean of y/x.
    pub constant: f64,
    /// Share of the variance of log y that x explains with this one constant: 1 − Σ(ln y − ln cx)²/Σ(ln y − mean)². Negative
    /// where x does worse than no x at all. None of fewer than three points, or where y does not vary.
    pub explained: Option<f64>,
    /// The ratio y/(cx) farthest from 1.
    pub worst: f64,
    /// The standard deviation of ln y/(cx), as a factor.
    pub spread: f64,
    /// Greatest y over least y.
    pub span: f64,
    /// How many points.
    pub points: usize,
}

impl Proportion {
    /// The constant for `points` (x, y), all above 0; `None` of none.
    pub fn of(points: &[(f64, f64)]) -> Option<Self> {
        let logs: Vec<(f64, f64)> = usable(points).map(|(x, y)| (x.ln(), y.ln())).collect();
        if logs.is_empty() {
            return None;
        }
        let c = mean(logs.iter().map(|(x, y)| y - x));
        let my = mean(logs.iter().map(|p| p.1));
        let residuals = || logs.iter().map(|(x, y)| y - x - c);
        let around: f64 = residuals().map(|r| r * r).sum();
        let all: f64 = logs.iter().map(|(_, y)| (y - my).powi(2)).sum();
        let worst = residuals().fold(0.0f64, |worst, r| if r.abs() > worst.abs() { r } else { worst });
        let ys = || logs.iter().map(|p| p.1);
        Some(Self {
            constant: c.exp(),
            explained: (logs.len() > 2 && all > 1e-9).then(|| 1.0 - around / all),
            worst: worst.exp(),
            spread: (around / (logs.len() as f64 - 1.0).max(1.0)).sqrt().exp(),
            span: (ys().fold(f64::NEG_INFINITY, f64::max) - ys().fold(f64::INFINITY, f64::min)).exp(),
            points: logs.len(),
        })
    }
}

fn usable(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    points.iter().copied().filter(|(x, y)| x.is_normal() && y.is_normal() && *x > 0.0 && *y > 0.0)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), v| (sum + v, n + 1.0));
    sum / n
}

/// The 97.5 % point of Student's t with `freedom` degrees of freedom, at least 1. To 30 from the table of the NIST/SEMATECH
/// e-Handbook of Statistical Methods, 1.3.6.7.2; beyond by Fisher's expansion about the normal distribution (Abramowitz
/// and Stegun 26.7.5), which is right to three decimals there.
fn student_t_975(freedom: usize) -> f64 {
    const TABLE: [f64; 30] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
        2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
    ];
    const Z: f64 = 1.959_964;
    match TABLE.get(freedom.max(1) - 1) {
        Some(&t) => t,
        None => {
            let v = freedom as f64;
            Z + (Z.powi(3) + Z) / (4.0 * v) + (5.0 * Z.powi(5) + 16.0 * Z.powi(3) + 3.0 * Z) / (96.0 * v * v)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exact_power_law_is_found_without_doubt() {
        let points: Vec<_> = [1e3, 3e3, 1e4, 1e5, 1e6].map(|x: f64| (x, 5.0 * x.powf(1.5))).into();
        let law = PowerLaw::through(&points).unwrap();
        assert!((law.exponent - 1.5).abs() < 1e-12 && law.half_width.unwrap() < 1e-6);
        assert!((law.at(2e3) / (5.0 * 2e3f64.powf(1.5)) - 1.0).abs() < 1e-9);
        assert_eq!((law.points, law.range), (5, (1e3, 1e6)));
    }

    /// The textbook's formula, worked by hand: x = e⁰ … e⁴, y = e^(1, 2.1, 2.9, 4.2, 4.8); slope 0.97, residual sum 0.083,
    /// standard error √(0.083/3/10), t(3) = 3.182.
    #[test]
    fn the_interval_is_the_textbooks() {
        let y = [1.0f64, 2.1, 2.9, 4.2, 4.8];
        let points: Vec<_> = y.iter().enumerate().map(|(i, y)| ((i as f64).exp(), y.exp())).collect();
        let law = PowerLaw::through(&points).unwrap();
        assert!((law.exponent - 0.97).abs() < 1e-12, "{law:?}");
        let mean = 3.0;
        let residual: f64 = y.iter().enumerate().map(|(i, y)| (y - mean - 0.97 * (i as f64 - 2.0)).powi(2)).sum();
        let half = 3.182 * (residual / 3.0 / 10.0).sqrt();
        assert!((law.half_width.unwrap() - half).abs() < 1e-12 && (0.16..0.18).contains(&half), "{half}");
    }

    /// Noise of known spread: of 400 intervals about 95 in 100 hold the true exponent.
    #[test]
    fn intervals_cover_what_they_promise() {
        let mut state = 7u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut held = 0;
        for _ in 0..400 {
            let points: Vec<_> = (6..13)
                .map(|i| {
                    let x = 10f64.powf(f64::from(i) / 2.0);
                    let noise: f64 = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                    (x, 3.0 * x.powf(1.07) * (0.1 * noise).exp())
                })
                .collect();
            let law = PowerLaw::through(&points).unwrap();
            held += usize::from((law.exponent - 1.07).abs() <= law.half_width.unwrap());
        }
        assert!((360..=396).contains(&held), "{held}");
    }

    #[test]
    fn few_or_odd_points_are_no_panic() {
        assert_eq!(PowerLaw::through(&[]), None);
        assert_eq!(PowerLaw::through(&[(2.0, 3.0)]), None);
        assert_eq!(PowerLaw::through(&[(2.0, 3.0), (2.0, 4.0)]), None);
        assert_eq!(PowerLaw::through(&[(0.0, 3.0), (2.0, f64::NAN), (1.0, -1.0)]), None);
        let two = PowerLaw::through(&[(1.0, 1.0), (10.0, 100.0)]).unwrap();
        assert!((two.exponent - 2.0).abs() < 1e-12 && two.half_width.is_none());
        assert_eq!(Proportion::of(&[]), None);
        assert_eq!(Proportion::of(&[(1.0, 2.0)]).unwrap().explained, None);
    }

    #[test]
    fn one_constant_and_what_it_explains() {
        let exact = Proportion::of(&[(1.0, 2.0), (10.0, 20.0), (1e6, 2e6)]).unwrap();
        assert!((exact.constant - 2.0).abs() < 1e-12 && (exact.worst - 1.0).abs() < 1e-9);
        assert!((exact.explained.unwrap() - 1.0).abs() < 1e-12 && (exact.span - 1e6).abs() < 1e-3);
        // x says nothing of y: worse than nothing.
        let none = Proportion::of(&[(1e6, 2.0), (10.0, 3.0), (1.0, 2.0)]).unwrap();
        assert!(none.explained.unwrap() < 0.0);
        let off = Proportion::of(&[(1.0, 1.0), (1.0, 1.0), (1.0, 8.0)]).unwrap();
        assert!((off.constant - 2.0).abs() < 1e-12 && (off.worst - 4.0).abs() < 1e-9);
    }

    #[test]
    fn the_expansion_meets_the_table() {
        assert_eq!(student_t_975(3), 3.182);
        // Values of the same table.
        for (freedom, t) in [(31, 2.040), (40, 2.021), (60, 2.000), (100, 1.984)] {
            assert!((student_t_975(freedom) - t).abs() < 6e-4, "{freedom}");
        }
    }
}
