//! Repeated timing: how often, and what is kept of it.

use crate::rows::Spread;
use std::time::{Duration, Instant};

/// How often something is timed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// At most so many timed runs.
    pub runs: usize,
    /// No further run begins when those so far, the warm-up included, took this long.
    pub enough: Duration,
    /// Whether the very first build counts, and no other (see [`super::measure_build`]): in a fresh process, a build into
    /// fresh memory.
    pub cold: bool,
}

impl Default for Repeats {
    /// Five runs, but not more than about a second.
    fn default() -> Self {
        Self { runs: 5, enough: Duration::from_secs(1), cold: false }
    }
}

/// Median, least and greatest of `values`; `None` of none.
pub fn spread(mut values: Vec<f64>) -> Option<Spread> {
    values.sort_by(f64::total_cmp);
    let (&min, &max) = (values.first()?, values.last()?);
    let n = values.len();
    let median = 0.5 * (values[(n - 1) / 2] + values[n / 2]);
    Some(Spread { median, min, max, runs: n })
}

/// Times `run` repeatedly, in seconds. The first run warms caches and memory up and counts only where it already took
/// all the time there was.
///
/// # Errors
/// The first error of `run`.
pub fn repeat<E>(repeats: &Repeats, mut run: impl FnMut() -> Result<(), E>) -> Result<Spread, E> {
    let begin = Instant::now();
    let mut once = || {
        let start = Instant::now();
        run().map(|()| start.elapsed().as_secs_f64())
    };
    let mut seconds = vec![once()?];
    if begin.elapsed() < repeats.enough {
        seconds.clear();
        while seconds.len() < repeats.runs.max(1) && (seconds.is_empty() || begin.elapsed() < repeats.enough) {
            seconds.push(once()?);
        }
    }
    Ok(spread(seconds).expect("at least one run"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_of_few() {
        assert_eq!(spread(vec![]), None);
        let of = |v: &[f64]| spread(v.to_vec()).map(|s| (s.median, s.min, s.max, s.runs));
        assert_eq!(of(&[3.0, 1.0, 2.0]), Some((2.0, 1.0, 3.0, 3)));
        assert_eq!(of(&[4.0, 1.0, 2.0, 3.0]), Some((2.5, 1.0, 4.0, 4)));
    }

    #[test]
    fn runs_are_limited_by_number_and_by_time() {
        let mut calls = 0;
        let mut call = |repeats| {
            calls = 0;
            let spread = repeat::<()>(&repeats, || {
                calls += 1;
                Ok(())
            });
            (spread.unwrap().runs, calls)
        };
        assert_eq!(call(Repeats { runs: 3, enough: Duration::from_secs(60), cold: false }), (3, 4));
        assert_eq!(call(Repeats { runs: 3, enough: Duration::ZERO, cold: false }), (1, 1));
        assert_eq!(repeat(&Repeats::default(), || Err("no")), Err("no"));
    }
}
