//! Experiments on the page: the thesis' findings put to the test, a section an experiment.

use super::drawing;
use super::provenance::Origin;
use crate::report::PRESETS;
use crate::report::experiments::{Experiments, lit, tests, wrong};
use crate::report::figures::Figures;
use crate::report::number::{grouped, padded, percent};
use crate::report::printed::Model;
use crate::rows::{Construction, Experiment, ExperimentRow, Lighting};
use maud::{Markup, html};

const ARITIES: [usize; 3] = [2, 4, 8];
const KINDS: [(Construction, usize); 6] = [
    (Construction::TopDown, 2),
    (Construction::TopDown, 4),
    (Construction::TopDown, 8),
    (Construction::BottomUp, 2),
    (Construction::BottomUp, 4),
    (Construction::BottomUp, 8),
];

/// All sections for which there are rows.
pub(crate) fn sections(rows: Experiments, figures: &Figures) -> Markup {
    let all = [lookup, rule_q8, first_leaf, collapse, origins, conjecture, candidates, readings];
    html! {
        @if !rows.0.is_empty() {
            h2 id="experiments" { "The findings put to the test" }
            @for (experiment, section) in Experiment::ALL.into_iter().zip(all) {
                @if rows.of(experiment).next().is_some() {
                    h3 id=(experiment.id()) { (title(experiment)) }
                    (section(rows, figures))
                    (Origin::experiment(experiment, rows.0.first().map_or("", |r| &r.commit)).line())
                }
            }
        }
    }
}

const fn title(experiment: Experiment) -> &'static str {
    match experiment {
        Experiment::Lookup => "Does time per pixel grow with the scene?",
        Experiment::RuleQ8 => "Does arity 8 visit more nodes than arity 4?",
        Experiment::FirstLeaf => "Are the pictures right?",
        Experiment::Collapse => "What does the collapse cost?",
        Experiment::Origins => "What do secondary rays cost when they start where they should?",
        Experiment::Conjecture => "Would wide trees win with all 100 planes?",
        Experiment::Candidates => "How many candidates are enough?",
        Experiment::Readings => "Which reading of the text comes closest to the printed tables?",
    }
}

fn number(x: Option<f64>, digits: i32) -> String {
    x.map_or("—".to_owned(), |x| grouped(&padded(x, digits)))
}

fn count(x: Option<usize>) -> String {
    x.map_or("—".to_owned(), |n| grouped(&n.to_string()))
}

/// A table over the models: a line each, cells by kind of tree.
fn by_model(heads: &[String], cell: impl Fn(Model, usize) -> String) -> Markup {
    html! {
        div .scroll { table .dense {
            thead { tr { th .name { "Model" } @for head in heads { th { (head) } } } }
            tbody { @for model in Model::ALL { tr {
                th .name { (model.name()) }
                @for i in 0..heads.len() { td { (cell(model, i)) } }
            } } }
        } }
    }
}

fn kind_names() -> Vec<String> {
    KINDS.map(|(c, k)| format!("{} {k}", c.id())).to_vec()
}

fn lookup(rows: Experiments, figures: &Figures) -> Markup {
    let time = |m: Model, i: usize, setting| {
        rows.tree(Experiment::Lookup, &m.scene(), KINDS[i], setting).and_then(|r| r.us_per_pixel)
    };
    html! {
        p {
            "Before each triangle test the program looked the triangle up by a scan over all triangles. Here the same trees are traced with such a scan \
             and without: microseconds per pixel, primary rays, without / with it."
        }
        (drawing(figures, "lookup", "Time per pixel with and without the linear lookup, and as printed.", html! {
            "Time per pixel against the number of triangles: printed, and here with and without the linear lookup."
        }))
        (by_model(&kind_names(), |m, i| {
            format!("{} / {}", number(time(m, i, "lookup=direct"), 3), number(time(m, i, "lookup=linear"), 3))
        }))
    }
}

