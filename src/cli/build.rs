//! `bvh-lab build`: one tree, its time, its work, its statistics.

use super::arguments::{BuildArguments, RunArguments};
use super::output::{json, maybe, say, short, spread_text};
use super::progress::Reading;
use super::tree_file::{self, RefitReport};
use super::{Failure, Outcome, off, wrong};
use bvh_lab::build::{BuildOptions, Engine, Preset, find};
use bvh_lab::bvh::file::{self, SavedTree};
use bvh_lab::bvh::{Bvh, Coverage, Limits, export_boxes, export_json, tree_hash};
use bvh_lab::cost::{SahParams, epo, leaf_counts, sah, stats};
use bvh_lab::lab::{
    BuildCell, Built, EPO_LIMIT, Measured, Repeats, human_seconds, leaf_count_rays, measure_build, spread,
};
use bvh_lab::rows::{Spread, Status};
use bvh_lab::scene::Scene;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// The JSON object of `build`; figures that are undefined are `null`.
#[derive(Debug, Serialize)]
pub struct BuildReport {
    pub scene: String,
    pub triangles: usize,
    pub dropped: usize,
    /// `file` where the tree came from one.
    pub builder: &'static str,
    /// That file.
    pub tree: Option<String>,
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
    /// Only where asked for.
    pub lcv: Option<f64>,
    pub bytes: Option<usize>,
    /// The most bytes that a build holds beyond the triangles, boxes and tree included; on several threads of one run.
    pub peak_bytes: Option<usize>,
    /// Triangles in more than one leaf, by spatial splits or rule Q8.
    pub duplicated: Option<usize>,
    pub q8_hidden: Option<usize>,
    pub counters: BTreeMap<&'static str, u64>,
    pub refit: Option<RefitReport>,
    pub version: &'static str,
    pub commit: &'static str,
}

impl BuildReport {
    /// Measures `builder` on `scene`; the tree comes along where there is one.
    ///
    /// # Errors
    /// A builder that fails or returns a wrong tree.
    pub fn measure(scene: &Scene, cell: &BuildCell) -> Result<(Self, Option<Box<Built>>), Failure> {
        let (builder, options) = (cell.builder, &cell.options);
        let mut report = Self {
            builder: builder.id,
            preset: builder.preset(options).map(Preset::id),
            engine: builder.engine(options).map(Engine::id),
            threads: builder.threads(options),
            ..Self::empty(scene, options)
        };
        let built = match measure_build(&scene.triangles, cell) {
            Measured::Ok(built) => built,
            Measured::Capped { projected_ms } => {
                report.status = if projected_ms.is_some() { Status::Projected } else { Status::Capped };
                report.projected_ms = projected_ms;
                return Ok((report, None));
            }
            Measured::Failed(why) => return Err(wrong(format!("{} on {}: {why}", cell.builder.id, scene.name))),
        };
        report.describe(scene, &built.bvh, &built.coverage);
        report.build_ms = Some(milliseconds(built.seconds));
        report.tree_hash = Some(built.hash.to_string());
        report.counters = built.counters.nonzero().collect();
        report.peak_bytes = built.peak_bytes;
        Ok((report, Some(built)))
    }

    /// What a tree from a file is worth: everything that a build has but time and work.
    pub fn of_file(scene: &Scene, path: &Path, saved: &SavedTree) -> Self {
        let options = BuildOptions { arity: saved.bvh.arity, ..BuildOptions::default() };
        let mut report = Self { tree: Some(path.display().to_string()), ..Self::empty(scene, &options) };
        report.describe(scene, &saved.bvh, &saved.coverage);
        report.tree_hash = Some(tree_hash(&saved.bvh).to_string());
        report
    }

    fn describe(&mut self, scene: &Scene, bvh: &Bvh, coverage: &Coverage) {
        let tree = stats(bvh);
        self.inner = Some(tree.inner);
        self.leaves = Some(tree.leaves);
        self.empty = Some(tree.empty);
        self.avg_degree = tree.avg_degree;
        self.max_depth = Some(tree.max_depth);
        self.max_leaf = Some(tree.max_leaf);
        self.leaf_histogram = Some(tree.leaf_histogram);
        self.sah = sah(bvh, SahParams::default());
        self.epo = (scene.triangles.len() <= EPO_LIMIT).then(|| epo(bvh, &scene.triangles)).flatten();
        self.bytes = Some(tree.bytes);
        self.duplicated = Some(coverage.duplicated);
        self.q8_hidden = Some(coverage.hidden);
    }

