//! Rows of a study that never ran: near the printed numbers, off by known, repeatable amounts.

use bvh_lab::report::printed::{self, Model};
use bvh_lab::rows::{BuildRow, Construction, DecisionRow, Lighting, RowFile, Status, TraceRow};
use std::path::Path;

pub const CONSTRUCTIONS: [Construction; 2] = [Construction::TopDown, Construction::BottomUp];
pub const ARITIES: [usize; 3] = [2, 4, 8];

fn reference(table: u8, model: Model, construction: Construction, arity: usize) -> Option<f64> {
    let cell = printed::cells()
        .iter()
        .find(|c| (c.table, c.model, c.construction, c.arity) == (table, model, Some(construction), Some(arity)));
    cell.and_then(|c| c.reference()).map(|f| f.value)
}

fn triangles(model: Model) -> usize {
    [648, 2540, 11_516, 25_340, 88_748][model as usize]
}

/// A factor within ±5 % that depends on the cell alone.
fn wobble(model: Model, construction: Construction, arity: usize) -> f64 {
    let step = (model as usize * 7 + arity * 3 + construction as usize * 5) % 11;
    0.95 + step as f64 * 0.01
}

/// A build; the huge ones beyond the reach of the literal engine are projected, one is capped.
pub fn build(preset: &str, model: Model, construction: Construction, arity: usize) -> BuildRow {
    let printed = reference(2, model, construction, arity);
    let seconds = printed.unwrap_or(3.0e6 * arity as f64) * 0.08 * wobble(model, construction, arity);
    let status = match seconds {
        s if s > 60_000.0 && construction == Construction::BottomUp => Status::Capped,
        s if s > 600.0 => Status::Projected,
        _ => Status::Ok,
    };
    let measured = (status == Status::Ok).then_some(seconds * 1000.0);
    let q8 = construction == Construction::TopDown && arity == 8 && measured.is_some();
    let degree = match (construction, arity) {
        (Construction::TopDown, k) => k as f64,
        (_, k) => reference(3, model, construction, k).unwrap_or(k as f64 * 0.85),
    };
    BuildRow {
        preset: preset.to_owned(),
        scene: model.scene(),
        triangles: triangles(model),
        construction,
        arity,
        engine: "literal".to_owned(),
        status,
        budget_s: Some(600.0),
        build_ms: measured,
        build_ms_min: measured,
        build_ms_max: measured,
        runs: usize::from(measured.is_some()),
        projected_ms: (status == Status::Projected).then_some(seconds * 1000.0),
        note: match status {
            Status::Projected => "projected from counted box unions".to_owned(),
            Status::Capped => "budget of 600 s".to_owned(),
            _ => String::new(),
        },
        tree_hash: measured.map(|_| format!("{:032x}", triangles(model) * arity)),
        inner: measured.map(|_| triangles(model) / arity),
        leaves: measured.map(|_| triangles(model) / 2),
        empty: measured.map(|_| 0),
        avg_degree: measured.map(|_| degree * 1.01),
        max_depth: measured.map(|_| 20),
        max_leaf: measured.map(|_| 4),
        sah: measured.map(|_| 12.5),
        epo: None,
        bytes: measured.map(|_| triangles(model) * 64),
        combinations: 1_000,
        box_unions: 10_000,
        original_unions: 1_000_000,
        pair_distances: 0,
        nearest_searches: 0,
        dp_steps: 0,
        search_visits: 0,
        scene_hash: "0".into(),
        original_visits: None,
        original_list_steps: None,
        q8_nodes: if q8 { 17 } else { 0 },
        q8_duplicated: q8.then_some(3),
        q8_hidden: q8.then_some(2),
        threads: 1,
        machine: "Synthetic CPU, Linux".to_owned(),
        version: "0.1.0+rows2".to_owned(),
        commit: "0123abcd".to_owned(),
    }
}

/// The same tree by the exact engine, which always finishes.
pub fn exact(preset: &str, model: Model, construction: Construction, arity: usize) -> BuildRow {
    let literal = build(preset, model, construction, arity);
    BuildRow {
        engine: "exact".to_owned(),
        status: Status::Ok,
        budget_s: None,
        build_ms: Some(triangles(model) as f64 * 0.002),
        runs: 3,
        projected_ms: None,
        note: String::new(),
        tree_hash: Some(format!("{:032x}", triangles(model) * arity)),
        avg_degree: literal.avg_degree.or(Some(arity as f64 * 0.9)),
        ..literal
    }
}

