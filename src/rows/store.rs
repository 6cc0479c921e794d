//! Row files on disk: written row by row, read back whole, never silently mixed.

use serde::{Serialize, de::DeserializeOwned};
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A kind of row with a file of its own.
pub trait Row: Serialize + DeserializeOwned + Clone {
    /// The file's name in the rows folder.
    const FILE: &'static str;

    /// What identifies the cell; no two rows of a file share it.
    fn key(&self) -> String;

    /// Version and commit of the program that measured it.
    fn origin(&self) -> (&str, &str);
}

/// What can be wrong with a row file.
#[derive(Debug, thiserror::Error)]
pub enum RowError {
    /// The file system refused.
    #[error("cannot {what} {path}: {source}", path = path.display())]
    Io {
        /// What was tried.
        what: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A row cannot be read.
    #[error("{path}:{line}: not a row of this version ({reason}); move the file away or name another --out", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What is wrong.
        reason: String,
    },
    /// Two rows are about the same cell.
    #[error("{path}: two rows are about the same cell ({key}); remove one", path = path.display())]
    Duplicate {
        /// The file.
        path: PathBuf,
        /// The cell.
        key: String,
    },
    /// Rows of different programs stand side by side.
    #[error("{path}: rows of {first} and of {second} are mixed; measure again into another --out", path = path.display())]
    Mixed {
        /// The file.
        path: PathBuf,
        /// Version and commit of the first row.
        first: String,
        /// Another version and commit.
        second: String,
    },
}

/// Reads all rows of one kind from the folder `dir`; a missing file holds no rows, and a last line without its end, left
/// by a run that was killed while writing, is none.
///
/// # Errors
/// Unreadable or malformed files, two rows about one cell, rows of different versions or commits.
pub fn read<R: Row>(dir: &Path) -> Result<Vec<R>, RowError> {
    let path = dir.join(R::FILE);
    let text = match fs::read_to_string(&path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => return Err(io("read", &path, source)),
    };
    parse(&path, whole_lines(&text))
}

/// Reads all rows of one kind from a file of any name, which has to be there.
///
/// # Errors
/// As [`read`].
pub fn read_file<R: Row>(path: &Path) -> Result<Vec<R>, RowError> {
    let text = fs::read_to_string(path).map_err(|source| io("read", path, source))?;
    parse(path, whole_lines(&text))
}

fn whole_lines(text: &str) -> &str {
    &text[..text.rfind('\n').map_or(0, |end| end + 1)]
}

fn parse<R: Row>(path: &Path, text: &str) -> Result<Vec<R>, RowError> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut rows: Vec<R> = Vec::new();
    for row in reader.deserialize() {
        rows.push(row.map_err(|e: csv::Error| RowError::Malformed {
            path: path.into(),
            line: e.position().map_or(1, csv::Position::line),
            reason: match e.kind() {
                csv::ErrorKind::Deserialize { err, .. } => err.kind().to_string(),
                _ => e.to_string(),
            },
        })?);
    }
    let mut seen = HashMap::new();
    for (i, row) in rows.iter().enumerate() {
        if seen.insert(row.key(), i).is_some() {
            return Err(RowError::Duplicate { path: path.into(), key: row.key() });
        }
        refuse_mixture(path, &rows[0], row)?;
    }
    Ok(rows)
}

fn refuse_mixture<R: Row>(path: &Path, first: &R, second: &R) -> Result<(), RowError> {
    let name = |(version, commit): (&str, &str)| format!("{version} ({commit})");
    if first.origin() == second.origin() {
        return Ok(());
    }
    Err(RowError::Mixed { path: path.into(), first: name(first.origin()), second: name(second.origin()) })
}

/// A row file that grows one row at a time; each row is on disk before the next is measured.
#[derive(Debug)]
pub struct RowFile<R> {
    path: PathBuf,
    rows: Vec<R>,
}

impl<R: Row> RowFile<R> {
    /// Opens the file of this kind in `dir` (made if absent). A last line without its end, left by a run that was
    /// killed while writing, is cut off.
    ///
    /// # Errors
    /// As [`read`]; an existing file is left as it is then.
    pub fn open(dir: &Path) -> Result<Self, RowError> {
        fs::create_dir_all(dir).map_err(|e| io("create", dir, e))?;
        let path = dir.join(R::FILE);
        let rows = match fs::read_to_string(&path) {
            Ok(text) => {
                let whole = whole_lines(&text);
                let rows = parse(&path, whole)?;
                if whole.len() < text.len() {
                    let file = OpenOptions::new().write(true).open(&path);
                    file.and_then(|f| f.set_len(whole.len() as u64)).map_err(|e| io("repair", &path, e))?;
                }
                rows
            }
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(e) => return Err(io("read", &path, e)),
        };
        Ok(Self { path, rows })
    }

    /// The rows so far.
    pub fn rows(&self) -> &[R] {
        &self.rows
    }

    /// The row of the cell `key`.
    pub fn get(&self, key: &str) -> Option<&R> {
        self.rows.iter().find(|r| r.key() == key)
    }

