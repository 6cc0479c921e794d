//! From bytes to the logical lines of an OBJ or MTL file: encodings, line ends, comments, continuations.

use std::borrow::Cow;

/// A line as its keyword and the rest, both trimmed, never empty; without comment, continuations joined.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Line<'a> {
    /// Where it starts in the file, counted from 1.
    pub(super) number: usize,
    text: Cow<'a, str>,
}

impl Line<'_> {
    /// The first word.
    pub(super) fn keyword(&self) -> &str {
        self.text.split_whitespace().next().unwrap_or_default()
    }

    /// All after the first word.
    pub(super) fn rest(&self) -> &str {
        self.text[self.keyword().len()..].trim()
    }

    /// The words after the first.
    pub(super) fn words(&self) -> impl Iterator<Item = &str> {
        self.text.split_whitespace().skip(1)
    }
}

/// Text of a file in UTF-8 (with or without a byte order mark) or else in Latin-1, in which any byte is a character.
///
/// # Errors
/// A sentence where the bytes are UTF-16 or UTF-32, or hold a NUL and so are no text.
pub(super) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, &'static str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.starts_with(b"\xfe\xff") || bytes.starts_with(b"\xff\xfe") {
        return Err("the encoding is UTF-16; save the file as UTF-8");
    }
    if bytes.contains(&0) {
        return Err("this is no text: it holds a NUL byte; if the encoding is UTF-16, save the file as UTF-8");
    }
    Ok(match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect::<String>().into(),
    })
}

/// The logical lines that are not empty. Lines end in LF, CR LF or CR; a backslash at the end joins the next line; a
/// comment runs from a `#` that begins a word, and ends with its own line, backslash or not.
pub(super) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut rest = text;
    let mut number = 0;
    std::iter::from_fn(move || {
        while !rest.is_empty() {
            number += 1;
            let start = number;
            let (mut text, mut continues) = physical_line(&mut rest);
            let mut joined = String::new();
            while continues && !rest.is_empty() {
                number += 1;
                joined.push_str(text);
                joined.push(' ');
                (text, continues) = physical_line(&mut rest);
            }
            let text = match joined.is_empty() {
                true => Cow::Borrowed(text.trim()),
                false => Cow::Owned((joined + text).trim().to_owned()),
            };
            if !text.is_empty() {
                return Some(Line { number: start, text });
            }
        }
        None
    })
}

/// Takes a physical line off `rest`; returns it without comment and backslash, and whether it had the backslash.
fn physical_line<'a>(rest: &mut &'a str) -> (&'a str, bool) {
    let end = rest.find(['\n', '\r']).unwrap_or(rest.len());
    let (line, tail) = rest.split_at(end);
    *rest = tail.strip_prefix("\r\n").or(tail.get(1..)).unwrap_or_default();
    let comment = line.match_indices('#').map(|(at, _)| at);
    let begins_word = |&at: &usize| line[..at].chars().next_back().is_none_or(char::is_whitespace);
    if let Some(at) = comment.into_iter().find(begins_word) {
        return (&line[..at], false);
    }
    match line.strip_suffix('\\') {
        Some(start) => (start, true),
        None => (line, false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &str) -> Vec<(usize, String)> {
        lines(text).map(|line| (line.number, line.text.into_owned())).collect()
    }

    #[test]
    fn lines_end_join_and_lose_their_comments() {
        let expected = |lines: &[(usize, &str)]| lines.iter().map(|&(n, t)| (n, t.to_owned())).collect::<Vec<_>>();
        assert_eq!(split("a\nb\r\nc\rd"), expected(&[(1, "a"), (2, "b"), (3, "c"), (4, "d")]));
        assert_eq!(split("f 1 2 \\\n 3 \\\r\n4\ng"), expected(&[(1, "f 1 2   3  4"), (4, "g")]));
        assert_eq!(split("# art \\\nv 1 # x\n\n  \no box#1"), expected(&[(2, "v 1"), (5, "o box#1")]));
        assert_eq!(split("f 1 \\"), expected(&[(1, "f 1")]));
        assert_eq!(split("\\\n\\\n"), expected(&[]));
        assert_eq!(split(""), expected(&[]));
    }

    #[test]
    fn words_of_a_line() {
        let line = lines("\tusemtl   many  words ").next().unwrap();
        assert_eq!((line.keyword(), line.rest()), ("usemtl", "many  words"));
        assert_eq!(line.words().collect::<Vec<_>>(), ["many", "words"]);
    }

    #[test]
    fn encodings() {
        assert_eq!(decode(b"\xef\xbb\xbfv").unwrap(), "v");
        assert_eq!(decode("é".as_bytes()).unwrap(), "é");
        assert_eq!(decode(b"caf\xe9").unwrap(), "café");
        assert!(decode(b"\xfe\xff\0v").unwrap_err().contains("encoding"));
        assert!(decode(b"v\0").unwrap_err().contains("encoding"));
    }
}
