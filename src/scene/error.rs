//! What can be wrong with a scene.

use std::path::{Path, PathBuf};

/// Why a scene could not be had; each message says what, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The words that name the scene are off (exit status 2).
    #[error("unknown scene '{spec}': {reason}; `bvh-lab list scenes` shows what there is")]
    Unknown {
        /// What was asked for.
        spec: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The file could not be read.
    #[error("cannot read {path}: {source}", path = one_line(path))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file could not be written.
    #[error("cannot write {path}: {source}", path = one_line(path))]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not what its ending promises.
    #[error("{path}{at}: {reason}", path = one_line(path), at = line.map(|l| format!(":{l}")).unwrap_or_default())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1, where there is one.
        line: Option<usize>,
        /// What is wrong and what to do.
        reason: String,
    },
    /// Nothing is left to build a tree over.
    #[error("{name}: no triangles{detail}; a tree needs at least one")]
    Empty {
        /// The scene.
        name: String,
        /// What was there instead, led in by " (" where known.
        detail: String,
    },
}

/// A path as it is shown: control characters escaped, so that a message stays one line.
pub(super) fn one_line(path: &Path) -> String {
    let shown = path.display().to_string();
    if shown.contains(char::is_control) { shown.escape_debug().to_string() } else { shown }
}
