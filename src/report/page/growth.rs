//! Growth on the page: why the original builds grew, and time and work against size.

use super::drawing;
use crate::report::figures::Figures;
use crate::report::growth::Growth;
use crate::report::growth::exponents::Exponent;
use crate::report::growth::laws::{Law, Residual, usage};
use crate::report::growth::samples::{CAP_SECONDS, Times};
use crate::report::number::{grouped, padded, significant};
use crate::report::printed::Flag;
use crate::rows::{Construction, ScalingRow, Status};
use maud::{Markup, html};

/// What the page tells of growth.
#[derive(Clone, Copy)]
pub(crate) struct Fits<'a> {
    /// The rows.
    pub growth: &'a Growth,
    /// Times as constants times counts.
    pub laws: &'a [Law],
    /// Each cell against its law.
    pub residuals: &'a [Residual],
    /// Exponents.
    pub exponents: &'a [Exponent],
}

/// Figure 4 with both engines.
pub(crate) fn figure4_extended(figures: &Figures, preset: &str, name: &str) -> Markup {
    let label = "Figure 4 extended: build times of the literal and of the exact engines.";
    drawing(
        figures,
        name,
        label,
        html! {
            "Figure 4 extended (preset " (preset) "). The same trees by the literal engines, which do the thesis' work (rings: projected), and by the exact \
             engines, which find the same choices without it."
        },
    )
}

/// Both sections; nothing where no row is about growth.
pub(crate) fn sections(fits: &Fits, figures: &Figures) -> Markup {
    html! {
        @if !fits.growth.work.is_empty() { (why(fits, figures)) }
        @if !fits.growth.scaling.is_empty() { (scaling(fits, figures)) }
    }
}

fn why(fits: &Fits, figures: &Figures) -> Markup {
    let main =
        |construction| fits.laws.iter().find(|l| l.main && l.times == Times::Printed && l.construction == construction);
    html! {
        h2 id="why" { "Why the original builds grew" }
        p {
            "The thesis reports how its build times grew and leaves open why. Here the work of its program is counted, for each of its \
             trees, and one constant an algorithm turns the count into seconds. What the constant leaves over is shown."
        }
        @if let Some(law) = main(Construction::TopDown) {
            p {
                b { "Top-down. " }
                "For every combination of splits the program united the boxes of all triangles of the node again: combinations \
                 times triangles, summed over the nodes of the tree. "
                (verdict(fits, law))
            }
        }
        @if let Some(law) = main(Construction::BottomUp) {
            p {
                b { "Bottom-up. " }
                "For every search of a nearest cluster the program walked a kd-tree that was never balanced and kept its dead entries, and \
                 put every cluster within a radius that spans most of the scene into a sorted list, by walking the list. "
                (verdict(fits, law))
            }
        }
        (given_up(fits))
        (drawing(figures, "why", "Seconds taken against seconds predicted from counted work.", html! {
            "Each point is one build: seconds taken against the count of its work times its algorithm's constant. Left the printed times against the \
             work of the program; right our literal engines against their own, where the constant is one an arity, as what combinations have \
             in common is computed once."
        }))
        h3 id="constants" { "One constant an algorithm" }
        p .soft {
            "Explained: the share of the variance of log time that the count explains with this one constant; negative where the count does worse than \
             no count. Spread: the standard deviation of what is left, as a factor. Rows in pale letters are counts to compare with. "
            a href="tables/why.csv" { "CSV" }
        }
        (constants(fits))
        h3 id="columns" { "Growth with the scene, column by column" }
        p .soft {
            "Exponents of the number of triangles, least squares in log-log, with 95 % confidence intervals (Student's t). Doubtful prints are left out."
        }
        (columns(fits))
        (cells(fits))
    }
}

/// What a law explains, and what the counts beside it do.
fn verdict(fits: &Fits, law: &Law) -> Markup {
    let others: Vec<&Law> =
        fits.laws.iter().filter(|l| !l.main && l.times == law.times && l.construction == law.construction).collect();
    let worst = worst(fits, law);
    html! {
        "These " (law.count.unit) "s at " (nanoseconds(law.fit.constant)) " each give the " (law.fit.points) " printed times, which span a factor of "
        (grouped(&significant(law.fit.span, 3))) ", to within a factor of " (padded(law.fit.spread, 3)) " (one standard deviation): they explain "
        b { (share(law.fit.explained)) } " of the variance of log time. "
        @if let Some(worst) = worst {
            "Farthest off is " (cell_name(worst)) ", which took " (padded(worst.ratio(), 3)) " times as long as predicted. "
        }
        @if !others.is_empty() {
            "To compare: "
            @for (i, other) in others.iter().enumerate() {
                @if i > 0 { ", " }
                (other.count.name) " " (share(other.fit.explained))
            }
            "."
        }
    }
}

