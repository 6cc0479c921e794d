//! Numbers as text: significant digits without exponents, and thousands grouped for reading.

/// `x` to `digits` significant digits, plain decimals, no exponent; trailing zeros of the fraction go.
pub(crate) fn significant(x: f64, digits: i32) -> String {
    let text = padded(x, digits);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// As [`significant`], trailing zeros kept: for columns that are read.
pub(crate) fn padded(x: f64, digits: i32) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    // `{:e}` rounds first, so that 9.9996 at four digits counts as 10.00.
    let rounded: f64 = format!("{x:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(x);
    let decimals = (digits - 1 - rounded.abs().log10().floor() as i32).max(0) as usize;
    format!("{rounded:.decimals$}")
}

/// A ratio as a signed difference in percent.
pub(crate) fn percent(ratio: f64) -> String {
    let text = format!("{:+.1} %", (ratio - 1.0) * 100.0);
    match &text[..] {
        "-0.0 %" | "+0.0 %" => "0.0 %".to_owned(),
        _ => text.replace('-', "−"),
    }
}

/// Commas between the thousands of a plain decimal number's whole part.
pub(crate) fn grouped(text: &str) -> String {
    let whole = text.find('.').unwrap_or(text.len());
    let first = text.find(|c: char| c.is_ascii_digit()).unwrap_or(0);
    let mut out = String::with_capacity(text.len() + 4);
    for (i, c) in text.char_indices() {
        if i > first && i < whole && (whole - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits_are_kept_and_no_exponent_appears() {
        let cases = [
            (1234.5678, 6, "1234.57"),
            (152_442.0, 3, "152000"),
            (0.000_012_345_6, 3, "0.0000123"),
            (9.9996, 4, "10"),
            (2.5, 6, "2.5"),
            (0.0, 3, "0"),
            (-0.0512, 2, "-0.051"),
        ];
        for (x, digits, text) in cases {
            assert_eq!(significant(x, digits), text);
        }
        assert_eq!(padded(0.1, 3), "0.100");
        assert_eq!(padded(9.9996, 4), "10.00");
    }

    #[test]
    fn ratios_are_differences_in_percent() {
        assert_eq!(percent(1.0213), "+2.1 %");
        assert_eq!(percent(0.94), "−6.0 %");
        assert_eq!(percent(0.99999), "0.0 %");
    }

    #[test]
    fn thousands_are_grouped() {
        let cases = [
            ("648", "648"),
            ("2540", "2,540"),
            ("1233.42", "1,233.42"),
            ("-1000000", "-1,000,000"),
            ("0.0001", "0.0001"),
        ];
        for (plain, text) in cases {
            assert_eq!(grouped(plain), text);
        }
    }
}
