//! The matrix of hard cases: 24 rows × every builder, reading, engine and arity × every kernel, with brute force in f64 as the judge.
//!
//! A builder or kernel joins by being registered. Every answer to all three queries (closest, any, all hits) is judged by
//! [`bvh_lab::trace::Oracle`]; the watertight kernels are besides held to brute force bit for bit, which decides ties: the lowest id.
//!
//! | row | case | where |
//! |--:|---|---|
//! | 1, 2 | closed spheres from inside, near and far | `cases::closed`; 10⁷ rays in `watertight` |
//! | 3, 4 | origins on slab planes; 26 directions, either sign of zero | `cases::zeros` |
//! | 5, 6 | boxes of no thickness; triangles without area | `cases::flat` |
//! | 7, 8, 9 | coincident; 1 to 9 triangles; nested | `cases::small`; `rules::no_call_stack_grows_with_depth` |
//! | 8 | no triangle | `rules::nothing_to_trace_is_a_clean_error` |
//! | 10 | NaN and ∞ vertices | `rules::triangles_that_are_no_numbers_are_left_out` |
//! | 11 | NaN and ∞ rays | `cases::numbers` |
//! | 12 | scene × 2^k | `rules::powers_of_two_scale_t_and_nothing_else` |
//! | 13, 14 | denormals; about 10¹⁹ | `cases::numbers` |
//! | 15 | 10⁷ equal areas summed | `cost::sum::tests::ten_million_equal_terms` |
//! | 16 | hits at t_min and t_max | `cases::intervals` |
//! | 17 | secondary rays; thin walls | `cases::secondary` |
//! | 18 | overlapping boxes | `cases::shapes` |
//! | 19 | quantised nodes | `rules::boxes_in_few_bits_contain_the_exact_ones` |
//! | 20 | two engines, one tree | `rules::engines_build_the_same_trees` |
//! | 21 | order of rays, threads, instructions | `rules::order_threads_and_instructions_change_nothing` |
//! | 22, 23, 24 | stadium; slivers; far from the origin | `cases::shapes`; costs in `tests/quality` and `tests/builders` |
//!
//! What builders alone are held to (near-linear time on 10⁵ coincident triangles, costs in the stadium): `tests/builders`, `tests/quality`.
//!
//! Expected failures are those of the thesis' traversal: it takes a farther hit where boxes overlap (row 18, but boxes overlap in
//! nearly every scene), and misses by its absolute thresholds (rows 12, 16, 24, and scenes far smaller or larger than 1), among them
//! boxes entered at exactly 0 (row 3). Their
//! numbers over the thesis' own trees are pinned ([`EXPECTED`]); it is excused for nothing else. Trees with rule Q8 lack triangles:
//! what any kernel does not find there is counted apart, and pinned as well.

mod bites;
mod cases;
#[path = "../support/hard_scenes.rs"]
mod hard_scenes;
mod judge;
mod rays;
mod rules;
mod scenes;
mod shared_scenes;
#[path = "../support/variants.rs"]
mod variants;
mod watertight;

use bvh_lab::build::{BUILDERS, BuildOptions, Builder, Engine, Parameter};
use bvh_lab::refine::STEPS;
use bvh_lab::trace::{KERNELS, Kernel};
use judge::{Outcome, Tally, judge, trees};
use std::collections::BTreeMap;
use variants::variants;

/// More triangles than this are left to the engines that end soon: their trees are those of the literal ones (row 20).
const LITERAL: usize = 130;

/// By row: hits of `first-leaf` in the thesis' trees that are not the closest, its misses of what is certainly hit, and what
/// `scalar` does not find in trees with rule Q8.
const EXPECTED: &[(u8, u64, u64, u64)] = &[
    (2, 0, 174, 18),
    (3, 13916, 7112, 0),
    (4, 3980, 40, 0),
    (6, 0, 0, 2),
    (8, 4, 0, 0),
    (9, 0, 6100, 0),
    (13, 0, 10280, 0),
    (14, 0, 7760, 0),
    (18, 4900, 0, 0),
    (22, 254, 0, 0),
    (23, 0, 0, 2),
    (24, 38, 186, 0),
];

/// Every refinement step, after one builder.
fn refined() -> Vec<(&'static Builder, BuildOptions)> {
    let builder = BUILDERS.iter().find(|b| b.id == "lbvh").unwrap();
    assert!(builder.parameters.contains(&Parameter::Refine));
    let steps = STEPS.iter().map(|step| step.id.parse().unwrap());
    steps
        .flat_map(|refine| [2, 8].map(|arity| (builder, BuildOptions { arity, refine, ..BuildOptions::default() })))
        .collect()
}

#[test]
fn every_row_by_every_builder_arity_and_kernel() {
    let mut rows: BTreeMap<u8, Vec<Tally>> = BTreeMap::new();
    let mut failures = Vec::new();
    println!("seed {}; a line a case: trees, rays; for each kernel hits, and of them or beside them:", cases::SEED);
    println!(
        "b right at a border, where either answer is; f farther and m missed, expected failures of the thesis' kernel; q hidden by Q8"
    );
    for case in cases::all() {
        let few = case.triangles.len() <= LITERAL;
        let all = variants().filter(|(b, o)| few || b.engine(o) != Some(Engine::Literal)).chain(refined());
        let trees = trees(&case.triangles, &all.collect::<Vec<_>>());
        let Outcome { tallies, failures: wrong } = judge(&case, &trees);
        println!("{:>3} {:<33} {:>3} × {:>5}: {}", case.row, case.what, trees.len(), case.rays.len(), line(&tallies));
        wrong.iter().take(3).for_each(|why| println!("      {why}"));
        failures.extend(wrong);
        let row = rows.entry(case.row).or_insert_with(|| vec![Tally::default(); KERNELS.len()]);
        row.iter_mut().zip(&tallies).for_each(|(sum, one)| sum.add(one));
    }
    let few: Vec<_> = failures.iter().take(20).collect();
    assert!(failures.is_empty(), "{} failures, the first: {few:#?}", failures.len());
    let scalar = KERNELS.iter().position(|k| k.kernel == Kernel::Scalar).unwrap();
    let published = KERNELS.iter().position(|k| matches!(k.kernel, Kernel::FirstLeaf(_))).unwrap();
    let count = |(&row, tallies): (&u8, &Vec<Tally>)| {
        (row, tallies[published].farther[0], tallies[published].missed[0], tallies[scalar].hidden)
    };
    let counts: Vec<_> = rows.iter().map(count).filter(|c| c.1 + c.2 + c.3 > 0).collect();
    assert_eq!(counts, EXPECTED, "by row: farther and missed by first-leaf in the thesis' trees, hidden by rule Q8");
    for (k, info) in KERNELS.iter().enumerate().filter(|(k, _)| *k != published) {
        assert!(rows.values().all(|row| row[k].farther == [0, 0] && row[k].missed == [0, 0]), "{}", info.id);
    }
}

fn line(tallies: &[Tally]) -> String {
    let one = |(tally, info): (&Tally, &bvh_lab::trace::KernelInfo)| {
        let mut text = format!("{} {}", info.id, tally.hits);
        let [farther, missed] = [tally.farther, tally.missed].map(|n| n[0] + n[1]);
        for (n, what) in [(tally.border, 'b'), (farther, 'f'), (missed, 'm'), (tally.hidden, 'q')] {
            if n > 0 {
                text += &format!(" {n}{what}");
            }
        }
        text
    };
    tallies.iter().zip(KERNELS).map(one).collect::<Vec<_>>().join(", ")
}
