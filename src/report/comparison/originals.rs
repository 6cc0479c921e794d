//! What modern builders pay over the thesis' exact constructions in cost, and what they gain in time.

use super::{Class, Comparison, Entrant, Kind, build_ms, geometric_mean, positive};
use crate::rows::CompareRow;

/// Modern builders against originals, over the scenes of one class.
#[derive(Debug)]
pub(crate) struct Originals {
    /// The originals: with leaves by cost where they took part, else as the thesis has them.
    pub names: Vec<String>,
    /// Whether their leaves are by cost.
    pub equal_leaves: bool,
    /// One line a modern contestant, by rising cost.
    pub lines: Vec<Line>,
}

/// One modern contestant.
#[derive(Debug)]
pub(crate) struct Line {
    /// What it is called.
    pub label: String,
    /// Against each original, in the order of [`Originals::names`].
    pub against: Vec<Option<Pair>>,
    /// Against the original of the least SAH on each scene.
    pub best: Option<Pair>,
}

/// Geometric means over the scenes that both have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    /// SAH over that of the original.
    pub cost: f64,
    /// Build time over that of the original.
    pub time: f64,
}

/// The comparison of the main class; `None` without originals or without others.
pub(crate) fn originals(comparison: &Comparison) -> Option<Originals> {
    let class = comparison.main_class()?;
    let entrants = comparison.entrants();
    let here = |e: &&Entrant| e.rows.first().is_some_and(|r| Class::of(r) == class);
    let of_thesis: Vec<&Entrant> = entrants.iter().filter(here).filter(|e| kind(e) == Kind::Original).collect();
    let with_leaves: Vec<&Entrant> = of_thesis.iter().copied().filter(|e| e.rows[0].recipe.contains('+')).collect();
    let equal_leaves = !with_leaves.is_empty();
    let originals = if equal_leaves { with_leaves } else { of_thesis };
    let others = entrants.iter().filter(here).filter(|e| matches!(kind(e), Kind::Modern | Kind::Refined));
    let mut lines: Vec<Line> = others.map(|e| line(e, &originals)).filter(|l| l.best.is_some()).collect();
    lines.sort_by(|a, b| a.best.map(|p| p.cost).unwrap_or(0.0).total_cmp(&b.best.map(|p| p.cost).unwrap_or(0.0)));
    let names = originals.iter().map(|e| e.label.clone()).collect();
    (!originals.is_empty() && !lines.is_empty()).then_some(Originals { names, equal_leaves, lines })
}

fn kind(entrant: &Entrant) -> Kind {
    Kind::of(entrant.rows[0])
}

fn line(entrant: &Entrant, originals: &[&Entrant]) -> Line {
    let of_scene = |original: &Entrant, scene: &str| original.rows.iter().copied().find(|r| r.scene == scene).cloned();
    let against = |original: &&Entrant| pair(entrant, |row| of_scene(original, &row.scene));
    let best = pair(entrant, |row| {
        let there = originals.iter().filter_map(|o| of_scene(o, &row.scene)).filter(|o| positive(o.sah).is_some());
        there.min_by(|a, b| a.sah.unwrap_or(f64::MAX).total_cmp(&b.sah.unwrap_or(f64::MAX)))
    });
    Line { label: entrant.label.clone(), against: originals.iter().map(against).collect(), best }
}

fn pair(entrant: &Entrant, original: impl Fn(&CompareRow) -> Option<CompareRow>) -> Option<Pair> {
    let pairs: Vec<_> = entrant.rows.iter().filter_map(|row| Some((*row, original(row)?))).collect();
    let cost = pairs.iter().filter_map(|(ours, theirs)| Some(positive(ours.sah)? / positive(theirs.sah)?));
    let time = pairs.iter().filter_map(|(ours, theirs)| Some(build_ms(ours)? / build_ms(theirs)?));
    Some(Pair { cost: geometric_mean(cost)?, time: geometric_mean(time)? })
}
