//! One study of the smallest scene, run once; every test starts from a copy of what it left.

use bvh_lab::rows::{BuildRow, Row, TraceRow, read};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;
use tempfile::TempDir;

/// The cells that the shared study has: all builds of tiny as published, all lighting cases.
pub const CELLS: [&str; 6] = ["--scenes", "thesis:tiny", "--preset", "published", "--only", "table5,table7,table9"];

/// Where the shared study is. No test changes it.
pub static STUDY: LazyLock<PathBuf> = LazyLock::new(|| {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join("study-of-tiny");
    let _ = fs::remove_dir_all(&dir);
    let output = reproduce(&dir, &CELLS, "600");
    assert!(output.status.success(), "{}", text(&output.stderr));
    dir
});

/// Runs `reproduce` with `cells` and seconds a cell into `out`.
pub fn reproduce(out: &Path, cells: &[&str], budget: &str) -> Output {
    command(&[&["reproduce"], cells, &["--budget", budget, "--out"]].concat()).arg(out).output().unwrap()
}

/// Runs `report` from `rows` into `out`.
pub fn report(rows: &Path, out: &Path) -> Output {
    command(&["report", "--rows"]).arg(rows).arg("--out").arg(out).output().unwrap()
}

pub fn command(words: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("bvh-lab"));
    command.args(words);
    command
}

/// A fresh folder with the shared study's rows.
pub fn copy_of_rows() -> TempDir {
    let dir = TempDir::new().unwrap();
    fs::create_dir(dir.path().join("rows")).unwrap();
    for file in [BuildRow::FILE, TraceRow::FILE] {
        fs::copy(STUDY.join("rows").join(file), dir.path().join("rows").join(file)).unwrap();
    }
    dir
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// The lines of a row file, its header first.
pub fn lines<R: Row>(out: &Path) -> Vec<String> {
    fs::read_to_string(out.join("rows").join(R::FILE)).unwrap().lines().map(str::to_owned).collect()
}

pub fn write_lines<R: Row>(out: &Path, lines: &[String]) {
    fs::write(out.join("rows").join(R::FILE), lines.join("\n") + "\n").unwrap();
}

pub fn builds(out: &Path) -> Vec<BuildRow> {
    read(&out.join("rows")).unwrap()
}

pub fn traces(out: &Path) -> Vec<TraceRow> {
    read(&out.join("rows")).unwrap()
}

/// Asserts exit status 1 and one line; returns the line.
pub fn refused(output: &Output) -> String {
    let err = text(&output.stderr);
    assert_eq!((output.status.code(), text(&output.stdout).as_str()), (Some(1), ""), "{err}");
    let line = err.trim_end();
    assert!(line.starts_with("bvh-lab: ") && !line.contains('\n'), "{err}");
    line.to_owned()
}
