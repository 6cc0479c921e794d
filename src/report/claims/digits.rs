//! Printed digits that cannot be right, found by arithmetic: from other printed figures, or from what rows show must be so.

use super::evidence::{ByModel, Evidence, KINDS, Tree, bottom_up, median, printed_cell, top_down};
use super::{Claim, Finding, Source, Verdict};
use crate::report::PRESETS;
use crate::report::printed::{self, Flag, Model, Printed};
use crate::rows::{Lighting, Status};

pub(super) const CLAIMS: &[Claim] = &[Claim {
    id: "printed-digits",
    statement: "The printed tables can be taken at their digits.",
    quote: "Data Tables",
    place: "Tables 1 to 9",
    predicate: "No printed figure breaks a rule of arithmetic: more rays cost no less, a collapse takes no negative time, top-down times \
                grow with the arity, the sizes are those of Table 1, a secondary ray of the program adds exactly one node, times fit the \
                counted work.",
    decide: digits,
    sources: &[Source::Section("digits", "figures that cannot be right")],
}];

/// A printed figure that breaks a rule.
#[derive(Clone, Debug)]
pub(crate) struct Suspect {
    /// The cell.
    pub cell: &'static Printed,
    /// Which rule it breaks, with the figures.
    pub rule: String,
}

/// Every printed figure that breaks a rule, table by table. Rules about rows are left out where there are none.
pub(crate) fn suspects(ev: &Evidence) -> Vec<Suspect> {
    let mut all = sizes();
    for model in Model::ALL {
        for tree in KINDS.map(|k| k.of(model)) {
            let rules = [bottom_up_below_binary, not_above_smaller_arity, off_the_work, off_the_degree];
            all.extend(rules.iter().filter_map(|rule| rule(ev, tree)));
            for (table, primary) in [(6, 4), (7, 5), (8, 4), (9, 5)] {
                all.extend(less_with_more_rays(tree, table, primary));
            }
            for table in [7, 9] {
                all.extend(not_one_node_a_ray(ev, tree, table));
            }
        }
    }
    all.sort_by_key(|s| (s.cell.table, s.cell.model, s.cell.construction, s.cell.arity));
    all
}

fn value(table: u8, tree: Tree) -> Option<(&'static Printed, f64)> {
    let cell = printed_cell(table, tree)?;
    Some((cell, cell.printed.as_ref()?.value))
}

fn sizes() -> Vec<Suspect> {
    let size = |p: &Printed| p.printed.as_ref().map(|f| f.value);
    let differs = |p: &&Printed| p.is_size_column() && size(p) != Some(p.size as f64);
    let suspect = |cell: &'static Printed| Suspect { cell, rule: format!("Table 1 has {} triangles", cell.size) };
    printed::cells().iter().filter(differs).map(suspect).collect()
}

/// A tree that is collapsed takes the time of the binary one and more; 5 % for noise.
fn bottom_up_below_binary(_: &Evidence, tree: Tree) -> Option<Suspect> {
    let (cell, ours) = value(2, tree)?;
    let (_, binary) = value(2, bottom_up(2).of(tree.model))?;
    let wrong = tree.construction == bottom_up(2).0 && tree.arity > 2 && ours < 0.95 * binary;
    wrong.then(|| Suspect { cell, rule: format!("less than its binary tree ({binary} s), from which it is collapsed") })
}

/// 100 candidates, then 50 choose 3, then 25 choose 7: top-down times grow with the arity.
fn not_above_smaller_arity(_: &Evidence, tree: Tree) -> Option<Suspect> {
    let (cell, ours) = value(2, tree)?;
    let smaller = top_down(tree.arity / 2).of(tree.model);
    let (_, less) = value(2, smaller).filter(|_| tree.construction == top_down(2).0 && tree.arity > 2)?;
    (ours <= less).then(|| Suspect { cell, rule: format!("no more than at arity {} ({less} s)", smaller.arity) })
}

