//! Geometric means over scenes, relative to one builder.

use super::{Class, Comparison, Entrant, bytes_a_triangle, geometric_mean, nodes, peak_bytes_a_triangle, positive};
use crate::report::number::significant;
use crate::rows::CompareRow;

/// Who others are measured by, the first of these that takes part.
const REFERENCES: [&str; 2] = ["sweep-sah", "binned-sah"];

/// A figure that is averaged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quantity {
    /// Its column in CSV files.
    pub id: &'static str,
    /// Its head on the page.
    pub head: &'static str,
    /// Whether more of it is better.
    pub more_is_better: bool,
    /// Of a row.
    pub of: fn(&CompareRow) -> Option<f64>,
}

/// All of them, in the order of the columns.
pub(crate) const QUANTITIES: &[Quantity] = &[
    Quantity { id: "build_ms", head: "time", more_is_better: false, of: |r| r.build_ms },
    Quantity { id: "peak_bytes", head: "memory", more_is_better: false, of: peak_bytes_a_triangle },
    Quantity { id: "sah", head: "SAH", more_is_better: false, of: |r| r.sah },
    Quantity { id: "epo", head: "EPO", more_is_better: false, of: |r| r.epo },
    Quantity { id: "lcv", head: "LCV", more_is_better: false, of: |r| r.lcv },
    Quantity { id: "nodes", head: "nodes", more_is_better: false, of: nodes },
    Quantity { id: "bytes", head: "memory", more_is_better: false, of: bytes_a_triangle },
    Quantity { id: "primary_nodes", head: "nodes a ray", more_is_better: false, of: |r| r.primary_nodes },
    Quantity { id: "primary_tri_tests", head: "triangles", more_is_better: false, of: |r| r.primary_tri_tests },
    Quantity { id: "primary_mrays", head: "MRays/s", more_is_better: true, of: |r| r.primary_mrays },
    Quantity { id: "diffuse_nodes", head: "nodes a ray", more_is_better: false, of: |r| r.diffuse_nodes },
    Quantity { id: "diffuse_tri_tests", head: "triangles", more_is_better: false, of: |r| r.diffuse_tri_tests },
    Quantity { id: "diffuse_mrays", head: "MRays/s", more_is_better: true, of: |r| r.diffuse_mrays },
];

/// The means of one class.
#[derive(Debug)]
pub(crate) struct Means {
    /// Arity and leaf limit.
    pub class: Class,
    /// Who others are measured by; its own ratios are 1.
    pub reference: String,
    /// One line a contestant.
    pub lines: Vec<Line>,
}

/// The means of one contestant.
#[derive(Debug)]
pub(crate) struct Line {
    /// What it is called.
    pub label: String,
    /// Scenes where both it and the reference have figures.
    pub scenes: usize,
    /// Ratios in the order of [`QUANTITIES`]; none where no scene has the figure of both.
    pub ratios: Vec<Option<f64>>,
}

/// Means of every class that has somebody to measure by: the first of [`REFERENCES`], else the first contestant with figures.
pub(crate) fn means(comparison: &Comparison) -> Vec<Means> {
    let entrants = comparison.entrants();
    comparison.classes().into_iter().filter_map(|class| of_class(class, &entrants)).collect()
}

fn of_class(class: Class, entrants: &[Entrant]) -> Option<Means> {
    let here: Vec<&Entrant> =
        entrants.iter().filter(|e| e.rows.first().is_some_and(|r| Class::of(r) == class)).collect();
    let named = |name: &&str| here.iter().find(|e| e.rows[0].recipe == **name);
    let reference = REFERENCES.iter().find_map(named).or(here.first())?;
    let line = |entrant: &&Entrant| {
        let pairs: Vec<_> = entrant
            .rows
            .iter()
            .filter_map(|row| Some((*row, *reference.rows.iter().find(|r| r.scene == row.scene)?)))
            .collect();
        let ratio = |q: &Quantity| {
            geometric_mean(pairs.iter().filter_map(|(a, b)| Some(positive((q.of)(a))? / positive((q.of)(b))?)))
        };
        Line { label: entrant.label.clone(), scenes: pairs.len(), ratios: QUANTITIES.iter().map(ratio).collect() }
    };
    Some(Means { class, reference: reference.label.clone(), lines: here.iter().map(line).collect() })
}

/// The means as CSV text.
pub(crate) fn csv_text(means: &[Means]) -> String {
    let mut text = String::from("recipe,arity,leaf_limit,relative_to,scenes");
    QUANTITIES.iter().for_each(|q| text.push_str(&format!(",{}", q.id)));
    text.push('\n');
    for of_class in means {
        for line in &of_class.lines {
            let Class { arity, leaf_limit } = of_class.class;
            let names = [&line.label, &of_class.reference].map(|name| format!("\"{}\"", name.replace('"', "\"\"")));
            text.push_str(&format!("{},{arity},{leaf_limit},{},{}", names[0], names[1], line.scenes));
            for ratio in &line.ratios {
                text.push(',');
                text.push_str(&ratio.map_or(String::new(), |r| significant(r, 5)));
            }
            text.push('\n');
        }
    }
    text
}
