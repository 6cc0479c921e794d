//! Numbers as OBJ and MTL files spell them.

/// The number that `word` spells, and whether that took a repair.
///
/// Whatever Rust reads stands (`.5`, `5.`, `+1e2`, `inf`, `nan`). Four more spellings are found in files and understood
/// elsewhere: Fortran's exponent (`1.5D+02`), a sign before the exponent's letter (`3.1+e2`), a decimal comma (`1,5`), and a
/// comma, semicolon or `f` behind the number (`1.5,` `1.5f`).
#[inline]
pub(super) fn number(word: &[u8]) -> Option<(f32, bool)> {
    let text = std::str::from_utf8(word).ok()?;
    match text.parse() {
        Ok(value) => Some((value, false)),
        Err(_) => repaired(text).map(|value| (value, true)),
    }
}

#[cold]
fn repaired(text: &str) -> Option<f32> {
    let is_plain = |text: &str| text.chars().all(|c| c.is_ascii_digit() || "+-.,eEdD".contains(c));
    let text = text.strip_suffix([',', ';', 'f', 'F']).unwrap_or(text);
    if !is_plain(text) || !text.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let text = text.replace(['d', 'D', 'E'], "e").replace("+e", "e+").replace("-e", "e-");
    let with_point = |text: String| if text.contains('.') { text } else { text.replacen(',', ".", 1) };
    with_point(text).parse().ok()
}

/// A whole number with an optional sign, or none where it is none or beyond i64.
#[inline]
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for &digit in digits {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.checked_mul(10)?.checked_add(digit.into())?;
    }
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings() {
        for (word, value) in
            [("1", 1.0), (".5", 0.5), ("-2.", -2.0), ("+1e002", 100.0), ("007.5", 7.5), ("1e-300", 0.0)]
        {
            assert_eq!(number(word.as_bytes()), Some((value, false)), "{word}");
        }
        assert_eq!(number(b"1e39"), Some((f32::INFINITY, false)));
        assert!(number(b"-nan").is_some_and(|(value, _)| value.is_nan()));
        for (word, value) in [
            ("1.5D+02", 150.0),
            ("-2d1", -20.0),
            ("3.1+e2", 310.0),
            ("3.1-E2", 0.031),
            ("-1,25", -1.25),
            ("1.5,", 1.5),
            ("1,5,", 1.5),
            ("2;", 2.0),
            ("0.5f", 0.5),
        ] {
            assert_eq!(number(word.as_bytes()), Some((value, true)), "{word}");
        }
        for word in ["", "1.#IND", "-1.#INF", "x", "1.2.3", "1,2,3", "f", ",", "--1", "0x10", "1e", "1 2", "é", "1-2"]
        {
            assert_eq!(number(word.as_bytes()), None, "{word}");
        }
        assert_eq!(number(b"\xff"), None);
    }

    #[test]
    fn integers() {
        assert_eq!(["7", "-12", "+3"].map(|w| integer(w.as_bytes())), [Some(7), Some(-12), Some(3)]);
        for word in ["", "-", "1.0", "x", "99999999999999999999", " 1"] {
            assert_eq!(integer(word.as_bytes()), None, "{word}");
        }
    }
}
