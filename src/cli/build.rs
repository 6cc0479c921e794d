//! `bvh-lab build`: one tree, its time, its work, its statistics.

use super::arguments::{BuildArguments, RunArguments};
use super::output::{json, maybe, say, spread_text};
use super::{Failure, Outcome, off, wrong};
use bvh_lab::build::{BuildOptions, Builder, Engine, Preset, find};
use bvh_lab::cost::{SahParams, epo, sah, stats};
use bvh_lab::lab::{BuildCell, Built, Measured, Repeats, human_seconds, measure_build, spread};
use bvh_lab::rows::{Spread, Status};
use bvh_lab::scene::Scene;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// EPO is left out above so many triangles.
const EPO_LIMIT: usize = 1_000_000;

/// The JSON object of `build`; figures that are undefined are `null`.
#[derive(Debug, Serialize)]
pub struct BuildReport {
    pub scene: String,
    pub triangles: usize,
    pub dropped: usize,
    pub builder: &'static str,
    pub refine: Vec<&'static str>,
    pub arity: usize,
    pub preset: Option<&'static str>,
    pub engine: Option<&'static str>,
    pub costs: &'static str,
    pub threads: usize,
    pub status: Status,
    #[serde(serialize_with = "with_nulls")]
    pub build_ms: Option<Spread>,
    pub projected_ms: Option<f64>,
    pub tree_hash: Option<String>,
    pub inner: Option<usize>,
    pub leaves: Option<usize>,
    pub empty: Option<usize>,
    pub avg_degree: Option<f64>,
    pub max_depth: Option<usize>,
    pub max_leaf: Option<usize>,
    pub leaf_histogram: Option<Vec<usize>>,
    pub sah: Option<f64>,
    pub epo: Option<f64>,
    pub bytes: Option<usize>,
    pub q8_duplicated: Option<usize>,
    pub q8_hidden: Option<usize>,
    pub counters: BTreeMap<&'static str, u64>,
    pub version: &'static str,
    pub commit: &'static str,
}

impl BuildReport {
    /// Measures `builder` on `scene`; the tree comes along where there is one.
    ///
    /// # Errors
    /// A builder that fails or returns a wrong tree.
    pub fn measure(scene: &Scene, cell: &BuildCell) -> Result<(Self, Option<Box<Built>>), Failure> {
        let mut report = Self::empty(scene, cell.builder, &cell.options);
        let built = match measure_build(&scene.triangles, cell) {
            Measured::Ok(built) => built,
            Measured::Capped { projected_ms } => {
                report.status = if projected_ms.is_some() { Status::Projected } else { Status::Capped };
                report.projected_ms = projected_ms;
                return Ok((report, None));
            }
            Measured::Failed(why) => return Err(wrong(format!("{} on {}: {why}", cell.builder.id, scene.name))),
        };
        let tree = stats(&built.bvh);
        report.build_ms = Some(milliseconds(built.seconds));
        report.tree_hash = Some(built.hash.to_string());
        report.inner = Some(tree.inner);
        report.leaves = Some(tree.leaves);
        report.empty = Some(tree.empty);
        report.avg_degree = tree.avg_degree;
        report.max_depth = Some(tree.max_depth);
        report.max_leaf = Some(tree.max_leaf);
        report.leaf_histogram = Some(tree.leaf_histogram);
        report.sah = sah(&built.bvh, SahParams::default());
        report.epo = (scene.triangles.len() <= EPO_LIMIT).then(|| epo(&built.bvh, &scene.triangles)).flatten();
        report.bytes = Some(tree.bytes);
        report.q8_duplicated = Some(built.coverage.duplicated);
        report.q8_hidden = Some(built.coverage.hidden);
        report.counters = built.counters.nonzero().collect();
        Ok((report, Some(built)))
    }

