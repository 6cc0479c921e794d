//! Rows of both sections: as CSV files, and as the tables on standard output.

use comfy_table::{CellAlignment, Table, presets};
use serde::Serialize;
use std::path::Path;

/// What every row says of its origin.
#[derive(Clone, Debug, Serialize)]
pub struct Origin {
    /// Processor, hardware threads, operating system.
    pub machine: String,
    /// The laboratory's commit.
    pub commit: String,
    /// Vector instructions that the Rust libraries were compiled for; C++ is compiled for the machine.
    pub rust_target: &'static str,
}

/// One library, preset, scene and number of threads: a build.
#[derive(Clone, Debug, Serialize)]
pub struct BuildRow {
    /// The scene as it was asked for.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// The library.
    pub library: String,
    /// Its version.
    pub version: String,
    /// Its preset.
    pub preset: String,
    /// Threads.
    pub threads: usize,
    /// `ok`, or what went wrong.
    pub status: String,
    /// Median build time, milliseconds.
    pub median_ms: Option<f64>,
    /// Least.
    pub min_ms: Option<f64>,
    /// Greatest.
    pub max_ms: Option<f64>,
    /// Timed builds.
    pub runs: usize,
    /// Million triangles a second, by the median.
    pub mtris_per_s: Option<f64>,
    /// SAH of the tree as it was built, at arity 2, c_trav = c_isect = 1.
    pub sah: Option<f64>,
    /// SAH with equal leaves: at most four triangles, where the cost wants them.
    pub sah_leaf4: Option<f64>,
    /// The most triangles of a leaf as it was built.
    pub max_leaf: Option<usize>,
    /// References over triangles: above 1 where spatial splits put triangles into several leaves.
    pub references: Option<f64>,
    /// Inner boxes that are not the union of those below; scored as if they were.
    pub loose_boxes: Option<usize>,
}

/// One library, preset, traversal, scene and ray set: closest hits on one thread.
#[derive(Clone, Debug, Serialize)]
pub struct TraceRow {
    /// The scene as it was asked for.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// Which rays.
    pub rays: String,
    /// How many.
    pub count: usize,
    /// The library.
    pub library: String,
    /// Its version.
    pub version: String,
    /// Its preset.
    pub preset: String,
    /// Its traversal.
    pub traversal: String,
    /// `ok`, or what went wrong.
    pub status: String,
    /// Median, million rays a second.
    pub median_mrays: Option<f64>,
    /// Least.
    pub min_mrays: Option<f64>,
    /// Greatest.
    pub max_mrays: Option<f64>,
    /// Timed passes.
    pub runs: usize,
    /// Rays with another answer than the reference, within a triangle's width of an edge.
    pub differ_at_edges: usize,
    /// Rays with another answer elsewhere.
    pub differ_elsewhere: usize,
}

/// Writes rows with their origin.
pub fn write<R: Serialize>(path: &Path, origin: &Origin, rows: &[R]) -> Result<(), Box<dyn std::error::Error>> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut writer = csv::Writer::from_path(path)?;
    for row in rows {
        writer.serialize((row, origin))?;
    }
    writer.flush()?;
    Ok(())
}

/// Digits that a reader can use.
fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |v| if v < 10.0 { format!("{v:.3}") } else { format!("{v:.1}") })
}

fn table(header: &[&str], text_columns: usize) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN).set_header(header);
    for column in table.column_iter_mut().skip(text_columns) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

/// The builds of one scene.
pub fn build_table(rows: &[BuildRow]) -> Table {
    let header = ["library", "preset", "thr", "ms", "min", "max", "Mtri/s", "SAH", "SAH≤4", "leaf", "refs", "status"];
    let mut table = table(&header, 2);
    for row in rows {
        table.add_row([
            row.library.clone(),
            row.preset.clone(),
            row.threads.to_string(),
            number(row.median_ms),
            number(row.min_ms),
            number(row.max_ms),
            number(row.mtris_per_s),
            number(row.sah),
            number(row.sah_leaf4),
            row.max_leaf.map_or_else(|| "-".into(), |n| n.to_string()),
            row.references.map_or_else(|| "-".into(), |r| format!("{r:.2}")),
            row.status.clone(),
        ]);
    }
    table
}

/// The traces of one scene.
pub fn trace_table(rows: &[TraceRow]) -> Table {
    let header = ["library", "preset", "traversal", "rays", "Mray/s", "min", "max", "≠ edge", "≠ else", "status"];
    let mut table = table(&header, 4);
    for row in rows {
        table.add_row([
            row.library.clone(),
            row.preset.clone(),
            row.traversal.clone(),
            row.rays.clone(),
            number(row.median_mrays),
            number(row.min_mrays),
            number(row.max_mrays),
            row.differ_at_edges.to_string(),
            row.differ_elsewhere.to_string(),
            row.status.clone(),
        ]);
    }
    table
}
