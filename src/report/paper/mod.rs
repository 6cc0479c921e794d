//! The paper: the replication as a page to be read, `paper/paper.md` with everything that is a result filled in from rows.
//!
//! The text is a template (minijinja) in Markdown (pulldown-cmark). A name in it that is not filled in is an error, and a test holds it to having no
//! result of its own. Lines such as `@@figure5@@` stand for figures and tables.

mod context;

use crate::report::ReportError;
use crate::report::cells::Study;
use crate::report::claims::Judged;
use crate::report::figures::Figures;
use crate::report::page::{document, exhibit};
use crate::report::summary::Summary;
use maud::{PreEscaped, html};
use minijinja::{Environment, UndefinedBehavior};
use pulldown_cmark::{Options, Parser};

/// The paper's file.
pub(crate) const PAPER: &str = "paper.html";

const TEXT: &str = include_str!("../../../paper/paper.md");
const MARK: &str = "@@";

/// The paper as a self-contained page.
///
/// # Errors
/// A text that does not fit what it is filled with.
pub(crate) fn html(
    study: &Study,
    summary: &Summary,
    judged: &[Judged],
    figures: &Figures,
) -> Result<String, ReportError> {
    let text = fill(TEXT, &context::of(study, summary, judged))
        .map_err(|e| ReportError::Draw { figure: PAPER.into(), reason: format!("{e:#}") })?;
    let mut body = String::new();
    pulldown_cmark::html::push_html(&mut body, Parser::new_ext(&text, Options::ENABLE_TABLES));
    let body = with_exhibits(&body, |name| exhibit(study, figures, name).into_string());
    let page = html! {
        p .soft { a href=(crate::report::STUDY_PAGE) { "The study" } ": every table, figure and claim, with its rows." }
        article .paper { (PreEscaped(body)) }
    };
    Ok(document("bvh-lab: the replication", &page))
}

fn fill(text: &str, context: &minijinja::Value) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.render_str(text, context)
}

/// Puts figures and tables where their marks stand alone in a paragraph.
fn with_exhibits(body: &str, exhibit: impl Fn(&str) -> String) -> String {
    let (open, close) = (format!("<p>{MARK}"), format!("{MARK}</p>"));
    let mut parts = body.split(&open);
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once(&close) {
            Some((name, rest)) => out += &(exhibit(name) + rest),
            None => out += part,
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_give_way_to_exhibits() {
        let text = "<p>before</p>\n<p>@@figure5@@</p>\n<p>after</p>";
        assert_eq!(with_exhibits(text, |name| format!("[{name}]")), "<p>before</p>\n[figure5]\n<p>after</p>");
    }

    #[test]
    fn a_name_that_is_not_filled_in_is_an_error() {
        assert!(fill("{{ nothing.here }}", &minijinja::context! {}).is_err());
    }

    /// No result is typed in: outside of code and references the prose has no decimal, percent or grouped number but the parameters of the
    /// thesis and of the comparison.
    #[test]
    fn the_text_has_no_number_of_its_own() {
        let prose = TEXT.split("## References").next().unwrap();
        let allowed = ["6 %", "2014", "100", "50", "25"];
        let mut rest = String::new();
        for (i, part) in prose.split("{{").enumerate() {
            rest += if i == 0 { part } else { part.split_once("}}").unwrap().1 };
        }
        for allowed in allowed {
            rest = rest.replace(allowed, "");
        }
        let rest: String = rest.lines().filter(|l| !l.starts_with("    ") && !l.starts_with("@@")).collect();
        let digits: Vec<_> = rest.split_whitespace().filter(|w| w.chars().any(|c| c.is_ascii_digit())).collect();
        let harmless = |w: &&&str| ["1", "Q8", "5,", "|---|---|--:|"].contains(&w.trim_end_matches([';', ')']));
        let typed: Vec<_> = digits.iter().filter(|w| !harmless(w)).collect();
        assert!(typed.is_empty(), "{typed:?}");
    }
}