    fn empty(scene: &Scene, builder: &Builder, options: &BuildOptions) -> Self {
        Self {
            scene: scene.name.clone(),
            triangles: scene.triangles.len(),
            dropped: scene.dropped.total(),
            builder: builder.id,
            arity: options.arity,
            refine: options.refine.iter().map(|step| step.id).collect(),
            preset: builder.preset(options).map(Preset::id),
            engine: builder.engine(options).map(Engine::id),
            costs: options.costs.id(),
            threads: builder.threads(options),
            status: Status::Ok,
            build_ms: None,
            projected_ms: None,
            tree_hash: None,
            inner: None,
            leaves: None,
            empty: None,
            avg_degree: None,
            max_depth: None,
            max_leaf: None,
            leaf_histogram: None,
            sah: None,
            epo: None,
            bytes: None,
            q8_duplicated: None,
            q8_hidden: None,
            counters: BTreeMap::new(),
            version: bvh_lab::lab::version(),
            commit: bvh_lab::lab::commit(),
        }
    }

    /// Builder, steps and, where it has any, its reading, engine and f32 costs.
    pub fn made_by(&self) -> String {
        let costs = (self.costs != "exact").then(|| format!("{} costs", self.costs));
        let reading = [self.preset.map(Into::into), self.engine.map(Into::into), costs];
        let reading: Vec<String> = reading.into_iter().flatten().collect();
        let steps: String = self.refine.iter().map(|id| format!("+{id}")).collect();
        let builder = format!("{}{steps}", self.builder);
        if reading.is_empty() { builder } else { format!("{builder} ({})", reading.join(", ")) }
    }

    /// Build time in words: measured, projected or capped.
    pub fn time(&self) -> String {
        match (&self.build_ms, self.projected_ms) {
            (Some(ms), _) => human_seconds(ms.median / 1e3),
            (None, Some(ms)) => format!("capped; ~{}", human_seconds(ms / 1e3)),
            (None, None) => "capped".into(),
        }
    }
}

/// Runs the command.
pub fn run(a: &BuildArguments) -> Outcome {
    set_threads(&a.run)?;
    let options = a.tree.options().map_err(off)?;
    let scene = load(&a.scene)?;
    let in_this_process = a.cold && a.run.runs == Some(1);
    let cell = BuildCell {
        builder: a.tree.builder.builder,
        options,
        budget: a.budget,
        repeats: Repeats { cold: in_this_process, ..repeats(&a.run) },
    };
    let (mut report, _) = while_waiting(&a.scene, || BuildReport::measure(&scene, &cell))?;
    if a.cold && !in_this_process && report.status == Status::Ok {
        report.build_ms = Some(cold_runs(usize::from(a.run.runs.unwrap_or(5)))?);
    }
    if a.run.json { json(&report) } else { say(&text(&report)) }
}

/// Does `work`, and says every ten seconds that it is not done yet.
fn while_waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    const BETWEEN: Duration = Duration::from_secs(10);
    let (done, is_done) = std::sync::mpsc::channel::<()>();
    std::thread::scope(|threads| {
        threads.spawn(move || {
            let mut waited = Duration::ZERO;
            while let Err(RecvTimeoutError::Timeout) = is_done.recv_timeout(BETWEEN) {
                waited += BETWEEN;
                eprintln!(
                    "bvh-lab: {what}: still building after {} s; with --budget SECONDS it stops and projects its time",
                    waited.as_secs()
                );
            }
        });
        let result = work();
        drop(done);
        result
    })
}

/// Loads a scene and tells on standard error what there is to tell of it.
pub fn load(spec: &str) -> Result<Scene, Failure> {
    let scene = Scene::load(spec)?;
    scene.warnings.iter().for_each(|w| eprintln!("bvh-lab: {}: {w}", scene.name));
    Ok(scene)
}

/// Uses as many threads as asked for, everywhere.
pub fn set_threads(run: &RunArguments) -> Outcome {
    let threads = run.threads.map_or(0, usize::from);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(wrong)
}

