//! What holds, at the top of the page: every claim of the thesis with its verdict, and what decided it one click away.

use crate::report::PRESETS;
use crate::report::claims::{Finding, Judged, Source, Suspect, Verdict};
use crate::report::number::{grouped, padded};
use crate::report::page::tables::printed_name;
use crate::report::printed::Flag;
use maud::{Markup, html};

/// The section.
pub(crate) fn section(judged: &[Judged]) -> Markup {
    let count = |v: Verdict| judged.iter().filter(|j| j.headline().verdict == v).count();
    html! {
        h2 id="claims" { "What holds " a .soft href="claims.csv" { "CSV" } " " a .soft href="claims.json" { "JSON" } }
        p {
            "The thesis makes " (judged.len()) " statements that rows can test. For the program that made its numbers, "
            @for (i, v) in Verdict::ALL.into_iter().filter(|v| count(*v) > 0).enumerate() {
                @if i > 0 { ", " } b { (count(v)) } " " span class=(format!("verdict {}", v.class())) { (v.words()) }
            }
            ". The last column says whether the same is found when the algorithms are built as the text words them. Click a line for the \
             quotation, the test, and the figures that decided."
        }
        div .claims {
            div .claim-head { span { "Verdict" } span { "Statement, and why" } span { "as worded" } }
            @for verdict in Verdict::ALL {
                @for j in judged.iter().filter(|j| j.headline().verdict == verdict) { (line(j)) }
            }
        }
    }
}

fn badge(finding: &Finding) -> Markup {
    html! { span class=(format!("verdict {}", finding.verdict.class())) { (finding.verdict.words()) } }
}

fn line(j: &Judged) -> Markup {
    let claim = j.claim;
    html! {
        details .claim id=(format!("claim-{}", claim.id)) {
            summary {
                span { (badge(j.headline())) }
                span { b { (claim.statement) } " " span .why { (j.headline().why) } }
                span { (badge(&j.findings[1])) }
            }
            blockquote { "“" (claim.quote) "” " span .soft { (claim.place) } }
            p { b { "Test. " } (claim.predicate) }
            @for (preset, finding) in PRESETS.iter().zip(&j.findings) {
                p { b { "Preset " (preset) ". " } (badge(finding)) " " (finding.why) }
                (figures(finding))
            }
            p .soft {
                "Evidence: "
                @for (i, source) in claim.sources.iter().enumerate() { @if i > 0 { "; " } (link(*source)) }
                "."
            }
        }
    }
}

fn link(source: Source) -> Markup {
    match source {
        Source::Table(n) => html! {
            a href=(format!("#{}-table{n}", PRESETS[0])) { "Table " (n) } " (" a href=(format!("tables/table{n}.csv")) { "CSV" } "; as worded "
            a href=(format!("tables/text/table{n}.csv")) { "CSV" } ")"
        },
        Source::Section(anchor, name) => html! { a href=(format!("#{anchor}")) { (name) } },
        Source::Rows(file) => html! { a href=(file) { code { (file) } } },
    }
}

/// One line a quantity; quantities over the same labels share a table.
fn figures(finding: &Finding) -> Markup {
    let labels = |i: usize| finding.figures[i].values.iter().map(|v| &v.0).collect::<Vec<_>>();
    let starts: Vec<usize> = (0..finding.figures.len()).filter(|&i| i == 0 || labels(i) != labels(i - 1)).collect();
    html! {
        @for (n, &start) in starts.iter().enumerate() {
            @let end = starts.get(n + 1).copied().unwrap_or(finding.figures.len());
            div .scroll { table .narrow .dense {
                thead { tr { th .name { "" } @for label in labels(start) { th { (label) } } } }
                tbody { @for series in &finding.figures[start..end] { tr {
                    th .name { (series.name) }
                    @for (_, x) in &series.values { td { (grouped(&padded(*x, 4))) } }
                } } }
            } }
        }
    }
}

/// The printed figures that break a rule.
pub(crate) fn digits(suspects: &[Suspect]) -> Markup {
    html! {
        h2 id="digits" { "Printed figures that cannot be right" }
        p {
            "Found by arithmetic: from other printed figures, or from what the rows show must be so. A figure that is corrected or doubted \
             says so in every table above; the others are shown as printed."
        }
        div .scroll { table .dense {
            thead { tr { th .name { "Cell" } th { "Printed" } th .name { "Why it cannot be" } th .name { "In the data" } } }
            tbody { @for s in suspects { tr {
                th .name { (printed_name(s.cell)) }
                td { (s.cell.printed.as_ref().map_or(String::new(), |f| grouped(&f.text))) }
                td .name .wrap { (s.rule) }
                td .name .wrap {
                    @match (&s.cell.corrected, s.cell.flag) {
                        (Some(right), _) => { "read as " (grouped(&right.text)) ": " (s.cell.reason) },
                        (None, Flag::Printed) => "as printed",
                        (None, _) => (s.cell.reason),
                    }
                }
            } } }
        } }
    }
}
