//! Does it pay to look several splits ahead? Trees by single splits and by the best of several, at equal arity and leaf
//! limit: SAH, work per diffuse ray, time of one build. Binary trees become wide by the cheapest collapse there is, so
//! that only the splits are compared.
//!
//! `cargo run --release --example several_splits_ahead -- [SCENE…]`

use bvh_lab::build::binned_sah::{self, BinnedSah};
use bvh_lab::build::kway_sah::{self, Cuts, KwaySah, Nodes};
use bvh_lab::build::sweep_sah::{self, SweepSah};
use bvh_lab::build::{BuildError, MAX_LEAF};
use bvh_lab::bvh::{Bvh, Limits, Node, validate};
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::geom::{Aabb, Ray};
use bvh_lab::scene::Scene;
use bvh_lab::trace::{Batch, Kernel, Query, Tracer, count_batch, diffuse_rays, primary_rays};
use std::time::Instant;

const ARITIES: [usize; 3] = [2, 4, 8];
const MOST: usize = 8;

type Build = Box<dyn Fn(&[Aabb], usize) -> Result<Bvh, BuildError>>;

/// How a tree of some arity is built: its own way, or from a binary tree over single triangles.
fn ways() -> Vec<(&'static str, Build)> {
    let kway = |params: KwaySah| move |boxes: &[Aabb], arity| cheapest(kway_sah::build(boxes, &params, &mut ()), arity);
    let one = KwaySah { max_leaf: 1, ..KwaySah::default() };
    let cuts_ahead = |parts| kway(KwaySah { parts, nodes: Nodes::Cuts, ..one });
    let wide = |cuts| {
        move |boxes: &[Aabb], parts| kway_sah::build(boxes, &KwaySah { parts, cuts, ..KwaySah::default() }, &mut ())
    };
    vec![
        ("sweep-sah", Box::new(|b, k| cheapest(sweep_sah::build(b, &SweepSah { max_leaf: 1 }, &mut ()), k))),
        ("binned-sah", {
            let params = BinnedSah { max_leaf: 1, ..BinnedSah::default() };
            Box::new(move |b, k| cheapest(binned_sah::build(b, &params, &mut ()), k))
        }),
        ("1 cut of the grid", Box::new(kway(KwaySah { parts: 2, nodes: Nodes::Cuts, ..one }))),
        ("3 cuts, binary", Box::new(cuts_ahead(4))),
        ("7 cuts, binary", Box::new(cuts_ahead(8))),
        ("whole grid, first cut", Box::new(kway(KwaySah { max_leaf: 1, ..KwaySah::at_arity(2) }))),
        ("k slabs, wide", Box::new(wide(Cuts::Slabs))),
        ("k parts, wide", Box::new(wide(Cuts::Guillotine))),
    ]
}

fn cheapest(binary: Result<Bvh, BuildError>, arity: usize) -> Result<Bvh, BuildError> {
    binary.map(|binary| Collapse::of(&binary, arity).tree())
}

/// The cheapest tree of an arity that keeps boxes of a binary tree, leaves included: the least costs of each node in at
/// most k nodes, from below.
struct Collapse<'a> {
    binary: &'a Bvh,
    arity: usize,
    counts: Vec<usize>,
    /// As one node, at 1; as at most k, at k.
    costs: Vec<[f64; MOST + 1]>,
    closed: Vec<bool>,
}

impl<'a> Collapse<'a> {
    fn of(binary: &'a Bvh, arity: usize) -> Self {
        let n = binary.nodes.len();
        let costs = vec![[f64::INFINITY; MOST + 1]; n];
        let mut all = Self { binary, arity, counts: vec![0; n], costs, closed: vec![true; n] };
        for (index, node) in binary.nodes.iter().enumerate().rev() {
            let below = binary.children(index);
            all.counts[index] = if node.is_leaf() { node.count() } else { all.counts[below].iter().sum() };
            let (area, count) = (node.aabb.surface_area(), all.counts[index]);
            let leaf = if node.is_leaf() || count <= MAX_LEAF { area * count as f64 } else { f64::INFINITY };
            let open = area + all.cut(index, arity);
            all.closed[index] = leaf <= open;
            for k in 1..=arity {
                all.costs[index][k] = leaf.min(open).min(all.cut(index, k));
            }
        }
        all
    }

