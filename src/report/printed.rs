//! The thesis' printed numbers as data: Tables 1 to 9 of Beick 2014, with what each misread figure means and why.

use crate::rows::Construction;
use serde::Deserialize;
use std::fmt;
use std::sync::LazyLock;

/// The five models of the thesis' scene (Table 1), by growing size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// 648 triangles.
    Tiny,
    /// 2,540 triangles as printed.
    Small,
    /// 11,516 triangles.
    Med,
    /// 25,340 triangles.
    Large,
    /// 88,748 triangles.
    Huge,
}

impl Model {
    /// All five, by growing size.
    pub const ALL: [Self; 5] = [Self::Tiny, Self::Small, Self::Med, Self::Large, Self::Huge];

    /// Its id in rows and tables, lower case.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Tiny => "tiny",
            Self::Small => "small",
            Self::Med => "med",
            Self::Large => "large",
            Self::Huge => "huge",
        }
    }

    /// Its name in the thesis.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tiny => "Tiny",
            Self::Small => "Small",
            Self::Med => "Medium",
            Self::Large => "Large",
            Self::Huge => "Huge",
        }
    }

    /// The scene in rows that stands for it.
    pub fn scene(self) -> String {
        format!("thesis:{}", self.id())
    }
}

/// How far a printed number can be taken at its word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Flag {
    /// As printed.
    Printed,
    /// Misread or misprinted; `corrected` holds what is meant.
    Corrected,
    /// Doubted; `corrected` holds the likely figure where there is one.
    Doubtful,
    /// No number: the build was stopped at eleven days.
    Capped,
}

/// A number as it was printed (thousands separators left out) and its value.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Figure {
    /// Its digits.
    pub text: String,
    /// Its value.
    pub value: f64,
}

impl TryFrom<String> for Figure {
    type Error = std::num::ParseFloatError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let value = text.parse()?;
        Ok(Self { text, value })
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// One printed number of Tables 1 to 9.
///
/// Without a construction it is a triangle count: a cell of Table 1 or of the size column of another table.
#[derive(Clone, Debug, Deserialize)]
pub struct Printed {
    /// Table, 1 to 9.
    pub table: u8,
    /// Which model.
    pub model: Model,
    /// The model's triangles.
    pub size: usize,
    /// Top-down or bottom-up.
    pub construction: Option<Construction>,
    /// Branching factor: 2, 4 or 8.
    pub arity: Option<usize>,
    /// What is printed; none where the build was capped. Units are the table's (see [`quantity`]).
    pub printed: Option<Figure>,
    /// What is meant, where that differs.
    pub corrected: Option<Figure>,
    /// How far the number can be taken at its word.
    pub flag: Flag,
    /// Why it is corrected, doubted or absent; empty for plain numbers.
    pub reason: String,
}

impl Printed {
    /// The figure to compare with: the corrected one, else the printed one.
    pub fn reference(&self) -> Option<&Figure> {
        self.corrected.as_ref().or(self.printed.as_ref())
    }

    /// Whether it belongs to the size column of a table about something else.
    pub fn is_size_column(&self) -> bool {
        self.table != 1 && self.construction.is_none()
    }
}

/// What a table holds, with its unit.
pub const fn quantity(table: u8) -> &'static str {
    match table {
        1 => "triangles",
        2 => "build seconds",
        3 => "average degree",
        4 | 6 | 8 => "microseconds per pixel",
        _ => "nodes per pixel",
    }
}

/// Whether a table holds times, which depend on the machine.
pub const fn is_time(table: u8) -> bool {
    matches!(table, 2 | 4 | 6 | 8)
}

