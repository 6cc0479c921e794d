//! Claims about secondary rays.

use super::evidence::{ByModel, Evidence, KINDS, Kind, changes, mean, range, span};
use super::{Claim, Finding, Source, Verdict};
use crate::report::PRESETS;
use crate::report::experiments::lit;
use crate::report::printed::Model;
use crate::rows::{Experiment, Lighting};

const ROWS: Source = Source::Rows("rows/traces.csv");
const NOTE: Source = Source::Section("secondary", "what secondary rays add");
const ORIGINS: Source = Source::Section("origins", "with corrected origins");

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        id: "secondary-rays-add-little",
        statement: "Secondary rays add only 10 to 20 % to the work.",
        quote: "neither the average time per pixel nor nodes traversed per pixel substantially increased when secondary rays were \
                incorporated — each by only about 10-20%",
        place: "Results and Analysis, Tables 4 to 9",
        predicate: "Nodes per pixel grow by at most 20 % on average with one reflection or see-through rays. If each secondary ray adds the \
                    root and hardly anything else (0.95 to 1.1 nodes), they never met the scene.",
        decide: add_little,
        sources: &[Source::Table(7), Source::Table(9), NOTE, ORIGINS, ROWS],
    },
    Claim {
        id: "lighting-mirrors",
        statement: "The trees rank alike under all three lighting cases.",
        quote: "the relative performances of the BVHs are mirrored with each of the lighting effects",
        place: "Results and Analysis, Tables 4 to 9",
        predicate: "Of all pairs of the six trees of a model, at least 90 % are ordered alike by nodes per pixel with and without secondary \
                    rays.",
        decide: mirrors,
        sources: &[Source::Table(5), Source::Table(7), Source::Table(9), ROWS],
    },
];

const CASES: [Lighting; 2] = [Lighting::Reflection, Lighting::Opacity];

fn add_little(ev: &Evidence, preset: &str) -> Finding {
    const LITTLE: f64 = 1.2;
    const ROOT_ALONE: std::ops::RangeInclusive<f64> = 0.95..=1.1;
    let mut per_ray = Vec::new();
    let mut found = [const { Vec::new() }; 2];
    for (case, found) in CASES.into_iter().zip(&mut found) {
        for model in Model::ALL {
            for tree in KINDS.map(|k| k.of(model)) {
                let Some((with, without)) = ev.trace(preset, tree, case).zip(ev.trace(preset, tree, Lighting::Primary))
                else {
                    continue;
                };
                let Some((more, few)) = with.nodes_per_pixel.zip(without.nodes_per_pixel) else { continue };
                found.push((model, more / few));
                // Primary rays are one a pixel: what is left are secondary ones, as a fraction of the pixels.
                if let Some((all, first)) = with.rays.zip(without.rays).filter(|(all, first)| all > first && *first > 0)
                {
                    per_ray.push((more - few) / ((all - first) as f64 / first as f64));
                }
            }
        }
    }
    let by_model = found
        .each_ref()
        .map(|f| ByModel::of(|m| mean(f.iter().filter(|(model, _)| *model == m).map(|(_, ratio)| *ratio))));
    if by_model.iter().any(|r| !r.is_enough()) {
        return Finding::undecided("traversals with and without secondary rays of at least three models");
    }
    let added = range(per_ray.iter().copied());
    let little = by_model.iter().all(|r| mean(r.values()).is_some_and(|x| x <= LITTLE));
    let root_alone = !per_ray.is_empty() && ROOT_ALONE.contains(&added.0) && ROOT_ALONE.contains(&added.1);
    let verdict = match (little, root_alone) {
        (true, true) => Verdict::Artefact,
        (true, false) => Verdict::Holds,
        _ => Verdict::Fails,
    };
    let mut why = format!(
        "A reflection changes nodes per pixel by {}, see-through rays by {}.",
        changes(by_model[0].range()),
        changes(by_model[1].range())
    );
    if !per_ray.is_empty() {
        why += &format!(" A secondary ray visits {} nodes", span(added, 4));
        why += if root_alone { ": the root alone, for it starts beyond the scene." } else { "." };
    }
    let corrected = (preset == PRESETS[0]).then(|| CASES.map(|case| corrected(ev, case)));
    if let Some([reflection, opacity]) = corrected.as_ref().filter(|c| c.iter().all(ByModel::is_enough)) {
        why += &format!(
            " Started where they should, on the same trees, they add {} and {}.",
            changes(reflection.range()),
            changes(opacity.range())
        );
    }
    let found = Finding::new(verdict, why)
        .with("nodes per pixel, reflection ÷ primary, mean over trees", by_model[0].labelled())
        .with("nodes per pixel, opacity ÷ primary, mean over trees", by_model[1].labelled())
        .with(
            "nodes per secondary ray",
            [("least", added.0), ("greatest", added.1)].into_iter().filter(|x| x.1.is_finite()),
        );
    let corrected = corrected.into_iter().flatten().zip(["reflection", "opacity"]);
    corrected
        .filter(|(r, _)| !r.0.is_empty())
        .fold(found, |f, (r, name)| f.with(format!("the same with corrected origins, {name} ÷ primary"), r.labelled()))
}

/// Nodes per pixel with secondary rays that start at the hit point, over those of primary rays: the program's trees, mean over the six.
fn corrected(ev: &Evidence, case: Lighting) -> ByModel {
    ByModel::of(|m| {
        let scene = m.scene();
        let nodes = |k: Kind, lighting| {
            lit(ev.experiments(), Experiment::Origins, &scene, (k.0, k.1), lighting).and_then(|r| r.nodes_per_pixel)
        };
        mean(KINDS.into_iter().filter_map(|k| Some(nodes(k, case)? / nodes(k, Lighting::Primary)?)))
    })
}

fn mirrors(ev: &Evidence, preset: &str) -> Finding {
    const ALIKE: f64 = 0.9;
    let shares = CASES.map(|case| ByModel::of(|m| share_alike(ev, preset, m, case)));
    if shares.iter().any(|s| !s.is_enough()) {
        return Finding::undecided("traversals of all six trees of at least three models under all lighting cases");
    }
    let means = shares.each_ref().map(|s| mean(s.values()).unwrap_or(0.0));
    let verdict = if means.iter().all(|m| *m >= ALIKE) { Verdict::Holds } else { Verdict::Fails };
    let why = format!(
        "{:.0} % of the pairs keep their order with a reflection, {:.0} % with see-through rays.",
        100.0 * means[0],
        100.0 * means[1]
    );
    Finding::new(verdict, why)
        .with("pairs ordered alike, reflection", shares[0].labelled())
        .with("pairs ordered alike, opacity", shares[1].labelled())
}

/// Share of the pairs of a model's six trees that nodes per pixel order alike in both cases.
fn share_alike(ev: &Evidence, preset: &str, model: Model, case: Lighting) -> Option<f64> {
    let nodes =
        |lighting| -> Option<Vec<f64>> { KINDS.iter().map(|k| ev.nodes(preset, k.of(model), lighting)).collect() };
    let (plain, lit) = (nodes(Lighting::Primary)?, nodes(case)?);
    let pairs = (0..plain.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    mean(pairs.map(|(i, j)| f64::from(u8::from(plain[i].total_cmp(&plain[j]) == lit[i].total_cmp(&lit[j])))))
}
