//! Where the original's f32 costs decide otherwise than exact ones: `top-down published`, both searches at every node.
//!
//! Source: Beick 2014, "Construction Algorithms"; the two arithmetics are those of [`super::Costs`]. Both searches see the
//! same triangles in the same node, the tree goes on as the exact one says, and [`Decisions`] counts where the f32 one
//! would have gone another way. [`build_single`] is the tree by f32 costs throughout, the same as the literal engine's.
//!
//! Neither enumerates: the module `least_sum` proves that its choice is the enumeration's. Nodes without any choice (rule
//! Q8) are not compared. Choices of different axis or positions never divide a node into the same children in the same
//! order: of two that did, both arithmetics would keep the first.

use super::Published;
use super::arithmetic::{Arithmetic, SingleCost};
use super::least_sum::{Chosen, LeastSum, each_run};
use super::published_tree::{Search, Splitting, grow};
use crate::build::{BuildError, ChildCost, Probe, Work};
use crate::bvh::Bvh;
use crate::geom::Aabb;

/// Relative differences below are those of f64 terms' own rounding.
const SAME: f64 = 1e-13;

/// How often f32 costs choose other splits than exact ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Decisions {
    /// Inner nodes at which both had a choice.
    pub compared: usize,
    /// Nodes at which they chose differently.
    pub different: usize,
    /// Of these, nodes at which both choices have the same f32 sum, so that the order decided.
    pub rounded_ties: usize,
    /// Of these, nodes at which both choices have the same exact cost, as far as f64 terms can tell: nothing is lost.
    pub same_cost: usize,
    /// The greatest excess of an f32 choice's exact cost, 0.125 included, over the least one, relative to that.
    pub largest_excess: f64,
}

impl Decisions {
    /// Nodes at which the f32 sum of the exact choice is above that of the f32 choice: rounding turned the order round.
    pub fn reversals(&self) -> usize {
        self.different - self.rounded_ties
    }
}

/// Builds by exact costs, and asks the f32 costs about every node.
///
/// # Errors
/// Those of [`super::published_literal::build`].
pub fn compare<P: Probe>(boxes: &[Aabb], params: &Published, probe: &mut P) -> Result<(Bvh, Decisions), BuildError> {
    let mut decisions = Decisions::default();
    let (mut exact, mut single) = (LeastSum::<ChildCost>::new(), LeastSum::<SingleCost>::new());
    let bvh = grow(boxes, params, probe, |mut node, probe| {
        let (exact_terms, single_terms) = begin(&node, &mut exact, &mut single);
        each_run(&mut node, probe, |axis, run, aabb, n| {
            exact.put(axis, run, exact_terms.term(aabb, n - 1));
            single.put(axis, run, single_terms.term(aabb, n - 1));
        });
        if !counted(&node, 2, probe) {
            return Search::Stopped;
        }
        match (exact.first_of_least(probe), single.first_of_least(probe)) {
            (Some(by_exact), Some(by_single)) => {
                let unit = exact_terms.term(&node.aabb, 1);
                decisions.note(unit, (&exact, by_exact), (&single, by_single));
                Search::Best(by_exact.choice)
            }
            _ => Search::None,
        }
    })?;
    Ok((bvh, decisions))
}

/// Builds by f32 costs: the tree of [`super::published_literal::build_by`] with [`super::Costs::Single`].
///
/// # Errors
/// Those of [`super::published_literal::build`].
pub fn build_single<P: Probe>(boxes: &[Aabb], params: &Published, probe: &mut P) -> Result<Bvh, BuildError> {
    let mut single = LeastSum::<SingleCost>::new();
    grow(boxes, params, probe, |mut node, probe| {
        let terms = SingleCost::of_node(&node.aabb, node.ids.len());
        single.begin(&node);
        each_run(&mut node, probe, |axis, run, aabb, n| single.put(axis, run, terms.term(aabb, n - 1)));
        if !counted(&node, 1, probe) {
            return Search::Stopped;
        }
        single.first_of_least(probe).map_or(Search::None, |best| Search::Best(best.choice))
    })
}

fn begin(
    node: &Splitting,
    exact: &mut LeastSum<ChildCost>,
    single: &mut LeastSum<SingleCost>,
) -> (ChildCost, SingleCost) {
    exact.begin(node);
    single.begin(node);
    let n = node.ids.len();
    (ChildCost::of_node(&node.aabb, n), SingleCost::of_node(&node.aabb, n))
}

/// Counts the terms of one node in so many arithmetics; `false` when the probe asks to stop.
fn counted<P: Probe>(node: &Splitting, arithmetics: u64, probe: &mut P) -> bool {
    let positions = node.params.positions(node.ids.len()) as u64;
    let runs = 3 * (positions + 1) * (positions + 2) / 2;
    probe.add(Work::ChildCosts, arithmetics * runs);
    probe.go_on(arithmetics * runs * node.params.arity as u64)
}

impl Decisions {
    /// Counts one node whose exact costs have `unit` for 1.
    fn note(
        &mut self,
        unit: i64,
        (exact, by_exact): (&LeastSum<ChildCost>, Chosen<ChildCost>),
        (single, by_single): (&LeastSum<SingleCost>, Chosen<SingleCost>),
    ) {
        self.compared += 1;
        if by_exact.choice == by_single.choice {
            return;
        }
        self.different += 1;
        self.rounded_ties += usize::from(single.cost_of(&by_exact.choice) == by_single.cost);
        let least = by_exact.cost as f64 + 0.125 * unit as f64;
        // A node without area has no costs.
        let excess = (exact.cost_of(&by_single.choice) - by_exact.cost) as f64 / least.max(1.0);
        self.same_cost += usize::from(excess <= SAME);
        self.largest_excess = self.largest_excess.max(excess);
    }
}

#[cfg(test)]
mod tests;
