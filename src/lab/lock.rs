//! One run at a time per folder of rows: two would overwrite each other's.

use crate::rows::RowError;
use std::fs::{File, TryLockError};
use std::path::Path;

/// Held as long as a run writes rows.
#[derive(Debug)]
pub(super) struct Lock(#[expect(dead_code, reason = "held for its lock, which ends with it")] File);

impl Lock {
    /// The file's name in the rows folder.
    pub const FILE: &'static str = ".lock";

    /// Takes the folder, made if absent.
    ///
    /// # Errors
    /// The file system's, or that another run has it.
    pub fn take(rows: &Path) -> Result<Self, RowError> {
        let io = |what, source| RowError::Io { what, path: rows.into(), source };
        std::fs::create_dir_all(rows).map_err(|e| io("create", e))?;
        let file = File::create(rows.join(Self::FILE)).map_err(|e| io("write to", e))?;
        match file.try_lock() {
            Ok(()) => Ok(Self(file)),
            Err(TryLockError::WouldBlock) => Err(io("write to", std::io::Error::other("another run is writing there"))),
            // A file system without locks: as good as it gets.
            Err(TryLockError::Error(_)) => Ok(Self(file)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_run_is_refused_until_the_first_ends() {
        let dir = tempfile::tempdir().unwrap();
        let first = Lock::take(dir.path()).unwrap();
        assert!(Lock::take(dir.path()).is_err());
        drop(first);
        assert!(Lock::take(dir.path()).is_ok());
    }
}
