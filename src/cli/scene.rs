//! `bvh-lab scene`: what a scene holds.

use super::arguments::SceneArguments;
use super::build::load;
use super::output::{json, say, short};
use super::{Outcome, off, wrong};
use bvh_lab::scene::{Dropped, Effect, EffectSet, Material, Scene, effects, export_obj};
use serde::Serialize;
use std::path::Path;

/// The JSON object of `scene`.
#[derive(Debug, Serialize)]
struct SceneReport<'a> {
    scene: &'a str,
    triangles: usize,
    dropped: Dropped,
    bounds: Bounds,
    surface_area: f64,
    objects: Vec<ObjectReport<'a>>,
    materials: Vec<MaterialReport<'a>>,
    effects: Vec<Effect>,
    /// Materials that call for each effect, in the order of `effects`.
    called_for_by: Vec<Vec<String>>,
    warnings: &'a [String],
}

#[derive(Debug, Serialize)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

#[derive(Debug, Serialize)]
struct ObjectReport<'a> {
    name: &'a str,
    triangles: usize,
}

#[derive(Debug, Serialize)]
struct MaterialReport<'a> {
    name: &'a str,
    triangles: usize,
    diffuse: [f32; 3],
    specular: [f32; 3],
    emission: [f32; 3],
    shininess: f32,
    refraction_index: f32,
    opacity: f32,
    illumination_model: u8,
    /// What it calls for.
    effects: Vec<Effect>,
}

/// Runs the command.
pub fn run(a: &SceneArguments) -> Outcome {
    if let Some(path) = a.export.as_ref().filter(|p| !p.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"))) {
        return Err(off(format!("{}: scenes are exported as .obj", path.display())));
    }
    let same_file = |a: &Path, b: &Path| a.canonicalize().ok().zip(b.canonicalize().ok()).is_some_and(|(a, b)| a == b);
    if let Some(path) = a.export.as_ref().filter(|p| same_file(p, Path::new(&a.scene))) {
        return Err(off(format!("{}: that is the scene itself; export it under another name", path.display())));
    }
    let scene = load(&a.scene)?;
    if let Some(path) = &a.export {
        export_obj(&scene, path).map_err(wrong)?;
        eprintln!("bvh-lab: wrote {}", path.display());
    }
    let report = report(&scene);
    if a.json { json(&report) } else { say(&text(&report)) }
}

fn report(scene: &Scene) -> SceneReport<'_> {
    let bounds = scene.bounds();
    let mut per_material = vec![0; scene.materials.len()];
    scene.material_ids.iter().for_each(|&m| per_material[usize::from(m)] += 1);
    let used = scene.materials.iter().zip(&per_material).filter(|(_, n)| **n > 0);
    let (used_effects, called_for_by) = effects(scene).into_iter().map(|e| (e.effect, e.materials)).unzip();
    SceneReport {
        scene: &scene.name,
        triangles: scene.triangles.len(),
        dropped: scene.dropped,
        bounds: Bounds { min: bounds.min.into(), max: bounds.max.into() },
        surface_area: scene.surface_area(),
        objects: scene.objects.iter().map(|o| ObjectReport { name: &o.name, triangles: o.triangles.len() }).collect(),
        materials: used.map(|(m, &triangles)| material(m, triangles)).collect(),
        effects: used_effects,
        called_for_by,
        warnings: &scene.warnings,
    }
}

fn material(m: &Material, triangles: usize) -> MaterialReport<'_> {
    MaterialReport {
        name: &m.name,
        triangles,
        diffuse: m.diffuse.into(),
        specular: m.specular.into(),
        emission: m.emission.into(),
        shininess: m.shininess,
        refraction_index: m.refraction_index,
        opacity: m.opacity,
        illumination_model: m.illumination_model,
        effects: EffectSet::of(m).iter().collect(),
    }
}

fn text(r: &SceneReport) -> String {
    let corner = |v: [f32; 3]| v.map(|x| short(x.into())).join(", ");
    let mut lines = vec![
        format!("{}: {} in {}", r.scene, counted(r.triangles, "triangle"), counted(r.objects.len(), "object")),
        format!("dropped     {} not finite, {} points and lines", r.dropped.not_finite, r.dropped.points_and_lines),
        format!("bounds      ({}) … ({})", corner(r.bounds.min), corner(r.bounds.max)),
        format!("area        {}", short(r.surface_area)),
    ];
    for m in &r.materials {
        lines.push(format!("material    {}: {}", m.name, counted(m.triangles, "triangle")));
    }
    if r.effects.is_empty() {
        lines.push("effects     none called for".into());
    }
    for (effect, materials) in r.effects.iter().zip(&r.called_for_by) {
        lines.push(format!("effect      {}, called for by {}", effect.id(), materials.join(", ")));
    }
    lines.join("\n")
}

/// `1 object`, `2 objects`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
