//! Boxes and triangles from bytes, through one builder: a valid tree, or the error that the boxes call for.

use crate::bytes::Bytes;
use crate::variants::variants;
use bvh_lab::build::{Brake, BuildError, BuildOptions, Builder, Counters, Engine, Input, Parameter};
use bvh_lab::bvh::{quantised, tree_hash, validate, validate_parts};
use bvh_lab::cost::{SahParams, sah};
use bvh_lab::geom::{Aabb, Triangle};
use bvh_lab::refine::STEPS;
use std::sync::LazyLock;

/// Every variant, and every step of refinement after every builder that takes it.
pub static RECIPES: LazyLock<Vec<(&Builder, BuildOptions)>> = LazyLock::new(|| {
    let plain: Vec<_> = variants().collect();
    let refined =
        plain.iter().filter(|(b, _)| b.parameters.contains(&Parameter::Refine)).flat_map(|&(builder, options)| {
            STEPS.iter().map(move |step| {
                (builder, BuildOptions { refine: step.id.parse().expect("a step's own id"), ..options })
            })
        });
    let refined: Vec<_> = refined.filter(|(builder, options)| builder.check(options).is_ok()).collect();
    plain.into_iter().chain(refined).collect()
});

/// More boxes than these are left to the engines that end soon.
const LITERAL: usize = 24;

/// One execution.
///
/// # Panics
/// On what must not be.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes(data);
    let recipe = usize::from(bytes.byte()) | usize::from(bytes.byte()) << 8;
    let (builder, mut options) = RECIPES[recipe % RECIPES.len()];
    let (style, n) = (bytes.style(), bytes.below(65));
    if n > LITERAL && builder.engine(&options) == Some(Engine::Literal) {
        options.engine = Engine::Exact;
    }
    if bytes.byte() & 1 == 0 {
        let boxes: Vec<_> = (0..n).map(|_| bytes.aabb(style)).collect();
        check(builder, &options, Input::of_boxes(&boxes));
    } else {
        let triangles: Vec<_> = (0..n).map(|_| bytes.triangle(style)).collect();
        let boxes: Vec<_> = triangles.iter().map(Triangle::aabb).collect();
        check(builder, &options, Input::of_triangles(&triangles, &boxes));
    }
}

fn check(builder: &Builder, options: &BuildOptions, input: Input) {
    let built = (builder.timed)(input, options, &mut Brake::default());
    let expected = match input.boxes.iter().position(|b| !Aabb::is_valid(b)) {
        _ if input.boxes.is_empty() => Some(BuildError::NoTriangles),
        bad => bad.map(BuildError::InvalidBox),
    };
    let Ok(bvh) = built else {
        assert_eq!(built.err(), expected, "{} {options:?}", builder.id);
        return;
    };
    assert_eq!(expected, None, "{} {options:?} takes a box without sense", builder.id);
    // A triangle with a NaN has a box, but no shape that parts of it could cover.
    let triangles = input.triangles.filter(|t| t.iter().all(Triangle::is_finite));
    let limits = builder.limits(options);
    let valid = match triangles {
        Some(triangles) => validate_parts(&bvh, triangles, input.boxes, &limits).map(drop),
        None if input.triangles.is_some() && limits.spatial => Ok(()),
        None => validate(&bvh, input.boxes, &limits).map(drop),
    };
    assert!(valid.is_ok(), "{} {options:?}: {valid:?}", builder.id);
    assert!(sah(&bvh, SahParams::default()).is_none_or(f64::is_finite), "{} {options:?}", builder.id);
    let counted = (builder.counted)(input, options, &mut Counters::default());
    assert_eq!(counted.as_ref().map(tree_hash).ok(), Some(tree_hash(&bvh)), "{} {options:?}", builder.id);
    let stored = quantised(&bvh, 8);
    assert!(stored.nodes.iter().zip(&bvh.nodes).all(|(s, e)| s.aabb.contains(&e.aabb)), "{} {options:?}", builder.id);
}
