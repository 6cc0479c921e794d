//! `bvh-lab compare`: builders side by side, on one scene or several.

mod object;

use super::arguments::{CompareArguments, Recipe};
use super::build::{load, repeats, set_threads};
use super::output::{json, maybe, say, table};
use super::progress::Progress;
use super::reproduce::keep_rows_when_interrupted;
use super::{Failure, Outcome, off, tree_file, wrong};
use bvh_lab::build::{BuildOptions, Preset};
use bvh_lab::lab::{Comparison, Contestant, Repeats, human_seconds, standard_recipes};
use bvh_lab::report::{self, gate};
use bvh_lab::rows::{CompareRow, Row, Status, read_file};
use bvh_lab::scene::Scene;

/// Rounds where none are asked for: short builds want more than [`Repeats::default`] has, long ones stop by their time.
const ROUNDS: usize = 9;

/// Runs the command.
pub fn run(a: &CompareArguments) -> Outcome {
    set_threads(&a.run)?;
    if !a.kernel.1.is_exact() {
        return Err(off(format!(
            "what --kernel {} hits depends on the tree, so there is nothing to compare",
            a.kernel.0
        )));
    }
    if a.scenes.len() > 1 && !a.trees.is_empty() {
        return Err(off("--tree is the tree of one scene, and several are named"));
    }
    let mut contestants = contestants(a)?;
    let baseline = a.baseline.as_ref().map(|path| read_file::<CompareRow>(path)).transpose().map_err(wrong)?;
    let scenes = scenes(a)?;
    for path in &a.trees {
        let tree = Box::new(tree_file::read(path, &scenes[0])?);
        contestants.push(Contestant::Tree { name: path.display().to_string(), tree });
    }
    if let Some(out) = &a.out {
        keep_rows_when_interrupted(out)?;
    }
    let comparison = Comparison {
        contestants,
        rows: a.out.as_ref().map(|out| out.join("rows")),
        budget: a.budget,
        repeats: match a.run.runs {
            Some(_) => repeats(&a.run),
            None => Repeats { runs: ROUNDS, ..Repeats::default() },
        },
        kernel: a.kernel.1,
        kernel_id: a.kernel.0.clone(),
        size: a.size,
    };
    let mut progress = Progress::new();
    let measured = comparison.run(&scenes, &mut progress);
    progress.end();
    let measured = measured.map_err(wrong)?;
    let verdict = baseline.map(|base| gate::check(&measured.concat(), &base, &a.fail_if, a.allow_missing));
    if a.run.json {
        json(&object::report(&scenes, &measured, verdict.as_ref()))?;
    } else {
        let mut texts: Vec<_> = scenes.iter().zip(&measured).map(|(scene, rows)| text(scene, rows)).collect();
        texts.extend(Some(report::advice(&measured.concat()).join("\n")).filter(|advice| !advice.is_empty()));
        say(&texts.join("\n\n"))?;
    }
    if let (Some(rows), Some(out)) = (&comparison.rows, &a.out) {
        report::write(rows, out).map_err(wrong)?;
        eprintln!("bvh-lab: {}", out.join(report::COMPARISON_PAGE).display());
    }
    finish(&measured, verdict)
}

/// The scenes, each once.
fn scenes(a: &CompareArguments) -> Result<Vec<Scene>, Failure> {
    let mut scenes: Vec<Scene> = Vec::new();
    for spec in &a.scenes {
        let scene = load(spec)?;
        if scenes.iter().all(|s| s.name != scene.name) {
            scenes.push(scene);
        }
    }
    Ok(scenes)
}