static CELLS: LazyLock<Vec<Printed>> = LazyLock::new(|| {
    csv::Reader::from_reader(include_str!("printed.csv").as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("printed.csv is part of the program and parsed by its tests")
});

/// Every printed number, table by table, model by model, top-down before bottom-up, by growing arity.
pub fn cells() -> &'static [Printed] {
    &CELLS
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn table(number: u8) -> impl Iterator<Item = &'static Printed> {
        cells().iter().filter(move |c| c.table == number && !c.is_size_column())
    }

    fn cell(number: u8, model: Model, construction: Construction, arity: usize) -> &'static Printed {
        table(number)
            .find(|c| c.model == model && c.construction == Some(construction) && c.arity == Some(arity))
            .unwrap()
    }

    #[test]
    fn every_cell_is_there_once() {
        let counts: Vec<usize> = (1..=9).map(|t| table(t).count()).collect();
        assert_eq!(counts, [5, 30, 10, 30, 30, 30, 30, 30, 30]);
        let keys: HashSet<_> = cells().iter().map(|c| (c.table, c.model, c.construction, c.arity)).collect();
        assert_eq!(keys.len(), cells().len());
        assert_eq!(cells().iter().filter(|c| c.is_size_column()).count(), 35);
        let sizes = [648, 2540, 11516, 25340, 88748];
        for c in cells() {
            assert_eq!(c.size, sizes[c.model as usize]);
            assert_eq!(c.construction.is_some(), c.arity.is_some());
        }
    }

    #[test]
    fn capped_cells_are_empty_and_four_a_table() {
        for t in [2, 4, 5, 6, 7, 8, 9] {
            assert_eq!(table(t).filter(|c| c.flag == Flag::Capped).count(), 4, "table {t}");
        }
        for c in cells() {
            assert_eq!(c.flag == Flag::Capped, c.printed.is_none());
            assert_eq!(c.flag == Flag::Printed, c.reason.is_empty(), "{c:?}");
            assert!(c.flag != Flag::Corrected || c.corrected.is_some(), "{c:?}");
            assert!(c.flag != Flag::Capped || c.model == Model::Huge);
        }
        let nodes = [5, 7, 9].into_iter().flat_map(table);
        assert_eq!(nodes.filter(|c| c.printed.is_some()).count(), 90 - 12);
    }

    /// Sums of the printed figures, added up over the transcription by another program.
    #[test]
    fn sums_are_those_of_the_transcription() {
        let sums = [
            (1, 128_792.0),
            (2, 286_946.178),
            (3, 36.79),
            (4, 3_601.58),
            (5, 151.99),
            (6, 4_221.98),
            (7, 162.76),
            (8, 4_015.78),
            (9, 161.78),
        ];
        for (number, sum) in sums {
            let ours: f64 = table(number).filter_map(|c| c.printed.as_ref()).map(|p| p.value).sum();
            assert!((ours - sum).abs() < 1e-6, "table {number}: {ours} instead of {sum}");
        }
    }

    #[test]
    fn corrections_keep_within_their_bounds() {
        use Construction::{BottomUp, TopDown};
        let reference = |t, m, c, k| cell(t, m, c, k).reference().unwrap().value;
        assert!((1100.0..=2400.0).contains(&reference(2, Model::Tiny, TopDown, 8)));
        assert!((95.0..=240.0).contains(&reference(2, Model::Small, TopDown, 4)));
        assert_eq!(reference(2, Model::Small, TopDown, 8), 10_008.0);
        assert_eq!(reference(2, Model::Huge, TopDown, 2), 91.44);
        for (i, model) in Model::ALL[..4].iter().enumerate() {
            let degree = [3.60, 3.60, 3.60, 3.71][i];
            assert_eq!(reference(3, *model, BottomUp, 4), degree);
            for k in [4, 8] {
                let degree = reference(3, *model, BottomUp, k);
                assert!(degree > 2.0 && degree <= k as f64);
            }
            // Top-down times grow with the arity, once corrected.
            let times = [2, 4, 8].map(|k| reference(2, *model, TopDown, k));
            assert!(times.is_sorted(), "{model:?}: {times:?}");
        }
        assert_eq!(reference(3, Model::Large, BottomUp, 8), 6.71);
        assert_eq!(cells().iter().filter(|c| c.flag == Flag::Corrected).count(), 8);
        assert_eq!(cells().iter().filter(|c| c.flag == Flag::Doubtful).count(), 4);
    }

    /// Times grow with the model in every column, nodes per pixel too (Table 2's doubtful cells included).
    #[test]
    fn columns_grow_with_the_model() {
        for (number, construction) in
            [2, 5, 7, 9].into_iter().flat_map(|t| [(t, Construction::TopDown), (t, Construction::BottomUp)])
        {
            for arity in [2, 4, 8] {
                let column: Vec<f64> = Model::ALL
                    .iter()
                    .filter_map(|m| cell(number, *m, construction, arity).reference())
                    .map(|f| f.value)
                    .collect();
                // Table 9 prints 3.74 for Tiny and 3.70 for Small, bottom-up, arity 8; Table 7 prints 3.68 twice.
                let slack = if number == 2 { 0.0 } else { 0.05 };
                assert!(column.windows(2).all(|w| w[1] >= w[0] - slack), "{number} {construction:?} {arity}");
            }
        }
    }
}
