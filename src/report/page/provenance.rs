//! Provenance: which program, machine and call the rows came from; below every table and figure, and at the page's end.

use crate::report::cells::Study;
use crate::report::growth::Growth;
use crate::rows::Experiment;
use maud::{Markup, html};
use std::collections::BTreeSet;

/// What made a table or figure.
#[derive(Clone, Debug)]
pub(crate) struct Origin<'a> {
    /// Files of rows that it is drawn from.
    rows: &'static str,
    /// The command that measures them.
    command: String,
    /// The commit whose program did.
    commit: &'a str,
}

impl<'a> Origin<'a> {
    /// Of a table of the thesis.
    pub fn table(number: u8, commit: &'a str) -> Self {
        let rows = if number > 3 { "rows/traces.csv" } else { "rows/builds.csv" };
        Self { rows, command: format!("bvh-lab reproduce --only table{number}"), commit }
    }

    /// Of an experiment.
    pub fn experiment(experiment: Experiment, commit: &'a str) -> Self {
        Self { rows: "rows/experiments.csv", command: format!("bvh-lab reproduce --only {}", experiment.id()), commit }
    }

    /// Of a figure, by its file name.
    pub fn figure(name: &str, commit: &'a str) -> Self {
        let made = |rows, command: &str| Self { rows, command: command.to_owned(), commit };
        match name.split('_').next().unwrap_or(name) {
            "figure3" => made("rows/figure3.png", "bvh-lab reproduce --only figure3"),
            "figure3-lit" => made("rows/figure3-lit.png", "bvh-lab reproduce --only figure3"),
            "figure4" | "figure4-extended" => made("rows/builds.csv", "bvh-lab reproduce --only figure4"),
            "figure5" => made("rows/traces.csv", "bvh-lab reproduce --only figure5"),
            "scaling-time" | "scaling-work" => made("rows/scaling.csv", "bvh-lab scaling"),
            "why" => made("rows/work.csv", "bvh-lab scaling"),
            "lookup" => Self::experiment(Experiment::Lookup, commit),
            "candidates" => Self::experiment(Experiment::Candidates, commit),
            "wrong-pixels" => made("rows/wrong-pixels.png", "bvh-lab reproduce --only first-leaf"),
            _ => made("rows/compare.csv", "bvh-lab compare SCENE… --out DIR"),
        }
    }

    /// As one line.
    pub fn line(&self) -> Markup {
        html! {
            p .origin {
                "Rows: " a href=(self.rows) { (self.rows) } " · made by " code { (self.command) }
                @if !self.commit.is_empty() { " · commit " code { (self.commit) } }
            }
        }
    }
}

/// The page's footer.
pub(crate) fn footer(study: &Study, growth: &Growth) -> Markup {
    let distinct = |of: &dyn Fn() -> BTreeSet<String>| of().into_iter().collect::<Vec<_>>().join(", ");
    let builds = &study.builds;
    let traces = &study.traces;
    let decisions = &study.decisions;
    let scaling = &growth.scaling;
    // Version, commit and machine of every row.
    let mut origins: Vec<[&str; 3]> = Vec::new();
    origins.extend(builds.iter().map(|r| [&*r.version, &*r.commit, &*r.machine]));
    origins.extend(traces.iter().map(|r| [&*r.version, &*r.commit, &*r.machine]));
    origins.extend(decisions.iter().map(|r| [&*r.version, &*r.commit, &*r.machine]));
    origins.extend(scaling.iter().map(|r| [&*r.version, &*r.commit, &*r.machine]));
    let [versions, commits, machines] =
        [0, 1, 2].map(|field| distinct(&|| origins.iter().map(|origin| origin[field].to_owned()).collect()));
    let build_threads = distinct(&|| builds.iter().map(|r| r.threads.to_string()).collect());
    let trace_threads = distinct(&|| traces.iter().map(|r| r.threads.to_string()).collect());
    html! {
        footer {
            dl {
                dt { "Program and rows" } dd { "bvh-lab " (versions) }
                dt { "Commit" } dd { code { (commits) } }
                dt { "Machine" } dd { (machines) }
                dt { "Threads" } dd { "builds " (build_threads) "; traversals " (trace_threads) }
                dt { "Rows" } dd {
                    (builds.len()) " builds, " (traces.len()) " traversals, " (decisions.len()) " comparisons of costs, " (study.experiments.len()) " trees of experiments, "
                    (scaling.len()) " against size, " (growth.work.len()) " of counted work"
                }
                dt { "Measure again" } dd { code { "bvh-lab reproduce --out DIR" } ", " code { "bvh-lab scaling --out DIR" } }
                dt { "Draw again" } dd { code { "bvh-lab report --rows DIR/rows --out DIR" } }
            }
        }
    }
}
