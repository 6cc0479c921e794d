//! Exponents: how time and each count of a series grow with the number of triangles.

use super::{Growth, milliseconds, steps};
use crate::report::fit::PowerLaw;
use crate::report::number::significant;
use crate::report::printed::{self, Flag};
use crate::rows::{Construction, ScalingRow, Status};

/// One fitted exponent.
#[derive(Clone, Debug)]
pub(crate) struct Exponent {
    /// `gen:spheres`, or `thesis` for its five scenes.
    pub family: String,
    /// A builder's id, or `collapse`.
    pub builder: String,
    /// Reading of the thesis.
    pub preset: String,
    /// Children per inner node.
    pub arity: usize,
    /// `exact`, `literal`, empty for the collapse; `printed` for the thesis' own times and work.
    pub engine: String,
    /// What grows, such as `time`.
    pub quantity: &'static str,
    /// The fit.
    pub law: PowerLaw,
    /// The greatest size's value per triangle over the least size's: 1 for linear growth.
    pub per_triangle: f64,
}

/// What of a row is fitted, by name: `time` in milliseconds, all elementary steps together, each count, and the work that
/// the literal engine and the thesis' program would have had with the same tree.
type Quantity = (&'static str, fn(&ScalingRow) -> Option<f64>);

const QUANTITIES: [Quantity; 13] = [
    ("time", milliseconds),
    ("steps", steps),
    ("combinations", |r| count(r, r.combinations)),
    ("child_costs", |r| count(r, r.child_costs)),
    ("box_unions", |r| count(r, r.box_unions)),
    ("original_unions", |r| count(r, r.original_unions)),
    ("pair_distances", |r| count(r, r.pair_distances)),
    ("nearest_searches", |r| count(r, r.nearest_searches)),
    ("merges", |r| count(r, r.merges)),
    ("dp_steps", |r| count(r, r.dp_steps)),
    ("search_visits", |r| count(r, r.search_visits)),
    ("literal_steps", |r| r.literal_steps),
    ("literal_unions", |r| r.literal_unions),
];

fn count(row: &ScalingRow, n: u64) -> Option<f64> {
    (row.status == Status::Ok && n > 0).then_some(n as f64)
}

/// Every exponent that two sizes or more tell of, series by series in the order of the rows.
pub(crate) fn exponents(growth: &Growth) -> Vec<Exponent> {
    let mut all = Vec::new();
    for rows in series(&growth.scaling) {
        let first = rows[0];
        for (quantity, of) in QUANTITIES {
            let points: Vec<_> = rows.iter().filter_map(|r| Some((r.triangles as f64, of(r)?))).collect();
            if let Some((law, per_triangle)) = fit(&points) {
                all.push(Exponent {
                    family: first.family.clone(),
                    builder: first.builder.clone(),
                    preset: first.preset.clone(),
                    arity: first.arity,
                    engine: first.engine.clone(),
                    quantity,
                    law,
                    per_triangle,
                });
            }
        }
    }
    all.extend(thesis(growth));
    all
}

/// The rows of each series by rising size.
pub(crate) fn series(rows: &[ScalingRow]) -> Vec<Vec<&ScalingRow>> {
    let mut all: Vec<Vec<&ScalingRow>> = Vec::new();
    for row in rows {
        match all.iter_mut().find(|s| s[0].series() == row.series()) {
            Some(series) => series.push(row),
            None => all.push(vec![row]),
        }
    }
    all.iter_mut().for_each(|s| s.sort_by_key(|r| r.triangles));
    all
}

/// The printed times of each column of Table 2, and the work of the program for the same trees.
fn thesis(growth: &Growth) -> Vec<Exponent> {
    let mut all = Vec::new();
    for (construction, arity) in
        [Construction::TopDown, Construction::BottomUp].into_iter().flat_map(|c| [2, 4, 8].map(|k| (c, k)))
    {
        let column = || {
            printed::cells().iter().filter(move |p| {
                p.table == 2
                    && p.construction == Some(construction)
                    && p.arity == Some(arity)
                    && p.flag != Flag::Doubtful
            })
        };
        let times: Vec<_> = column().filter_map(|p| Some((p.size as f64, p.reference()?.value * 1e3))).collect();
        // The same cells, so that the two exponents are about the same trees.
        let work: Vec<_> = column()
            .filter(|p| p.reference().is_some())
            .filter_map(|p| {
                let row = growth.program_work(&p.model.scene(), construction, arity)?;
                Some((row.0 as f64, row.1))
            })
            .collect();
        let quantity = match construction {
            Construction::TopDown => "box unions of the program",
            Construction::BottomUp => "kd-tree steps of the program",
        };
        for (quantity, points) in [("time", times), (quantity, work)] {
            if growth.work.is_empty() {
                continue;
            }
            if let Some((law, per_triangle)) = fit(&points) {
                all.push(Exponent {
                    family: "thesis".into(),
                    builder: construction.id().into(),
                    preset: "published".into(),
                    arity,
                    engine: "printed".into(),
                    quantity,
                    law,
                    per_triangle,
                });
            }
        }
    }
    all
}

fn fit(points: &[(f64, f64)]) -> Option<(PowerLaw, f64)> {
    let law = PowerLaw::through(points)?;
    let (first, last) = (points.first()?, points.last()?);
    Some((law, (last.1 / last.0) / (first.1 / first.0)))
}

/// The fits as CSV.
pub(crate) fn csv_text(exponents: &[Exponent]) -> String {
    let mut text =
        String::from("family,builder,preset,arity,engine,quantity,points,from,to,exponent,low,high,per_triangle\n");
    for e in exponents {
        let bound = |sign: f64| e.law.half_width.map_or(String::new(), |h| significant(e.law.exponent + sign * h, 5));
        let fields = [
            e.family.clone(),
            e.builder.clone(),
            e.preset.clone(),
            e.arity.to_string(),
            e.engine.clone(),
            e.quantity.to_owned(),
            e.law.points.to_string(),
            e.law.range.0.round().to_string(),
            e.law.range.1.round().to_string(),
            significant(e.law.exponent, 5),
            bound(-1.0),
            bound(1.0),
            significant(e.per_triangle, 4),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}