/// A traversal.
pub fn trace(preset: &str, model: Model, construction: Construction, arity: usize, lighting: Lighting) -> TraceRow {
    let index = lighting as u8 * 2;
    let nodes = reference(5 + index, model, construction, arity).unwrap_or(13.0 - arity as f64 * 0.6);
    let nodes = nodes * wobble(model, construction, arity);
    TraceRow {
        preset: preset.to_owned(),
        scene: model.scene(),
        triangles: triangles(model),
        construction,
        arity,
        lighting,
        status: Status::Ok,
        us_per_pixel: Some(nodes * 0.02),
        us_per_pixel_min: Some(nodes * 0.019),
        us_per_pixel_max: Some(nodes * 0.022),
        runs: 5,
        nodes_per_pixel: Some(nodes),
        box_tests_per_pixel: Some(nodes * arity as f64 * 0.6),
        triangle_tests_per_pixel: Some(nodes * 0.5),
        hit_fraction: Some(0.35),
        rays: Some(90_000),
        cut: Some(if lighting == Lighting::Opacity { 4 } else { 0 }),
        tree_hash: Some(format!("{:032x}", triangles(model) * arity)),
        note: String::new(),
        threads: 1,
        machine: "Synthetic CPU, Linux".to_owned(),
        version: "0.1.0+rows2".to_owned(),
        commit: "0123abcd".to_owned(),
    }
}

/// Decisions of one scene and arity; f32 costs change a little.
pub fn decision(model: Model, arity: usize) -> DecisionRow {
    let nodes = triangles(model) / arity;
    DecisionRow {
        preset: "published".to_owned(),
        scene: model.scene(),
        triangles: triangles(model),
        scene_hash: "0".into(),
        arity,
        status: Status::Ok,
        budget_s: Some(5.0),
        note: String::new(),
        compared: Some(nodes),
        different: Some(nodes / 10),
        rounded_ties: Some(nodes / 20),
        same_cost: Some(nodes / 40),
        largest_excess: Some(3.5e-7),
        exact_tree_hash: Some(format!("{:032x}", triangles(model) * arity)),
        f32_tree_hash: Some(format!("{:032x}", triangles(model) * arity + 1)),
        exact_sah: Some(12.5),
        f32_sah: Some(12.5 * 1.01),
        exact_epo: Some(2.0),
        f32_epo: Some(1.9),
        exact_nodes_per_pixel: Some(5.0),
        f32_nodes_per_pixel: Some(5.1),
        threads: 1,
        machine: "Synthetic CPU, Linux".to_owned(),
        version: "0.1.0+rows2".to_owned(),
        commit: "0123abcd".to_owned(),
    }
}

/// All rows of both presets, with the changes `change_build` and `change_trace` make; `None` leaves a row out.
pub fn rows(
    change_build: impl Fn(BuildRow) -> Option<BuildRow>,
    change_trace: impl Fn(TraceRow) -> Option<TraceRow>,
) -> (Vec<BuildRow>, Vec<TraceRow>) {
    let (mut builds, mut traces) = (Vec::new(), Vec::new());
    for preset in ["published", "text"] {
        for model in Model::ALL {
            for construction in CONSTRUCTIONS {
                for arity in ARITIES {
                    builds.extend(change_build(build(preset, model, construction, arity)));
                    builds.extend(change_build(exact(preset, model, construction, arity)));
                    let lit = Lighting::ALL.map(|l| trace(preset, model, construction, arity, l));
                    traces.extend(lit.into_iter().filter_map(&change_trace));
                }
            }
        }
    }
    (builds, traces)
}

/// Puts rows and a picture on disk as a study does.
pub fn store(dir: &Path, (builds, traces): (Vec<BuildRow>, Vec<TraceRow>)) {
    let mut file = RowFile::open(dir).unwrap();
    builds.into_iter().for_each(|row| file.put(row).unwrap());
    let mut file = RowFile::open(dir).unwrap();
    traces.into_iter().for_each(|row| file.put(row).unwrap());
    let picture = image::RgbImage::from_fn(300, 300, |x, y| image::Rgb([(x / 2) as u8, (y / 2) as u8, 90]));
    picture.save(dir.join("figure3.png")).unwrap();
    picture.save(dir.join("figure3-lit.png")).unwrap();
}
