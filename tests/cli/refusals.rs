//! Wrong words, wrong files: one clear line, the right exit status, never a panic.

use crate::support::{Lab, refused, taken_apart, tri_bytes};

#[test]
fn words_that_are_off_end_with_status_2() {
    let lab = Lab::new();
    for (words, says) in [
        ("fly", "fly"),
        ("build", "SCENE"),
        ("build nowhere", "unknown scene 'nowhere'"),
        ("build thesis:tinny", "did you mean 'thesis:tiny'"),
        ("build thesis:", "no such level"),
        ("build gen:soup", "number of triangles is missing"),
        ("build gen:soup:0", "from 1 to"),
        ("build gen:nothing:9", "no such family"),
        ("build gen:soup:10:x", "seed"),
        ("scene gen:soup:99999999999999999999", "from 1 to"),
        ("compare nowhere", "unknown scene"),
        ("render nowhere", "unknown scene"),
        ("trace nowhere", "unknown scene"),
        ("reproduce --scenes nowhere --out out", "unknown scene"),
        ("build thesis:tiny -b magic", "there is no such builder; there are top-down, bottom-up"),
        ("compare thesis:tiny -b top-down,magic", "there is no such builder"),
        ("build thesis:tiny -k 3", "2, 4, 8 or 16"),
        ("build thesis:tiny -k two", "2, 4, 8 or 16"),
        ("compare thesis:tiny -k 2,3", "2, 4, 8 or 16"),
        ("compare", "SCENE"),
        ("compare thesis:tiny --kernel first-leaf", "depends on the tree"),
        ("compare thesis:tiny -b bottom-up+leaves -k 4", "bottom-up takes +leaves at arity 2 alone"),
        ("render thesis:tiny --camera 1,2,3", "--camera: '1' is not one of eye=x,y,z"),
        ("compare thesis:tiny --max-leaf 0", "--max-leaf"),
        ("compare thesis:tiny --baseline a.csv", "--fail-if"),
        ("compare thesis:tiny --fail-if sah>1%", "--baseline"),
        ("compare thesis:tiny --allow-missing", "--baseline"),
        ("compare thesis:tiny --baseline a.csv --fail-if sah", "'sah' is no bound: METRIC>PERCENT%"),
        ("compare thesis:tiny --baseline a.csv --fail-if sah>1", "'sah>1' is no bound"),
        ("compare thesis:tiny --baseline a.csv --fail-if sah>-1%", "'sah>-1%' is no bound"),
        ("compare thesis:tiny --baseline a.csv --fail-if sah>nan%", "'sah>nan%' is no bound"),
        ("compare thesis:tiny --baseline a.csv --fail-if primary_mrays<101%", "is no bound"),
        (
            "compare thesis:tiny --baseline a.csv --fail-if sah>1%,fun>1%",
            "no figure 'fun' to bound; there are build_ms, sah",
        ),
        ("build thesis:tiny --budget abc", "a number of seconds"),
        ("build thesis:tiny --budget 0", "a number of seconds above 0"),
        ("build thesis:tiny --budget=-1", "a number of seconds above 0"),
        ("build thesis:tiny --budget nan", "a number of seconds above 0"),
        ("build thesis:tiny --budget inf", "--budget"),
        ("reproduce --budget abc", "a number of seconds"),
        ("reproduce --full --budget 3", "--full"),
        ("reproduce --only table10", "table1 … table9"),
        ("reproduce --only figure2", "figure3 … figure5"),
        ("reproduce --only", "--only"),
        ("scaling --family nothing", "there is no family 'nothing'; there are spheres"),
        ("scaling --sizes 0", "--sizes"),
        ("scaling --sizes x", "--sizes"),
        ("scaling --budget 0", "a number of seconds above 0"),
        ("scaling --scenes nowhere --out out", "unknown scene"),
        ("build thesis:tiny --preset walter", "top-down has no preset walter"),
        ("compare thesis:tiny -b top-down --preset walter", "top-down has not this preset"),
        ("compare thesis:tiny -b binned-sah,top-down -k 16", "top-down has not this preset and arity"),
        ("compare thesis:tiny -b binned-sah --preset text", "none is compared"),
        ("build thesis:tiny --preset old", "published, text, walter"),
        ("build thesis:tiny --engine quick", "--engine"),
        ("build thesis:tiny --q8 maybe", "on, off"),
        ("build thesis:tiny --costs f64", "exact, f32"),
        ("build thesis:tiny --engine exact --costs f32", "adds its costs in f32"),
        ("trace thesis:tiny --engine literal --preset text --costs f32", "adds its costs in f32"),
        ("render thesis:tiny --engine literal -b bottom-up --costs f32", "bottom-up has no use for --costs"),
        ("build thesis:tiny -k 16", "top-down has no arity 16"),
        ("build thesis:tiny -b top-down+rotations", "top-down takes no step but +leaves"),
        ("build thesis:tiny -b bottom-up+leaves -k 4", "bottom-up takes +leaves at arity 2 alone"),
        ("build thesis:tiny -b top-down --max-leaf 2", "top-down has no use for --max-leaf without +leaves"),
        ("build thesis:tiny -b agglo-local+magic", "there is no step magic; there are"),
        ("build thesis:tiny -b agglo-local --preset walter", "agglo-local has no presets"),
        ("build thesis:tiny -b agglo-local --engine exact", "agglo-local has no engines"),
        ("build thesis:tiny -b agglo-local --bins 8", "agglo-local has no use for --bins"),
        ("build thesis:tiny -b agglo-local --max-leaf 0", "--max-leaf"),
        ("build thesis:tiny -b agglo-local --collapse x", "--collapse"),
        ("build thesis:tiny --candidates 0", "--candidates"),
        ("build thesis:tiny --threads 0", "--threads"),
        ("build thesis:tiny --threads -1", "-1"),
        ("build thesis:tiny --runs 0", "--runs"),
        ("build thesis:tiny --wings", "--wings"),
        ("trace thesis:tiny --kernel magic", "there is no such kernel; there are scalar"),
        ("trace thesis:tiny --rays x", "primary, diffuse, any"),
        ("trace thesis:tiny --linear-lookup", "first-leaf"),
        ("trace thesis:tiny --tie-slip off", "first-leaf"),
        ("trace thesis:tiny --rays-file a.rays --size 9x9", "--size"),
        ("trace thesis:tiny --rays-file a.rays --rays diffuse", "traced as they are"),
        ("trace thesis:tiny --size 9", "WIDTHxHEIGHT"),
        ("render thesis:tiny --size 0x9", "WIDTHxHEIGHT"),
        ("render thesis:tiny --size 99999x9", "WIDTHxHEIGHT"),
        ("render thesis:tiny -o picture.jpg", "pictures are written as .png"),
        ("render thesis:tiny -o picture", "pictures are written as .png"),
        ("render thesis:tiny --camera up", "--camera"),
        ("render thesis:tiny --camera eye=0,0,0,look=0,0,0", "same point"),
        ("render thesis:tiny --heatmap cold", "nodes, tests"),
        ("scene thesis:tiny --export scene.stl", "scenes are exported as .obj"),
        ("list wings", "scenes, builders, kernels, experiments, refinements"),
    ] {
        let line = lab.refuse(words, 2);
        assert!(line.contains(says), "{words}: {line}");
        // What is refused leaves nothing behind.
        assert_eq!(std::fs::read_dir(lab.path("")).unwrap().count(), 0, "{words}");
    }
}