    /// A report without figures, by no builder.
    fn empty(scene: &Scene, options: &BuildOptions) -> Self {
        Self {
            scene: scene.name.clone(),
            triangles: scene.triangles.len(),
            dropped: scene.dropped.total(),
            builder: "file",
            tree: None,
            arity: options.arity,
            refine: options.refine.iter().map(|step| step.id).collect(),
            preset: None,
            engine: None,
            costs: options.costs.id(),
            threads: rayon::current_num_threads(),
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
            lcv: None,
            bytes: None,
            peak_bytes: None,
            duplicated: None,
            q8_hidden: None,
            counters: BTreeMap::new(),
            refit: None,
            version: bvh_lab::lab::version(),
            commit: bvh_lab::lab::commit(),
        }
    }

    /// Builder, steps and, where it has any, its reading, engine and f32 costs.
    pub fn made_by(&self) -> String {
        if let Some(file) = &self.tree {
            return file.clone();
        }
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
            (None, None) if self.tree.is_some() => "–".into(),
            (None, None) => "capped".into(),
        }
    }
}

/// Runs the command.
pub fn run(a: &BuildArguments) -> Outcome {
    set_threads(&a.run)?;
    if let Some(path) = a.output.as_ref().filter(|p| !p.extension().is_some_and(|e| e.eq_ignore_ascii_case("bvh"))) {
        return Err(off(format!("{}: trees are written as .bvh", path.display())));
    }
    check_export(a)?;
    if let Some(path) = &a.tree.file {
        return tree_file::run(a, path);
    }
    let options = a.tree.options().map_err(off)?;
    let scene = load(&a.scene)?;
    let in_this_process = a.cold && a.run.runs == Some(1);
    let cell = BuildCell {
        builder: a.tree.builder.builder,
        options,
        budget: a.budget,
        repeats: Repeats { cold: in_this_process, ..repeats(&a.run) },
    };
    let (mut report, built) = while_waiting(&a.scene, || BuildReport::measure(&scene, &cell))?;
    if a.cold && !in_this_process && report.status == Status::Ok {
        report.build_ms = Some(cold_runs(usize::from(a.run.runs.unwrap_or(5)))?);
    }
    let limits = cell.builder.limits(&options);
    finish(a, &scene, report, built.as_ref().map(|built| (&built.bvh, &limits)))
}

/// Measures what takes a tree, writes the tree, and says everything. Without a tree there is nothing to write.
pub fn finish(a: &BuildArguments, scene: &Scene, mut report: BuildReport, tree: Option<(&Bvh, &Limits)>) -> Outcome {
    if let Some((bvh, _)) = tree.filter(|_| a.lcv) {
        report.lcv = leaf_counts(bvh, &leaf_count_rays(scene, bvh)).map(|counts| counts.lcv);
    }
    match (&a.output, tree) {
        (Some(path), Some((bvh, limits))) => file::write(path, bvh, limits, &scene.triangles).map_err(wrong)?,
        (Some(path), None) => {
            let path = path.display();
            return Err(wrong(format!("{path}: there is no tree to write, as the build was capped; raise --budget")));
        }
        (None, _) => {}
    }
    if let (Some(path), Some((bvh, _))) = (&a.export, tree) {
        let export = if is_json(path) { export_json } else { export_boxes };
        export(bvh, path).map_err(wrong)?;
    }
    if a.run.json { json(&report) } else { say(&text(&report)) }
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

/// Refuses a path that trees are not exported to.
fn check_export(a: &BuildArguments) -> Outcome {
    match &a.export {
        Some(path) if !is_json(path) && !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) => {
            Err(off(format!("{}: trees are exported as .json or .obj", path.display())))
        }
        Some(path) if path.canonicalize().ok().is_some_and(|p| Path::new(&a.scene).canonicalize().ok() == Some(p)) => {
            Err(off(format!("{}: that is the scene itself; export the tree under another name", path.display())))
        }
        _ => Ok(()),
    }
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
    let mut reading = Reading::new(spec);
    let scene = Scene::load_watched(spec, &mut |done, size| reading.tell(done, size));
    reading.end();
    let scene = scene?;
    if let Some(line) = account(&scene) {
        eprintln!("bvh-lab: {}: {line}", scene.name);
    }
    Ok(scene)
}

