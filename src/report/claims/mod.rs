//! Claims: what the thesis finds, each with a predicate over rows and a verdict that is computed whenever a report is drawn.
//!
//! A claim is data and one function. The function sees [`Evidence`], the rows and the printed numbers, and returns a [`Finding`]: a
//! verdict, one sentence that says why, and the figures that decided it. Where rows are missing the verdict is
//! [`Verdict::Undecided`]; nothing here knows a result.

mod artefacts;
mod builds;
mod digits;
mod evidence;
mod export;
mod outlook;
mod secondary;
mod traversal;
mod trees;

pub(crate) use digits::{Suspect, suspects};
pub(crate) use evidence::Evidence;
pub(crate) use export::{csv_text, json_text};

use crate::report::PRESETS;
use serde::Serialize;

/// What is found about a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(crate) enum Verdict {
    /// The rows show what the thesis says.
    #[serde(rename = "holds")]
    Holds,
    /// They show it, but the printed figures, as they stand, do not.
    #[serde(rename = "holds with corrected data")]
    Corrected,
    /// The thesis saw what it says, and the cause is its program, not the trees: without that cause it is gone.
    #[serde(rename = "artefact of the implementation")]
    Artefact,
    /// The rows, or the thesis' own figures, show something else.
    #[serde(rename = "does not hold")]
    Fails,
    /// The rows that would decide it are not there.
    #[serde(rename = "not decidable here")]
    Undecided,
}

impl Verdict {
    /// All of them, in the order in which a page lists them.
    pub const ALL: [Self; 5] = [Self::Holds, Self::Corrected, Self::Artefact, Self::Fails, Self::Undecided];

    /// As it is written.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Corrected => "holds with corrected data",
            Self::Artefact => "artefact of the implementation",
            Self::Fails => "does not hold",
            Self::Undecided => "not decidable here",
        }
    }

    /// Its class on the page.
    pub const fn class(self) -> &'static str {
        match self {
            Self::Holds => "v-holds",
            Self::Corrected => "v-corrected",
            Self::Artefact => "v-artefact",
            Self::Fails => "v-fails",
            Self::Undecided => "v-undecided",
        }
    }
}

/// A quantity that decided, with its values by model, arity or whatever it runs over.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Series {
    /// What it is, with its unit.
    pub name: String,
    /// Label and value.
    pub values: Vec<(String, f64)>,
}

/// A verdict with its reasons.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Finding {
    /// The verdict.
    pub verdict: Verdict,
    /// One or two sentences, with the figures that matter most.
    pub why: String,
    /// All figures that decided.
    pub figures: Vec<Series>,
}

impl Finding {
    fn new(verdict: Verdict, why: impl Into<String>) -> Self {
        Self { verdict, why: why.into(), figures: Vec::new() }
    }

    /// Rows are missing; `what` says which.
    fn undecided(what: impl std::fmt::Display) -> Self {
        Self::new(Verdict::Undecided, format!("There are no rows about {what}."))
    }

    /// Adds a quantity.
    fn with<L: ToString>(mut self, name: impl Into<String>, values: impl IntoIterator<Item = (L, f64)>) -> Self {
        let values = values.into_iter().map(|(label, value)| (label.to_string(), value)).collect();
        self.figures.push(Series { name: name.into(), values });
        self
    }
}

/// Where the evidence is to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A table of the thesis, on the page.
    Table(u8),
    /// A section of the page: its anchor and what it is called.
    Section(&'static str, &'static str),
    /// A file of rows.
    Rows(&'static str),
}

/// Something that the thesis finds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Claim {
    /// Its name in files and anchors.
    pub id: &'static str,
    /// What it says, in our words.
    pub statement: &'static str,
    /// The thesis' own words.
    pub quote: &'static str,
    /// Where they stand.
    pub place: &'static str,
    /// What has to be so for it to hold, in words.
    pub predicate: &'static str,
    /// The same as code, for a preset.
    pub decide: fn(&Evidence, &str) -> Finding,
    /// Where the evidence is.
    pub sources: &'static [Source],
}

/// A claim with what was found about it, by what the program did and by what the words say.
#[derive(Clone, Debug)]
pub(crate) struct Judged {
    /// The claim.
    pub claim: &'static Claim,
    /// One finding a preset, in the order of [`PRESETS`].
    pub findings: [Finding; 2],
}

impl Judged {
    /// The finding about the program that made the printed numbers.
    pub fn headline(&self) -> &Finding {
        &self.findings[0]
    }
}

/// Every claim, in the order of the thesis.
pub(crate) fn claims() -> impl Iterator<Item = &'static Claim> {
    [
        builds::CLAIMS,
        trees::CLAIMS,
        traversal::CLAIMS,
        artefacts::CLAIMS,
        secondary::CLAIMS,
        outlook::CLAIMS,
        digits::CLAIMS,
    ]
    .into_iter()
    .flatten()
}

/// Decides all of them.
pub(crate) fn judge(evidence: &Evidence) -> Vec<Judged> {
    claims().map(|claim| Judged { claim, findings: PRESETS.map(|preset| (claim.decide)(evidence, preset)) }).collect()
}

#[cfg(test)]
mod tests;
