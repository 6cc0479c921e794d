//! Standard output: text for people, one JSON value for programs; a closed pipe is no error.

use super::{Outcome, wrong};
use bvh_lab::rows::Spread;
use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;
use std::io::{ErrorKind, Write};

/// Prints `text` and a line end.
pub fn say(text: &str) -> Outcome {
    let mut out = std::io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(wrong(format!("cannot write to standard output: {e}"))),
        _ => Ok(()),
    }
}

/// Prints one JSON value.
pub fn json(value: &impl Serialize) -> Outcome {
    say(&serde_json::to_string_pretty(value).map_err(wrong)?)
}

/// A table whose first `left` columns are words and whose other columns are numbers.
pub fn table(header: &[&str], left: usize, rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header).add_rows(rows);
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_cell_alignment(if i < left { CellAlignment::Left } else { CellAlignment::Right });
    }
    table.to_string()
}

/// Median with its spread, in `unit`.
pub fn spread_text(s: &Spread, unit: &str) -> String {
    let runs = if s.runs == 1 { "run" } else { "runs" };
    format!("{} {unit} ({} … {}, {} {runs})", short(s.median), short(s.min), short(s.max), s.runs)
}

/// A figure with three significant digits or more, never in exponent form below a million.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if !(1e-3..1e9).contains(&a) => format!("{x:.3e}"),
        a if a >= 100.0 => format!("{x:.0}"),
        a if a >= 10.0 => format!("{x:.1}"),
        a if a >= 1.0 => format!("{x:.2}"),
        _ => format!("{x:.3}"),
    }
}

/// [`short`], or a dash.
pub fn maybe(x: Option<f64>) -> String {
    x.map_or_else(|| "–".into(), short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_stay_short() {
        let all = [0.0, 0.012345, 1.23456, 12.3456, 123.456, 1234567.0, 1.5e12].map(short);
        assert_eq!(all, ["0", "0.012", "1.23", "12.3", "123", "1234567", "1.500e12"]);
        assert_eq!(maybe(None), "–");
    }
}
