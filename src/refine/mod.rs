//! Refinement: from a tree to a tree. Each step is one file and one entry of [`STEPS`].
//!
//! Every step takes trees whose leaves hold parts of triangles (spatial splits), too: the box of a leaf stays what it is, wherever
//! the leaf goes. A triangle that stands in several leaves counts as often, until leaves are made of them: a leaf holds it once. So
//! for these trees what a step takes for their cost is a bound, and that the cost never rises is tested, not proven.

mod bottom_up;
mod collapse;
mod dynamic;
mod equal_leaves;
mod layout;
mod leaves;
mod refit;
mod reinsertion;
mod rotations;
#[cfg(test)]
mod testing;
mod treelets;
mod watch;

pub use collapse::{Collapse, collapse, collapse_by_leaf_cost, collapse_greedily, collapse_optimally};
pub use equal_leaves::equal_leaves;
pub use leaves::open_leaves;
pub use refit::refit;
pub use reinsertion::{Reinsertion, reinsert};
pub use rotations::rotate;
pub use treelets::restructure;
pub use watch::Watch;

use crate::bvh::Bvh;
use std::str::FromStr;

/// A step that makes a binary tree better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// [`open_leaves`].
    Leaves,
    /// [`reinsert`] by the default parameters.
    Reinsertion,
    /// [`reinsert`] by [`Reinsertion::PAIRS`].
    ReinsertionPairs,
    /// [`rotate`].
    Rotations,
    /// [`restructure`].
    Treelets,
}

/// What a step is called, where it comes from, and the code.
#[derive(Clone, Copy, Debug)]
pub struct StepInfo {
    /// Its id on the command line: `-b BUILDER+ID`.
    pub id: &'static str,
    /// The step.
    pub step: Step,
    /// The publication it comes from.
    pub paper: &'static str,
    /// What it does, in one line.
    pub summary: &'static str,
    /// From a valid binary tree, and the most triangles that a leaf may hold, to a valid binary tree.
    pub apply: fn(&Bvh, usize, &mut Watch) -> Bvh,
}

/// All steps.
pub const STEPS: &[StepInfo] = &[
    StepInfo {
        id: "leaves",
        step: Step::Leaves,
        paper: "MacDonald and Booth 1990",
        summary: "SAH-optimal leaf collapse: subtrees become leaves where that lowers the cost; last of every other step, too",
        apply: |bvh, max_leaf, _| open_leaves(bvh, max_leaf),
    },
    StepInfo {
        id: "reinsertion",
        step: Step::Reinsertion,
        paper: "Meister and Bittner 2018",
        summary: "subtrees move to where they enlarge the tree least, the largest first",
        apply: |bvh, max_leaf, watch| reinsert(bvh, max_leaf, &Reinsertion::default(), watch),
    },
    StepInfo {
        id: "reinsertion-pairs",
        step: Step::ReinsertionPairs,
        paper: "Bittner, Hapala and Havran 2013; Meister and Bittner 2018",
        summary: "reinsertion for as long as it gains, then of two subtrees at once where one alone gains nothing",
        apply: |bvh, max_leaf, watch| reinsert(bvh, max_leaf, &Reinsertion::PAIRS, watch),
    },
    StepInfo {
        id: "rotations",
        step: Step::Rotations,
        paper: "Kensler 2008",
        summary: "children and grandchildren swap places where that makes boxes smaller",
        apply: rotate,
    },
    StepInfo {
        id: "treelets",
        step: Step::Treelets,
        paper: "Karras and Aila 2013",
        summary: "parts of seven subtrees get the best of all shapes",
        apply: restructure,
    },
];

/// Steps in the order in which they are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refinements([Option<Step>; Refinements::MOST]);

impl Refinements {
    /// The most steps that one build takes.
    pub const MOST: usize = 4;

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0[0].is_none()
    }

    /// The steps.
    pub fn iter(&self) -> impl Iterator<Item = &'static StepInfo> + '_ {
        self.0.iter().flatten().map(|step| {
            STEPS.iter().find(|info| info.step == *step).expect("every step has its entry") // by `every_step_is_registered`
        })
    }

    /// Takes the steps, then [`open_leaves`] if it was not the last of them. A tree that is less refined where the watch was
    /// told to stop.
    pub fn apply(&self, bvh: Bvh, max_leaf: usize, watch: &mut Watch) -> Bvh {
        let refined = self.iter().fold(bvh, |bvh, info| (info.apply)(&bvh, max_leaf, watch));
        match self.iter().last() {
            Some(info) if info.step != Step::Leaves => open_leaves(&refined, max_leaf),
            _ => refined,
        }
    }
}

impl std::fmt::Display for Refinements {
    /// `+id` for each step: what the command line takes behind a builder's id.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.iter().try_for_each(|info| write!(f, "+{}", info.id))
    }
}

impl FromStr for Refinements {
    type Err = String;

    /// Ids of steps with a plus sign between them; nothing is no step.
    fn from_str(words: &str) -> Result<Self, String> {
        let mut steps = [None; Self::MOST];
        for (i, id) in words.split('+').filter(|_| !words.is_empty()).enumerate() {
            let known = || STEPS.iter().map(|s| s.id).collect::<Vec<_>>().join(", ");
            let info = STEPS.iter().find(|s| s.id == id);
            let info = info.ok_or_else(|| format!("there is no step {id}; there are {}", known()))?;
            let place = steps.get_mut(i).ok_or_else(|| format!("{} steps are the most", Self::MOST))?;
            *place = Some(info.step);
        }
        Ok(Self(steps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_registered_and_read_back() {
        for info in STEPS {
            let one: Refinements = info.id.parse().unwrap();
            assert_eq!(one.iter().map(|i| i.id).collect::<Vec<_>>(), [info.id]);
            let two: Refinements = format!("{0}+{0}", info.id).parse().unwrap();
            assert_eq!(two.to_string(), format!("+{0}+{0}", info.id));
        }
        assert!("".parse::<Refinements>().unwrap().is_empty());
        assert!("none".parse::<Refinements>().is_err());
        assert!("leaves+leaves+leaves+leaves+leaves".parse::<Refinements>().is_err());
    }
}
