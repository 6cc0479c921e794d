//! What a caller can ask of a builder, and which of it a builder understands.

use super::top_down::Costs;
use crate::refine::{Collapse, Refinements};

/// A reading of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// What its program did.
    Published,
    /// What its text says.
    Text,
    /// Bottom-up by union area, as the paper it cites has it.
    Walter,
}

/// How the work is done; the tree does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Near-linear work, provably the same choices.
    Exact,
    /// Every combination, every pair.
    Literal,
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 3] = [Self::Published, Self::Text, Self::Walter];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Text => "text",
            Self::Walter => "walter",
        }
    }
}

impl Engine {
    /// All engines.
    pub const ALL: [Self; 2] = [Self::Exact, Self::Literal];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Literal => "literal",
        }
    }
}

/// What a caller can ask of a builder. A builder refuses what it does not understand ([`super::Builder::check`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Children per inner node: 2, 4, 8 or, for modern builders, 16.
    pub arity: usize,
    /// Reading of the thesis; builders that have none leave it alone.
    pub preset: Preset,
    /// How the work is done; builders with one way of working leave it alone.
    pub engine: Engine,
    /// Candidate positions or planes per axis of a top-down search; the thesis' 200/arity if `None`.
    pub candidates: Option<usize>,
    /// Rule Q8 of the preset `published` at arity 8 (see [`super::top_down::Published::q8`]).
    pub q8: bool,
    /// In which numbers costs are added; only the literal `top-down published` has f32.
    pub costs: Costs,
    /// The most triangles a leaf holds; [`super::MAX_LEAF`] if `None`.
    pub max_leaf: Option<usize>,
    /// Bins per axis of a binned search; the builder's default if `None`.
    pub bins: Option<usize>,
    /// Neighbours looked at on either side, or candidates kept for each cluster; the builder's default if `None`.
    pub radius: Option<usize>,
    /// The most triangles of a cluster that the search for splits takes as a whole; the builder's default if `None`.
    pub cluster: Option<usize>,
    /// References that spatial splits may add, in percent of the triangles; the builder's default if `None`.
    pub split_budget: Option<usize>,
    /// What is done to the binary tree, step by step.
    pub refine: Refinements,
    /// How a binary tree becomes one of higher arity; the builder's default if `None`.
    pub collapse: Option<Collapse>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            arity: 2,
            preset: Preset::Published,
            engine: Engine::Exact,
            candidates: None,
            q8: true,
            costs: Costs::Exact,
            max_leaf: None,
            bins: None,
            radius: None,
            cluster: None,
            split_budget: None,
            refine: Refinements::default(),
            collapse: None,
        }
    }
}

/// An option that not every builder understands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// [`BuildOptions::candidates`].
    Candidates,
    /// [`BuildOptions::q8`].
    Q8,
    /// [`BuildOptions::costs`].
    Costs,
    /// [`BuildOptions::max_leaf`].
    MaxLeaf,
    /// [`BuildOptions::bins`].
    Bins,
    /// [`BuildOptions::radius`].
    Radius,
    /// [`BuildOptions::cluster`].
    Cluster,
    /// [`BuildOptions::split_budget`].
    SplitBudget,
    /// [`BuildOptions::refine`].
    Refine,
    /// [`BuildOptions::collapse`].
    Collapse,
}

impl Parameter {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Candidates,
        Self::Q8,
        Self::Costs,
        Self::MaxLeaf,
        Self::Bins,
        Self::Radius,
        Self::Cluster,
        Self::SplitBudget,
        Self::Refine,
        Self::Collapse,
    ];

    /// What the command line calls it.
    pub const fn flag(self) -> &'static str {
        match self {
            Self::Candidates => "--candidates",
            Self::Q8 => "--q8",
            Self::Costs => "--costs",
            Self::MaxLeaf => "--max-leaf",
            Self::Bins => "--bins",
            Self::Radius => "--radius",
            Self::Cluster => "--cluster",
            Self::SplitBudget => "--split-budget",
            Self::Refine => "+STEP",
            Self::Collapse => "--collapse",
        }
    }

    /// Whether `options` ask for something other than the default.
    pub fn is_set(self, options: &BuildOptions) -> bool {
        match self {
            Self::Candidates => options.candidates.is_some(),
            Self::Q8 => !options.q8,
            Self::Costs => options.costs != Costs::Exact,
            Self::MaxLeaf => options.max_leaf.is_some(),
            Self::Bins => options.bins.is_some(),
            Self::Radius => options.radius.is_some(),
            Self::Cluster => options.cluster.is_some(),
            Self::SplitBudget => options.split_budget.is_some(),
            Self::Refine => !options.refine.is_empty(),
            Self::Collapse => options.collapse.is_some(),
        }
    }
}
