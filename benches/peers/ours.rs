//! The laboratory's own builders, by recipe: `BUILDER[:NUMBER][+STEP…]`, builder and steps as on the command line, the number
//! that of its `--radius`, `--cluster` or `--bins`.

use crate::subject::{Built, Prepared, Subject};
use crate::tree::PeerTree;
use bvh_lab::build::{self, Brake, BuildOptions, Builder, Input, Parameter};
use bvh_lab::bvh::Bvh;
use bvh_lab::geom::{Ray, Triangle};
use bvh_lab::lab;
use bvh_lab::refine::STEPS;
use bvh_lab::trace::{HitRecord, Kernel, Query, Scratch, Tracer};

/// Kernels that are traced with, by id.
const KERNELS: [&str; 5] = ["scalar", "bvh4", "bvh8", "bvh4-fast", "bvh8-fast"];

/// Builders whose refined trees are measured by default, each with every step there is.
const REFINED: [&str; 3] = ["ploc", "binned-sah", "sbvh"];

/// Settings other than the default that are measured by default.
const NUMBERED: [(&str, &[usize]); 2] = [("ploc", &[1, 2, 4, 16]), ("hlbvh", &[8, 64])];

/// A builder with its options.
#[derive(Clone, Debug)]
pub struct Recipe {
    word: String,
    builder: &'static Builder,
    options: BuildOptions,
}

impl std::str::FromStr for Recipe {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let (builder, steps) = word.split_once('+').unwrap_or((word, ""));
        let (id, number) = builder.split_once(':').map_or((builder, None), |(id, number)| (id, Some(number)));
        let number = number.map(|n| n.parse().map_err(|_| format!("{word}: {n} is not a number"))).transpose()?;
        let builder = build::find(id).ok_or_else(|| format!("there is no builder {id}"))?;
        let meant = [Parameter::Radius, Parameter::Cluster].into_iter().find(|p| builder.parameters.contains(p));
        let options = BuildOptions {
            radius: number.filter(|_| meant == Some(Parameter::Radius)),
            cluster: number.filter(|_| meant == Some(Parameter::Cluster)),
            bins: number.filter(|_| meant.is_none()),
            refine: steps.parse()?,
            preset: builder.presets.first().copied().unwrap_or(BuildOptions::default().preset),
            ..BuildOptions::default()
        };
        builder.check(&options).map_err(|e| e.to_string())?;
        Ok(Self { word: word.to_owned(), builder, options })
    }
}

/// All modern builders there are, and some with refinement: the list grows with the registers.
pub fn default_recipes() -> Vec<String> {
    let modern = build::BUILDERS.iter().filter(|b| b.presets.is_empty()).map(|b| b.id.to_owned());
    let set = NUMBERED.iter().flat_map(|(id, numbers)| numbers.iter().map(move |n| format!("{id}:{n}")));
    let steps: Vec<_> = STEPS.iter().map(|s| s.id).filter(|&id| id != "leaves").collect();
    let refined = build::BUILDERS
        .iter()
        .filter(|b| REFINED.contains(&b.id) && b.parameters.contains(&Parameter::Refine))
        .flat_map(|b| steps.iter().map(|step| format!("{}+{step}", b.id)));
    modern.chain(set).chain(refined).collect()
}

impl Recipe {
    /// The tree, boxes included in the work.
    ///
    /// # Errors
    /// What the builder says, in one line.
    pub fn tree(&self, triangles: &[Triangle]) -> Result<Bvh, String> {
        let boxes = self.builder.boxes(triangles, &self.options);
        let input = Input::of_triangles(triangles, &boxes);
        (self.builder.timed)(input, &self.options, &mut Brake::default()).map_err(|e| e.to_string())
    }
}

impl Subject for Recipe {
    fn library(&self) -> &'static str {
        "bvh-lab"
    }

    fn version(&self) -> String {
        lab::commit().to_owned()
    }

    fn preset(&self) -> String {
        self.word.clone()
    }

    fn builds_with(&self, threads: usize) -> bool {
        threads == 1 || (self.builder.parallel)(&self.options)
    }

    fn spatial(&self) -> bool {
        self.builder.spatial
    }

    fn prepare<'a>(&'a self, triangles: &'a [Triangle], _threads: usize) -> Box<dyn Prepared + 'a> {
        Box::new(Ours { recipe: self, triangles })
    }
}

struct Ours<'a> {
    recipe: &'a Recipe,
    triangles: &'a [Triangle],
}

impl Prepared for Ours<'_> {
    fn build(&self) -> Result<Box<dyn Built + '_>, String> {
        let bvh = self.recipe.tree(self.triangles)?;
        Ok(Box::new(OurTree { bvh, triangles: self.triangles }))
    }
}

struct OurTree<'a> {
    bvh: Bvh,
    triangles: &'a [Triangle],
}

impl Built for OurTree<'_> {
    fn tree(&self) -> Option<PeerTree> {
        Some(PeerTree::own(self.bvh.clone()))
    }

    fn traversals(&self, _query: Query) -> Vec<&'static str> {
        KERNELS.to_vec()
    }

    fn trace(&self, query: Query, traversal: usize, rays: &[Ray], hits: &mut [HitRecord]) {
        self.tracer(query, traversal)(rays, hits);
    }

    fn tracer(&self, query: Query, traversal: usize) -> Box<dyn Fn(&[Ray], &mut [HitRecord]) + '_> {
        let kernel = Kernel::from_id(KERNELS[traversal]).expect("kernels named here are registered");
        let tracer = Tracer::new(kernel, &self.bvh, self.triangles);
        Box::new(move |rays, hits| {
            tracer.trace_all(query, rays, hits, &mut Scratch::default(), &mut ());
        })
    }
}