/// Recipes × readings × arities.
fn contestants(a: &CompareArguments) -> Result<Vec<Contestant>, Failure> {
    let standard = a.builders.is_empty();
    let recipes = match standard {
        true => standard_recipes().into_iter().map(|(builder, refine)| Recipe { builder, refine }).collect(),
        false => a.builders.clone(),
    };
    let asked: Vec<Preset> = a.preset.iter().map(|&p| p.into()).collect();
    let mut all = Vec::new();
    for Recipe { builder, refine } in recipes {
        let max_leaf = a.max_leaf.map(|n| n as usize).filter(|_| builder.limits_leaves(&refine));
        let options = BuildOptions { refine, max_leaf, ..BuildOptions::default() };
        let before = all.len();
        let mut missing = Vec::new();
        for arity in &a.arities {
            let wanted = builder.variants(options).into_iter().filter(|o| {
                o.arity == *arity
                    && builder.engine(o).is_none_or(|engine| engine == a.engine.into())
                    && builder.preset(o).is_none_or(|preset| asked.is_empty() || asked.contains(&preset))
            });
            let found = all.len();
            for options in wanted {
                match builder.check(&options) {
                    Ok(()) => all.push((builder, options)),
                    // Not every recipe of the standard set is one at every arity.
                    Err(_) if standard => {}
                    Err(e) => return Err(off(e)),
                }
            }
            if all.len() == found && !standard {
                missing.push(arity.to_string());
            }
        }
        if all.len() == before && !standard {
            return Err(off(format!(
                "{}{refine} has not this preset and arity; `bvh-lab list builders` shows which have what",
                builder.id
            )));
        }
        if !missing.is_empty() {
            eprintln!("bvh-lab: {}{refine} has no trees of arity {}", builder.id, missing.join(", "));
        }
    }
    let mut once: Vec<(_, BuildOptions)> = Vec::new();
    for (builder, options) in all {
        if once.iter().all(|(b, o): &(&bvh_lab::build::Builder, _)| b.id != builder.id || *o != options) {
            once.push((builder, options));
        }
    }
    if !asked.is_empty() && once.iter().all(|(builder, options)| builder.preset(options).is_none()) {
        return Err(off(
            "--preset is for the thesis' builders, and none is compared; `bvh-lab list builders` shows which have what",
        ));
    }
    Ok(once.into_iter().map(|(builder, options)| Contestant::Recipe { builder, options }).collect())
}

/// What failed, a line each: contestants that were wrong, bounds that were passed.
fn finish(measured: &[Vec<CompareRow>], verdict: Option<gate::Verdict>) -> Outcome {
    let wrong = measured.iter().flatten().filter(|r| r.status == Status::Error);
    let mut lines: Vec<String> = wrong.map(|r| format!("{}: failed: {}", r.key(), r.note)).collect();
    if let Some(verdict) = verdict {
        if verdict.unknown > 0 {
            eprintln!("bvh-lab: {} rows are not in the baseline: nothing holds them", verdict.unknown);
        }
        if verdict.violations.is_empty() {
            eprintln!("bvh-lab: {} figures are within their bounds", verdict.compared);
        }
        lines.extend(verdict.violations);
    }
    if lines.is_empty() { Ok(()) } else { Err(Failure::Several(lines)) }
}

fn text(scene: &Scene, rows: &[CompareRow]) -> String {
    let header = [
        "builder", "k", "build", "SAH", "EPO", "LCV", "nodes", "boxes", "tris", "MRays/s", "nodes", "boxes", "tris",
        "MRays/s", "kB", "peak kB",
    ];
    let lines = rows.iter().map(|r| {
        let mut line = vec![r.name(), r.arity.to_string(), time(r)];
        line.extend([r.sah, r.epo, r.lcv].map(maybe));
        line.extend([r.primary_nodes, r.primary_box_tests, r.primary_tri_tests, r.primary_mrays].map(maybe));
        line.extend([r.diffuse_nodes, r.diffuse_box_tests, r.diffuse_tri_tests, r.diffuse_mrays].map(maybe));
        line.extend([r.bytes, r.peak_bytes].map(|b| b.map_or_else(|| "–".into(), |b| ((b + 500) / 1000).to_string())));
        line
    });
    let [primary, diffuse] =
        [|r: &CompareRow| r.primary_rays, |r: &CompareRow| r.diffuse_rays].map(|of| rows.iter().map(of).max());
    let mut text = format!(
        "{}: {} triangles; the first nodes to MRays/s are of {} primary rays, the second of {} diffuse ones; medians\n{}",
        scene.name,
        scene.triangles.len(),
        primary.unwrap_or(0),
        diffuse.unwrap_or(0),
        table(&header, 1, lines)
    );
    for row in rows.iter().filter(|r| !r.note.is_empty() && r.status != Status::Capped) {
        text.push_str(&format!("\n{}, arity {}: {}", row.name(), row.arity, row.note));
    }
    text
}

/// Build time in words: measured, projected or capped.
fn time(r: &CompareRow) -> String {
    match (r.status, r.build_ms, r.projected_ms) {
        (Status::Error, ..) => "failed".into(),
        (Status::Ok, Some(ms), _) => human_seconds(ms / 1e3),
        (Status::Ok, None, _) => "–".into(),
        (_, _, Some(ms)) => format!("capped; ~{}", human_seconds(ms / 1e3)),
        _ => "capped".into(),
    }
}
