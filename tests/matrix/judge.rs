//! One case by every tree and every kernel, each answer judged.

use crate::cases::{Case, Demand};
use bvh_lab::build::{Brake, BuildOptions, Builder, Input};
use bvh_lab::bvh::{Bvh, validate_parts};
use bvh_lab::geom::{Hit, Ray, Triangle, WatertightRay};
use bvh_lab::simd::Simd;
use bvh_lab::trace::{
    Arithmetic, KERNELS, Kernel, KernelInfo, Oracle, Query, Scratch, Tracer, Verdict, brute_force, brute_force_all,
};
use rayon::prelude::*;

/// A tree, and where it comes from.
pub struct Tree {
    pub name: String,
    /// Whether the thesis' own constructions built it: what its traversal gets wrong there never changes.
    pub of_thesis: bool,
    /// Whether rule Q8 may have hidden triangles in it: what is not found then is the tree's fault.
    pub q8: bool,
    pub bvh: Bvh,
}

/// Builds by `variants`, in parallel; every tree is validated.
pub fn trees(triangles: &[Triangle], variants: &[(&'static Builder, BuildOptions)]) -> Vec<Tree> {
    let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
    let build = |(builder, options): &(&'static Builder, BuildOptions)| {
        let name = name(builder, options);
        let input = Input::of_triangles(triangles, &boxes);
        let bvh = (builder.timed)(input, options, &mut Brake::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        if let Err(violations) = validate_parts(&bvh, triangles, &boxes, &builder.limits(options)) {
            panic!("{name}: {violations}");
        }
        let of_thesis = !builder.presets.is_empty() && options.refine.is_empty();
        Tree { name, of_thesis, q8: builder.limits(options).q8, bvh }
    };
    variants.par_iter().map(build).collect()
}

pub fn name(builder: &Builder, o: &BuildOptions) -> String {
    let preset = builder.preset(o).map_or("", |p| p.id());
    let engine = builder.engine(o).map_or("", |e| e.id());
    let q8 = if o.q8 { "" } else { "no q8" };
    let refine: String = o.refine.iter().map(|step| format!("+{}", step.id)).collect();
    format!("{}{refine} {preset} {engine} {q8} arity {}", builder.id, o.arity)
}

/// Answers of one kernel, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Closest-hit answers judged.
    pub judged: u64,
    /// Hits among them.
    pub hits: u64,
    /// Right at a triangle's border, where either answer is.
    pub border: u64,
    /// Of `first-leaf`: a hit that is not the closest, in the thesis' trees and in others.
    pub farther: [u64; 2],
    /// Of `first-leaf`: no hit, where its absolute thresholds say so.
    pub missed: [u64; 2],
    /// Of any kernel in trees with rule Q8: not the hit there is.
    pub hidden: u64,
}

impl Tally {
    pub fn add(&mut self, other: &Self) {
        self.judged += other.judged;
        self.hits += other.hits;
        self.border += other.border;
        self.hidden += other.hidden;
        for i in 0..2 {
            self.farther[i] += other.farther[i];
            self.missed[i] += other.missed[i];
        }
    }
}

/// What came of a case: tallies in the order of [`KERNELS`], and every failure in words.
#[derive(Default)]
pub struct Outcome {
    pub tallies: Vec<Tally>,
    pub failures: Vec<String>,
}

/// What there is to know of a ray before any tree is looked at.
struct Truth {
    by_f64: Oracle,
    by_f32: Oracle,
    closest: Option<Hit>,
    all: Vec<Hit>,
}

pub fn judge(case: &Case, trees: &[Tree]) -> Outcome {
    let truth = |ray: &Ray| Truth {
        by_f64: Oracle::new(&case.triangles, ray, Arithmetic::Watertight),
        by_f32: Oracle::new(&case.triangles, ray, Arithmetic::Fast),
        closest: brute_force::<WatertightRay>(&case.triangles, ray),
        all: brute_force_all::<WatertightRay>(&case.triangles, ray),
    };
    let truths: Vec<_> = case.rays.par_iter().map(truth).collect();
    let jobs: Vec<_> = trees.iter().flat_map(|tree| (0..KERNELS.len()).map(move |k| (tree, k))).collect();
    let judged: Vec<_> = jobs.par_iter().map(|&(tree, k)| (k, one_kernel(case, &truths, tree, &KERNELS[k]))).collect();
    let mut outcome = Outcome { tallies: vec![Tally::default(); KERNELS.len()], failures: Vec::new() };
    for (k, (tally, failures)) in judged {
        outcome.tallies[k].add(&tally);
        outcome.failures.extend(failures);
    }
    outcome
}

fn one_kernel(case: &Case, truths: &[Truth], tree: &Tree, info: &KernelInfo) -> (Tally, Vec<String>) {
    let tracer = Tracer::new(info.kernel, &tree.bvh, &case.triangles);
    let baseline = tracer.clone().at_level(Simd::Baseline);
    let is_wide = info.kernel.is_wide();
    let mut scratch = Scratch::default();
    let mut answer = |tracer: &Tracer, ray: &Ray| {
        let mut all = Vec::new();
        tracer.all_hits(ray, &mut scratch, &mut (), &mut all);
        let closest = tracer.trace(Query::Closest, ray, &mut scratch, &mut ());
        Answer { closest, any: tracer.trace(Query::Any, ray, &mut scratch, &mut ()).is_some(), all }
    };
    let (mut tally, mut failures) = (Tally::default(), Vec::new());
    let mut before = None;
    for (i, (ray, truth)) in case.rays.iter().zip(truths).enumerate() {
        let found = answer(&tracer, ray);
        let verdict = truth.oracle(info.kernel).judge(found.closest);
        let mut wrong = against_truth(truth, info.kernel, tree.q8, &found, verdict);
        if !tree.q8 {
            wrong.extend(case.demand.broken(i, info.kernel, found.closest, before));
        }
        if is_wide && answer(&baseline, ray) != found {
            wrong.push("other answers by the baseline's instructions".into());
        }
        tally.count(verdict, found.closest.is_some(), tree);
        before = found.closest;
        failures.extend(wrong.into_iter().map(|why| {
            let Case { row, what, .. } = case;
            format!("row {row}, {what}: {} on {}, {ray:?}, found {:?}: {why}", info.id, tree.name, found.closest)
        }));
    }
    (tally, failures)
}

/// What a kernel says to the three queries.
#[derive(PartialEq)]
struct Answer {
    closest: Option<Hit>,
    any: bool,
    all: Vec<Hit>,
}

impl Truth {
    fn oracle(&self, kernel: Kernel) -> &Oracle {
        if kernel.is_exact() { &self.by_f64 } else { &self.by_f32 }
    }
}

/// What is wrong with a kernel's answers; `hides` where the tree may lack triangles.
fn against_truth(truth: &Truth, kernel: Kernel, hides: bool, found: &Answer, closest: Verdict) -> Vec<String> {
    let oracle = truth.oracle(kernel);
    let mut wrong = Vec::new();
    let mut demand = |fine: bool, why: String| {
        if !fine {
            wrong.push(why);
        }
    };
    let is_published = matches!(kernel, Kernel::FirstLeaf(_));
    let excused = (is_published || hides) && matches!(closest, Verdict::Farther | Verdict::Missed);
    demand(closest.is_right() || excused, format!("{closest:?}"));
    let any = oracle.judge_any(found.any);
    demand(any.is_right() || excused && any == Verdict::Missed, format!("any hit: {any:?}"));
    // All hits of the thesis' kernel are those of `scalar`.
    let all = if is_published { truth.by_f64.judge_all(&found.all) } else { oracle.judge_all(&found.all) };
    demand(all.is_right() || hides && all == Verdict::Missed, format!("all hits: {all:?}"));
    if kernel.is_exact() && !hides {
        demand(found.closest == truth.closest, format!("brute force has {:?}", truth.closest));
        demand(found.any == truth.closest.is_some(), "any hit is not what brute force has".into());
    }
    if (kernel.is_exact() || is_published) && !hides {
        demand(found.all == truth.all, format!("all hits by brute force: {:?}", truth.all));
    }
    wrong
}

impl Demand {
    /// What is wrong with the answer to ray `i`, where the one before it got `before`.
    fn broken(&self, i: usize, kernel: Kernel, found: Option<Hit>, before: Option<Hit>) -> Option<String> {
        let is_published = matches!(kernel, Kernel::FirstLeaf(_));
        let (is_wrong, why) = match self {
            Self::Oracle => (false, String::new()),
            Self::NoMiss => (kernel.is_exact() && found.is_none(), "no ray may miss".into()),
            Self::NoHit => (kernel.is_exact() && found.is_some(), "no ray may hit".into()),
            Self::Pairs => (i % 2 == 1 && found != before, format!("{before:?} with the other zeros")),
            Self::Exactly(hits) => (!is_published && found != hits[i], format!("it is {:?}", hits[i])),
        };
        is_wrong.then_some(why)
    }
}

impl Tally {
    fn count(&mut self, verdict: Verdict, hit: bool, tree: &Tree) {
        let whose = usize::from(!tree.of_thesis);
        self.judged += 1;
        self.hits += u64::from(hit);
        match verdict {
            Verdict::Border => self.border += 1,
            Verdict::Farther | Verdict::Missed if tree.q8 => self.hidden += 1,
            Verdict::Farther => self.farther[whose] += 1,
            Verdict::Missed => self.missed[whose] += 1,
            Verdict::Right | Verdict::Beside | Verdict::Off => {}
        }
    }
}
