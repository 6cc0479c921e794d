//! Tables 1 to 9 as CSV, ours beside the printed numbers.

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