fn rule_q8(rows: Experiments, _: &Figures) -> Markup {
    let row = |m: Model, setting| rows.tree(Experiment::RuleQ8, &m.scene(), (Construction::TopDown, 8), setting);
    let heads = [
        "nodes per pixel, rule off",
        "rule on",
        "rule adds",
        "triangles in several leaves",
        "triangles lost from sight",
        "wrong pixels, rule off",
        "rule on",
    ];
    html! {
        p {
            "Nodes of five to seven triangles have no seven splits. What the program did with them (rule Q8) sends rays into more nodes and \
             loses triangles: they stand only under boxes that do not contain them."
        }
        (by_model(&heads.map(str::to_owned), |m, i| {
            let (off, on) = (row(m, "rule=off"), row(m, "rule=on"));
            let nodes = |r: Option<&ExperimentRow>| r.and_then(|r| r.nodes_per_pixel);
            match i {
                0 => number(nodes(off), 4),
                1 => number(nodes(on), 4),
                2 => nodes(on).zip(nodes(off)).map_or("—".into(), |(a, b)| percent(a / b)),
                3 => count(on.and_then(|r| r.q8_duplicated)),
                4 => count(on.and_then(|r| r.q8_hidden)),
                5 => count(off.and_then(wrong)),
                _ => count(on.and_then(wrong)),
            }
        }))
    }
}

fn first_leaf(rows: Experiments, figures: &Figures) -> Markup {
    let row = |m: Model, i: usize, setting| rows.tree(Experiment::FirstLeaf, &m.scene(), KINDS[i], setting);
    html! {
        p {
            "The program's traversal ends at the first leaf that reports a hit. Where boxes overlap a nearer surface can lie in another leaf. \
             Pixels of 90,000 that see a farther surface than the closest, or none: first leaf / closest hit, on the same trees."
        }
        (by_model(&kind_names(), |m, i| {
            let of = |setting| row(m, i, setting).and_then(wrong);
            format!("{} / {}", count(of("traversal=first-leaf")), count(of("traversal=closest")))
        }))
        (drawing(figures, "wrong-pixels", "Pixels at which the first leaf with a hit does not hold the closest surface.", html! {
            "Thesis scene, Large, through the six trees of the program: top-down above, bottom-up below, arity 2, 4, 8 from the left. Red: a farther \
             surface is seen; blue: nothing is seen."
        }))
        p .soft { "What the closest hit costs: nodes per pixel, first leaf / closest hit." }
        (by_model(&kind_names(), |m, i| {
            let of = |setting| row(m, i, setting).and_then(|r| r.nodes_per_pixel);
            format!("{} / {}", number(of("traversal=first-leaf"), 4), number(of("traversal=closest"), 4))
        }))
    }
}

fn collapse(rows: Experiments, _: &Figures) -> Markup {
    let cells = PRESETS.map(|p| [4, 8].map(|k| (p, k)));
    let cells: Vec<(&str, usize)> = cells.into_iter().flatten().collect();
    let heads: Vec<String> = cells.iter().map(|(p, k)| format!("{p}, to {k}")).collect();
    html! {
        p { "Microseconds that the collapse takes, the binary tree being there. Beside Table 2, this is what a higher arity costs from the bottom up." }
        (by_model(&heads, |m, i| {
            let (preset, arity) = cells[i];
            let mut all = rows.of(Experiment::Collapse);
            let row = all.find(|r| r.scene == m.scene() && r.preset == preset && r.arity == arity);
            number(row.and_then(|r| r.build_ms).map(|ms| ms * 1e3), 3)
        }))
    }
}

fn origins(rows: Experiments, _: &Figures) -> Markup {
    html! {
        p {
            "The program's trees, traced for the closest hit, secondary rays starting at the hit point: what one reflection / see-through rays \
             change in nodes per pixel. As published, each secondary ray visits the root and nothing else."
        }
        (by_model(&kind_names(), |m, i| {
            let scene = m.scene();
            let nodes = |l| lit(rows, Experiment::Origins, &scene, KINDS[i], l).and_then(|r| r.nodes_per_pixel);
            let change = |l| nodes(l).zip(nodes(Lighting::Primary)).map_or("—".into(), |(a, b)| percent(a / b));
            format!("{} / {}", change(Lighting::Reflection), change(Lighting::Opacity))
        }))
    }
}

