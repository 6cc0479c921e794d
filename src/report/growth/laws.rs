//! Laws: time as one constant times a count, and how much of the growth that leaves to explain.

use super::Growth;
use super::samples::{Sample, Times};
use crate::report::fit::Proportion;
use crate::report::number::significant;
use crate::rows::Construction;

/// A count that may explain times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Count {
    /// Its name in tables.
    pub name: &'static str,
    /// One of it.
    pub unit: &'static str,
    /// Its value; none where the rows do not hold it.
    pub of: fn(&Sample) -> Option<f64>,
}

const UNIONS: Count =
    Count { name: "box unions (combinations × triangles of the node)", unit: "box union", of: |s| s.work };
const COMBINATIONS: Count = Count { name: "combinations alone", unit: "combination", of: |s| s.steps };
const TRIANGLES: Count = Count { name: "triangles alone", unit: "triangle", of: |s| Some(s.triangles) };
const KD_STEPS: Count = Count { name: "kd-tree visits and list walks (replayed)", unit: "step", of: |s| s.work };
const SQUARES: Count = Count { name: "triangles squared", unit: "triangle²", of: |s| Some(s.triangles.powi(2)) };
const CUBES: Count = Count { name: "triangles cubed", unit: "triangle³", of: |s| Some(s.triangles.powi(3)) };
const LITERAL_COMBINATIONS: Count = Count { name: "combinations (closed form)", unit: "combination", of: |s| s.steps };
const DISTANCES: Count =
    Count { name: "distances (closed form; the chain's as counted)", unit: "distance", of: |s| s.steps };

/// One algorithm's times against one count.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    /// Whose times.
    pub times: Times,
    /// Top-down or bottom-up.
    pub construction: Construction,
    /// Reading.
    pub preset: String,
    /// Arities that share the constant.
    pub arities: Vec<usize>,
    /// The count.
    pub count: Count,
    /// Whether it is the one that the code says, not one to compare with.
    pub main: bool,
    /// The fit.
    pub fit: Proportion,
}

/// A cell against its algorithm's main law.
#[derive(Clone, Debug)]
pub(crate) struct Residual {
    /// The cell.
    pub sample: Sample,
    /// Its count.
    pub count: f64,
    /// Seconds by the law.
    pub predicted: f64,
}

impl Residual {
    /// Seconds taken over seconds predicted.
    pub fn ratio(&self) -> f64 {
        self.sample.seconds / self.predicted
    }
}

/// All laws: the printed times first, then ours; each algorithm's main one before those it is compared with.
pub(crate) fn laws(growth: &Growth) -> Vec<Law> {
    let mut laws = Vec::new();
    let printed = growth.printed_samples();
    let all = vec![2, 4, 8];
    for (construction, counts) in [
        (Construction::TopDown, [UNIONS, COMBINATIONS, TRIANGLES]),
        (Construction::BottomUp, [KD_STEPS, SQUARES, CUBES]),
    ] {
        for (i, count) in counts.into_iter().enumerate() {
            // Only cells that the main count is known of, so that all counts are judged by the same times.
            let known: Vec<Sample> = printed.iter().filter(|s| s.work.is_some()).cloned().collect();
            laws.extend(law(&known, Times::Printed, construction, "published", &all, count, i == 0));
        }
    }
    let ours = growth.our_samples();
    for construction in [Construction::TopDown, Construction::BottomUp] {
        let count = if construction == Construction::TopDown { LITERAL_COMBINATIONS } else { DISTANCES };
        for preset in ["published", "text", "walter"] {
            // A bottom-up build of arity 4 or 8 is the binary one and a collapse.
            let groups: &[&[usize]] =
                if construction == Construction::TopDown { &[&[2], &[4], &[8]] } else { &[&[2, 4, 8]] };
            for arities in groups {
                laws.extend(law(&ours, Times::Ours, construction, preset, arities, count, true));
            }
            if construction == Construction::TopDown {
                laws.extend(law(&ours, Times::Ours, construction, preset, &all, count, false));
            }
        }
    }
    laws
}

fn law(
    samples: &[Sample],
    times: Times,
    construction: Construction,
    preset: &str,
    arities: &[usize],
    count: Count,
    main: bool,
) -> Option<Law> {
    let points: Vec<_> = samples
        .iter()
        .filter(|s| s.construction == construction && s.preset == preset && arities.contains(&s.arity) && s.fits())
        .filter_map(|s| Some(((count.of)(s)?, s.seconds)))
        .collect();
    // One build meets any constant.
    let fit = Proportion::of(&points).filter(|fit| fit.points > 1)?;
    Some(Law { times, construction, preset: preset.into(), arities: arities.to_vec(), count, main, fit })
}

/// Every cell with a count against its main law, those that are not fitted included.
pub(crate) fn residuals(growth: &Growth, laws: &[Law]) -> Vec<Residual> {
    let samples = growth.printed_samples().into_iter().chain(growth.our_samples());
    samples
        .filter_map(|sample| {
            let law = laws.iter().find(|l| {
                l.main
                    && l.times == sample.times
                    && l.construction == sample.construction
                    && l.preset == sample.preset
                    && l.arities.contains(&sample.arity)
            })?;
            let count = (law.count.of)(&sample)?;
            Some(Residual { predicted: law.fit.constant * count, count, sample })
        })
        .collect()
}

impl Times {
    /// Its name in tables.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Ours => "ours",
        }
    }
}

impl Law {
    /// Its arities as words.
    pub fn arities(&self) -> String {
        self.arities.iter().map(ToString::to_string).collect::<Vec<_>>().join("/")
    }
}

/// The laws as CSV.
pub(crate) fn laws_csv(laws: &[Law]) -> String {
    let mut text =
        String::from("times,construction,preset,arities,count,main,points,span,ns_per_unit,explained,spread,worst\n");
    for l in laws {
        let fields = [
            l.times.id().to_owned(),
            l.construction.id().to_owned(),
            l.preset.clone(),
            l.arities(),
            l.count.name.to_owned(),
            l.main.to_string(),
            l.fit.points.to_string(),
            significant(l.fit.span, 5),
            significant(l.fit.constant * 1e9, 5),
            l.fit.explained.map_or(String::new(), |x| significant(x, 5)),
            significant(l.fit.spread, 5),
            significant(l.fit.worst, 5),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

/// The residuals as CSV.
pub(crate) fn residuals_csv(residuals: &[Residual]) -> String {
    let mut text = String::from("times,construction,preset,scene,arity,triangles,count,seconds,predicted,ratio,use\n");
    for r in residuals {
        let s = &r.sample;
        let fields = [
            s.times.id().to_owned(),
            s.construction.id().to_owned(),
            s.preset.clone(),
            s.scene.clone(),
            s.arity.to_string(),
            s.triangles.to_string(),
            significant(r.count, 6),
            significant(s.seconds, 6),
            significant(r.predicted, 6),
            significant(r.ratio(), 5),
            usage(s).to_owned(),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

/// What part a cell has in the fit.
pub(crate) fn usage(sample: &Sample) -> &'static str {
    use crate::report::printed::Flag;
    match sample.flag {
        Flag::Capped => "capped: at least so long",
        Flag::Doubtful => "doubtful: not fitted",
        _ if sample.extrapolated => "work continued: not fitted",
        _ => "fitted",
    }
}
