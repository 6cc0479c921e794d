//! The JSON object of `compare`.

use bvh_lab::report::gate::Verdict;
use bvh_lab::rows::{CompareRow, Spread, Status};
use bvh_lab::scene::Scene;
use serde::Serialize;
use serde_json::{Map, Value};

/// One contestant in the JSON object: what `build` says of a tree, and what tracing it took; figures that are undefined are `null`.
#[derive(Debug, Serialize)]
struct Entry<'a> {
    recipe: &'a str,
    builder: &'a str,
    /// The file that the tree came from.
    tree: Option<&'a str>,
    refine: Vec<&'a str>,
    arity: usize,
    leaf_limit: usize,
    preset: Option<&'a str>,
    engine: Option<&'a str>,
    costs: &'static str,
    threads: usize,
    status: Status,
    note: &'a str,
    build_ms: Value,
    projected_ms: Option<f64>,
    tree_hash: Option<&'a str>,
    inner: Option<usize>,
    leaves: Option<usize>,
    empty: Option<usize>,
    avg_degree: Option<f64>,
    max_depth: Option<usize>,
    max_leaf: Option<usize>,
    references: Option<usize>,
    sah: Option<f64>,
    epo: Option<f64>,
    lcv: Option<f64>,
    bytes: Option<usize>,
    peak_bytes: Option<usize>,
    /// Triangles in more than one leaf, by spatial splits or rule Q8.
    duplicated: Option<usize>,
    q8_hidden: Option<usize>,
    counters: Map<String, Value>,
    /// Primary rays.
    nodes_per_ray: Option<f64>,
    box_tests_per_ray: Option<f64>,
    tri_tests_per_ray: Option<f64>,
    mrays_per_s: Option<Spread>,
    hit_hash: Option<&'a str>,
    diffuse: Diffuse<'a>,
    version: &'a str,
    commit: &'a str,
}

/// The same of diffuse rays.
#[derive(Debug, Serialize)]
struct Diffuse<'a> {
    rays: usize,
    nodes_per_ray: Option<f64>,
    box_tests_per_ray: Option<f64>,
    tri_tests_per_ray: Option<f64>,
    mrays_per_s: Option<Spread>,
    hit_hash: Option<&'a str>,
}

/// One scene in the JSON object.
#[derive(Clone, Debug, Serialize)]
struct SceneReport {
    scene: String,
    triangles: usize,
    dropped: usize,
    threads: usize,
    kernel: String,
    rays: usize,
    builders: Vec<Value>,
}

/// The JSON object: every scene in `scenes`; the fields of a single one stand at the top, too.
#[derive(Debug, Serialize)]
pub struct Report {
    #[serde(flatten)]
    only: Option<SceneReport>,
    scenes: Vec<SceneReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gate: Option<Value>,
}

/// All scenes, and what the gate found where there is one.
pub fn report(scenes: &[Scene], measured: &[Vec<CompareRow>], verdict: Option<&Verdict>) -> Report {
    let of_scene = |(scene, rows): (&Scene, &Vec<CompareRow>)| SceneReport {
        scene: scene.name.clone(),
        triangles: scene.triangles.len(),
        dropped: scene.dropped.total(),
        threads: rayon::current_num_threads(),
        kernel: rows.first().map_or_else(String::new, |r| r.kernel.clone()),
        rays: rows.iter().map(|r| r.primary_rays).max().unwrap_or(0),
        builders: rows.iter().map(|r| serde_json::json!(Entry::of(r))).collect(),
    };
    let scenes: Vec<SceneReport> = scenes.iter().zip(measured).map(of_scene).collect();
    Report {
        only: if let [only] = &scenes[..] { Some(only.clone()) } else { None },
        gate: verdict
            .map(|v| serde_json::json!({"compared": v.compared, "unknown": v.unknown, "violations": v.violations})),
        scenes,
    }
}

impl<'a> Entry<'a> {
    fn of(r: &'a CompareRow) -> Self {
        let word = |w: &'a str| (!w.is_empty()).then_some(w);
        let of_file = r.builder == "file";
        let steps = r.recipe.split('+').skip(1).filter(|_| !of_file);
        Self {
            recipe: &r.recipe,
            builder: &r.builder,
            tree: of_file.then_some(&r.recipe),
            refine: steps.collect(),
            arity: r.arity,
            leaf_limit: r.leaf_limit,
            preset: word(&r.preset),
            engine: word(&r.engine),
            costs: "exact",
            threads: r.threads,
            status: r.status,
            note: &r.note,
            build_ms: match r.build() {
                Some(spread) => serde_json::json!(spread),
                None => serde_json::json!({"median": null, "min": null, "max": null, "runs": 0}),
            },
            projected_ms: r.projected_ms,
            tree_hash: r.tree_hash.as_deref(),
            inner: r.inner,
            leaves: r.leaves,
            empty: r.empty,
            avg_degree: r.avg_degree,
            max_depth: r.max_depth,
            max_leaf: r.max_leaf,
            references: r.references,
            sah: r.sah,
            epo: r.epo,
            lcv: r.lcv,
            bytes: r.bytes,
            peak_bytes: r.peak_bytes,
            duplicated: r.duplicated,
            q8_hidden: r.hidden,
            counters: r.work().map(|(kind, n)| (kind.to_owned(), n.into())).collect(),
            nodes_per_ray: r.primary_nodes,
            box_tests_per_ray: r.primary_box_tests,
            tri_tests_per_ray: r.primary_tri_tests,
            mrays_per_s: r.primary(),
            hit_hash: r.primary_hit_hash.as_deref(),
            diffuse: Diffuse {
                rays: r.diffuse_rays,
                nodes_per_ray: r.diffuse_nodes,
                box_tests_per_ray: r.diffuse_box_tests,
                tri_tests_per_ray: r.diffuse_tri_tests,
                mrays_per_s: r.diffuse(),
                hit_hash: r.diffuse_hit_hash.as_deref(),
            },
            version: &r.version,
            commit: &r.commit,
        }
    }
}
