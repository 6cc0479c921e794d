//! Plain advice: which builder for which use, computed from the rows, with the figures that decide it.
//!
//! A build and the rays that are traced through its tree are one bill: `build + rays · time a ray`. Who has the smallest bill depends
//! on the number of rays alone, so the advice is a list of ranges of that number, and a few uses that are points on it.
//! Bills of several scenes are averaged geometrically, so that no scene counts more for being larger.

use super::{Class, Comparison, Entrant, build_ms, bytes_a_triangle, geometric_mean, mrays, positive, ray_ns};
use crate::report::number::{grouped, padded, significant};
use crate::rows::{CompareRow, Spread};

/// A picture of 1920 × 1080 pixels, a primary and a diffuse ray each.
const FRAME: f64 = 2.0 * 1920.0 * 1080.0;

/// Bills are looked at between so many rays, in decades, and at so many numbers a decade.
const DECADES: std::ops::RangeInclusive<i32> = 3..=13;
const STEPS: i32 = 50;

/// Trees within this of the fastest are fast enough to look at their size.
const FAST_ENOUGH: f64 = 0.1;

/// One use.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Advice {
    /// What for.
    pub purpose: String,
    /// Who.
    pub pick: String,
    /// The figures that decide it.
    pub why: String,
}

/// Who has the smallest bill over a range of rays.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Range {
    /// Rays a build, from; none at the lower end.
    pub from: Option<f64>,
    /// To; none at the upper end.
    pub to: Option<f64>,
    /// Who.
    pub pick: String,
    /// Its build time in milliseconds, geometric mean.
    pub build_ms: f64,
    /// Million rays per second, geometric mean.
    pub mrays: f64,
}

/// All that is advised.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Counsel {
    /// Use by use.
    pub uses: Vec<Advice>,
    /// By number of rays.
    pub ranges: Vec<Range>,
    /// Contestants that have no figure on some scene, so that nothing is said of them.
    pub left_out: Vec<String>,
    /// How far measurements can be believed; none where runs were not repeated.
    pub noise: Option<Noise>,
}

/// Relative spreads of measured figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Half the span of the builds of one contestant on one scene.
    pub builds: f64,
    /// The same of rays per second.
    pub rays: f64,
    /// The difference from which two means over the scenes are clearly apart, of builds.
    pub builds_apart: f64,
    /// The same of rays per second.
    pub rays_apart: f64,
}

impl Noise {
    /// Said of a difference that may be none.
    fn doubt(apart: Option<f64>, difference: f64) -> &'static str {
        if apart.is_some_and(|apart| difference.abs() < apart) { " (not clearly apart)" } else { "" }
    }
}

/// A contestant that has a time and a speed on every scene.
struct Candidate<'a> {
    label: &'a str,
    rows: &'a [&'a CompareRow],
    build_ms: f64,
    mrays: f64,
    bytes: Option<f64>,
}

impl Candidate<'_> {
    /// Mean logarithm of the milliseconds that a build and so many rays take.
    fn bill(&self, rays: f64) -> f64 {
        let ms = |row: &&CompareRow| build_ms(row).unwrap_or(0.0) + rays * ray_ns(row).unwrap_or(0.0) * 1e-6;
        self.rows.iter().map(|row| ms(row).ln()).sum::<f64>() / self.rows.len() as f64
    }
}

/// Advice from all rows; none with fewer than two candidates.
pub(crate) fn counsel(comparison: &Comparison) -> Counsel {
    let entrants = comparison.entrants();
    let complete = |e: &&Entrant| {
        e.rows.len() == comparison.scenes.len() && e.rows.iter().all(|r| build_ms(r).is_some() && ray_ns(r).is_some())
    };
    let candidate = |e| -> Option<Candidate> {
        let Entrant { label, rows }: &Entrant = e;
        Some(Candidate {
            label,
            rows,
            build_ms: geometric_mean(rows.iter().filter_map(|r| build_ms(r)))?,
            mrays: geometric_mean(rows.iter().filter_map(|r| mrays(r)))?,
            bytes: geometric_mean(rows.iter().filter_map(|r| bytes_a_triangle(r))),
        })
    };
    let candidates: Vec<_> = entrants.iter().filter(complete).filter_map(candidate).collect();
    let left_out = entrants.iter().filter(|e| !complete(e)).map(|e| e.label.clone()).collect();
    if candidates.len() < 2 {
        return Counsel { left_out, ..Counsel::default() };
    }
    let ranges = ranges(&candidates);
    let noise = noise(&candidates);
    let (builds, rays) = (noise.map(|n| n.builds_apart), noise.map(|n| n.rays_apart));
    let mut uses =
        vec![every_frame(&candidates, rays), fastest_build(&candidates, builds), trace_much(&candidates, rays)];
    uses.extend(least_cost(comparison, &entrants));
    uses.extend(memory(&candidates));
    Counsel { uses, ranges, left_out, noise }
}

