//! `bvh-lab compare`: builders side by side on one scene.

use super::arguments::{CompareArguments, Recipe};
use super::build::{BuildReport, load, repeats, set_threads};
use super::output::{json, maybe, say, table};
use super::trace::{Measured, measure};
use super::{Outcome, off};
use bvh_lab::build::{BUILDERS, BuildOptions, Builder, Preset};
use bvh_lab::lab::BuildCell;
use bvh_lab::refine::Refinements;
use bvh_lab::rows::Spread;
use bvh_lab::trace::{Batch, Kernel, Query, primary_rays};
use serde::Serialize;

/// One builder of the comparison.
#[derive(Debug, Serialize)]
struct Entry {
    #[serde(flatten)]
    build: BuildReport,
    nodes_per_ray: Option<f64>,
    box_tests_per_ray: Option<f64>,
    tri_tests_per_ray: Option<f64>,
    mrays_per_s: Option<Spread>,
    hit_hash: Option<String>,
}

/// Runs the command.
pub fn run(a: &CompareArguments) -> Outcome {
    set_threads(&a.run)?;
    let variants = variants(a)?;
    let scene = load(&a.scene)?;
    let rays = primary_rays(&scene.camera, a.size.0, a.size.1);
    let mut entries = Vec::new();
    for (builder, options) in variants {
        let preset = builder.preset(&options).map_or("", Preset::id);
        eprintln!("bvh-lab: {}{} {preset} arity {} …", builder.id, options.refine, options.arity);
        let cell = BuildCell { builder, options, budget: Some(a.budget), repeats: repeats(&a.run) };
        let (build, built) = BuildReport::measure(&scene, &cell)?;
        let traced: Option<Measured> = match &built {
            Some(built) => {
                let batch = Batch {
                    kernel: Kernel::Scalar,
                    query: Query::Closest,
                    bvh: &built.bvh,
                    triangles: &scene.triangles,
                    rays: &rays,
                };
                Some(measure(&batch, &repeats(&a.run))?)
            }
            None => None,
        };
        entries.push(Entry {
            build,
            nodes_per_ray: traced.as_ref().and_then(|t| t.nodes_per_ray),
            box_tests_per_ray: traced.as_ref().and_then(|t| t.box_tests_per_ray),
            tri_tests_per_ray: traced.as_ref().and_then(|t| t.tri_tests_per_ray),
            mrays_per_s: traced.as_ref().map(|t| t.mrays_per_s),
            hit_hash: traced.map(|t| t.hit_hash),
        });
    }
    let reference = entries.iter().find(|e| e.build.q8_hidden == Some(0)).and_then(|e| e.hit_hash.clone());
    for e in entries.iter().filter(|e| e.hit_hash.is_some() && e.hit_hash != reference) {
        let (made_by, k) = (e.build.made_by(), e.build.arity);
        let hidden = e.build.q8_hidden.unwrap_or(0);
        eprintln!(
            "bvh-lab: {made_by} arity {k}: rays hit something else than with the others ({hidden} triangles are hidden by rule Q8)"
        );
    }
    if a.run.json {
        return json(&serde_json::json!({
            "scene": scene.name,
            "triangles": scene.triangles.len(),
            "dropped": scene.dropped.total(),
            "threads": rayon::current_num_threads(),
            "kernel": "scalar",
            "rays": rays.len(),
            "builders": entries,
        }));
    }
    say(&text(&scene.name, scene.triangles.len(), &entries))
}

/// Builders × readings × arities.
fn variants(a: &CompareArguments) -> Result<Vec<(&'static Builder, BuildOptions)>, super::Failure> {
    let recipes = if a.builders.is_empty() {
        BUILDERS.iter().map(|builder| Recipe { builder, refine: Refinements::default() }).collect()
    } else {
        a.builders.clone()
    };
    let asked: Vec<Preset> = a.preset.iter().map(|&p| p.into()).collect();
    let mut all = Vec::new();
    for Recipe { builder, refine } in recipes {
        let options = BuildOptions { refine, ..BuildOptions::default() };
        for arity in &a.arities {
            let wanted = builder.variants(options).into_iter().filter(|o| {
                o.arity == *arity
                    && builder.engine(o).is_none_or(|engine| engine == a.engine.into())
                    && builder.preset(o).is_none_or(|preset| asked.is_empty() || asked.contains(&preset))
            });
            all.extend(wanted.map(|options| (builder, options)));
        }
    }
    all.iter().try_for_each(|(builder, options)| builder.check(options)).map_err(off)?;
    if all.is_empty() {
        return Err(off(
            "none of these builders has this preset and arity; `bvh-lab list builders` shows which have what",
        ));
    }
    Ok(all)
}

fn text(scene: &str, triangles: usize, entries: &[Entry]) -> String {
    let header = ["builder", "k", "build", "SAH", "EPO", "nodes/ray", "boxes/ray", "tris/ray", "MRays/s", "kB"];
    let rows = entries.iter().map(|e| {
        vec![
            e.build.made_by(),
            e.build.arity.to_string(),
            e.build.time(),
            maybe(e.build.sah),
            maybe(e.build.epo),
            maybe(e.nodes_per_ray),
            maybe(e.box_tests_per_ray),
            maybe(e.tri_tests_per_ray),
            maybe(e.mrays_per_s.map(|s| s.median)),
            e.build.bytes.map_or_else(|| "–".into(), |b| (b / 1000).to_string()),
        ]
    });
    format!("{scene}: {triangles} triangles\n{}", table(&header, 1, rows))
}