    /// The shares of both children of the best division of a node into 2 to k nodes, with its cost.
    fn shares(&self, index: usize, k: usize) -> impl Iterator<Item = (usize, f64)> {
        let children = self.binary.children(index);
        let sum = move |i: usize| self.costs[children.start][i] + self.costs[children.start + 1][k - i];
        (1..k).take(if self.binary.nodes[index].is_leaf() { 0 } else { k }).map(move |i| (i, sum(i)))
    }

    fn cut(&self, index: usize, k: usize) -> f64 {
        self.shares(index, k).map(|(_, cost)| cost).fold(f64::INFINITY, f64::min)
    }

    fn tree(&self) -> Bvh {
        let (mut nodes, mut triangle_ids) = (vec![self.binary.nodes[0]], Vec::new());
        let mut pending = vec![(0, 0)];
        while let Some((place, index)) = pending.pop() {
            let aabb = self.binary.nodes[index].aabb;
            if self.closed[index] {
                let (first, mut below) = (triangle_ids.len(), vec![index]);
                while let Some(index) = below.pop() {
                    triangle_ids.extend_from_slice(self.binary.leaf_triangles(index));
                    below.extend(self.binary.children(index).rev());
                }
                nodes[place] = Node::leaf(aabb, first, triangle_ids.len() - first);
                continue;
            }
            let (mut children, mut open) = (Vec::new(), vec![(index, self.arity)]);
            while let Some((inner, k)) = open.pop() {
                let cut = self.cut(inner, k);
                if inner != index && (k == 1 || self.costs[inner][1] <= cut) {
                    children.push(inner);
                } else if let Some((i, _)) = self.shares(inner, k).find(|&(_, cost)| cost == cut) {
                    let first = self.binary.children(inner).start;
                    open.extend([(first + 1, k - i), (first, i)]);
                }
            }
            let first = nodes.len();
            nodes[place] = Node::inner(aabb, first, children.len());
            nodes.extend(children.iter().map(|&child| self.binary.nodes[child]));
            pending.extend((first..).zip(children).collect::<Vec<_>>().into_iter().rev());
        }
        Bvh { nodes, triangle_ids, arity: self.arity }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    bvh_lab::lab::keep_freed_memory();
    let mut scenes: Vec<_> = std::env::args().skip(1).collect();
    if scenes.is_empty() {
        scenes = ["spheres:20000", "stadium:20000", "terrain:20000", "soup:20000"].map(|s| format!("gen:{s}")).into();
    }
    for name in scenes {
        let scene = Scene::load(&name)?;
        let boxes = scene.boxes();
        println!("\n{name}: {} triangles\n", boxes.len());
        println!("| tree | k | SAH | nodes/ray | box tests/ray | triangle tests/ray | build ms |");
        println!("|---|--:|--:|--:|--:|--:|--:|");
        let mut rays: Vec<Ray> = Vec::new();
        for (way, build) in ways() {
            for arity in ARITIES {
                let start = Instant::now();
                let bvh = build(&boxes, arity)?;
                let ms = start.elapsed().as_secs_f64() * 1e3;
                validate(&bvh, &boxes, &Limits::default())?;
                if rays.is_empty() {
                    let primary = primary_rays(&scene.camera, 256, 256);
                    rays = diffuse_rays(&bvh, &scene.triangles, &primary, 1);
                }
                let tracer = Tracer::new(Kernel::Scalar, &bvh, &scene.triangles);
                let (_, work) = count_batch(&Batch { tracer: &tracer, query: Query::Closest, rays: &rays });
                let per_ray = |n: u64| n as f64 / rays.len() as f64;
                println!(
                    "| {way} | {arity} | {:.2} | {:.1} | {:.1} | {:.2} | {ms:.0} |",
                    sah(&bvh, SahParams::default()).unwrap_or(f64::NAN),
                    per_ray(work.nodes),
                    per_ray(work.box_tests),
                    per_ray(work.triangle_tests),
                );
            }
        }
    }
    Ok(())
}
