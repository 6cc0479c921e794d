//! What is compared: builds of both engines, held against each other node by node.

use bvh_lab::build::{BUILDERS, Brake, BuildOptions, Builder, Counters, Engine, Input, Preset};
use bvh_lab::bvh::{Bvh, tree_hash};
use bvh_lab::geom::Aabb;
use bvh_lab::scene::Scene;
use rayon::ThreadPoolBuilder;

/// A builder with its options; the engine in them is of no meaning.
pub type Variant = (&'static Builder, BuildOptions);

/// Every builder, reading, arity and rule Q8 on and off where it makes a difference, with these candidates.
pub fn variants(candidates: impl Fn(Preset, usize) -> Option<usize>) -> Vec<Variant> {
    let mut all = Vec::new();
    for builder in BUILDERS {
        for &preset in builder.presets {
            for &arity in builder.arities {
                let candidates = candidates(preset, arity).filter(|_| builder.id == "top-down");
                let has_rule = builder.id == "top-down" && preset == Preset::Published && arity == 8;
                for q8 in if has_rule { &[true, false][..] } else { &[true] } {
                    all.push((builder, BuildOptions { arity, preset, candidates, q8: *q8, ..Default::default() }));
                }
            }
        }
    }
    all
}

/// The variants of one builder and reading.
pub fn only(id: &str, preset: Preset, variants: Vec<Variant>) -> Vec<Variant> {
    variants.into_iter().filter(|(b, o)| b.id == id && o.preset == preset).collect()
}

/// The boxes of a scene.
pub fn boxes(scene: &str) -> Vec<Aabb> {
    Scene::load(scene).unwrap().boxes()
}

/// One engine's tree; the counted build must give the timed one's.
pub fn build((builder, options): &Variant, engine: Engine, boxes: &[Aabb]) -> Result<Bvh, String> {
    let options = BuildOptions { engine, ..*options };
    (builder.timed)(Input::of_boxes(boxes), &options, &mut Brake::default())
        .map_err(|e| format!("{} {options:?}: {e}", builder.id))
}

/// Where two trees differ: kinds, triangles below leaves, children and their order, boxes.
fn difference(a: &Bvh, b: &Bvh) -> Option<String> {
    let mut pairs = vec![(0, 0)];
    while let Some((i, j)) = pairs.pop() {
        let (x, y) = (&a.nodes[i], &b.nodes[j]);
        let sorted = |bvh: &Bvh, index| {
            let mut ids = bvh.leaf_triangles(index).to_vec();
            ids.sort_unstable();
            ids
        };
        if (x.is_leaf(), x.count(), sorted(a, i)) != (y.is_leaf(), y.count(), sorted(b, j)) {
            return Some(format!("nodes {i} and {j}: {x:?} {:?} and {y:?} {:?}", sorted(a, i), sorted(b, j)));
        }
        if x.aabb != y.aabb {
            return Some(format!("boxes of nodes {i} and {j}: {:?} and {:?}", x.aabb, y.aabb));
        }
        pairs.extend(a.children(i).zip(b.children(j)));
    }
    None
}

/// Counts the comparisons of one test, and prints their number when it ends.
pub struct Tally {
    of: &'static str,
    trees: usize,
}

impl Tally {
    /// None yet.
    pub fn new(of: &'static str) -> Self {
        Self { of, trees: 0 }
    }

    /// Checks that both engines return the same tree.
    pub fn compare(&mut self, variant: &Variant, boxes: &[Aabb]) -> Result<(), String> {
        let literal = build(variant, Engine::Literal, boxes)?;
        self.compare_with(&literal, variant, boxes)
    }

    /// Checks that the exact engine returns the tree `literal`, timed and counted.
    pub fn compare_with(&mut self, literal: &Bvh, variant: &Variant, boxes: &[Aabb]) -> Result<(), String> {
        let exact = build(variant, Engine::Exact, boxes)?;
        let (id, options, n) = (variant.0.id, variant.1, boxes.len());
        if let Some(difference) = difference(literal, &exact) {
            return Err(format!("{id} {options:?}, {n} triangles, literal and exact: {difference}"));
        }
        if tree_hash(literal) != tree_hash(&exact) {
            return Err(format!("{id} {options:?}, {n} triangles: the hash sees a difference that the walk does not"));
        }
        let mut counters = Counters::default();
        let counted = (variant.0.counted)(
            Input::of_boxes(boxes),
            &BuildOptions { engine: Engine::Exact, ..options },
            &mut counters,
        );
        if counted.map(|c| tree_hash(&c)) != Ok(tree_hash(&exact)) {
            return Err(format!("{id} {options:?}, {n} triangles: counting changes the exact tree"));
        }
        self.trees += 1;
        Ok(())
    }

    /// [`Tally::compare`] for all `variants`.
    ///
    /// # Panics
    /// Where trees differ.
    pub fn compare_all(&mut self, variants: &[Variant], boxes: &[Aabb], name: &str) {
        for variant in variants {
            if let Err(why) = self.compare(variant, boxes) {
                panic!("{name}: {why}");
            }
        }
    }

    /// Checks that the exact engine returns the same tree on 1, 2 and 7 threads.
    ///
    /// # Panics
    /// Where trees differ.
    pub fn compare_threads(&mut self, variant: &Variant, boxes: &[Aabb], name: &str) {
        let hashes = [1, 2, 7].map(|threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| tree_hash(&build(variant, Engine::Exact, boxes).unwrap()))
        });
        assert!(hashes.iter().all(|h| *h == hashes[0]), "{name}: {} {:?}: {hashes:?}", variant.0.id, variant.1);
        self.trees += hashes.len() - 1;
    }
}

impl Drop for Tally {
    fn drop(&mut self) {
        println!("{}: {} comparisons, all equal until here", self.of, self.trees);
    }
}
