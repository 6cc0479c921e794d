//! Who takes part unless told otherwise: every builder, and what a practitioner would do after it.

use crate::build::{BUILDERS, Builder};
use crate::refine::Refinements;

/// Steps that are tried besides. The thesis' builders end in leaves by rules of their own; with `+leaves` their costs compare.
const REFINED: &[(&str, &str)] = &[
    ("top-down", "leaves"),
    ("bottom-up", "leaves"),
    ("lbvh", "treelets"),
    ("ploc", "reinsertion"),
    ("binned-sah", "rotations"),
    ("binned-sah", "reinsertion"),
    ("binned-sah", "reinsertion+treelets"),
    ("kway-sah", "reinsertion+treelets"),
    ("sbvh", "reinsertion+treelets"),
];

/// Every builder of the register, each followed by itself with the steps that are tried besides.
pub fn standard_recipes() -> Vec<(&'static Builder, Refinements)> {
    let refined = |builder: &'static Builder| {
        let steps = REFINED.iter().filter(|(id, _)| *id == builder.id);
        steps.map(move |(_, steps)| (builder, steps.parse().expect("steps are registered"))) // by the test below
    };
    BUILDERS.iter().flat_map(|b| [(b, Refinements::default())].into_iter().chain(refined(b))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, find};

    #[test]
    fn every_builder_takes_part_and_every_recipe_is_one() {
        let recipes = standard_recipes();
        assert!(BUILDERS.iter().all(|b| recipes.iter().any(|(r, steps)| r.id == b.id && steps.is_empty())));
        assert_eq!(recipes.len(), BUILDERS.len() + REFINED.len());
        assert!(REFINED.iter().all(|(id, _)| find(id).is_some()));
        for (builder, refine) in recipes {
            builder.check(&BuildOptions { refine, ..BuildOptions::default() }).unwrap();
        }
    }
}
