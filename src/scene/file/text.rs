//! From bytes to the logical lines of a text format, as they come: encodings, line ends, comments, continuations.
//!
//! A file is read once, in blocks, and never held whole: what a reader needs is its longest line.

use std::borrow::Cow;
use std::io::{self, Read};

/// Bytes read at a time.
const BLOCK: usize = 1 << 18;

/// Why a text could not be read on.
#[derive(Debug)]
pub(super) enum Fault {
    /// The system, or a damaged compressed file.
    Io(io::Error),
    /// The bytes are no text in an encoding that is understood; a sentence about it.
    Encoding(&'static str),
}

/// A stream of logical lines. Lines end in LF, CR LF or CR; a backslash at the end joins the next line; a comment runs
/// from a `#` that begins a word, and ends with its own line, backslash or not.
pub(super) struct Lines<R> {
    source: R,
    buffer: Vec<u8>,
    /// What of the buffer is still to be looked at.
    rest: std::ops::Range<usize>,
    at_end: bool,
    /// Physical lines so far.
    number: usize,
    joined: Vec<u8>,
}

/// A line without comment and surrounding white space, never empty, continuations joined. Its bytes hold no NUL and are
/// UTF-8 or some 8-bit encoding that agrees with ASCII.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Line<'a> {
    /// Where it starts in the file, counted from 1.
    pub(super) number: usize,
    bytes: &'a [u8],
}

impl<'a> Line<'a> {
    /// The first word and all after it, trimmed.
    #[inline]
    pub(super) fn split(&self) -> (&'a [u8], &'a [u8]) {
        let end = self.bytes.iter().position(u8::is_ascii_whitespace).unwrap_or(self.bytes.len());
        let (keyword, rest) = self.bytes.split_at(end);
        (keyword, rest.trim_ascii_start())
    }
}

/// The words of `text`.
#[inline]
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = text;
    std::iter::from_fn(move || {
        rest = rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, tail) = rest.split_at(end);
        rest = tail;
        (!word.is_empty()).then_some(word)
    })
}

/// Bytes as characters: UTF-8, or else Latin-1, in which any byte is a character.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect::<String>().into(),
    }
}

impl<R: Read> Lines<R> {
    pub(super) fn new(source: R) -> Self {
        Self { source, buffer: Vec::new(), rest: 0..0, at_end: false, number: 0, joined: Vec::new() }
    }

    /// The next line that is not empty.
    ///
    /// # Errors
    /// [`Fault::Encoding`] where the bytes are UTF-16 or UTF-32, or hold a NUL and so are no text.
    pub(super) fn next(&mut self) -> Result<Option<Line<'_>>, Fault> {
        loop {
            let Some(line) = self.physical()? else { return Ok(None) };
            let number = self.number;
            let (text, continues) = strip(&self.buffer[line.clone()]);
            let line = line.start..line.start + text.len();
            if !continues {
                if text.trim_ascii().is_empty() {
                    continue;
                }
                return Ok(Some(Line { number, bytes: self.buffer[line].trim_ascii() }));
            }
            self.joined.clear();
            self.joined.extend_from_slice(&self.buffer[line]);
            let mut continues = true;
            while continues {
                self.joined.push(b' ');
                let Some(line) = self.physical()? else { break };
                let (text, more) = strip(&self.buffer[line]);
                self.joined.extend_from_slice(text);
                continues = more;
            }
            if !self.joined.trim_ascii().is_empty() {
                return Ok(Some(Line { number, bytes: self.joined.trim_ascii() }));
            }
        }
    }

    /// The place of the next physical line in the buffer, without its end; none at the end of the file.
    fn physical(&mut self) -> Result<Option<std::ops::Range<usize>>, Fault> {
        let mut searched = 0;
        loop {
            let rest = &self.buffer[self.rest.clone()];
            let found = memchr::memchr2(b'\n', b'\r', &rest[searched..]).map(|at| at + searched);
            match found {
                // Whether a CR has its LF is known with the byte behind it.
                Some(at) if rest[at] == b'\n' || at + 1 < rest.len() || self.at_end => {
                    let length = if rest[at..].starts_with(b"\r\n") { 2 } else { 1 };
                    let start = self.rest.start;
                    self.rest.start += at + length;
                    self.number += 1;
                    return Ok(Some(start..start + at));
                }
                None if self.at_end => {
                    let line = self.rest.clone();
                    self.rest.start = self.rest.end;
                    self.number += 1;
                    return Ok((!line.is_empty()).then_some(line));
                }
                _ => {
                    searched = found.unwrap_or(rest.len());
                    self.refill()?;
                }
            }
        }
    }

    /// Moves what is left to the front and reads another block behind it.
    fn refill(&mut self) -> Result<(), Fault> {
        let first = self.buffer.is_empty();
        self.buffer.copy_within(self.rest.clone(), 0);
        self.rest = 0..self.rest.len();
        let wanted = self.rest.end + BLOCK;
        if self.buffer.len() < wanted {
            self.buffer.resize(wanted, 0);
        }
        let from = self.rest.end;
        while self.rest.end < wanted {
            match self.source.read(&mut self.buffer[self.rest.end..wanted]) {
                Ok(0) => {
                    self.at_end = true;
                    break;
                }
                Ok(n) => self.rest.end += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => return Err(Fault::Io(e)),
            }
        }
        let new = &self.buffer[from..self.rest.end];
        if first && (new.starts_with(b"\xfe\xff") || new.starts_with(b"\xff\xfe")) {
            return Err(Fault::Encoding("the encoding is UTF-16; save the file as UTF-8"));
        }
        if memchr::memchr(0, new).is_some() {
            let told = "this is no text: it holds a NUL byte; if the encoding is UTF-16, save the file as UTF-8";
            return Err(Fault::Encoding(told));
        }
        if first && new.starts_with(b"\xef\xbb\xbf") {
            self.rest.start += 3;
        }
        Ok(())
    }
}