#[test]
fn files_that_are_off_end_with_status_1() {
    let lab = Lab::new();
    lab.write("empty.obj", "");
    lab.write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
    lab.write("far.obj", "v 0 0 0\nf 1 2 3\n");
    lab.write("empty.tri", "");
    lab.write("torn.tri", [0; 35]);
    lab.write("nan.tri", [0xff; 36]);
    lab.write("scene.step", "ISO-10303-21;\n");
    lab.write("empty.stl", "solid\nendsolid\n");
    lab.write("torn.rays", [0; 33]);
    std::fs::create_dir(lab.path("folder.obj")).unwrap();
    for (words, says) in [
        ("build missing.obj", "cannot read missing.obj"),
        ("scene no/where.tri", "cannot read no/where.tri"),
        ("build empty.obj", "no triangles"),
        ("build points.obj", "no triangles"),
        ("build far.obj", "far.obj"),
        ("build empty.tri", "no triangles"),
        ("build torn.tri", "35 bytes are not a whole number of triangles"),
        ("build nan.tri", "only 1 triangles with a NaN or infinite vertex"),
        ("build scene.step", "no known format"),
        ("build empty.stl", "no triangles"),
        ("build folder.obj", "directory"),
        ("trace missing.obj", "cannot read"),
        ("render missing.obj", "cannot read"),
        ("compare missing.obj", "cannot read"),
        ("reproduce --scenes missing.obj --only table2 --out out", "cannot read"),
        ("trace thesis:tiny --rays-file missing.rays", "cannot read missing.rays"),
        ("trace thesis:tiny --rays-file torn.rays", "33 bytes are not a multiple of 32"),
        ("trace gen:soup:9 --size 4x4 --runs 1 --hits-out no/where", "cannot write no/where"),
        ("render gen:soup:9 --size 4x4 -o no/where.png", "cannot write no/where.png"),
        ("scene thesis:tiny --export no/where.obj", "cannot write no/where.obj"),
        ("build thesis:tiny -k 4 --candidates 1", "1 candidates cannot split into 4 children"),
        ("report --rows nothing --out out", "no rows in nothing"),
        ("reproduce --scenes gen:soup:9 --only table2 --out empty.obj", "empty.obj"),
    ] {
        let line = lab.refuse(words, 1);
        assert!(line.contains(says), "{words}: {line}");
    }
}

