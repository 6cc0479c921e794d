//! How much the thesis' collapse depends on which child of a binary node comes first: average degrees at arity 8 of the
//! same bottom-up trees as they are, with all siblings swapped, and with twenty random sibling orders.

use bvh_lab::build::{self, Brake, BuildOptions, Input};
use bvh_lab::bvh::Bvh;
use bvh_lab::cost::stats;
use bvh_lab::refine::collapse;
use bvh_lab::scene::Scene;

/// The binary tree with the children of some nodes swapped.
fn swapped(bvh: &Bvh, mut swap: impl FnMut() -> bool) -> Bvh {
    let mut bvh = bvh.clone();
    for index in 0..bvh.nodes.len() {
        let children = bvh.children(index);
        if children.len() == 2 && swap() {
            bvh.nodes.swap(children.start, children.start + 1);
        }
    }
    bvh
}

fn degree(bvh: &Bvh, arity: usize) -> f64 {
    stats(&collapse(bvh, arity)).avg_degree.unwrap_or(f64::NAN)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let builder = build::find("bottom-up").ok_or("no such builder")?;
    for level in ["tiny", "small", "med", "large"] {
        let boxes = Scene::load(&format!("thesis:{level}"))?.boxes();
        let bvh = (builder.timed)(Input::of_boxes(&boxes), &BuildOptions::default(), &mut Brake::default())?;
        let all = swapped(&bvh, || true);
        let random: Vec<f64> = (0..20u64)
            .map(|seed| {
                let mut x = seed * 7919 + 1;
                let coin = || {
                    x ^= x << 13;
                    x ^= x >> 7;
                    x ^= x << 17;
                    x & 1 == 1
                };
                degree(&swapped(&bvh, coin), 8)
            })
            .collect();
        let least = random.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = random.iter().copied().fold(0.0, f64::max);
        let (as_is, other) = (degree(&bvh, 8), degree(&all, 8));
        println!("{level:6} as is {as_is:.3}, all swapped {other:.3}, random {least:.3} to {greatest:.3}");
    }
    Ok(())
}