fn worst<'a>(fits: &'a Fits, law: &Law) -> Option<&'a Residual> {
    let of = fits
        .residuals
        .iter()
        .filter(|r| r.sample.times == law.times && r.sample.construction == law.construction && r.sample.fits());
    of.max_by(|a, b| a.ratio().ln().abs().total_cmp(&b.ratio().ln().abs()))
}

/// The builds that the thesis gave up, with what they would have taken.
fn given_up(fits: &Fits) -> Markup {
    // From the bottom up, one stands for all: the arities share the work.
    let told = |r: &&Residual| r.sample.construction == Construction::TopDown || r.sample.arity == 2;
    let capped: Vec<&Residual> = fits.residuals.iter().filter(|r| r.sample.flag == Flag::Capped).filter(told).collect();
    html! {
        @if !capped.is_empty() {
            p {
                b { "Given up. " }
                "The thesis stopped these builds after eleven days; by the same constants they would have taken: "
                @for (i, r) in capped.iter().enumerate() {
                    @if i > 0 { "; " }
                    (cell_name(r)) " " b { (padded(r.predicted / 86_400.0, 3)) " days" }
                    @if r.sample.extrapolated { " (work continued by a power law from smaller scenes)" }
                    (against_the_cap(fits, r))
                }
                "."
            }
        }
    }
}

/// What to make of a prediction below the eleven days that the build was given.
fn against_the_cap(fits: &Fits, r: &Residual) -> &'static str {
    let of = |l: &&Law| l.main && l.times == r.sample.times && l.construction == r.sample.construction;
    let spread = fits.laws.iter().find(of).map_or(1.0, |l| l.fit.spread);
    match CAP_SECONDS / r.predicted {
        short if short <= 1.0 => "",
        short if short <= spread.powi(2) => ", short of eleven by no more than twice the spread of the others",
        _ => {
            ", far short of eleven: the count does not explain this one (the scene's file is lost; ours has its size alone)"
        }
    }
}

fn constants(fits: &Fits) -> Markup {
    html! {
        div .scroll { table {
            thead { tr {
                th .name { "Times" } th .name { "Algorithm" } th .name { "Arity" } th .name { "Count" } th { "Builds" } th { "Times span" }
                th { "Constant" } th { "Explained" } th { "Spread" } th { "Worst ratio" }
            } }
            tbody { @for l in fits.laws {
                tr .soft[!l.main] {
                    td .name { (l.times.id()) }
                    td .name { (l.construction.id()) " " (l.preset) }
                    td .name { (l.arities()) }
                    td .name { (l.count.name) }
                    td { (l.fit.points) }
                    td { (grouped(&significant(l.fit.span, 3))) " ×" }
                    td { (nanoseconds(l.fit.constant)) }
                    td { (share(l.fit.explained)) }
                    td { (padded(l.fit.spread, 3)) " ×" }
                    td { (padded(l.fit.worst, 3)) }
                }
            } }
        } }
    }
}

fn columns(fits: &Fits) -> Markup {
    let of = |builder: &str, arity: usize, time: bool| {
        fits.exponents.iter().find(|e| {
            e.engine == "printed" && e.builder == builder && e.arity == arity && (e.quantity == "time") == time
        })
    };
    let cell = |e: Option<&Exponent>| e.map_or("—".to_owned(), interval);
    let column = |c: Construction| [2, 4, 8].map(|k| (c.id(), k));
    html! {
        div .scroll { table {
            thead { tr {
                th .name { "Column of Table 2" } th { "Printed time grows as n to the" } th { "Counted work grows as n to the" } th { "Cells: times, work" }
            } }
            tbody { @for (builder, k) in column(Construction::TopDown).into_iter().chain(column(Construction::BottomUp)) {
                @let (time, work) = (of(builder, k, true), of(builder, k, false));
                tr {
                    th .name { (builder) ", " (k) }
                    td { (cell(time)) }
                    td { (cell(work)) }
                    td { (time.map_or(0, |e| e.law.points)) ", " (work.map_or(0, |e| e.law.points)) }
                }
            } }
        } }
    }
}

fn cells(fits: &Fits) -> Markup {
    html! {
        details id="residuals" {
            summary { "Every build against its prediction (" (fits.residuals.len()) ")" }
            p .soft { a href="tables/why-cells.csv" { "CSV" } }
            div .scroll { table {
                thead { tr {
                    th .name { "Times" } th .name { "Build" } th { "Count" } th { "Seconds predicted" } th { "Seconds taken" } th { "Ratio" } th .name { "Use" }
                } }
                tbody { @for r in fits.residuals { tr {
                    td .name { (r.sample.times.id()) }
                    td .name { (cell_name(r)) @if r.sample.times == Times::Ours { ", " (r.sample.preset) } }
                    td { (grouped(&significant(r.count, 3))) }
                    td { (grouped(&padded(r.predicted, 3))) }
                    td { @if r.sample.flag == Flag::Capped { "> " } (grouped(&padded(r.sample.seconds, 3))) }
                    td { @if r.sample.flag == Flag::Capped { "> " } (padded(r.ratio(), 3)) }
                    td .name { (usage(&r.sample)) }
                } } }
            } }
        }
    }
}

