//! Axes: where a value goes, and which values are named.

use crate::report::number::grouped;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// A linear coordinate with ticks of our choice.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    range: Range<f64>,
    ticks: Vec<f64>,
}

impl Axis {
    /// An axis over a non-empty range.
    pub fn new(range: Range<f64>, ticks: Vec<f64>) -> Self {
        Self { range, ticks }
    }
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let part = (value - self.range.start) / (self.range.end - self.range.start);
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => Vec::new(),
            false => self.ticks.clone(),
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// The vertical axis of all panels of a sheet.
#[derive(Clone, Debug)]
pub(crate) enum Scale {
    /// Equal steps.
    Linear(Range<f64>),
    /// Equal factors; the range is of powers of ten.
    Decades(Range<i32>),
}

impl Scale {
    /// Where a value stands on the axis.
    pub fn place(&self, value: f64) -> f64 {
        match self {
            Self::Linear(_) => value,
            Self::Decades(_) => value.log10(),
        }
    }

    /// The value at a place, the inverse of [`Self::place`].
    pub fn value(&self, place: f64) -> f64 {
        match self {
            Self::Linear(_) => place,
            Self::Decades(_) => 10f64.powf(place),
        }
    }

    /// Room for the labels and the axis' name, in units of the canvas.
    pub fn label_width(&self) -> i32 {
        match self {
            Self::Linear(_) => 92,
            Self::Decades(_) => 176,
        }
    }

    /// The places it spans.
    pub fn range(&self) -> Range<f64> {
        match self {
            Self::Linear(range) => range.clone(),
            Self::Decades(range) => f64::from(range.start)..f64::from(range.end),
        }
    }

    /// The places that are named.
    pub fn ticks(&self) -> Vec<f64> {
        match self {
            Self::Linear(range) => {
                let step = nice_step(range.end - range.start);
                let (first, last) = ((range.start / step).ceil() as i64, (range.end / step).floor() as i64);
                (first..=last).map(|i| i as f64 * step).collect()
            }
            Self::Decades(range) => (range.start..=range.end).map(f64::from).collect(),
        }
    }

    /// The name of a place.
    pub fn label(&self, place: f64) -> String {
        match self {
            Self::Linear(_) => place.to_string(),
            Self::Decades(_) if place < 0.0 => format!("{:.*}", -place as usize, 10f64.powf(place)),
            Self::Decades(_) => grouped(&format!("{:.0}", 10f64.powf(place))),
        }
    }
}

/// The smallest of 1, 2, 5, 10, 20, 50, … that cuts the span into at most sixteen steps.
fn nice_step(span: f64) -> f64 {
    let steps = (0..30).flat_map(|decade| [1.0, 2.0, 5.0].map(|s| s * 10f64.powi(decade)));
    steps.into_iter().find(|step| span / step <= 16.0).unwrap_or(span)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_named_in_plain_numbers() {
        let scale = Scale::Decades(-3..7);
        let labels: Vec<_> = [-3.0, -1.0, 0.0, 3.0, 6.0].map(|t| scale.label(t)).into();
        assert_eq!(labels, ["0.001", "0.1", "1", "1,000", "1,000,000"]);
        assert_eq!(scale.ticks().len(), 11);
        assert_eq!(scale.value(scale.place(42.0)).round(), 42.0);
    }

    #[test]
    fn linear_ticks_stay_few_whatever_the_range() {
        for end in [1.0, 14.0, 17.0, 250.0, 1e6] {
            let ticks = Scale::Linear(0.0..end).ticks();
            assert!((2..=17).contains(&ticks.len()), "{end}: {ticks:?}");
            assert!(ticks.iter().all(|t| (0.0..=end).contains(t)));
        }
    }
}
