//! The summary: what a factor in build time buys, in sentences whose every number and direction comes from rows.

use super::Accuracy;
use super::series::{Point, Series, all};
use crate::report::number::{grouped, significant};

/// One sentence or two a series, with the study that it belongs to.
pub(crate) fn sentences(accuracy: &Accuracy) -> Vec<(String, String)> {
    let series = all(accuracy);
    let mut all_said = Vec::new();
    for s in &series {
        let said = match s.study {
            "planes" | "bins" | "clustering" => settings(s, &series),
            "decisions" => decisions(s),
            "intersection" => kernel(s),
            _ => storage(s),
        };
        all_said.extend(said.map(|text| (s.study.to_owned(), text)));
    }
    all_said
}

/// What a setting is a number of.
pub(crate) fn unit(study: &str, method: &str) -> &'static str {
    match (study, method) {
        ("planes", _) => "planes an axis",
        ("bins", _) => "bins an axis",
        ("clustering", "ploc") => "neighbours on either side",
        ("clustering", _) => "candidates",
        ("decisions", _) => "bits",
        _ => "bits a coordinate",
    }
}

fn name(s: &Series) -> String {
    match s.study {
        "planes" => format!("{}, arity {}", s.method, s.arity),
        _ => s.method.to_owned(),
    }
}

/// A factor as a change in percent.
pub(crate) fn percent(factor: f64) -> String {
    let change = (factor - 1.0) * 100.0;
    let text = if change.abs() < 9.95 { format!("{:.1} %", change.abs()) } else { format!("{:.0} %", change.abs()) };
    match text.as_str() {
        "0.0 %" => "no change".into(),
        _ => text,
    }
}

fn more_or_less(factor: f64, less: &str, more: &str) -> String {
    let text = percent(factor);
    match text.as_str() {
        "no change" => "no change".into(),
        _ => format!("{text} {}", if factor < 1.0 { less } else { more }),
    }
}

fn settings(s: &Series, series: &[Series]) -> Option<String> {
    let numbered: Vec<&Point> = s.points.iter().filter(|p| p.setting.is_some() && p.sah.is_some()).collect();
    let (first, last) = (numbered.first()?, numbered.last()?);
    if first.setting == last.setting {
        return None;
    }
    let by_sah = |a: &&&Point, b: &&&Point| a.sah.unwrap_or(f64::MAX).total_cmp(&b.sah.unwrap_or(f64::MAX));
    let best = numbered.iter().min_by(by_sah)?;
    let ratio = |of: fn(&Point) -> Option<f64>, a: &Point, b: &Point| Some(of(b)? / of(a)?);
    let unit = unit(s.study, s.method);
    let setting = |p: &Point| p.setting.unwrap_or(0);
    let time = ratio(|p| p.time, first, last)?;
    let cost = ratio(|p| p.sah, first, last)?;
    let rate = ratio(|p| p.rate, first, last)?;
    let mut text = format!(
        "{}: from {} to {} {unit}, a factor of {} in build time {} {} and {}.",
        name(s),
        setting(first),
        setting(last),
        significant(time, 2),
        if cost < 1.0 { "buys" } else { "makes things worse:" },
        more_or_less(cost, "less cost", "more cost"),
        more_or_less(rate, "fewer rays per second", "more rays per second"),
    );
    if cost > 1.01 {
        text += &format!(" {} give the cheapest tree of these.", setting(best));
    } else if let Some(enough) = numbered.iter().find(|p| p.sah <= best.sah.map(|b| b * 1.01)) {
        let time = ratio(|p| p.time, enough, last)?;
        text += &format!(" {} are within 1 % of the best of these, {}", setting(enough), setting(best));
        text += &match (time - 1.0).abs() < 0.05 {
            true => "; the time is nearly the same.".to_owned(),
            false => format!("; {} take {} times as long.", setting(last), significant(time, 2)),
        };
    }
    // The zero line of its study, a method without a setting.
    let exact = series.iter().find(|e| e.study == s.study && e.points.iter().any(|p| p.setting.is_none()));
    if let (Some(exact), Some(cost), Some(time)) = (exact, best.sah, best.time) {
        text += &format!(
            " Against {}, which leaves nothing out, {} {unit} build in {} of the time at {}.",
            exact.method,
            setting(best),
            percent_of(time),
            more_or_less(cost, "less cost", "more cost"),
        );
    }
    Some(text)
}

fn percent_of(factor: f64) -> String {
    format!("{} %", significant(factor * 100.0, 2))
}

fn kernel(s: &Series) -> Option<String> {
    let point = s.points.first().filter(|_| s.method != "scalar")?;
    let (rate, wrong) = (point.rate?, point.wrong?);
    Some(format!(
        "Kernel {}, {}: {} than scalar, {} wrong hits in a million.",
        s.method,
        if s.rays == "edges" { "rays at corners and edges".to_owned() } else { format!("{} rays", s.rays) },
        more_or_less(rate, "fewer rays per second", "more rays per second"),
        grouped(&significant(wrong, 3)),
    ))
}

fn decisions(s: &Series) -> Option<String> {
    let parts: Vec<String> = s
        .points
        .iter()
        .filter_map(|p| {
            let (compared, different) = p.flips.filter(|f| f.0 > 0)?;
            Some(format!(
                "f{} decides {} of {} otherwise than costs without rounding, at most {} above the least cost, and its trees have {} in {} of the time",
                p.setting?,
                grouped(&different.to_string()),
                grouped(&compared.to_string()),
                percent_of(p.excess?),
                more_or_less(p.sah?, "less cost", "more cost"),
                percent_of(p.time?),
            ))
        })
        .collect();
    (!parts.is_empty()).then(|| format!("{}: {}.", s.method, parts.join("; ")))
}

fn storage(s: &Series) -> Option<String> {
    let parts: Vec<String> = s
        .points
        .iter()
        .filter(|p| p.setting != Some(32))
        .filter_map(|p| {
            Some(format!(
                "{} bits a coordinate take {} of the bytes for {} box tests and {}",
                p.setting?,
                percent_of(p.bytes?),
                more_or_less(p.boxes?, "fewer", "more"),
                more_or_less(p.rate?, "fewer rays per second", "more rays per second"),
            ))
        })
        .collect();
    let whose = if s.method.starts_with("arity") { "Nodes of" } else { "Kernel" };
    (!parts.is_empty()).then(|| format!("{whose} {}, against f32: {}.", s.method, parts.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_become_changes() {
        assert_eq!(more_or_less(0.8, "less", "more"), "20 % less");
        assert_eq!(more_or_less(1.015, "less", "more"), "1.5 % more");
        assert_eq!(more_or_less(1.0001, "less", "more"), "no change");
        assert_eq!(percent_of(0.123), "12 %");
    }
}
