//! The gate: rows of a comparison held against those of an earlier one, for other people's continuous integration.

use crate::report::number::significant;
use crate::rows::{CompareRow, Row, Status};
use std::fmt;
use std::str::FromStr;

/// What a figure depends on besides the tree: two rows compare only where they have that in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Under {
    /// Nothing.
    Anything,
    /// The threads of the build.
    Build,
    /// The rays and the kernel.
    Rays,
    /// These, and the threads that traced.
    Trace,
}

/// A figure that can be bounded.
#[derive(Clone, Copy, Debug)]
struct Metric {
    name: &'static str,
    under: Under,
    of: fn(&CompareRow) -> Option<f64>,
}

fn float(count: Option<usize>) -> Option<f64> {
    count.map(|n| n as f64)
}

const METRICS: &[Metric] = &[
    Metric { name: "build_ms", under: Under::Build, of: |r| r.build_ms },
    Metric { name: "sah", under: Under::Anything, of: |r| r.sah },
    Metric { name: "epo", under: Under::Anything, of: |r| r.epo },
    Metric { name: "lcv", under: Under::Rays, of: |r| r.lcv },
    Metric { name: "inner", under: Under::Anything, of: |r| float(r.inner) },
    Metric { name: "leaves", under: Under::Anything, of: |r| float(r.leaves) },
    Metric { name: "max_depth", under: Under::Anything, of: |r| float(r.max_depth) },
    Metric { name: "peak_bytes", under: Under::Build, of: |r| float(r.peak_bytes) },
    Metric { name: "bytes", under: Under::Anything, of: |r| float(r.bytes) },
    Metric { name: "primary_nodes", under: Under::Rays, of: |r| r.primary_nodes },
    Metric { name: "primary_box_tests", under: Under::Rays, of: |r| r.primary_box_tests },
    Metric { name: "primary_tri_tests", under: Under::Rays, of: |r| r.primary_tri_tests },
    Metric { name: "primary_mrays", under: Under::Trace, of: |r| r.primary_mrays },
    Metric { name: "diffuse_nodes", under: Under::Rays, of: |r| r.diffuse_nodes },
    Metric { name: "diffuse_box_tests", under: Under::Rays, of: |r| r.diffuse_box_tests },
    Metric { name: "diffuse_tri_tests", under: Under::Rays, of: |r| r.diffuse_tri_tests },
    Metric { name: "diffuse_mrays", under: Under::Trace, of: |r| r.diffuse_mrays },
];

/// Every kind of counted work on its own.
const WORK: &str = "work";

/// Whether the tree is the same.
const TREE: &str = "tree";

/// What a bound is about.
#[derive(Clone, Copy, Debug)]
enum Subject {
    Metric(Metric),
    Work,
    Tree,
}

/// One bound, as `--fail-if` takes it: `sah>1%` is violated where a figure is more than 1 % above the baseline's,
/// `primary_mrays<10%` where it is more than 10 % below, `tree` where the tree is another one.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    subject: Subject,
    /// Whether a greater figure is the worse one.
    above: bool,
    /// Percent that are allowed.
    percent: f64,
}

impl Bound {
    /// What can be bounded, in the order of the columns.
    pub fn subjects() -> impl Iterator<Item = &'static str> {
        METRICS.iter().map(|m| m.name).chain([WORK, TREE])
    }
}

impl FromStr for Bound {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let word = word.trim();
        if word == TREE {
            return Ok(Self { subject: Subject::Tree, above: true, percent: 0.0 });
        }
        let form =
            || format!("'{word}' is no bound: METRIC>PERCENT%, METRIC<PERCENT% or tree are wanted, such as sah>1%");
        let at = word.find(['>', '<']).ok_or_else(form)?;
        let (name, above) = (word[..at].trim(), word[at..].starts_with('>'));
        let percent = word[at + 1..].trim().strip_suffix('%').ok_or_else(form)?.trim();
        let percent = percent.parse().ok().filter(|p: &f64| p.is_finite() && *p >= 0.0 && (above || *p <= 100.0));
        let percent = percent.ok_or_else(form)?;
        let subject = match METRICS.iter().find(|m| m.name == name) {
            Some(metric) => Subject::Metric(*metric),
            None if name == WORK => Subject::Work,
            None => {
                let names: Vec<_> = Self::subjects().collect();
                return Err(format!("there is no figure '{name}' to bound; there are {}", names.join(", ")));
            }
        };
        Ok(Self { subject, above, percent })
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.subject {
            Subject::Tree => return f.write_str(TREE),
            Subject::Work => WORK,
            Subject::Metric(metric) => metric.name,
        };
        write!(f, "{name}{}{}%", if self.above { '>' } else { '<' }, self.percent)
    }
}

/// What the gate found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// One line for each bound that a row violates, each baseline row without a counterpart, each pair that does not compare.
    pub violations: Vec<String>,
    /// Figures that were held against the baseline's.
    pub compared: usize,
    /// Rows that the baseline does not know.
    pub unknown: usize,
}

