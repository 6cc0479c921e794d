//! One folder, one program: how the tests call `bvh-lab` and take its answers apart.

use assert_cmd::Command;
use bvh_lab::scene::Scene;
use serde_json::Value;
use std::path::PathBuf;
use std::time::Duration;
use tempfile::TempDir;

/// A fresh folder that the program is run in, so that files go by their bare names.
pub struct Lab(TempDir);

/// What a call left behind.
#[derive(Debug)]
pub struct Run {
    pub status: i32,
    pub out: String,
    pub err: String,
}

impl Lab {
    pub fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// The program with `words`, split at spaces.
    pub fn command(&self, words: &str) -> Command {
        let mut command = assert_cmd::cargo::cargo_bin_cmd!("bvh-lab");
        command.current_dir(self.0.path()).args(words.split_whitespace()).timeout(Duration::from_secs(120));
        command
    }

    pub fn run(&self, words: &str) -> Run {
        taken_apart(self.command(words))
    }

    /// Standard output of a call that must succeed.
    pub fn fine(&self, words: &str) -> String {
        let run = self.run(words);
        assert_eq!(run.status, 0, "{words}: {}", run.err);
        run.out
    }

    /// The one JSON value that a call with `--json` prints, and nothing beside it.
    pub fn json(&self, words: &str) -> Value {
        let out = self.fine(&format!("{words} --json"));
        serde_json::from_str(&out).unwrap_or_else(|e| panic!("{words}: {e} in {out}"))
    }

    /// The line that a call ends with which must fail with `status`.
    pub fn refuse(&self, words: &str, status: i32) -> String {
        refused(&self.run(words), status, words)
    }
}

pub fn taken_apart(mut command: Command) -> Run {
    let output = command.output().unwrap();
    Run {
        status: output.status.code().expect("no signal, no time-out"),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Checks a refusal: the right status, one line on standard error, nothing on standard output.
pub fn refused(run: &Run, status: i32, words: &str) -> String {
    assert_eq!((run.status, run.out.as_str()), (status, ""), "{words}: {run:?}");
    let line = run.err.strip_suffix('\n').unwrap_or_else(|| panic!("{words}: no whole line in {run:?}"));
    let line = line.strip_prefix("bvh-lab: ").unwrap_or_else(|| panic!("{words}: {line}"));
    assert!(!line.contains('\n') && !line.is_empty(), "{words}: more than one line: {line}");
    assert!(!line.contains("panicked") && !line.contains("internal error"), "{words}: {line}");
    line.to_owned()
}

/// A scene's triangles as a `.tri` file.
pub fn tri_bytes(scene: &str) -> Vec<u8> {
    let scene = Scene::load(scene).unwrap();
    let vertices = scene.triangles.iter().flat_map(|t| t.v);
    vertices.flat_map(|v| [v.x, v.y, v.z]).flat_map(f32::to_le_bytes).collect()
}

/// Asserts that the object has all of `fields`.
pub fn has_fields(object: &Value, fields: &[&str]) {
    for field in fields {
        assert!(object.get(field).is_some(), "no field {field} in {object}");
    }
}

/// A figure that must be there.
pub fn number(object: &Value, field: &str) -> f64 {
    object[field].as_f64().unwrap_or_else(|| panic!("{field} is no number in {object}"))
}

/// A word that must be there.
pub fn word(object: &Value, field: &str) -> String {
    object[field].as_str().unwrap_or_else(|| panic!("{field} is no word in {object}")).to_owned()
}

/// Checks median, min, max and runs; returns the runs.
pub fn check_spread(spread: &Value) -> u64 {
    let [least, median, most] = ["min", "median", "max"].map(|f| number(spread, f));
    assert!(0.0 < least && least <= median && median <= most, "{spread}");
    spread["runs"].as_u64().unwrap()
}
