//! `bvh-lab list`: what there is.

use super::Outcome;
use super::arguments::{ListArguments, ListWord};
use super::output::{json, say};
use bvh_lab::build::{BUILDERS, Builder};
use bvh_lab::refine::STEPS;
use bvh_lab::rows::Experiment;
use bvh_lab::scene::families::FAMILIES;
use bvh_lab::scene::thesis;
use bvh_lab::trace::KERNELS;
use serde::Serialize;

/// One thing of a list.
#[derive(Debug, Serialize)]
struct Entry {
    id: String,
    summary: String,
    source: String,
    #[serde(flatten)]
    offers: Option<Offers>,
}

/// What a builder can be asked for.
#[derive(Debug, Serialize)]
struct Offers {
    presets: Vec<&'static str>,
    engines: Vec<&'static str>,
    arities: &'static [usize],
    parameters: Vec<&'static str>,
}

/// Runs the command.
pub fn run(a: &ListArguments) -> Outcome {
    let entries = match a.what {
        ListWord::Scenes => scenes(),
        ListWord::Builders => builders(),
        ListWord::Kernels => kernels(),
        ListWord::Experiments => experiments(),
        ListWord::Refinements => refinements(),
    };
    if a.json {
        return json(&entries);
    }
    let width = entries.iter().map(|e| e.id.len()).max().unwrap_or(0);
    let line = |e: &Entry| format!("{:width$}  {} ({})", e.id, e.summary, e.source);
    say(&entries.iter().map(line).collect::<Vec<_>>().join("\n"))
}

fn entry(id: impl Into<String>, source: impl Into<String>, summary: impl Into<String>) -> Entry {
    Entry { id: id.into(), summary: summary.into(), source: source.into(), offers: None }
}

fn scenes() -> Vec<Entry> {
    let levels = thesis::LEVELS.iter().map(|l| entry(format!("thesis:{}", l.name), "Beick 2014", l.summary));
    let families = FAMILIES.iter().map(|f| entry(format!("gen:{}:N[:SEED]", f.name), "generated", f.summary));
    let files = [
        entry(
            "SCENE+twist=DEGREES",
            "any scene",
            "turned about the vertical, more so the higher: the same triangles, moved",
        ),
        entry("FILE.obj", "file", "Wavefront OBJ with its MTL"),
        entry("FILE.ply, FILE.stl", "file", "Stanford PLY and STL, as text or binary"),
        entry("FILE.gltf, FILE.glb", "file", "glTF 2.0"),
        entry("FILE.tri", "file", "raw triangles: little-endian f32, nine a triangle"),
        entry("FILE.gz, FILE.zst", "file", "any of these, packed, as in FILE.obj.gz"),
    ];
    levels.chain(families).chain(files).collect()
}

fn builders() -> Vec<Entry> {
    let one = |b: &Builder| {
        let offers = Offers {
            presets: b.presets.iter().map(|p| p.id()).collect(),
            engines: b.engines.iter().map(|e| e.id()).collect(),
            arities: b.arities,
            parameters: b.parameters.iter().map(|p| p.flag()).collect(),
        };
        let arities: Vec<_> = b.arities.iter().map(ToString::to_string).collect();
        let mut summary = b.summary.to_owned();
        let lists = [("presets", offers.presets.join(", ")), ("engines", offers.engines.join(", "))];
        let lists = lists.into_iter().chain([("arity", arities.join(", ")), ("takes", offers.parameters.join(" "))]);
        for (what, list) in lists.filter(|(_, list)| !list.is_empty()) {
            summary += &format!("; {what} {list}");
        }
        Entry { offers: Some(offers), ..entry(b.id, b.paper, summary) }
    };
    BUILDERS.iter().map(one).collect()
}

fn kernels() -> Vec<Entry> {
    KERNELS.iter().map(|k| entry(k.id, k.paper, k.summary)).collect()
}

fn refinements() -> Vec<Entry> {
    STEPS.iter().map(|s| entry(format!("+{}", s.id), s.paper, s.summary)).collect()
}

fn experiments() -> Vec<Entry> {
    let mut all = vec![
        entry(
            "reproduce",
            "Beick 2014",
            "the thesis' study: Tables 1 to 9, Figures 3 to 5, beside the printed numbers",
        ),
        entry(
            "reproduce --only decisions",
            "Beick 2014",
            "the original's f32 costs beside exact ones: nodes split differently, and what the tree is worth",
        ),
        entry(
            "scaling",
            "Beick 2014",
            "time and work against size and arity; why the original builds grew as they did",
        ),
        entry(
            "compare --out DIR",
            "rows of this program",
            "builders side by side on your scenes: cost against build time, means, the price of the originals, advice",
        ),
        entry(
            "accuracy",
            "this laboratory",
            "what accuracy costs in time: planes, bins, neighbours, rounded costs, triangle tests, bits of stored boxes",
        ),
    ];
    let claims = Experiment::ALL.map(|e| entry(format!("reproduce --only {}", e.id()), "Beick 2014", e.summary()));
    all.splice(2..2, claims);
    all
}