/// The lines of a scene of the conjecture: builder, preset, arity and candidates.
const SEARCHES: [(usize, usize); 5] = [(2, 100), (4, 50), (4, 100), (8, 25), (8, 100)];

fn conjecture(rows: Experiments, _: &Figures) -> Markup {
    let scenes = rows.scenes(Experiment::Conjecture);
    html! {
        p {
            "Top-down trees with 100 candidates an axis at every arity, beside the thesis' 50 and 25; rule Q8 off. Below them the best k slabs \
             of one axis and the best k parts of a grid (" code { "kway-slab" } ", " code { "kway-sah" } "), and " code { "sweep-sah" } " with the cheapest collapse. \
             Closest hit, primary rays, one thread."
        }
        @for scene in scenes {
            details {
                summary { (scene) ", " (count(rows.of(Experiment::Conjecture).find(|r| r.scene == scene).map(|r| r.triangles))) " triangles" }
                div .scroll { table .dense {
                    thead { tr {
                        th .name { "Builder" } th { "Arity" } th { "Candidates" } th { "SAH" } th { "Nodes per pixel" } th { "Box and triangle tests" }
                        th { "µs per pixel, scalar" } th { "µs per pixel, wide kernel" }
                    } }
                    tbody {
                        @for preset in PRESETS { @for key in SEARCHES {
                            (conjecture_line(rows.search(Experiment::Conjecture, scene, preset, key)))
                        } }
                        @for id in ["kway-slab", "kway-sah", "sweep-sah"] { @for k in ARITIES { (conjecture_line(rows.yardstick(scene, id, k))) } }
                    }
                } }
            }
        }
    }
}

fn conjecture_line(row: Option<&ExperimentRow>) -> Markup {
    html! {
        @if let Some(r) = row { tr {
            th .name { (r.builder) " " (r.preset) }
            td { (r.arity) }
            td { (count(r.candidates)) }
            td { (number(r.sah, 4)) }
            td { (number(r.nodes_per_pixel, 4)) }
            td { (number(tests(r), 4)) }
            td { (number(r.us_per_pixel, 3)) }
            td { (number(r.wide_us_per_pixel, 3)) }
        } }
    }
}

fn candidates(_: Experiments, figures: &Figures) -> Markup {
    html! {
        p {
            "The tree's cost against the number of candidate ranks (" code { "published" } ") or planes (" code { "text" } "). More is not better where a \
             sum of plain areas decides (" code { "text" } "): it is least where a plane cuts off a few triangles, and more planes offer more such cuts."
        }
        (drawing(figures, "candidates", "SAH against the number of candidates.", html! {
            "SAH against candidates per axis, each line over its own least value."
        }))
    }
}

fn readings(rows: Experiments, _: &Figures) -> Markup {
    let readings = rows.readings();
    html! {
        p {
            "What the text leaves open, tried out: ranks or planes, one axis or mixed ones, areas weighted by triangles or plain; the distance \
             that merges clusters, the rule that collapses; the traversal. Distance is exp(mean |ln(ours ÷ printed)|) − 1 over nodes per pixel of Table 5, \
             Tiny to Large, arity 2, 4 and 8 (rule Q8 off). Ranks and weights on all three axes mixed were not built."
        }
        div .scroll { table .narrow .dense {
            thead { tr { th .name { "Construction" } th .name { "Reading" } th { "Cells" } th { "Distance" } } }
            tbody { @for r in &readings { tr {
                th .name { (r.construction.id()) }
                td .name { (r.name) }
                td { (r.ratios.len()) }
                td { (padded(100.0 * r.distance(), 3)) " %" }
            } } }
        } }
    }
}