/// The first two by what `of` says, the less the better.
fn first_two<'a, 'b>(all: &'b [Candidate<'a>], of: impl Fn(&Candidate) -> f64) -> [&'b Candidate<'a>; 2] {
    let mut order: Vec<_> = all.iter().collect();
    order.sort_by(|a, b| of(a).total_cmp(&of(b)));
    [order[0], order[1]]
}

fn every_frame(all: &[Candidate], apart: Option<f64>) -> Advice {
    let [first, second] = first_two(all, |c| c.bill(FRAME));
    let (bill, next) = (first.bill(FRAME).exp(), second.bill(FRAME).exp());
    let share = first.build_ms / bill;
    Advice {
        purpose: format!("Built for every frame ({} million rays a build)", significant(FRAME / 1e6, 2)),
        pick: first.label.into(),
        why: format!(
            "build and rays together take {}, of which the build is {}; next is {}, {} more{}",
            ms(bill),
            percent(share),
            second.label,
            percent(next / bill - 1.0),
            Noise::doubt(apart, next / bill - 1.0)
        ),
    }
}

fn fastest_build(all: &[Candidate], apart: Option<f64>) -> Advice {
    let [first, second] = first_two(all, |c| c.build_ms);
    let fastest = all.iter().map(|c| c.mrays).fold(0.0, f64::max);
    Advice {
        purpose: "Built as fast as can be".into(),
        pick: first.label.into(),
        why: format!(
            "{}; next is {}, which takes {} times as long{}; rays through its tree are {} slower than through the fastest",
            ms(first.build_ms),
            second.label,
            padded(second.build_ms / first.build_ms, 3),
            Noise::doubt(apart, second.build_ms / first.build_ms - 1.0),
            percent(1.0 - first.mrays / fastest)
        ),
    }
}

fn trace_much(all: &[Candidate], apart: Option<f64>) -> Advice {
    let [first, second] = first_two(all, |c| -c.mrays);
    let [frame, _] = first_two(all, |c| c.bill(FRAME));
    let pays = steps().find(|&rays| first.bill(rays) < frame.bill(rays));
    let pays = match pays.filter(|_| frame.label != first.label) {
        Some(rays) => format!("; it pays for itself over {} from {} rays a build on", frame.label, many(rays)),
        None => String::new(),
    };
    Advice {
        purpose: "Built once, traced for as long as you like".into(),
        pick: first.label.into(),
        why: format!(
            "{} million rays/s; next is {}, {} slower{}; its build takes {}{pays}",
            padded(first.mrays, 3),
            second.label,
            percent(1.0 - second.mrays / first.mrays),
            Noise::doubt(apart, 1.0 - second.mrays / first.mrays),
            ms(first.build_ms)
        ),
    }
}

/// The least SAH of the main class, whatever it takes to build; trees from files, too.
fn least_cost(comparison: &Comparison, entrants: &[Entrant]) -> Option<Advice> {
    let class = comparison.main_class()?;
    let cost = |e: &Entrant| {
        let all = e.rows.len() == comparison.scenes.len() && e.rows.iter().all(|r| Class::of(r) == class);
        let costs: Vec<f64> = e.rows.iter().filter_map(|r| positive(r.sah)).collect();
        geometric_mean(costs.iter().copied()).filter(|_| all && costs.len() == e.rows.len())
    };
    let mut order: Vec<_> = entrants.iter().filter_map(|e| Some((cost(e)?, e))).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(least, first), (next, second), ..] = order[..] else { return None };
    let rate = |e: &Entrant| geometric_mean(e.rows.iter().filter_map(|r| mrays(r)));
    let fastest = order.iter().filter_map(|(_, e)| Some((rate(e)?, e))).max_by(|a, b| a.0.total_cmp(&b.0));
    let speed = match (rate(first), fastest) {
        (Some(_), Some((_, fastest))) if fastest.label == first.label => {
            "; rays are fastest through it, too".to_owned()
        }
        (Some(rate), Some((most, fastest))) => {
            format!("; yet rays are {} slower through it than through {}", percent(1.0 - rate / most), fastest.label)
        }
        _ => String::new(),
    };
    Some(Advice {
        purpose: format!("The least SAH (arity {}, leaves of {})", class.arity, class.leaf_limit),
        pick: first.label.clone(),
        why: format!("SAH {}; next is {}, {} more{speed}", padded(least, 4), second.label, percent(next / least - 1.0)),
    })
}

