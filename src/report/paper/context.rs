//! What the paper's text is filled with.

use crate::report::cells::Study;
use crate::report::claims::{Judged, Verdict};
use crate::report::experiments::Experiments;
use crate::report::number::padded;
use crate::report::summary::Summary;
use minijinja::{Value, context};
use std::collections::BTreeMap;

/// All names that the text may use.
pub(super) fn of(study: &Study, summary: &Summary, judged: &[Judged]) -> Value {
    let row = study.builds.first();
    context! {
        version => row.map_or("", |r| &r.version),
        commit => study.commit(),
        machine => row.map_or("", |r| &r.machine),
        summary => context! {
            agree => summary.engines_agree.0,
            pairs => summary.engines_agree.1,
            within => summary.table5.within,
            compared => summary.table5.compared,
        },
        total => judged.len(),
        verdicts => verdicts(judged),
        claims => judged.iter().map(|j| (j.claim.id, claim(j))).collect::<BTreeMap<_, _>>(),
        list => judged.iter().map(claim).collect::<Vec<_>>(),
        readings => readings(study),
    }
}

fn verdicts(judged: &[Judged]) -> Vec<Value> {
    let count = |v: Verdict| judged.iter().filter(|j| j.headline().verdict == v).count();
    let counted = Verdict::ALL.into_iter().map(|v| (v, count(v))).filter(|(_, n)| *n > 0);
    counted.map(|(v, n)| context! { words => v.words(), count => n }).collect()
}

fn claim(j: &Judged) -> Value {
    let [published, text] = &j.findings;
    context! {
        id => j.claim.id,
        statement => j.claim.statement,
        verdict => published.verdict.words(),
        why => &published.why,
        text_verdict => text.verdict.words(),
        text_why => &text.why,
    }
}

fn readings(study: &Study) -> Vec<Value> {
    let all = Experiments(&study.experiments).readings();
    let one = |r: &crate::report::experiments::Reading| {
        context! { construction => r.construction.id(), name => &r.name, distance => padded(100.0 * r.distance(), 3) }
    };
    all.iter().map(one).collect()
}