#[test]
fn a_refusal_with_json_prints_no_json() {
    let lab = Lab::new();
    lab.refuse("build missing.obj --json", 1);
    lab.refuse("trace missing.obj --json", 1);
    lab.refuse("scene nowhere --json", 2);
    lab.refuse("compare nowhere --json", 2);
}

#[test]
fn odd_words_stay_on_one_line() {
    let lab = Lab::new();
    for odd in ["two\nlines", "two\nlines.obj", "\x1b[31mred", "thesis:\u{7}", "", "-", "--", "gen:", "🦀", "a\\b.tri"]
    {
        let mut command = lab.command("build");
        command.arg(odd);
        let run = taken_apart(command);
        let status = run.status;
        assert!(status == 1 || status == 2, "{odd:?}: {run:?}");
        refused(&run, status, odd);
    }
}

#[cfg(unix)]
#[test]
fn words_that_are_not_text_are_refused() {
    use std::os::unix::ffi::OsStrExt;
    let lab = Lab::new();
    let mut command = lab.command("scene");
    command.arg(std::ffi::OsStr::from_bytes(b"caf\xe9.obj"));
    refused(&taken_apart(command), 2, "not UTF-8");
}

#[test]
fn a_file_without_a_command_is_told_what_could_be_done_with_it() {
    let lab = Lab::new();
    lab.fine("scene gen:soup:9 --export some.obj");
    assert!(lab.refuse("some.obj", 2).contains("as in `bvh-lab render some.obj`"));
}

#[test]
fn a_budget_beyond_the_clock_is_no_limit() {
    let lab = Lab::new();
    assert_eq!(lab.json("build gen:soup:30 --runs 1 --budget 1e19")["status"], "ok");
}

#[test]
fn damaged_copies_of_a_good_file_never_panic() {
    let lab = Lab::new();
    lab.fine("scene gen:spheres:20 --export good.obj");
    let good = lab.read("good.obj");
    let raw = tri_bytes("gen:spheres:20");
    for step in 1..12 {
        lab.write("cut.obj", &good[..good.len() * step / 12]);
        lab.write("cut.tri", &raw[..raw.len() * step / 12]);
        let mut bent = good.clone();
        let at = good.len() * step / 12;
        bent[at] = b"/-x\xff\x009e \n#"[step % 10];
        lab.write("bent.obj", bent);
        for file in ["cut.obj", "cut.tri", "bent.obj"] {
            let run = lab.run(&format!("build {file} --runs 1 --json"));
            match run.status {
                0 => assert!(run.out.starts_with('{')),
                status => drop(refused(&run, status, file)),
            }
            assert!(run.status < 2, "{file} {step}: {run:?}");
        }
    }
}
