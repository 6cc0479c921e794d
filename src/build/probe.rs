//! Work counters and the brake: a type parameter of every builder, so that an unprobed build pays nothing.

use std::time::Instant;

/// Kinds of work that a builder counts, each where it is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Work {
    /// Choices of split positions evaluated, admissible or not.
    Combinations,
    /// Costs of one child computed.
    ChildCosts,
    /// Unions of two boxes.
    BoxUnions,
    /// What the thesis' program would have done: triangles of the node times combinations, each a union of two boxes.
    OriginalUnions,
    /// Distances between two clusters computed.
    PairDistances,
    /// Searches for the nearest cluster.
    NearestSearches,
    /// Merges of two clusters.
    Merges,
    /// Nodes that rule Q8 applied to.
    Q8Nodes,
    /// Nodes that rule Q8 applied to at slot 0, where the original read memory before its array.
    Q8AtStart,
    /// Nodes that no full choice of planes separated: fewer planes, or halves by id, were used.
    Fallbacks,
    /// Transitions of a dynamic program: a child's term added to the best cost of what is left beside it.
    DpSteps,
    /// Entries of a search structure looked at in searches for the nearest cluster: its nodes and its clusters.
    SearchVisits,
    /// Keys moved by a sort: each once for every digit that makes a difference.
    KeysSorted,
    /// Rounds in which all that are nearest to each other merge.
    Rounds,
    /// References put into bins.
    Binned,
    /// Binary splits of which the cost was taken.
    SplitCosts,
    /// Searches for a better place of a subtree.
    PlaceSearches,
    /// Nodes looked at in searches for a better place of a subtree.
    PlaceVisits,
    /// Reinsertions and rotations that were kept.
    Moves,
}

impl Work {
    /// All kinds, in the order of [`Counters`].
    pub const ALL: &[Self] = &[
        Self::Combinations,
        Self::ChildCosts,
        Self::BoxUnions,
        Self::OriginalUnions,
        Self::PairDistances,
        Self::NearestSearches,
        Self::Merges,
        Self::Q8Nodes,
        Self::Q8AtStart,
        Self::Fallbacks,
        Self::DpSteps,
        Self::SearchVisits,
        Self::KeysSorted,
        Self::Rounds,
        Self::Binned,
        Self::SplitCosts,
        Self::PlaceSearches,
        Self::PlaceVisits,
        Self::Moves,
    ];

    /// Its name in rows and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Combinations => "combinations",
            Self::ChildCosts => "child_costs",
            Self::BoxUnions => "box_unions",
            Self::OriginalUnions => "original_unions",
            Self::PairDistances => "pair_distances",
            Self::NearestSearches => "nearest_searches",
            Self::Merges => "merges",
            Self::Q8Nodes => "q8_nodes",
            Self::Q8AtStart => "q8_at_start",
            Self::Fallbacks => "fallbacks",
            Self::DpSteps => "dp_steps",
            Self::SearchVisits => "search_visits",
            Self::KeysSorted => "keys_sorted",
            Self::Rounds => "rounds",
            Self::Binned => "binned",
            Self::SplitCosts => "split_costs",
            Self::PlaceSearches => "place_searches",
            Self::PlaceVisits => "place_visits",
            Self::Moves => "moves",
        }
    }
}

/// What a builder tells while it works. `()` is the probe that costs nothing.
pub trait Probe {
    /// Whether counts go anywhere: what would be counted only for the probe can be left out where not.
    const COUNTS: bool = false;

    /// `n` units of `work` were done just now.
    #[inline(always)]
    fn add(&mut self, work: Work, n: u64) {
        let _ = (work, n);
    }

    /// Called now and then with the elementary steps (combinations or distances) since the last call; `false` asks the
    /// builder to stop with [`super::BuildError::Stopped`].
    #[inline(always)]
    fn go_on(&mut self, steps: u64) -> bool {
        let _ = steps;
        true
    }
}

impl Probe for () {}

impl<P: Probe> Probe for &mut P {
    const COUNTS: bool = P::COUNTS;

    #[inline(always)]
    fn add(&mut self, work: Work, n: u64) {
        (**self).add(work, n);
    }

    #[inline(always)]
    fn go_on(&mut self, steps: u64) -> bool {
        (**self).go_on(steps)
    }
}

/// A probe that stops the build at a point in time, and adds up the steps done until then.
#[derive(Clone, Debug, Default)]
pub struct Brake {
    deadline: Option<Instant>,
    steps: u64,
    unchecked: u64,
}

impl Brake {
    /// Looking at the clock costs as much as some tens of steps.
    const STEPS_BETWEEN_LOOKS: u64 = 1 << 16;

    /// Stops at `deadline`; never without one.
    pub fn new(deadline: Option<Instant>) -> Self {
        Self { deadline, ..Self::default() }
    }

    /// Elementary steps reported so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}

impl Probe for Brake {
    #[inline]
    fn go_on(&mut self, steps: u64) -> bool {
        self.steps += steps;
        self.unchecked += steps;
        if self.unchecked < Self::STEPS_BETWEEN_LOOKS {
            return true;
        }
        self.unchecked = 0;
        self.deadline.is_none_or(|at| Instant::now() < at)
    }
}

/// A probe that counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters([u64; Work::ALL.len()]);

impl Probe for Counters {
    const COUNTS: bool = true;

    #[inline(always)]
    fn add(&mut self, work: Work, n: u64) {
        self.0[work as usize] += n;
    }
}

impl Counters {
    /// The count of one kind of work.
    pub fn get(&self, work: Work) -> u64 {
        self.0[work as usize]
    }

    /// The kinds that occurred, with their counts.
    pub fn nonzero(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        Work::ALL.iter().map(|&w| (w.name(), self.get(w))).filter(|&(_, n)| n > 0)
    }
}