/// How often to time: as often as asked for, else until enough.
pub fn repeats(run: &RunArguments) -> Repeats {
    match run.runs {
        Some(runs) => Repeats { runs: runs.into(), enough: Duration::MAX, cold: false },
        None => Repeats::default(),
    }
}

/// The same command once more in fresh processes, one cold run each; without a budget, as the build has just kept it.
fn cold_runs(runs: usize) -> Result<Spread, Failure> {
    let program = std::env::current_exe().map_err(wrong)?;
    let mut words = std::env::args_os().skip(1);
    let mut arguments = Vec::new();
    while let Some(word) = words.next() {
        match word.to_str() {
            Some("--runs" | "--budget") => drop(words.next()),
            Some("--json") => {}
            Some(w) if w.starts_with("--runs=") || w.starts_with("--budget=") => {}
            _ => arguments.push(word),
        }
    }
    let one = || {
        let output = std::process::Command::new(&program)
            .args(&arguments)
            .args(["--runs", "1", "--json"])
            .stderr(std::process::Stdio::inherit())
            .output()
            .map_err(wrong)?;
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).map_err(wrong)?;
        report["build_ms"]["median"].as_f64().ok_or_else(|| wrong("a cold run gave no time"))
    };
    let milliseconds: Result<Vec<f64>, Failure> = (0..runs).map(|_| one()).collect();
    spread(milliseconds?).ok_or_else(|| wrong("no cold run was made"))
}

/// The object that the interface fixes, its figures `null` where there are none.
fn with_nulls<S: serde::Serializer>(spread: &Option<Spread>, serializer: S) -> Result<S::Ok, S::Error> {
    match spread {
        Some(spread) => spread.serialize(serializer),
        None => serde_json::json!({"median": null, "min": null, "max": null, "runs": 0}).serialize(serializer),
    }
}

fn milliseconds(s: Spread) -> Spread {
    Spread { median: s.median * 1e3, min: s.min * 1e3, max: s.max * 1e3, runs: s.runs }
}

fn text(r: &BuildReport) -> String {
    let count = |n: Option<usize>| n.map_or_else(|| "–".into(), |n| n.to_string());
    let mut lines = vec![
        format!("{}: {} triangles ({} dropped)", r.scene, r.triangles, r.dropped),
        format!("builder     {}, arity {}", r.made_by(), r.arity),
        match &r.build_ms {
            Some(ms) => format!("build       {}", spread_text(ms, "ms")),
            None => format!("build       {}", r.time()),
        },
    ];
    if r.status == Status::Ok {
        let nodes = format!("nodes       {} inner, {} leaves", count(r.inner), count(r.leaves));
        lines.push(match r.empty {
            Some(empty @ 1..) => format!("{nodes} ({empty} empty)"),
            _ => nodes,
        });
        let (depth, leaf) = (count(r.max_depth), count(r.max_leaf));
        lines.push(format!("shape       average degree {}, depth {depth}, fullest leaf {leaf}", maybe(r.avg_degree)));
        lines.push(format!("cost        SAH {}, EPO {}", maybe(r.sah), maybe(r.epo)));
        lines.push(format!("memory      {} bytes", count(r.bytes)));
        if find(r.builder).is_some_and(|builder| builder.spatial) {
            let references: usize =
                r.leaf_histogram.iter().flatten().enumerate().map(|(size, leaves)| size * leaves).sum();
            let several = count(r.q8_duplicated);
            lines.push(format!("references  {references}, {several} triangles in more than one leaf"));
        } else if r.q8_duplicated.unwrap_or(0) + r.q8_hidden.unwrap_or(0) > 0 {
            let (twice, hidden) = (count(r.q8_duplicated), count(r.q8_hidden));
            lines.push(format!("rule Q8     {twice} triangles in more than one leaf, {hidden} hidden from rays"));
        }
        for (work, n) in &r.counters {
            lines.push(format!("counted     {n} {}", work.replace('_', " ")));
        }
        lines.push(format!("tree hash   {}", r.tree_hash.as_deref().unwrap_or("–")));
    }
    lines.join("\n")
}