/// Holds `rows` to `bounds` against `baseline`. Rows match by scene, recipe, reading, engine, arity and leaf limit; a baseline
/// row without a counterpart is a violation unless `allow_missing`. Figures that the baseline row does not have are not looked at.
pub fn check(rows: &[CompareRow], baseline: &[CompareRow], bounds: &[Bound], allow_missing: bool) -> Verdict {
    let mut verdict = Verdict {
        unknown: rows.iter().filter(|r| baseline.iter().all(|b| b.key() != r.key())).count(),
        ..Verdict::default()
    };
    for base in baseline {
        match rows.iter().find(|r| r.key() == base.key()) {
            Some(row) => pair(row, base, bounds, &mut verdict),
            None if allow_missing => {}
            None => verdict.violations.push(format!("{}: in the baseline, but not compared now", base.key())),
        }
    }
    if verdict.compared == 0 && verdict.violations.is_empty() {
        verdict
            .violations
            .push("nothing of the baseline was compared: no row has a counterpart with these figures".into());
    }
    verdict
}

fn pair(row: &CompareRow, base: &CompareRow, bounds: &[Bound], verdict: &mut Verdict) {
    let key = base.key();
    if row.scene_hash != base.scene_hash {
        let (now, then) = (row.triangles, base.triangles);
        verdict
            .violations
            .push(format!("{key}: the scene is another one: {now} triangles now, {then} in the baseline"));
        return;
    }
    if base.status == Status::Ok && row.status != Status::Ok {
        verdict.violations.push(format!("{key}: {} now ({}), fine in the baseline", row.status.id(), row.note));
        return;
    }
    for bound in bounds {
        let violation = match bound.subject {
            Subject::Metric(metric) => {
                if (metric.of)(base).is_none() {
                    continue;
                }
                verdict.compared += 1;
                different_conditions(metric.under, row, base)
                    .map(|why| format!("{} does not compare: {why}", metric.name))
                    .or_else(|| bound.violated(metric.name, (metric.of)(row), (metric.of)(base)))
            }
            Subject::Work => {
                let now = |kind: &str| row.work().find(|w| w.0 == kind).map_or(0.0, |w| w.1 as f64);
                let then = |kind: &str| base.work().find(|w| w.0 == kind).map_or(0.0, |w| w.1 as f64);
                // A kind that the baseline does not have was 0 there.
                let fresh = row.work().map(|w| w.0).filter(|kind| base.work().all(|b| b.0 != *kind));
                let kinds: Vec<&str> = base.work().map(|w| w.0).chain(fresh).collect();
                verdict.compared += kinds.len();
                let lines = kinds.iter().filter_map(|kind| bound.violated(kind, Some(now(kind)), Some(then(kind))));
                verdict.violations.extend(lines.map(|line| format!("{key}: {line}")));
                continue;
            }
            Subject::Tree => {
                verdict.compared += 1;
                let hash = |r: &CompareRow| r.tree_hash.clone().unwrap_or_else(|| "none".into());
                (row.tree_hash != base.tree_hash)
                    .then(|| format!("the tree is another one: {} now, {} in the baseline", hash(row), hash(base)))
            }
        };
        verdict.violations.extend(violation.map(|line| format!("{key}: {line}")));
    }
}

fn different_conditions(under: Under, row: &CompareRow, base: &CompareRow) -> Option<String> {
    let differ = |what: &str, now: &dyn fmt::Display, then: &dyn fmt::Display| {
        let (now, then) = (now.to_string(), then.to_string());
        (now != then).then(|| format!("{what} {now} now, {then} in the baseline"))
    };
    let rays = || {
        differ("kernel", &row.kernel, &base.kernel)
            .or_else(|| differ("pixels", &row.pixels, &base.pixels))
            .or_else(|| differ("primary rays", &row.primary_rays, &base.primary_rays))
            .or_else(|| differ("diffuse rays", &row.diffuse_rays, &base.diffuse_rays))
    };
    match under {
        Under::Anything => None,
        Under::Build => differ("threads", &row.threads, &base.threads),
        Under::Rays => rays(),
        Under::Trace => rays().or_else(|| differ("threads", &row.trace_threads, &base.trace_threads)),
    }
}

impl Bound {
    fn violated(&self, name: &str, now: Option<f64>, then: Option<f64>) -> Option<String> {
        let then = then?;
        let Some(now) = now else {
            return Some(format!("{name} has no figure now, {} in the baseline", significant(then, 6)));
        };
        let (limit, side) = match self.above {
            true => (then * (1.0 + self.percent / 100.0), "above"),
            false => (then * (1.0 - self.percent / 100.0), "below"),
        };
        /// What rounding does to a limit is no violation.
        const ROUNDING: f64 = 1e-12;
        let beyond = if self.above { now > limit * (1.0 + ROUNDING) } else { now < limit * (1.0 - ROUNDING) };
        if !beyond {
            return None;
        }
        let by = match then {
            0.0 => String::new(),
            _ => format!("{} % ", significant(100.0 * (now / then - 1.0).abs(), 3)),
        };
        Some(format!(
            "{name} {} is {by}{side} {} of the baseline, {} % is allowed",
            significant(now, 6),
            significant(then, 6),
            self.percent
        ))
    }
}
