//! How long a literal build would take: work in closed form, scaled by what was measured.
//!
//! The thesis drew a "projected plot point" for the build that it gave up. Here a build that would pass its budget gets
//! a time from its counted work: the model below predicts the elementary steps (combinations or distances) of a whole
//! build, and the steps done so far give the time per step.

use crate::build::top_down::{Published, Text};
use crate::build::{BuildOptions, MAX_LEAF, Preset, Unfinished};
use crate::rows::Construction;
use std::collections::HashMap;

/// Searches for a nearest cluster per merge of the published chain, about as measured on the thesis' scenes. It only
/// weighs chains against other builds: a projection of a chain starts from the measured number.
const SEARCHES_PER_MERGE: f64 = 3.0;

/// A model of the steps that a literal build takes.
#[derive(Clone, Debug)]
pub struct Model {
    construction: Construction,
    options: BuildOptions,
    known: HashMap<usize, f64>,
}

impl Model {
    /// The model of one builder with its options.
    pub fn new(construction: Construction, options: BuildOptions) -> Self {
        Self { construction, options, known: HashMap::new() }
    }

    /// Steps of a whole build over `n` triangles. Bottom-up by pairs: exact. Top-down: as if every node split into
    /// equal parts, averaged over sizes from n/√arity to n·√arity: equal parts reach the leaf limit all at once, so that
    /// the count of one size alone goes up and down with log n. The chain: every search scans all clusters then alive.
    pub fn steps(&mut self, n: usize) -> f64 {
        match (self.construction, self.options.preset) {
            (Construction::BottomUp, Preset::Published) => SEARCHES_PER_MERGE * (n as f64).powi(2) / 2.0,
            (Construction::BottomUp, _) => ((n as f64).powi(3) - n as f64) / 6.0,
            (Construction::TopDown, _) => self.averaged(n),
        }
    }

    fn averaged(&mut self, n: usize) -> f64 {
        const SAMPLES: i32 = 128;
        if n <= MAX_LEAF {
            return 0.0;
        }
        let arity = self.options.arity as f64;
        let mut per_triangle = 0.0;
        for i in 0..SAMPLES {
            let size = n as f64 * arity.powf((f64::from(i) + 0.5) / f64::from(SAMPLES) - 0.5);
            let size = (size.round() as usize).max(MAX_LEAF + 1);
            per_triangle += self.top_down(size) / size as f64;
        }
        n as f64 * per_triangle / f64::from(SAMPLES)
    }

    fn top_down(&mut self, n: usize) -> f64 {
        if n <= MAX_LEAF {
            return 0.0;
        }
        if let Some(&steps) = self.known.get(&n) {
            return steps;
        }
        let arity = self.options.arity;
        let candidates = self.options.candidates.unwrap_or(200 / arity);
        let own = match self.options.preset {
            Preset::Published => Published { arity, candidates, q8: self.options.q8 }.combinations(n),
            // A node of fewer triangles than children cannot fill them all.
            _ => Text { arity, planes: candidates }.combinations(arity.min(n) - 1),
        };
        let (small, larger) = (n / arity, n % arity);
        let mut steps = own as f64;
        for (size, count) in [(small, arity - larger), (small + 1, larger)] {
            if count > 0 {
                steps += count as f64 * self.top_down(size);
            }
        }
        self.known.insert(n, steps);
        steps
    }

    /// Milliseconds of a build over `n` triangles, from one over `measured_n` that took `measured_ms`.
    pub fn from_smaller(&mut self, n: usize, measured_n: usize, measured_ms: f64) -> Option<f64> {
        let (steps, measured) = (self.steps(n), self.steps(measured_n));
        (measured > 0.0).then(|| measured_ms * steps / measured)
    }

