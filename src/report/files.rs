//! Files of a report: each written whole or not at all, and listed.

use crate::report::ReportError;
use crate::rows::write_whole;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder a report goes to, and what has been written there.
#[derive(Debug)]
pub(crate) struct Folder {
    root: PathBuf,
    written: Vec<PathBuf>,
}

impl Folder {
    /// A folder that is made when the first file goes there.
    pub fn new(root: &Path) -> Self {
        Self { root: root.into(), written: Vec::new() }
    }

    /// Writes the file `name` (a relative path) beside its place, then moves it there.
    ///
    /// # Errors
    /// The file system's.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), ReportError> {
        let path = self.root.join(name);
        let dir = path.parent().unwrap_or(&self.root);
        fs::create_dir_all(dir).map_err(|e| ReportError::io("create", dir, e))?;
        write_whole(&path, bytes)?;
        self.written.push(path);
        Ok(())
    }

    /// Removes the file `name`, left by an earlier report from other rows: it would not belong to this one.
    ///
    /// # Errors
    /// The file system's.
    pub fn remove(&self, name: &str) -> Result<(), ReportError> {
        let path = self.root.join(name);
        match fs::remove_file(&path) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(ReportError::io("remove", &path, e)),
            _ => Ok(()),
        }
    }

    /// Removes the files of the folder `dir` whose names begin with `prefix` and that have not been written now.
    ///
    /// # Errors
    /// The file system's.
    pub fn remove_others(&self, dir: &str, prefix: &str) -> Result<(), ReportError> {
        let path = self.root.join(dir);
        let entries = match fs::read_dir(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            entries => entries.map_err(|e| ReportError::io("read", &path, e))?,
        };
        for entry in entries {
            let entry = entry.map_err(|e| ReportError::io("read", &path, e))?;
            let name = entry.file_name();
            if name.to_string_lossy().starts_with(prefix) && !self.written.contains(&path.join(&name)) {
                self.remove(&format!("{dir}/{}", name.to_string_lossy()))?;
            }
        }
        Ok(())
    }

    /// What has been written, in order.
    pub fn into_written(self) -> Vec<PathBuf> {
        self.written
    }
}
