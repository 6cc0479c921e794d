//! Figures in words.

/// A duration for people: seconds, minutes, hours, days or years.
pub fn human_seconds(s: f64) -> String {
    const UNITS: [(f64, &str); 5] =
        [(31_557_600.0, "years"), (86_400.0, "days"), (3600.0, "hours"), (60.0, "minutes"), (1.0, "s")];
    let unit = UNITS.iter().find(|(size, _)| s >= 2.0 * size);
    let (size, name) = unit.unwrap_or(if s >= 1.0 { &UNITS[4] } else { &(1e-3, "ms") });
    let value = s / size;
    if value < 10.0 { format!("{value:.1} {name}") } else { format!("{value:.0} {name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_choose_their_unit() {
        let all = [0.0005, 0.25, 1.5, 90.0, 150.0, 8000.0, 950_400.0, 1e9].map(human_seconds);
        assert_eq!(all, ["0.5 ms", "250 ms", "1.5 s", "90 s", "2.5 minutes", "2.2 hours", "11 days", "32 years"]);
    }
}