    /// Milliseconds of a whole build over `n` triangles that was stopped after `steps` and `elapsed_ms`: the time per step
    /// so far, times the steps of the whole build. `None` when no step was made.
    ///
    /// The steps of a chain follow from its own searches so far; all others from [`Model::steps`].
    pub fn from_stopped(&mut self, n: usize, left: &Unfinished, steps: u64, elapsed_ms: f64) -> Option<f64> {
        if steps == 0 {
            return None;
        }
        let done = steps as f64;
        let all = match (self.construction, self.options.preset) {
            (Construction::BottomUp, Preset::Published) => {
                // Searches per merge change little, and each looks at all clusters then alive.
                let square = |n: usize| (n as f64).powi(2);
                let alive: usize = left.pending.iter().sum();
                let share = 1.0 - square(alive) / square(n);
                if share > 0.0 { done / share } else { self.steps(n) }
            }
            _ => self.steps(n),
        };
        Some(elapsed_ms * all.max(done) / done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::bottom_up::{all_pairs_literal, all_pairs_literal::Distance, chain_literal};
    use crate::build::top_down::{binomial, published_literal, text_literal};
    use crate::build::{BuildError, Probe};
    use crate::scene::Scene;

    fn model(construction: Construction, preset: Preset, arity: usize) -> Model {
        Model::new(construction, BuildOptions { arity, preset, ..BuildOptions::default() })
    }

    #[test]
    fn small_trees_are_counted_exactly() {
        let mut published = model(Construction::TopDown, Preset::Published, 2);
        assert_eq!(published.top_down(4), 0.0);
        assert_eq!(published.top_down(5), 3.0 * 4.0);
        assert_eq!(published.top_down(10), 3.0 * 9.0 + 2.0 * 12.0);
        let mut text = model(Construction::TopDown, Preset::Text, 4);
        assert_eq!(text.top_down(16), binomial(150, 3) as f64);
        let mut text = model(Construction::TopDown, Preset::Text, 8);
        assert_eq!(text.top_down(6), (binomial(75, 7) + binomial(75, 6) + binomial(75, 5)) as f64);
        let mut pairs = model(Construction::BottomUp, Preset::Text, 2);
        assert_eq!(pairs.steps(4), 6.0 + 3.0 + 1.0);
    }

    #[test]
    fn a_projection_scales_with_the_work() {
        let mut pairs = model(Construction::BottomUp, Preset::Walter, 2);
        let ratio = pairs.from_smaller(2000, 1000, 1.0).unwrap();
        assert!((ratio - 8.0).abs() < 1e-4);
        let whole = pairs.from_stopped(1000, &Unfinished { pending: vec![900] }, 1_000_000, 10.0).unwrap();
        assert!((whole - 10.0 * pairs.steps(1000) / 1e6).abs() < 1e-6);
        assert_eq!(pairs.from_stopped(1000, &Unfinished::default(), 0, 10.0), None);
    }

    #[test]
    fn work_of_a_top_down_build_grows_smoothly_with_size() {
        for arity in [2, 4, 8] {
            for preset in [Preset::Published, Preset::Text] {
                let mut m = model(Construction::TopDown, preset, arity);
                let per_triangle: Vec<f64> = (8..17).map(|e| m.steps(1 << e) / f64::from(1 << e)).collect();
                for pair in per_triangle.windows(2) {
                    let growth = pair[1] / pair[0];
                    assert!((0.6..1.5).contains(&growth), "{arity} {preset:?} {per_triangle:?}");
                }
            }
        }
    }

    /// A probe that stops after a number of steps, and tells how many were made.
    struct Stop {
        after: u64,
        made: u64,
    }

    impl Probe for Stop {
        fn go_on(&mut self, steps: u64) -> bool {
            self.made += steps;
            self.made < self.after
        }
    }

    /// Stops a real build after shares of its steps; the projected time (1 ms a step) must be near the real one.
    fn check_stopped(n: usize, model: &mut Model, build: &dyn Fn(&mut Stop) -> Result<crate::bvh::Bvh, BuildError>) {
        let mut whole = Stop { after: u64::MAX, made: 0 };
        build(&mut whole).unwrap();
        for share in [0.05, 0.2, 0.5, 0.9] {
            let mut stop = Stop { after: (whole.made as f64 * share) as u64, made: 0 };
            let Err(BuildError::Stopped(left)) = build(&mut stop) else { panic!("not stopped") };
            let projected = model.from_stopped(n, &left, stop.made, stop.made as f64).unwrap();
            let ratio = projected / whole.made as f64;
            assert!((0.6..1.7).contains(&ratio), "{model:?} {share}: {ratio}");
        }
    }

    #[test]
    fn builds_stopped_anywhere_project_to_about_the_whole() {
        let boxes = Scene::load("thesis:small").unwrap().boxes();
        let n = boxes.len();
        for arity in [2, 4] {
            let params = Published::at_arity(arity);
            check_stopped(n, &mut model(Construction::TopDown, Preset::Published, arity), &|probe| {
                published_literal::build(&boxes, &params, probe)
            });
        }
        let mut options = BuildOptions { arity: 4, preset: Preset::Text, ..BuildOptions::default() };
        options.candidates = Some(16);
        check_stopped(n, &mut Model::new(Construction::TopDown, options), &|probe| {
            text_literal::build(&boxes, &Text { arity: 4, planes: 16 }, probe)
        });
        check_stopped(n, &mut model(Construction::BottomUp, Preset::Published, 2), &|probe| {
            chain_literal::build(&boxes, probe, &mut ())
        });
        let few = &boxes[..400];
        check_stopped(400, &mut model(Construction::BottomUp, Preset::Text, 2), &|probe| {
            all_pairs_literal::build(few, Distance::Centres, probe)
        });
    }
}