/// All that was dropped, repaired or not found, in one line.
fn account(scene: &Scene) -> Option<String> {
    const MOST: usize = 6;
    let dropped = scene.dropped.to_string();
    let more = scene.warnings.len().saturating_sub(MOST);
    let rest = (more > 0).then(|| format!("and {more} more, which `bvh-lab scene {} --json` lists", scene.name));
    let all = std::iter::once(dropped).filter(|d| !d.is_empty()).map(|d| format!("left out {d}"));
    let parts: Vec<_> = all.chain(scene.warnings.iter().take(MOST).cloned()).chain(rest).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
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
            Some("--runs" | "--budget" | "--output" | "-o" | "--export") => drop(words.next()),
            Some("--json" | "--lcv") => {}
            Some(w)
                if ["--runs=", "--budget=", "--output=", "--export=", "-o"].iter().any(|own| w.starts_with(own)) => {}
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

pub fn milliseconds(s: Spread) -> Spread {
    Spread { median: s.median * 1e3, min: s.min * 1e3, max: s.max * 1e3, runs: s.runs }
}

fn text(r: &BuildReport) -> String {
    let count = |n: Option<usize>| n.map_or_else(|| "–".into(), |n| n.to_string());
    let mut lines = vec![
        format!("{}: {} triangles ({} dropped)", r.scene, r.triangles, r.dropped),
        format!("builder     {}, arity {}", r.made_by(), r.arity),
    ];
    match (&r.build_ms, &r.refit) {
        (Some(ms), _) => lines.push(format!("build       {}", spread_text(ms, "ms"))),
        (None, Some(refit)) => lines.extend(refit.text(r.sah)),
        (None, None) if r.tree.is_some() => {}
        (None, None) => lines.push(format!("build       {}", r.time())),
    }
    if r.status == Status::Ok {
        let nodes = format!("nodes       {} inner, {} leaves", count(r.inner), count(r.leaves));
        lines.push(match r.empty {
            Some(empty @ 1..) => format!("{nodes} ({empty} empty)"),
            _ => nodes,
        });
        let (depth, leaf) = (count(r.max_depth), count(r.max_leaf));
        lines.push(format!("shape       average degree {}, depth {depth}, fullest leaf {leaf}", maybe(r.avg_degree)));
        let lcv = r.lcv.map_or_else(String::new, |lcv| format!(", LCV {}", short(lcv)));
        lines.push(format!("cost        SAH {}, EPO {}{lcv}", maybe(r.sah), maybe(r.epo)));
        let peak = r.peak_bytes.map_or_else(String::new, |peak| {
            format!(", while it is built {peak}: {} a triangle", short(peak as f64 / r.triangles.max(1) as f64))
        });
        lines.push(format!("memory      {} bytes{peak}", count(r.bytes)));
        let references: usize = r.leaf_histogram.iter().flatten().enumerate().map(|(size, leaves)| size * leaves).sum();
        let repeats = references > r.triangles && r.q8_hidden == Some(0);
        if find(r.builder).map_or(repeats, |builder| builder.spatial) {
            let several = count(r.duplicated);
            lines.push(format!("references  {references}, {several} triangles in more than one leaf"));
        } else if r.duplicated.unwrap_or(0) + r.q8_hidden.unwrap_or(0) > 0 {
            let (twice, hidden) = (count(r.duplicated), count(r.q8_hidden));
            lines.push(format!("rule Q8     {twice} triangles in more than one leaf, {hidden} hidden from rays"));
        }
        for (work, n) in &r.counters {
            lines.push(format!("counted     {n} {}", work.replace('_', " ")));
        }
        lines.push(format!("tree hash   {}", r.tree_hash.as_deref().unwrap_or("–")));
    }
    lines.join("\n")
}
