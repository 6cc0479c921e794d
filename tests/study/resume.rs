//! Runs that are cut short, run again, or run with more time: what is measured is never measured twice.

use crate::support::{CELLS, builds, command, copy_of_rows, lines, reproduce, text, traces, write_lines};
use bvh_lab::lab::commit;
use bvh_lab::rows::{BuildRow, Row, Status, TraceRow};
use std::fs;
use std::path::Path;

/// The two cheapest cells, without pictures: what is enough where only the files matter.
const CHEAP: [&str; 6] = ["--scenes", "thesis:tiny", "--preset", "published", "--only", "table3"];

fn run(out: &Path, cells: &[&str], budget: &str) -> String {
    let output = reproduce(out, cells, budget);
    let err = text(&output.stderr);
    assert!(output.status.success(), "{err}");
    err
}

/// A row without what a second measurement changes.
fn untimed_build(row: &BuildRow) -> BuildRow {
    BuildRow { build_ms: None, build_ms_min: None, build_ms_max: None, runs: 0, ..row.clone() }
}

fn untimed_trace(row: &TraceRow) -> TraceRow {
    TraceRow { us_per_pixel: None, us_per_pixel_min: None, us_per_pixel_max: None, runs: 0, ..row.clone() }
}

#[test]
fn a_second_run_measures_nothing() {
    let dir = copy_of_rows();
    let before = (lines::<BuildRow>(dir.path()), lines::<TraceRow>(dir.path()));
    run(dir.path(), &CELLS, "600");
    // Neither does one with less time or fewer words.
    run(dir.path(), &CELLS, "0.001");
    run(dir.path(), &CHEAP, "600");
    assert_eq!((lines::<BuildRow>(dir.path()), lines::<TraceRow>(dir.path())), before);
}

#[test]
fn a_run_that_was_cut_short_goes_on_from_its_rows() {
    let dir = copy_of_rows();
    let before = (lines::<BuildRow>(dir.path()), lines::<TraceRow>(dir.path()));
    let whole = (builds(dir.path()), traces(dir.path()));
    // Killed while it wrote: the last build and its three pictures are gone, half a line stands in each file.
    let torn = |lines: &[String], keep: usize| lines[..keep].join("\n") + "\n" + &lines[keep][..lines[keep].len() / 2];
    let rows = dir.path().join("rows");
    fs::write(rows.join(BuildRow::FILE), torn(&before.0, 6)).unwrap();
    fs::write(rows.join(TraceRow::FILE), torn(&before.1, 16)).unwrap();
    run(dir.path(), &CELLS, "600");
    let after = (lines::<BuildRow>(dir.path()), lines::<TraceRow>(dir.path()));
    assert_eq!((after.0.len(), after.1.len()), (7, 19));
    // Times and all: not one finished cell was measured again.
    assert_eq!(after.0[..6], before.0[..6]);
    assert_eq!(after.1[..16], before.1[..16]);
    let again = (builds(dir.path()), traces(dir.path()));
    assert_eq!(
        again.0.iter().map(untimed_build).collect::<Vec<_>>(),
        whole.0.iter().map(untimed_build).collect::<Vec<_>>()
    );
    assert_eq!(
        again.1.iter().map(untimed_trace).collect::<Vec<_>>(),
        whole.1.iter().map(untimed_trace).collect::<Vec<_>>()
    );
    assert!(again.0[5].build_ms > Some(0.0) && again.1[17].us_per_pixel > Some(0.0));
}

#[test]
fn a_missing_picture_is_taken_of_the_tree_that_was_measured() {
    let dir = copy_of_rows();
    let before = lines::<BuildRow>(dir.path());
    let mut pictures = lines::<TraceRow>(dir.path());
    let gone = pictures.remove(10);
    write_lines::<TraceRow>(dir.path(), &pictures);
    run(dir.path(), &CELLS, "600");
    assert_eq!(lines::<BuildRow>(dir.path()), before);
    let after = lines::<TraceRow>(dir.path());
    assert_eq!(after[..18], pictures);
    let key = |line: &str| line.split(',').take(6).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(key(&after[18]), key(&gone));
    // A row that names another tree than the one that comes out is an error row, never a number.
    let mut bent = before.clone();
    let hash = builds(dir.path())[0].tree_hash.clone().unwrap();
    bent[1] = bent[1].replace(&hash, "00000000000000000000000000000000");
    write_lines::<BuildRow>(dir.path(), &bent);
    let first_tree = format!("{},", key(&after[1])[..5].join(","));
    let others: Vec<_> = after.iter().filter(|l| !l.starts_with(&first_tree)).cloned().collect();
    assert_eq!(others.len(), 16);
    write_lines::<TraceRow>(dir.path(), &others);
    let output = reproduce(dir.path(), &CELLS, "600");
    assert_eq!(output.status.code(), Some(1), "a result that is wrong ends with status 1");
    let errors: Vec<_> = traces(dir.path()).into_iter().filter(|t| t.status == Status::Error).collect();
    assert_eq!(errors.len(), 3);
    assert!(errors.iter().all(|t| t.nodes_per_pixel.is_none() && t.us_per_pixel.is_none() && !t.note.is_empty()));
}

