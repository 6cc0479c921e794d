//! Claims as files: one line a claim and preset, and the same with every figure as JSON.

use super::Judged;
use crate::report::PRESETS;
use crate::report::number::significant;
use serde_json::{Value, json};

/// `id,statement,place,preset,verdict,why,figures`; figures as `name: label value, …; name: …`.
pub(crate) fn csv_text(judged: &[Judged]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = ["id", "statement", "quote", "place", "preset", "verdict", "why", "figures"];
    let lines =
        judged.iter().flat_map(|j| PRESETS.iter().zip(&j.findings).map(move |(preset, f)| (j.claim, *preset, f)));
    let records = lines.map(|(c, preset, f)| {
        let figures: Vec<String> = f
            .figures
            .iter()
            .map(|s| {
                let values: Vec<_> = s.values.iter().map(|(l, x)| format!("{l} {}", significant(*x, 6))).collect();
                format!("{}: {}", s.name, values.join(", "))
            })
            .collect();
        let words = [c.id, c.statement, c.quote, c.place, preset, f.verdict.words(), &f.why];
        words.into_iter().map(str::to_owned).chain([figures.join("; ")]).collect::<Vec<_>>()
    });
    let all = std::iter::once(header.map(str::to_owned).to_vec()).chain(records);
    for record in all {
        writer.write_record(record).expect("a line in memory can be written");
    }
    let bytes = writer.into_inner().expect("a line in memory can be flushed");
    String::from_utf8(bytes).expect("everything written is text")
}

/// An array of claims; each with its words and, by preset, verdict, why and figures.
pub(crate) fn json_text(judged: &[Judged]) -> String {
    let one = |j: &Judged| {
        let findings: serde_json::Map<String, Value> =
            PRESETS.iter().zip(&j.findings).map(|(p, f)| ((*p).to_owned(), json!(f))).collect();
        let c = j.claim;
        json!({
            "id": c.id, "statement": c.statement, "quote": c.quote, "place": c.place, "predicate": c.predicate,
            "findings": findings,
        })
    };
    let all: Vec<Value> = judged.iter().map(one).collect();
    let mut text = serde_json::to_string_pretty(&all).expect("words and numbers can be written");
    text.push('\n');
    text
}
