//! Tables 1 to 9 as CSV, ours beside the printed numbers, and Table 2's two engines side by side.

use crate::report::cells::Cell;
use crate::report::number::significant;

/// A table as CSV text: `model,size,construction,arity,printed,corrected,ours,ratio,status`.
pub(crate) fn csv_text(cells: &[Cell]) -> String {
    let mut text = String::from("model,size,construction,arity,printed,corrected,ours,ratio,status\n");
    for cell in cells {
        let p = cell.printed;
        let figure = |f: &Option<crate::report::printed::Figure>| f.as_ref().map_or(String::new(), ToString::to_string);
        let fields = [
            p.model.id().to_owned(),
            p.size.to_string(),
            p.construction.map_or("", |c| c.id()).to_owned(),
            p.arity.map_or(String::new(), |k| k.to_string()),
            figure(&p.printed),
            figure(&p.corrected),
            cell.ours.map_or(String::new(), |x| significant(x, 6)),
            cell.ratio().map_or(String::new(), |x| significant(x, 5)),
            cell.status.id().to_owned(),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

/// Table 2's engines as CSV: seconds of the literal engine and of the exact one for the same tree, and how often the
/// second goes into the first: `model,size,construction,arity,literal,literal_status,exact,exact_status,ratio`.
pub(crate) fn engines_csv(literal: &[Cell], exact: &[Cell]) -> String {
    let mut text = String::from("model,size,construction,arity,literal,literal_status,exact,exact_status,ratio\n");
    for (literal, exact) in literal.iter().zip(exact) {
        let p = literal.printed;
        let figure = |x: Option<f64>, digits| x.map_or(String::new(), |x| significant(x, digits));
        let fields = [
            p.model.id().to_owned(),
            p.size.to_string(),
            p.construction.map_or("", |c| c.id()).to_owned(),
            p.arity.map_or(String::new(), |k| k.to_string()),
            figure(literal.ours, 6),
            literal.status.id().to_owned(),
            figure(exact.ours, 6),
            exact.status.id().to_owned(),
            figure(literal.exact_ratio(), 5),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}