/// The smallest tree among those that are fast enough.
fn memory(all: &[Candidate]) -> Option<Advice> {
    let fastest = all.iter().map(|c| c.mrays).fold(0.0, f64::max);
    let fast = |c: &&Candidate| c.mrays >= (1.0 - FAST_ENOUGH) * fastest;
    let smaller = |a: &&Candidate, b: &&Candidate| {
        a.bytes.unwrap_or(f64::MAX).total_cmp(&b.bytes.unwrap_or(f64::MAX)).then(b.mrays.total_cmp(&a.mrays))
    };
    let pick = all.iter().filter(fast).min_by(smaller)?;
    let least = all.iter().min_by(smaller)?;
    let size = |c: &Candidate| c.bytes.map_or_else(|| "–".into(), |b| padded(b, 3));
    let least_of_all = match least.label == pick.label {
        true => "; no tree is smaller".to_owned(),
        false => format!(
            "; the smallest of all is that of {}, {} bytes, with rays {} slower",
            least.label,
            size(least),
            percent(1.0 - least.mrays / fastest)
        ),
    };
    Some(Advice {
        purpose: format!("Memory is tight (rays at most {} slower than the fastest)", percent(FAST_ENOUGH)),
        pick: pick.label.into(),
        why: format!(
            "{} bytes a triangle, rays {} slower than the fastest{least_of_all}",
            size(pick),
            percent(1.0 - pick.mrays / fastest)
        ),
    })
}

fn steps() -> impl Iterator<Item = f64> {
    (DECADES.start() * STEPS..=DECADES.end() * STEPS).map(|i| 10f64.powf(f64::from(i) / f64::from(STEPS)))
}

fn ranges(all: &[Candidate]) -> Vec<Range> {
    let mut ranges: Vec<Range> = Vec::new();
    for rays in steps() {
        let [first, _] = first_two(all, |c| c.bill(rays));
        if ranges.last().is_some_and(|r| r.pick == first.label) {
            continue;
        }
        let from = ranges.last_mut().map(|last| {
            last.to = Some(rays);
            rays
        });
        let (pick, build_ms, mrays) = (first.label.to_owned(), first.build_ms, first.mrays);
        ranges.push(Range { from, to: None, pick, build_ms, mrays });
    }
    ranges
}

/// Estimated from the spans of all candidates' runs.
fn noise(all: &[Candidate]) -> Option<Noise> {
    let rows = || all.iter().flat_map(|c| c.rows);
    let scenes = all.first()?.rows.len();
    let (builds, builds_apart) = typical(rows().filter_map(|r| r.build()), scenes)?;
    let (rays, rays_apart) = typical(rows().flat_map(|r| [r.primary(), r.diffuse()]).flatten(), scenes)?;
    Some(Noise { builds, rays, builds_apart, rays_apart })
}

/// Median half-span relative to the median of the runs, and the difference from which two geometric means over scenes are apart:
/// two standard errors, taking runs as normal.
fn typical(spreads: impl Iterator<Item = Spread>, scenes: usize) -> Option<(f64, f64)> {
    let one = |s: Spread| {
        let half = 0.5 * (s.max - s.min) / s.median;
        let sigma = 2.0 * half / expected_span(s.runs);
        // The median of n normal values has π/2 of the variance of their mean.
        let error = sigma * (std::f64::consts::FRAC_PI_2 / s.runs as f64).sqrt();
        (half, 2.0 * (2.0 / scenes as f64).sqrt() * error)
    };
    let mut all: Vec<_> = spreads.filter(|s| s.runs > 1 && s.median > 0.0).map(one).collect();
    let middle = all.len() / 2;
    let mut median = |of: fn(&(f64, f64)) -> f64| {
        all.sort_by(|a, b| of(a).total_cmp(&of(b)));
        all.get(middle).map(of)
    };
    Some((median(|x| x.0)?, median(|x| x.1)?))
}

/// Expected span of n values of the standard normal distribution (Tippett 1925).
fn expected_span(n: usize) -> f64 {
    const SPANS: [f64; 9] = [1.128, 1.693, 2.059, 2.326, 2.534, 2.704, 2.847, 2.970, 3.078];
    SPANS[n.saturating_sub(2).min(SPANS.len() - 1)]
}

/// A share in percent: to a tenth below 10 %.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let text = if percent.abs() < 9.95 { format!("{percent:.1}") } else { grouped(&format!("{percent:.0}")) };
    format!("{} %", text.replace('-', "−"))
}

fn ms(milliseconds: f64) -> String {
    match milliseconds {
        ms if ms < 1000.0 => format!("{} ms", padded(ms, 3)),
        ms => format!("{} s", padded(ms / 1e3, 3)),
    }
}

/// A number of rays in words: three digits at most.
pub(crate) fn many(rays: f64) -> String {
    let (unit, name) = match rays {
        r if r >= 0.995e9 => (1e9, " billion"),
        r if r >= 0.995e6 => (1e6, " million"),
        _ => (1.0, ""),
    };
    format!("{}{name}", grouped(&significant(rays / unit, 2)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_words() {
        assert_eq!(
            [950.0, 1e5, 2.34e6, 9.99e8, 1.5e11].map(many),
            ["950", "100,000", "2.3 million", "1 billion", "150 billion"]
        );
        assert_eq!([0.001, 0.0996, 0.5, 12.0].map(percent), ["0.1 %", "10 %", "50 %", "1,200 %"]);
        assert_eq!([0.5, 1500.0].map(ms), ["0.500 ms", "1.50 s"]);
    }
}
