//! What accuracy costs in time: series out of rows, their tables, their figures, their page, and a summary in plain words.

mod figures;
mod page;
mod price;
mod series;
mod words;

use crate::report::ReportError;
use crate::report::figures::rendered;
use crate::report::files::Folder;
use crate::report::number::significant;
use crate::rows::{AccuracyRow, RowError, Status, read};
use std::path::Path;

pub(crate) const PAGE: &str = "accuracy.html";

/// All rows about accuracy.
#[derive(Debug)]
pub(crate) struct Accuracy {
    /// In the order in which they were measured.
    pub rows: Vec<AccuracyRow>,
}

impl Accuracy {
    /// Reads them.
    ///
    /// # Errors
    /// Rows that cannot be read.
    pub fn read(rows_dir: &Path) -> Result<Self, RowError> {
        Ok(Self { rows: read(rows_dir)? })
    }

    /// Rows that failed their verification.
    pub fn errors(&self) -> usize {
        self.rows.iter().filter(|r| r.status == Status::Error).count()
    }

    /// Writes table, figures and page; removes what an earlier report left where there are no rows.
    ///
    /// # Errors
    /// A drawing that fails, the file system's.
    pub fn write(&self, folder: &mut Folder) -> Result<(), ReportError> {
        let scenes = self.scenes();
        let sheets = figures::sheets(self, &scenes);
        let mut drawn = Vec::new();
        for (name, sheet) in sheets {
            let picture = sheet.map(|s| rendered(&name, &s)).transpose()?;
            for (ending, bytes) in
                [("svg", picture.as_ref().map(|p| p.svg.as_bytes())), ("png", picture.as_ref().map(|p| &p.png[..]))]
            {
                let file = format!("figures/{name}.{ending}");
                match bytes {
                    Some(bytes) => folder.write(&file, bytes)?,
                    None => folder.remove(&file)?,
                }
            }
            drawn.extend(picture.map(|p| (name, p)));
        }
        if self.rows.is_empty() {
            folder.remove("tables/accuracy.csv")?;
            folder.remove("tables/accuracy-robust.csv")?;
            return folder.remove(PAGE);
        }
        folder.write("tables/accuracy.csv", self.csv_text().as_bytes())?;
        folder.write("tables/accuracy-robust.csv", self.robust_text().as_bytes())?;
        folder.write(PAGE, page::html(self, &scenes, &drawn).as_bytes())
    }

    /// Scenes in the order in which they were measured.
    fn scenes(&self) -> Vec<&str> {
        let mut scenes: Vec<&str> = Vec::new();
        for row in &self.rows {
            if !scenes.contains(&row.scene.as_str()) {
                scenes.push(&row.scene);
            }
        }
        scenes
    }

    /// Every setting as a factor over scenes, as CSV.
    fn csv_text(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let header = [
            "study",
            "method",
            "arity",
            "rays",
            "setting",
            "scenes",
            "build_ms_factor",
            "sah_factor",
            "rate_factor",
            "bytes_factor",
            "box_tests_factor",
            "wrong_per_million",
            "decisions",
            "decided_otherwise",
            "largest_excess",
        ];
        writer.write_record(header).expect("a Vec takes every write");
        for series in series::all(self) {
            for p in &series.points {
                let factor = |x: Option<f64>| x.map_or(String::new(), |x| significant(x, 5));
                let record = [
                    series.study.to_owned(),
                    series.method.to_owned(),
                    series.arity.to_string(),
                    series.rays.to_owned(),
                    p.setting.map_or(String::new(), |s| s.to_string()),
                    p.scenes.to_string(),
                    factor(p.time),
                    factor(p.sah),
                    factor(p.rate),
                    factor(p.bytes),
                    factor(p.boxes),
                    factor(p.wrong),
                    p.flips.map_or(String::new(), |f| f.0.to_string()),
                    p.flips.map_or(String::new(), |f| f.1.to_string()),
                    factor(p.excess),
                ];
                writer.write_record(record).expect("a Vec takes every write");
            }
        }
        String::from_utf8(writer.into_inner().expect("a Vec takes every write")).expect("fields are text")
    }

    /// What watertight hits cost, as CSV.
    fn robust_text(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let header = [
            "kernel",
            "rays",
            "scenes",
            "robust_ns_per_ray",
            "fast_ns_per_ray",
            "time_factor",
            "robust_wrong_per_million",
            "fast_missed_per_million",
            "fast_other_per_million",
            "fast_off_per_million",
        ];
        writer.write_record(header).expect("a Vec takes every write");
        for p in price::all(self) {
            let [missed, other, off] = p.wrong;
            let figures = [p.nanoseconds[0], p.nanoseconds[1], p.factor(), p.robust_wrong, missed, other, off];
            let names = [p.kernel.to_owned(), p.rays.to_owned(), p.scenes.to_string()];
            let record = names.into_iter().chain(figures.map(|x| significant(x, 5)));
            writer.write_record(record.collect::<Vec<_>>()).expect("a Vec takes every write");
        }
        String::from_utf8(writer.into_inner().expect("a Vec takes every write")).expect("fields are text")
    }
}
