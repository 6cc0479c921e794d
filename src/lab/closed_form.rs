//! What a literal build of a given tree costs, in closed form: summed over the tree's nodes, nothing is searched.
//!
//! A node of n triangles costs a top-down search as many combinations as n (`published`) or the number of planes used at last
//! (`text`: its children less one) say, and the thesis' program united the boxes of all n triangles again for each of
//! them. So a tree from any engine tells what the literal engine, and the program, had to do for it. Bottom-up by pairs
//! the work follows from the number of triangles alone.
//!
//! The counts of the literal engines are the same, which the tests hold them to.

use crate::build::top_down::{Published, Text};
use crate::build::{BuildOptions, MAX_LEAF, Preset};
use crate::bvh::{Bvh, NodeKind};
use crate::rows::Construction;

/// Work in closed form.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LiteralWork {
    /// Combinations evaluated, or distances computed.
    pub steps: f64,
    /// Box unions of the thesis' program: combinations times triangles of the node; 0 bottom-up.
    pub unions: f64,
}

/// The work of a literal build of `bvh`; `None` for the published chain, whose searches are not written in its tree.
pub fn literal_work(bvh: &Bvh, construction: Construction, options: &BuildOptions) -> Option<LiteralWork> {
    let candidates = options.candidates.unwrap_or(200 / options.arity);
    match (construction, options.preset) {
        (Construction::BottomUp, Preset::Published) => None,
        (Construction::BottomUp, _) => {
            let n = bvh.triangle_ids.len() as f64;
            Some(LiteralWork { steps: (n.powi(3) - n) / 6.0, unions: 0.0 })
        }
        (Construction::TopDown, Preset::Published) => {
            let params = Published { arity: options.arity, candidates, q8: options.q8 };
            Some(sum(bvh, |n, _| params.combinations(n)))
        }
        (Construction::TopDown, _) => {
            let params = Text { arity: options.arity, planes: candidates };
            Some(sum(bvh, |_, children| params.combinations(children - 1)))
        }
    }
}

/// Adds up combinations, and combinations times triangles, over the nodes that were split.
fn sum(bvh: &Bvh, combinations: impl Fn(usize, usize) -> u64) -> LiteralWork {
    let mut slots = vec![0; bvh.nodes.len()];
    let mut work = LiteralWork::default();
    for (index, node) in bvh.nodes.iter().enumerate().rev() {
        match node.kind() {
            NodeKind::Leaf(range) => slots[index] = range.len(),
            NodeKind::Inner(children) => {
                let count = children.len();
                let n: usize = slots[children.clone()].iter().sum();
                slots[index] = n;
                // Rule Q8: seven leaves without triangles beside a child that holds one slot more than the node did.
                let ruled = children.into_iter().any(|c| bvh.nodes[c].is_leaf() && slots[c] == 0);
                if ruled {
                    slots[index] = n - 1;
                } else if n > MAX_LEAF {
                    let own = combinations(n, count) as f64;
                    work.steps += own;
                    work.unions += own * n as f64;
                }
            }
        }
    }
    work
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{self, Counters, Engine, Input, Work};
    use crate::scene::Scene;

    #[test]
    fn literal_engines_count_what_the_closed_forms_say() {
        let scenes =
            ["thesis:tiny", "gen:slivers:300", "gen:coincident:90", "gen:soup:7", "gen:spheres:5", "gen:soup:3"];
        for scene in scenes {
            let boxes = Scene::load(scene).unwrap().boxes();
            for (id, construction) in [("top-down", Construction::TopDown), ("bottom-up", Construction::BottomUp)] {
                let builder = build::find(id).unwrap();
                for (&preset, arity) in builder.presets.iter().flat_map(|p| [2, 4, 8].map(|k| (p, k))) {
                    let mut options =
                        BuildOptions { arity, preset, engine: Engine::Literal, ..BuildOptions::default() };
                    if (arity, preset) == (8, Preset::Text) {
                        options.candidates = Some(9);
                    }
                    if construction == Construction::BottomUp && arity > 2 {
                        continue;
                    }
                    let mut counters = Counters::default();
                    let bvh = (builder.counted)(Input::of_boxes(&boxes), &options, &mut counters).unwrap();
                    let Some(work) = literal_work(&bvh, construction, &options) else {
                        assert_eq!((id, preset), ("bottom-up", Preset::Published));
                        continue;
                    };
                    let counted = counters.get(Work::Combinations) + counters.get(Work::PairDistances);
                    assert_eq!(work.steps, counted as f64, "{scene} {id} {preset:?} {arity}");
                    let unions = counters.get(Work::OriginalUnions);
                    assert_eq!(work.unions, unions as f64, "{scene} {id} {preset:?} {arity}");
                }
            }
        }
    }
}