fn scaling(fits: &Fits, figures: &Figures) -> Markup {
    let rows = &fits.growth.scaling;
    let families: Vec<&str> = rows.iter().fold(Vec::new(), |mut all, r| {
        if !all.contains(&r.family.as_str()) {
            all.push(&r.family);
        }
        all
    });
    let of = |status| rows.iter().filter(|r| r.status == status).count();
    let twins = rows.iter().filter(|r| r.engine == "exact").filter_map(|exact| {
        let cell = |r: &ScalingRow| (r.scene.clone(), r.builder.clone(), r.preset.clone(), r.arity);
        let literal = rows.iter().find(|r| r.engine == "literal" && cell(r) == cell(exact))?;
        Some(literal.tree_hash.as_ref()? == exact.tree_hash.as_ref()?)
    });
    let (same, both) = twins.fold((0, 0), |(same, both), equal| (same + usize::from(equal), both + 1));
    html! {
        h2 id="scaling" { "Time and work against size" }
        p {
            "Every builder, reading and engine on scenes " code { (families.join(", ")) } " of growing size: " (of(Status::Ok)) " measured, "
            (of(Status::Projected)) " projected, " (of(Status::Capped)) " capped, " (of(Status::Error)) " failed. Where a literal and an exact \
             engine both finished, their trees' hashes are compared: " (same) " of " (both) " are equal."
        }
        (drawing(figures, "scaling-time", "Build time against the number of triangles.", html! {
            "Build time against the number of triangles, literal engines dotted, exact ones unbroken."
        }))
        (drawing(figures, "scaling-work", "Work against the number of triangles.", html! {
            "Work counted against the number of triangles; below, what the thesis' program would have done for the same trees."
        }))
        h3 id="exponents" { "Exponents" }
        p .soft {
            "Fitted over all finished sizes, with 95 % confidence intervals. n log n over three decades from a thousand has an exponent of about 1.1. \
             Per triangle: the greatest size's time per triangle over the smallest's. All counts: "
            a href="tables/scaling.csv" { "CSV" } "."
        }
        (exponents(fits))
    }
}

fn exponents(fits: &Fits) -> Markup {
    let times = fits.exponents.iter().filter(|e| e.engine != "printed" && e.quantity == "time");
    let same = |e: &Exponent, quantity: &str| {
        let key = |x: &Exponent| (x.family.clone(), x.builder.clone(), x.preset.clone(), x.arity, x.engine.clone());
        fits.exponents.iter().find(|x| x.quantity == quantity && key(x) == key(e)).map_or("—".to_owned(), interval)
    };
    html! {
        div .scroll { table {
            thead { tr {
                th .name { "Series" } th { "Sizes" } th { "From, to" } th { "Time grows as n to the" } th { "Steps grow as n to the" }
                th { "The literal engine's steps for these trees" } th { "Time per triangle" }
            } }
            tbody { @for e in times { tr {
                th .name {
                    (e.builder) " " (e.preset) " " (e.arity)
                    @if !e.engine.is_empty() { ", " (e.engine) }
                    @if fits.exponents.iter().any(|x| x.engine != "printed" && x.family != e.family) { " (" (e.family) ")" }
                }
                td { (e.law.points) }
                td { (grouped(&e.law.range.0.round().to_string())) ", " (grouped(&e.law.range.1.round().to_string())) }
                td { (interval(e)) }
                td { (same(e, "steps")) }
                td { (same(e, "literal_steps")) }
                td { (padded(e.per_triangle, 3)) " ×" }
            } } }
        } }
    }
}

/// An exponent with its interval.
fn interval(e: &Exponent) -> String {
    match e.law.half_width {
        Some(h) => format!("{:.2} ± {:.2}", e.law.exponent, h),
        None => format!("{:.2}", e.law.exponent),
    }
}

fn share(explained: Option<f64>) -> String {
    explained.map_or("—".to_owned(), |x| format!("{:.1} %", 100.0 * x).replace('-', "−"))
}

fn nanoseconds(seconds: f64) -> String {
    match seconds {
        s if s < 1e-9 => format!("{} ps", padded(s * 1e12, 3)),
        s if s < 1e-6 => format!("{} ns", padded(s * 1e9, 3)),
        s if s < 1e-3 => format!("{} µs", padded(s * 1e6, 3)),
        s => format!("{} ms", padded(s * 1e3, 3)),
    }
}

fn cell_name(r: &Residual) -> String {
    let s = &r.sample;
    format!("{}, {} arity {}", s.scene.trim_start_matches("thesis:"), s.construction.id(), s.arity)
}