#[test]
fn more_time_is_given_to_capped_cells_alone() {
    let dir = tempfile::tempdir().unwrap();
    const CELLS: [&str; 6] = ["--scenes", "thesis:tiny", "--preset", "published", "--only", "table2,table5"];
    let said = run(dir.path(), &CELLS, "0.04");
    let (first, first_lines) = (builds(dir.path()), lines::<BuildRow>(dir.path()));
    let octonary = first.iter().find(|r| r.key().contains("top-down k=8 literal")).unwrap();
    assert!(octonary.status == Status::Projected && octonary.projected_ms > Some(40.0), "{octonary:?}");
    assert!(octonary.tree_hash.is_none() && octonary.build_ms.is_none() && said.contains("capped"), "{said}");
    assert!(first.iter().any(|r| r.status == Status::Ok));
    // The pictures are those of the exact engine's tree.
    let traced = lines::<TraceRow>(dir.path());
    let picture = traces(dir.path()).into_iter().find(|t| t.key().contains("top-down k=8")).unwrap();
    assert!(picture.status == Status::Ok && picture.nodes_per_pixel > Some(1.0));
    // As much time again changes nothing; more of it finishes what was capped.
    run(dir.path(), &CELLS, "0.04");
    assert_eq!(lines::<BuildRow>(dir.path()), first_lines);
    run(dir.path(), &CELLS, "600");
    let (second, second_lines) = (builds(dir.path()), lines::<BuildRow>(dir.path()));
    assert_eq!(second.len(), 12);
    for (i, row) in first.iter().enumerate() {
        assert_eq!((second[i].key(), second[i].status), (row.key(), Status::Ok));
        assert_eq!(second_lines[i + 1] == first_lines[i + 1], row.status == Status::Ok, "{}", row.key());
    }
    assert_eq!(lines::<TraceRow>(dir.path()), traced);
}

#[test]
fn rows_of_another_commit_are_moved_aside_and_said_so() {
    for torn in [false, true] {
        let dir = copy_of_rows();
        let theirs = "0123456789ab";
        let change = |lines: Vec<String>| lines.iter().map(|l| l.replace(commit(), theirs)).collect::<Vec<_>>();
        let old = (change(lines::<BuildRow>(dir.path())), change(lines::<TraceRow>(dir.path())));
        write_lines::<BuildRow>(dir.path(), &old.0);
        write_lines::<TraceRow>(dir.path(), &old.1);
        let tail = if torn { "\npublished,thesis:ti" } else { "\n" };
        fs::write(dir.path().join("rows").join(BuildRow::FILE), old.0.join("\n") + tail).unwrap();
        let said = run(dir.path(), &CHEAP, "600");
        let moved = said.lines().find(|l| l.contains("moved")).unwrap_or_else(|| panic!("{said}"));
        assert!(moved.contains(theirs) && moved.contains("rows-0123456789ab-1"), "{moved}");
        let aside = dir.path().join("rows-0123456789ab-1");
        let kept = |file: &str| fs::read_to_string(aside.join(file)).unwrap();
        assert_eq!(kept(BuildRow::FILE), old.0.join("\n") + tail);
        assert_eq!(kept(TraceRow::FILE), old.1.join("\n") + "\n");
        let ours = builds(dir.path());
        assert!(ours.len() == 2 && ours.iter().all(|r| r.commit == commit()), "{ours:?}");
    }
}

#[test]
fn a_scene_that_is_not_there_moves_no_rows() {
    let dir = copy_of_rows();
    let old: Vec<_> = lines::<BuildRow>(dir.path()).iter().map(|l| l.replace(commit(), "0123456789ab")).collect();
    write_lines::<BuildRow>(dir.path(), &old);
    let output = reproduce(dir.path(), &["--scenes", "thesis:tiny,nowhere", "--only", "table3"], "600");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(lines::<BuildRow>(dir.path()), old);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_its_rows() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let dir = tempfile::tempdir().unwrap();
    // All exact builds take no time here, nor does the text's literal search at arity 2 and 4; at arity 8 half a minute.
    let cells = ["reproduce", "--scenes", "gen:spheres:60", "--preset", "text", "--only", "table2", "--full", "--out"];
    let child = command(&cells).arg(dir.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let file = dir.path().join("rows").join(BuildRow::FILE);
    let begin = Instant::now();
    while fs::read_to_string(&file).map_or(0, |rows| rows.matches('\n').count()) < 9 {
        assert!(begin.elapsed() < Duration::from_secs(60), "the first eight cells never came");
        std::thread::sleep(Duration::from_millis(10));
    }
    let rows = fs::read(&file).unwrap();
    let interrupt = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupt.success());
    let output = child.wait_with_output().unwrap();
    let err = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(err.contains("interrupted; finished rows are in"), "{err}");
    assert_eq!(fs::read(&file).unwrap(), rows);
    // The next run caps the long cell and goes on; what was measured stays.
    let rest = ["--scenes", "gen:spheres:60", "--preset", "text", "--only", "table2"];
    run(dir.path(), &rest, "0.05");
    assert!(fs::read(&file).unwrap().starts_with(&rows));
    assert_eq!(builds(dir.path()).len(), 12);
}