    /// Adds a row, or puts it in the place of the one about the same cell.
    ///
    /// # Errors
    /// A row of another program than the first; the file system's: the file then holds the rows it held before, a new row at its end perhaps in part.
    pub fn put(&mut self, row: R) -> Result<(), RowError> {
        if let Some(first) = self.rows.first() {
            refuse_mixture(&self.path, first, &row)?;
        }
        let key = row.key();
        if let Some(old) = self.rows.iter_mut().find(|r| r.key() == key) {
            *old = row;
            return self.rewrite();
        }
        let text = csv_text(std::slice::from_ref(&row), self.rows.is_empty());
        self.rows.push(row);
        let mut options = OpenOptions::new();
        let file =
            if self.rows.len() == 1 { options.write(true).create(true).truncate(true) } else { options.append(true) }
                .open(&self.path);
        file.and_then(|mut f: File| f.write_all(text.as_bytes())).map_err(|e| io("write", &self.path, e))
    }

    fn rewrite(&self) -> Result<(), RowError> {
        write_whole(&self.path, csv_text(&self.rows, true).as_bytes())
    }
}

/// Writes a file beside its place, then moves it there: it is never seen in part.
///
/// # Errors
/// The file system's; what stood there before still does then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RowError> {
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; rows are for others to read.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
        .tempfile_in(path.parent().unwrap_or(Path::new(".")))
        .and_then(|mut file| {
            file.write_all(bytes)?;
            file.persist(path).map_err(|e| e.error)?;
            Ok(())
        })
        .map_err(|e| io("write", path, e))
}

fn csv_text<R: Row>(rows: &[R], headers: bool) -> String {
    let mut writer = csv::WriterBuilder::new().has_headers(headers).from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).expect("a row is a flat record of plain fields");
    }
    let bytes = writer.into_inner().expect("a Vec takes every write");
    String::from_utf8(bytes).expect("fields are strings and numbers")
}

fn io(what: &'static str, path: &Path, source: std::io::Error) -> RowError {
    RowError::Io { what, path: path.into(), source }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Cell {
        name: String,
        value: Option<f64>,
        commit: String,
    }

    impl Row for Cell {
        const FILE: &'static str = "cells.csv";
        fn key(&self) -> String {
            self.name.clone()
        }
        fn origin(&self) -> (&str, &str) {
            ("1", &self.commit)
        }
    }

    fn cell(name: &str, value: f64, commit: &str) -> Cell {
        Cell { name: name.into(), value: Some(value), commit: commit.into() }
    }

    #[test]
    fn rows_are_on_disk_at_once_and_come_back() {
        let dir = tempfile::tempdir().unwrap();
        let mut file = RowFile::open(dir.path()).unwrap();
        file.put(cell("a", 0.1, "x")).unwrap();
        assert_eq!(read::<Cell>(dir.path()).unwrap().len(), 1);
        file.put(cell("b, \"quoted\"", 0.3, "x")).unwrap();
        let again = RowFile::<Cell>::open(dir.path()).unwrap();
        assert_eq!(again.rows(), file.rows());
        assert_eq!(again.get("a"), Some(&cell("a", 0.1, "x")));
    }

    #[test]
    fn the_same_cell_is_replaced() {
        let dir = tempfile::tempdir().unwrap();
        let mut file = RowFile::open(dir.path()).unwrap();
        for v in [1.0, 2.0, 3.0] {
            file.put(cell("a", v, "x")).unwrap();
            file.put(cell("b", -v, "x")).unwrap();
        }
        let rows = read::<Cell>(dir.path()).unwrap();
        assert_eq!(rows, [cell("a", 3.0, "x"), cell("b", -3.0, "x")]);
    }

    #[test]
    fn a_torn_last_line_is_cut_off() {
        let dir = tempfile::tempdir().unwrap();
        let mut file = RowFile::open(dir.path()).unwrap();
        file.put(cell("a", 1.0, "x")).unwrap();
        let path = dir.path().join(Cell::FILE);
        let whole = fs::read_to_string(&path).unwrap();
        fs::write(&path, format!("{whole}b,2.")).unwrap();
        let mut file = RowFile::<Cell>::open(dir.path()).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        file.put(cell("b", 2.5, "x")).unwrap();
        assert_eq!(read::<Cell>(dir.path()).unwrap().len(), 2);
    }

    #[test]
    fn a_row_of_another_program_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let mut file = RowFile::open(dir.path()).unwrap();
        file.put(cell("a", 1.0, "x")).unwrap();
        assert!(matches!(file.put(cell("b", 1.0, "y")), Err(RowError::Mixed { .. })));
        assert_eq!(read::<Cell>(dir.path()).unwrap().len(), 1);
    }

    #[test]
    fn duplicates_mixtures_and_nonsense_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(Cell::FILE);
        let refuse = |text: &str| {
            fs::write(&path, text).unwrap();
            assert!(RowFile::<Cell>::open(dir.path()).is_err());
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            read::<Cell>(dir.path()).unwrap_err()
        };
        let twice = refuse("name,value,commit\na,1,x\na,2,x\n");
        assert!(matches!(twice, RowError::Duplicate { .. }));
        let mixed = refuse("name,value,commit\na,1,x\nb,2,y\n");
        assert!(matches!(mixed, RowError::Mixed { .. }));
        let nonsense = refuse("name,value,commit\na,one,x\n");
        assert!(matches!(nonsense, RowError::Malformed { line: 2, .. }));
    }
}
