//! Provenance: which program, machine and call the rows came from.

use crate::report::cells::Study;
use crate::report::growth::Growth;
use maud::{Markup, html};
use std::collections::BTreeSet;

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
                    (builds.len()) " builds, " (traces.len()) " traversals, " (decisions.len()) " comparisons of costs, "
                    (scaling.len()) " against size, " (growth.work.len()) " of counted work"
                }
                dt { "Measure again" } dd { code { "bvh-lab reproduce --out DIR" } ", " code { "bvh-lab scaling --out DIR" } }
                dt { "Draw again" } dd { code { "bvh-lab report --rows DIR/rows --out DIR" } }
            }
        }
    }
}
