//! Words as text.
//!
//! In: `a b a⁻¹ b⁻¹`, `abAB`, `a1 b1 a1^-1 b1'`. Out: a word; and back. Holds: what is written is read as the same.
//!
//! ```text
//!   side   letter [digits] [mark]       letters 0 … 25: a … z; 26 … 51: a1 … z1; 52 …: a2 …
//!   mark   ⁻¹  ^-1  '                   inverse; a capital letter is inverse too, and with a mark is not
//! ```
//! White space between sides is free, and may be left out. The empty word is `1`, or nothing.

use super::{Letter, Path, Side, Word, WordError};
use std::fmt;
use std::str::FromStr;

/// Number of letters before digits are needed.
const LETTERS: u32 = 26;

/// Marks of an inverse.
const MARKS: [&str; 3] = ["⁻¹", "^-1", "'"];

impl fmt::Display for Letter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (letter, round) = (self.0 % LETTERS, self.0 / LETTERS);
        write!(f, "{}", char::from(b'a' + letter as u8))?;
        if round > 0 { write!(f, "{round}") } else { Ok(()) }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.letter, if self.inverse { MARKS[0] } else { "" })
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&written(self.sides(), |letter| letter.to_string()))
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&written(self.sides(), |letter| letter.to_string()))
    }
}

impl Word {
    /// Its text with other names of letters.
    pub fn to_text(&self, name: impl Fn(Letter) -> String) -> String {
        written(self.sides(), name)
    }
}

impl Path {
    /// Its text with other names of letters.
    pub fn to_text(&self, name: impl Fn(Letter) -> String) -> String {
        written(self.sides(), name)
    }
}

/// Sides with spaces between them; `1` if there are none.
fn written(sides: &[Side], name: impl Fn(Letter) -> String) -> String {
    let text = |s: &Side| format!("{}{}", name(s.letter), if s.inverse { MARKS[0] } else { "" });
    if sides.is_empty() { "1".to_owned() } else { sides.iter().map(text).collect::<Vec<_>>().join(" ") }
}

impl FromStr for Word {
    type Err = WordError;

    /// # Errors     [`WordError::Text`] where the text is no side; those of [`Word::new`]
    fn from_str(text: &str) -> Result<Self, WordError> {
        if text.trim() == "1" {
            return Ok(Self::default());
        }
        let mut sides = Vec::new();
        let mut reader = Reader { text: text.chars().collect(), at: 0 };
        while let Some(c) = reader.peek() {
            if c.is_whitespace() {
                reader.at += 1;
            } else {
                sides.push(reader.side()?);
            }
        }
        Self::new(sides)
    }
}

/// A text and how far it is read.
struct Reader {
    text: Vec<char>,
    at: usize,
}

impl Reader {
    fn peek(&self) -> Option<char> {
        self.text.get(self.at).copied()
    }

    /// Complains of the next character.
    fn wrong<T>(&self) -> Result<T, WordError> {
        Err(WordError::Text { at: self.at, found: self.peek() })
    }

    /// The next character, which must be of a kind.
    fn next(&mut self, is_right: impl Fn(char) -> bool) -> Result<char, WordError> {
        let Some(c) = self.peek().filter(|&c| is_right(c)) else { return self.wrong() };
        self.at += 1;
        Ok(c)
    }

    /// Reads one side.
    fn side(&mut self) -> Result<Side, WordError> {
        let name = self.next(|c| c.is_ascii_alphabetic())?;
        let within = u32::from(name.to_ascii_lowercase() as u8 - b'a');
        let round = self.number()?;
        let Some(letter) = round.checked_mul(LETTERS).and_then(|r| r.checked_add(within)) else { return self.wrong() };
        let marked = self.mark()?;
        Ok(Side { letter: Letter(letter), inverse: name.is_ascii_uppercase() != marked })
    }

    /// The number after a letter; 0 if there is none. It starts with no 0: names would not be unique.
    fn number(&mut self) -> Result<u32, WordError> {
        let mut number = 0u32;
        while let Some(digit) = self.peek().and_then(|c| c.to_digit(10)) {
            match number.checked_mul(10).and_then(|n| n.checked_add(digit)).filter(|&n| n > 0) {
                Some(n) => number = n,
                None => return self.wrong(),
            }
            self.at += 1;
        }
        Ok(number)
    }

    /// Whether a mark of inversion follows.
    fn mark(&mut self) -> Result<bool, WordError> {
        let Some(mark) = MARKS.iter().find(|mark| self.peek().is_some_and(|c| mark.starts_with(c))) else {
            return Ok(false);
        };
        for expected in mark.chars() {
            self.next(|c| c == expected)?;
        }
        Ok(true)
    }
}
