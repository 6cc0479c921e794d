//! The command line from outside: what is typed and what comes back, as `bvh-lab`'s users and their scripts see it.

mod accuracy;
mod build;
mod compare;
mod refusals;
mod render;
mod scaling;
mod scene;
mod support;
mod trace;
mod tree_file;

use std::process::{Command, Stdio};
use support::{Lab, taken_apart};

#[test]
fn help_and_version_are_no_errors() {
    let lab = Lab::new();
    let help = lab.fine("--help");
    for command in
        ["reproduce", "scaling", "accuracy", "build", "trace", "render", "compare", "report", "list", "scene"]
    {
        assert!(help.contains(command), "{command}");
        assert!(lab.fine(&format!("{command} --help")).contains("Usage:"));
    }
    assert_eq!(lab.fine("--version").trim(), concat!("bvh-lab ", env!("CARGO_PKG_VERSION")));
    let bare = lab.run("");
    assert_eq!((bare.status, bare.out.as_str()), (2, ""));
    assert!(bare.err.contains("Usage:"));
}

#[test]
fn everything_that_is_listed_works() {
    let lab = Lab::new();
    let ids = |what: &str| -> Vec<String> {
        let list = lab.json(&format!("list {what}"));
        let ids: Vec<_> = list.as_array().unwrap().iter().map(|e| support::word(e, "id")).collect();
        let text = lab.fine(&format!("list {what}"));
        assert!(!ids.is_empty() && ids.iter().all(|id| text.contains(id)), "{what}");
        ids
    };
    for builder in lab.json("list builders").as_array().unwrap() {
        let is_of_the_thesis = ["top-down", "bottom-up"].contains(&support::word(builder, "id").as_str());
        let engines = if is_of_the_thesis { &["exact", "literal"][..] } else { &[] };
        assert_eq!(builder["engines"], serde_json::json!(engines), "{builder}");
    }
    assert!(lab.fine("list builders").contains("engines exact, literal"));
    for id in ids("builders") {
        let report = lab.json(&format!("build gen:spheres:60 -b {id} --runs 1"));
        assert_eq!((support::word(&report, "builder"), support::word(&report, "status")), (id, "ok".to_owned()));
    }
    for id in ids("refinements") {
        let report = lab.json(&format!("build gen:spheres:60 -b agglo-local{id} --runs 1"));
        assert_eq!((&report["refine"], &report["status"]), (&serde_json::json!([&id[1..]]), &"ok".into()));
    }
    for id in ids("kernels") {
        let report = lab.json(&format!("trace gen:spheres:60 --kernel {id} --size 8x8 --runs 1"));
        assert_eq!(support::word(&report, "kernel"), id);
    }
    for id in ids("scenes") {
        if id.starts_with("thesis:") {
            assert!(lab.json(&format!("scene {id}"))["triangles"].as_u64() >= Some(648));
        } else if id.starts_with("gen:") {
            let scene = id.replace(":N[:SEED]", ":37:5");
            assert_eq!(lab.json(&format!("scene {scene}"))["triangles"], 37, "{scene}");
        }
    }
    assert!(ids("experiments").contains(&"reproduce".to_owned()));
}

#[test]
fn a_closed_pipe_is_no_error() {
    for words in [&["list", "scenes"][..], &["scene", "thesis:tiny"], &["build", "thesis:tiny", "--json"]] {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("bvh-lab"));
        let mut child = command.args(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        // The reading end goes before the program has anything to say.
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), err.as_str()), (Some(0), ""), "{words:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_under_standard_output_is_said() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("bvh-lab"));
    let output = command.args(["list", "scenes"]).stdout(full).stderr(Stdio::piped()).output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(err.starts_with("bvh-lab: cannot write to standard output") && err.lines().count() == 1, "{err}");
}

#[test]
fn colours_and_bars_stay_off_where_nobody_looks() {
    let lab = Lab::new();
    let mut command = lab.command("compare gen:soup:30 --size 8x8 --runs 1");
    command.env("CLICOLOR_FORCE", "1").env("NO_COLOR", "1");
    let run = taken_apart(command);
    assert_eq!(run.status, 0);
    assert!(!run.out.contains('\x1b') && !run.err.contains('\x1b') && !run.err.contains('\r'), "{run:?}");
}
