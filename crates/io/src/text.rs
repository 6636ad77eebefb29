//! Lines, tokens and numbers of text files.
//!
//! In: bytes, not necessarily UTF-8. Out: numbered lines (ended by LF, CR LF or CR), tokens between blanks, numbers.
//! Holds: numbers are rounded correctly, and [`Shortest`] prints the fewest digits that read back bit for bit.

use crate::error::{ContentDefect, Fault};
use quadloom_mesh::DVec3;
use std::fmt;

/// A line without its ending.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    /// From 1.
    pub number: u64,
    pub bytes: &'a [u8],
    /// Whether an ending follows; the last line of a truncated file has none.
    pub terminated: bool,
}

/// The lines of a file; knows what it has not read yet.
#[derive(Clone, Debug)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    /// Lines of `bytes`, without a UTF-8 byte order mark.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), number: 0 }
    }

    /// Number of the line read last.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The unread bytes.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The next line that is neither blank nor starts with `#`.
    pub fn next_content(&mut self) -> Option<Line<'a>> {
        self.find(|line| tokens(line.bytes).next().is_some())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;
    fn next(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let (bytes, skip) = match end {
            Some(k) => (&self.rest[..k], k + if self.rest[k..].starts_with(b"\r\n") { 2 } else { 1 }),
            None => (self.rest, self.rest.len()),
        };
        self.rest = &self.rest[skip..];
        Some(Line { number: self.number, bytes, terminated: end.is_some() })
    }
}

/// The blank-separated tokens of a line, up to one that starts with `#`.
pub(crate) fn tokens(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|t| !t.is_empty()).take_while(|t| t[0] != b'#')
}

/// A token as text for a message, shortened.
pub(crate) fn shown(token: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(&token[..token.len().min(LONGEST)]).into_owned();
    if token.len() > LONGEST { text + "…" } else { text }
}

/// The number a token spells, correctly rounded; NaN and infinities included.
pub(crate) fn number(token: &[u8]) -> Option<f64> {
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// The number a token spells, or the fault.
pub(crate) fn number_at(token: &[u8], line: u64) -> Result<f64, Fault> {
    number(token).ok_or_else(|| Fault::line(line, not_a_number(token)))
}

/// The finite number a token spells, or the fault.
pub(crate) fn coordinate(token: &[u8], line: u64) -> Result<f64, Fault> {
    let value = number_at(token, line)?;
    if value.is_finite() { Ok(value) } else { Err(Fault::line(line, ContentDefect::NotFinite(shown(token)))) }
}

/// The next three tokens as a point, or the fault.
pub(crate) fn point<'a>(
    tokens: &mut impl Iterator<Item = &'a [u8]>,
    line: u64,
    what: &'static str,
) -> Result<DVec3, Fault> {
    let mut p = [0.0; 3];
    for (found, value) in p.iter_mut().enumerate() {
        let token = tokens
            .next()
            .ok_or_else(|| Fault::line(line, ContentDefect::WrongCount { what, found, wanted: "3 coordinates" }))?;
        *value = coordinate(token, line)?;
    }
    Ok(p.into())
}

/// The integer a token spells, or the fault.
pub(crate) fn integer(token: &[u8], line: u64) -> Result<i64, Fault> {
    parse_integer(token).ok_or_else(|| Fault::line(line, not_a_number(token)))
}

/// The integer a token spells.
pub(crate) fn parse_integer(token: &[u8]) -> Option<i64> {
    // Short runs of digits, nearly every index there is, cannot overflow.
    if (1..=18).contains(&token.len()) && token.iter().all(u8::is_ascii_digit) {
        return Some(token.iter().fold(0, |n, &d| n * 10 + i64::from(d - b'0')));
    }
    std::str::from_utf8(token).ok()?.parse().ok()
}

/// What to say of a token that is no number: some programs spell NaN as `1.#QNAN` or `-nan(ind)`.
fn not_a_number(token: &[u8]) -> ContentDefect {
    let lower = token.to_ascii_lowercase();
    let has = |word: &[u8]| lower.windows(word.len()).any(|w| w == word);
    if has(b"nan") || has(b"#in") || has(b"inf") {
        ContentDefect::NotFinite(shown(token))
    } else {
        ContentDefect::NotANumber(shown(token))
    }
}

/// Prints the shortest decimal that reads back as the same double.
pub(crate) struct Shortest(pub f64);

impl fmt::Display for Shortest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The plain form is the commonest and most widely read; outside this range it would print long runs of zeros.
        let size = self.0.abs();
        if size == 0.0 || (1e-5..1e16).contains(&size) { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_any_way() {
        let lines: Vec<_> =
            Lines::new(b"\xef\xbb\xbfa\nb\r\nc\rd").map(|l| (l.number, l.bytes, l.terminated)).collect();
        let expected: [(u64, &[u8], bool); 4] = [(1, b"a", true), (2, b"b", true), (3, b"c", true), (4, b"d", false)];
        assert_eq!(lines, expected);
    }

    #[test]
    fn tokens_stop_at_a_comment() {
        assert_eq!(tokens(b" f\t1  2 # 3").collect::<Vec<_>>(), [b"f", b"1", b"2"]);
    }

    #[test]
    fn foreign_spellings_of_nan_are_recognised() {
        for token in ["1.#QNAN", "-nan(ind)", "-1.#INF"] {
            assert!(matches!(not_a_number(token.as_bytes()), ContentDefect::NotFinite(_)), "{token}");
        }
        assert!(matches!(not_a_number(b"1,5"), ContentDefect::NotANumber(_)));
    }

    proptest::proptest! {
        #[test]
        fn shortest_reads_back_bit_for_bit(bits: u64) {
            let x = f64::from_bits(bits);
            let text = Shortest(x).to_string();
            let back = number(text.as_bytes()).unwrap();
            proptest::prop_assert!(back.to_bits() == bits || x.is_nan() && back.is_nan());
            proptest::prop_assert!(text.len() <= 24, "{}", text);
        }
    }
}