/// Seconds per box union lie within a factor of 4 of their median over all readable cells.
fn off_the_work(ev: &Evidence, tree: Tree) -> Option<Suspect> {
    const FACTOR: f64 = 4.0;
    let rate = |t: Tree| Some(ev.work(PRESETS[0], t)? / value(2, t)?.1);
    let trees = Model::ALL.into_iter().flat_map(|m| KINDS[..3].iter().map(move |k| k.of(m)));
    let ours = rate(tree).filter(|_| tree.construction == top_down(2).0)?;
    let median = median(trees.filter_map(rate));
    let off = !(median / FACTOR..=median * FACTOR).contains(&ours);
    let rule = || {
        let (ours, median) = (ours / 1e6, median / 1e6);
        format!("the counted box unions would be {ours:.1} million a second; the median is {median:.1}")
    };
    if off { Some(Suspect { cell: printed_cell(2, tree)?, rule: rule() }) } else { None }
}

/// Replaying the collapse gives the degree; half a child off is too far.
fn off_the_degree(ev: &Evidence, tree: Tree) -> Option<Suspect> {
    let (cell, theirs) = value(3, tree)?;
    let rows = ev.study.builds_of(PRESETS[0], tree.model, tree.construction, tree.arity);
    let ours = rows.iter().find_map(|r| r.avg_degree.filter(|_| r.status == Status::Ok))?;
    ((ours - theirs).abs() > 0.5).then(|| Suspect { cell, rule: format!("the collapse gives {ours:.2}") })
}

/// Primary rays are traced in every case, so nodes cannot be fewer; times, 10 % for noise, neither.
fn less_with_more_rays(tree: Tree, table: u8, primary: u8) -> Option<Suspect> {
    let ((cell, ours), (_, less)) = (value(table, tree)?, value(primary, tree)?);
    let slack = if printed::is_time(table) { 0.9 } else { 1.0 };
    (ours < slack * less)
        .then(|| Suspect { cell, rule: format!("less than with primary rays alone ({less}, Table {primary})") })
}

/// In the program each secondary ray visits the root and nothing else, so a pixel that hits adds one node.
fn not_one_node_a_ray(ev: &Evidence, tree: Tree, table: u8) -> Option<Suspect> {
    const OFF: f64 = 0.05;
    let ((cell, ours), (_, less)) = (value(table, tree)?, value(5, tree)?);
    let hits = ev.trace(PRESETS[0], tree, Lighting::Primary)?.hit_fraction?;
    let added = ours - less;
    ((added - hits).abs() > OFF).then(|| Suspect {
        cell,
        rule: format!(
            "{added:+.2} nodes against Table 5, but {hits:.2} of the pixels hit, and each of them adds one node"
        ),
    })
}

fn digits(ev: &Evidence, preset: &str) -> Finding {
    if preset != PRESETS[0] {
        return Finding::new(Verdict::Undecided, "The printed digits are the program's: the words have none.");
    }
    let found = suspects(ev);
    let cells = |of: &dyn Fn(&Suspect) -> bool| {
        let mut keys: Vec<_> = found
            .iter()
            .filter(|s| of(s))
            .map(|s| (s.cell.table, s.cell.model, s.cell.construction, s.cell.arity))
            .collect();
        keys.dedup();
        keys.len()
    };
    let all = cells(&|_| true);
    let verdict = if all == 0 { Verdict::Holds } else { Verdict::Corrected };
    let unmarked = cells(&|s| s.cell.flag == Flag::Printed);
    let why = format!(
        "{all} printed figures break a rule; {} of them are corrected or doubted in the data, {unmarked} stand as printed, for want of a better \
         figure.",
        all - unmarked
    );
    let by_table =
        (1..=9).map(|t| (format!("Table {t}"), cells(&|s: &Suspect| s.cell.table == t) as f64)).filter(|x| x.1 > 0.0);
    let times = ByModel::of(|m| Some(ev.printed(6, top_down(2).of(m))? / ev.printed(4, top_down(2).of(m))?));
    Finding::new(verdict, why)
        .with("figures that break a rule", by_table)
        .with("printed time with one reflection ÷ without, top-down 2", times.labelled())
}
