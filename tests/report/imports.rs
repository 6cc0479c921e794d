//! The report reads rows and nothing else of this crate: looked up in its source text.

use std::fs;
use std::path::{Path, PathBuf};

/// Every way out of the report's rooms other than to the rows. `top` says that the file is the report's own `mod.rs`, whose parent
/// is the crate.
fn ways_out(text: &str, top: bool) -> Vec<String> {
    let mut found = Vec::new();
    for line in text.lines() {
        let mut refuse = |reason: &str| found.push(format!("{reason}: {}", line.trim()));
        for (at, path) in line.match_indices("crate::") {
            let target = &line[at + path.len()..];
            let word: String = target.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if word != "rows" && word != "report" {
                refuse("another module");
            }
        }
        if line.contains("bvh_lab::") || line.contains("#[path") {
            refuse("the crate by another name");
        }
        if line.contains("super::super") || top && line.contains("super::") {
            refuse("a climb to the crate");
        }
    }
    found
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files
}

#[test]
fn the_report_imports_rows_only() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/report");
    let files = sources(&folder);
    assert!(files.len() > 10);
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        assert_eq!(ways_out(&text, file == folder.join("mod.rs")), Vec::<String>::new(), "{}", file.display());
        assert!(text.starts_with("//! "), "{} does not say what lives there", file.display());
        assert!(text.lines().count() <= 400, "{} is two rooms", file.display());
    }
}

#[test]
fn ways_out_are_found() {
    let bad = [
        "use crate::geom::Aabb;",
        "use crate::{bvh, rows};",
        "let area = crate::geom::Aabb::area(&b);",
        "use super::super::geom;",
        "use bvh_lab::trace;",
        "use crate::rows::BuildRow; use crate::lab::measure;",
    ];
    for line in bad {
        assert_eq!(ways_out(line, false).len(), 1, "{line}");
    }
    assert_eq!(ways_out("use super::geom;", true).len(), 1);
    for line in
        ["use crate::rows::Row;", "use crate::report::cells::Cell;", "use super::nodes;", "pub(crate) fn f() {}"]
    {
        assert!(ways_out(line, false).is_empty(), "{line}");
    }
}
