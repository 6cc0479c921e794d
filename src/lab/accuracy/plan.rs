//! The settings of each part of the study.

use crate::build::rounding::{Decision, Rounding};
use crate::build::{self, BuildOptions, Builder, Preset};
use crate::trace::{Bits, KERNELS, Kernel, Width};

/// A part of the study: settings that are compared with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Candidate planes of the thesis' searches.
    Planes,
    /// Bins of binned searches, against every split.
    Bins,
    /// How far clustering looks for a partner, against looking everywhere.
    Clustering,
    /// Costs in f32 and f64, against costs without rounding.
    Decisions,
    /// Triangle tests and traversals, against the watertight test.
    Intersection,
    /// Bits of stored boxes, against f32.
    Storage,
}

/// One setting of one method.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    pub part: Part,
    pub method: String,
    pub number: Option<u32>,
    pub builder: &'static Builder,
    pub options: BuildOptions,
    pub rays: &'static str,
    /// What trees are traced by.
    pub kernel: Kernel,
    /// By what costs what is decided, where the builder is not the register's but one of [`crate::build::rounding`].
    pub costs: Option<(Decision, Rounding)>,
}

impl Part {
    /// All parts.
    pub const ALL: [Self; 6] =
        [Self::Planes, Self::Bins, Self::Clustering, Self::Decisions, Self::Intersection, Self::Storage];

    /// Its name on the command line and in rows.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Planes => "planes",
            Self::Bins => "bins",
            Self::Clustering => "clustering",
            Self::Decisions => "decisions",
            Self::Intersection => "intersection",
            Self::Storage => "storage",
        }
    }

    pub(super) fn settings(self) -> Vec<Setting> {
        match self {
            Self::Planes => planes(),
            Self::Bins => bins(),
            Self::Clustering => clustering(),
            Self::Decisions => decisions(),
            Self::Intersection => intersection(),
            Self::Storage => storage(),
        }
    }
}

/// Rays that trees are judged by: those that have lost all coherence.
const INCOHERENT: &str = "diffuse";

fn setting(part: Part, id: &str, number: Option<u32>, options: BuildOptions) -> Setting {
    let builder = build::find(id).expect("the study names builders that are registered");
    let method = builder.preset(&options).map_or_else(|| id.to_owned(), |preset| format!("{id} {}", preset.id()));
    Setting { part, method, number, builder, options, rays: INCOHERENT, kernel: Kernel::Scalar, costs: None }
}

fn planes() -> Vec<Setting> {
    const PUBLISHED: [u32; 9] = [4, 8, 16, 32, 64, 100, 200, 300, 400];
    const TEXT: [u32; 6] = [4, 8, 16, 32, 64, 100];
    let series = |preset, arity, numbers: &[u32]| {
        let one = |&n: &u32| {
            let options = BuildOptions { preset, arity, candidates: Some(n as usize), ..BuildOptions::default() };
            setting(Part::Planes, "top-down", Some(n), options)
        };
        numbers.iter().map(one).collect::<Vec<_>>()
    };
    let all = [2, 4].map(|arity| [series(Preset::Published, arity, &PUBLISHED), series(Preset::Text, arity, &TEXT)]);
    all.into_iter().flatten().flatten().collect()
}

fn bins() -> Vec<Setting> {
    const BINS: [u32; 7] = [4, 8, 16, 32, 64, 128, 256];
    let binned = BINS.map(|n| {
        let options = BuildOptions { bins: Some(n as usize), ..BuildOptions::default() };
        setting(Part::Bins, "binned-sah", Some(n), options)
    });
    binned.into_iter().chain([setting(Part::Bins, "sweep-sah", None, BuildOptions::default())]).collect()
}

fn clustering() -> Vec<Setting> {
    const PLOC: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
    const KD: [u32; 6] = [1, 2, 4, 8, 16, 32];
    let near = |id, n: u32| {
        let options = BuildOptions { radius: Some(n as usize), ..BuildOptions::default() };
        setting(Part::Clustering, id, Some(n), options)
    };
    let morton = PLOC.map(|n| near("ploc", n));
    let kd = KD.map(|n| near("agglo-kd", n));
    let everywhere = setting(Part::Clustering, "agglo-local", None, BuildOptions::default());
    morton.into_iter().chain(kd).chain([everywhere]).collect()
}

/// Plain builders by each arithmetic; of those in the register they have the limits.
fn decisions() -> Vec<Setting> {
    let one = |decision: Decision| {
        let like = match decision {
            Decision::Splits => "sweep-sah",
            Decision::Merges => "ploc",
        };
        Rounding::ALL.map(|rounding| Setting {
            method: decision.id().to_owned(),
            costs: Some((decision, rounding)),
            ..setting(Part::Decisions, like, rounding.bits(), BuildOptions::default())
        })
    };
    Decision::ALL.into_iter().flat_map(one).collect()
}

/// Every kernel that answers the same question as brute force; the thesis' own does not.
fn intersection() -> Vec<Setting> {
    let kernels = KERNELS.iter().filter(|k| !matches!(k.kernel, Kernel::FirstLeaf(_)));
    let one = |k: &crate::trace::KernelInfo| {
        ["primary", "diffuse", "edges"].map(|rays| Setting {
            method: k.id.to_owned(),
            rays,
            ..setting(Part::Intersection, "sweep-sah", None, BuildOptions::default())
        })
    };
    kernels.flat_map(one).collect()
}

/// Boxes of each arity decoded for kernel `scalar`, and the kernels that decode them on their way.
fn storage() -> Vec<Setting> {
    let one = |arity| {
        [32, 16, 8].map(|bits| {
            let options = BuildOptions { arity, ..BuildOptions::default() };
            let tree = setting(Part::Storage, "binned-sah", Some(bits), options);
            Setting { method: format!("arity {arity}"), ..tree }
        })
    };
    let kernels = [
        (32, Kernel::Wide { width: Width::Eight, fast: false }),
        (16, Kernel::Quantised(Bits::Sixteen)),
        (8, Kernel::Quantised(Bits::Eight)),
    ];
    let by_kernel = kernels.map(|(bits, kernel)| {
        let tree = setting(Part::Storage, "binned-sah", Some(bits), BuildOptions::default());
        Setting { method: "bvh8".to_owned(), kernel, ..tree }
    });
    [4, 8].into_iter().flat_map(one).chain(by_kernel).collect()
}