/// A physical line without comment and backslash, and whether it had the backslash.
#[inline]
fn strip(line: &[u8]) -> (&[u8], bool) {
    let begins_word = |&at: &usize| at == 0 || line[at - 1].is_ascii_whitespace();
    if let Some(at) = memchr::memchr_iter(b'#', line).find(begins_word) {
        return (&line[..at], false);
    }
    match line.strip_suffix(b"\\") {
        Some(start) => (start, true),
        None => (line, false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split_of(source: impl Read) -> Result<Vec<(usize, String)>, Fault> {
        let mut lines = Lines::new(source);
        let mut found = Vec::new();
        while let Some(line) = lines.next()? {
            found.push((line.number, String::from_utf8_lossy(line.bytes).into_owned()));
        }
        Ok(found)
    }

    fn split(text: &str) -> Vec<(usize, String)> {
        /// Hands out one byte at a time.
        struct Drops<'a>(&'a [u8]);
        impl Read for Drops<'_> {
            fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
                let n = self.0.len().min(buffer.len()).min(1);
                self.0.read(&mut buffer[..n])
            }
        }
        let whole = split_of(text.as_bytes()).unwrap();
        assert_eq!(split_of(Drops(text.as_bytes())).unwrap(), whole);
        whole
    }

    #[test]
    fn lines_end_join_and_lose_their_comments() {
        let expected = |lines: &[(usize, &str)]| lines.iter().map(|&(n, t)| (n, t.to_owned())).collect::<Vec<_>>();
        assert_eq!(split("a\nb\r\nc\rd"), expected(&[(1, "a"), (2, "b"), (3, "c"), (4, "d")]));
        assert_eq!(split("f 1 2 \\\n 3 \\\r\n4\ng"), expected(&[(1, "f 1 2   3  4"), (4, "g")]));
        assert_eq!(split("# art \\\nv 1 # x\n\n  \no box#1"), expected(&[(2, "v 1"), (5, "o box#1")]));
        assert_eq!(split("f 1 \\"), expected(&[(1, "f 1")]));
        assert_eq!(split("\\\n\\\n"), expected(&[]));
        assert_eq!(split("\u{feff}a\r"), expected(&[(1, "a")]));
        assert_eq!(split(""), expected(&[]));
    }

    #[test]
    fn lines_may_lie_across_blocks_and_be_longer_than_one() {
        let long = "x".repeat(3 * BLOCK + 7);
        let text = format!("{long}\r\n\n{}\r\nend", "y\r\n".repeat(BLOCK));
        let found = split_of(text.as_bytes()).unwrap();
        assert_eq!((found[0].1.len(), found.len()), (long.len(), BLOCK + 2));
        assert_eq!(found.last(), Some(&(BLOCK + 4, "end".to_owned())));
    }

    #[test]
    fn words_of_a_line() {
        let mut lines = Lines::new(b"\tusemtl   many  words ".as_slice());
        let line = lines.next().unwrap().unwrap();
        assert_eq!(line.split(), (b"usemtl".as_slice(), b"many  words".as_slice()));
        assert_eq!(words(line.split().1).collect::<Vec<_>>(), [b"many", b"words".as_slice()]);
    }

    #[test]
    fn encodings() {
        assert_eq!(split("\u{feff}v"), [(1, "v".to_owned())]);
        assert_eq!(decode("é".as_bytes()), "é");
        assert_eq!(decode(b"caf\xe9"), "café");
        for bytes in [b"\xfe\xff\0v".as_slice(), b"v\0", b"\xff\xfev\0"] {
            assert!(matches!(split_of(bytes), Err(Fault::Encoding(told)) if told.contains("encoding")));
        }
        assert!(matches!(split_of(Failing), Err(Fault::Io(_))));
    }

    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("broken"))
        }
    }
}
