//! Words in the generators of a map's group.
//!
//! In: text such as `(R*S^-1)^2*T`. Out: [`Word`], and the same as a product of flag reflections.
//! Holds: printing and parsing give the same word back; nothing is reduced but what stands side by side.

use crate::error::MapError;
use crate::map::Reflection;
use std::fmt;

/// A generator of the group, or the inverse of one: R turns the base face, S the base vertex, T is a reflection
/// ([Razafindrazaka2015] §9.1, Def. 9.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Letter {
    /// R.
    R,
    /// R⁻¹.
    RInverse,
    /// S.
    S,
    /// S⁻¹.
    SInverse,
    /// T, its own inverse.
    T,
}

impl Letter {
    /// The inverse generator.
    pub fn inverse(self) -> Self {
        match self {
            Self::R => Self::RInverse,
            Self::RInverse => Self::R,
            Self::S => Self::SInverse,
            Self::SInverse => Self::S,
            Self::T => Self::T,
        }
    }

    /// The same as a product of reflections: R = r₀r₁, S = r₁r₂, T = r₁.
    pub fn reflections(self) -> &'static [Reflection] {
        use Reflection::{R0, R1, R2};
        match self {
            Self::R => &[R0, R1],
            Self::RInverse => &[R1, R0],
            Self::S => &[R1, R2],
            Self::SInverse => &[R2, R1],
            Self::T => &[R1],
        }
    }

    fn symbol(self) -> (char, i64) {
        match self {
            Self::R => ('R', 1),
            Self::RInverse => ('R', -1),
            Self::S => ('S', 1),
            Self::SInverse => ('S', -1),
            Self::T => ('T', 1),
        }
    }
}

/// A product of generators, read from left to right.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word(Vec<Letter>);

/// Longest word that is read: powers can write long ones in a few characters.
const LONGEST: usize = 1 << 16;

impl Word {
    /// The word of these letters, without a letter beside its inverse.
    pub fn new(letters: impl IntoIterator<Item = Letter>) -> Self {
        let mut word = Self::default();
        letters.into_iter().for_each(|letter| word.push(letter));
        word
    }

    /// The letters from left to right.
    pub fn letters(&self) -> &[Letter] {
        &self.0
    }

    /// Multiplies by a letter from the right.
    pub fn push(&mut self, letter: Letter) {
        if self.0.last() == Some(&letter.inverse()) {
            self.0.pop();
        } else {
            self.0.push(letter);
        }
    }

    /// This word, then the other.
    pub fn then(&self, other: &Self) -> Self {
        Self::new(self.0.iter().chain(&other.0).copied())
    }

    /// The inverse word.
    pub fn inverse(&self) -> Self {
        Self(self.0.iter().rev().map(|l| l.inverse()).collect())
    }

    /// The word `exponent` times, or its inverse where that is negative.
    pub fn power(&self, exponent: i64) -> Self {
        let base = if exponent < 0 { self.inverse() } else { self.clone() };
        Self::new((0..exponent.unsigned_abs()).flat_map(|_| base.0.clone()))
    }

    /// The word as a product of flag reflections, without one beside itself.
    pub fn reflections(&self) -> Vec<Reflection> {
        let mut out: Vec<Reflection> = Vec::new();
        for &reflection in self.0.iter().flat_map(|l| l.reflections()) {
            if out.last() == Some(&reflection) {
                out.pop();
            } else {
                out.push(reflection);
            }
        }
        out
    }

    /// The word of a product of reflections: r₀ = RT, r₁ = T, r₂ = TS.
    pub fn of_reflections(reflections: &[Reflection]) -> Self {
        Self::new(reflections.iter().flat_map(|r| match r {
            Reflection::R0 => [Letter::R, Letter::T].iter().copied(),
            Reflection::R1 => [Letter::T].iter().copied(),
            Reflection::R2 => [Letter::T, Letter::S].iter().copied(),
        }))
    }

    /// If the word is a power of one letter: that letter and the exponent.
    pub fn as_power(&self) -> Option<(Letter, usize)> {
        let first = *self.0.first()?;
        self.0.iter().all(|&l| l == first).then_some((first, self.0.len()))
    }

    /// Reads a word: R, S, T, r0, r1, r2, brackets, powers, `*` or nothing between factors; `1` is the empty word.
    ///
    /// # Errors     the character that cannot be read
    pub fn parse(text: &str) -> Result<Self, MapError> {
        let mut parser = Parser { text, chars: text.chars().collect(), at: 0 };
        let word = parser.product()?;
        match parser.peek() {
            None => Ok(word),
            Some(c) => Err(parser.error(format!("{c:?} was not expected"))),
        }
    }
}

impl fmt::Display for Word {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return write!(f, "1");
        }
        let runs = self.0.chunk_by(|a, b| a == b);
        for (i, run) in runs.enumerate() {
            let (symbol, sign) = run[0].symbol();
            let exponent = sign * run.len() as i64;
            let star = if i == 0 { "" } else { "*" };
            match exponent {
                1 => write!(f, "{star}{symbol}")?,
                _ => write!(f, "{star}{symbol}^{exponent}")?,
            }
        }
        Ok(())
    }
}

struct Parser<'a> {
    text: &'a str,
    chars: Vec<char>,
    at: usize,
}

impl Parser<'_> {
    fn error(&self, what: impl Into<String>) -> MapError {
        MapError::Syntax { text: self.text.into(), at: self.at + 1, what: what.into() }
    }

    fn peek(&mut self) -> Option<char> {
        while self.chars.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.chars.get(self.at).copied()
    }

    fn product(&mut self) -> Result<Word, MapError> {
        let mut word = self.factor()?;
        loop {
            match self.peek() {
                Some('*' | '·' | '.') => {
                    self.at += 1;
                    word = word.then(&self.factor()?);
                }
                Some(c) if c == '(' || c.is_ascii_alphabetic() => word = word.then(&self.factor()?),
                _ => break,
            }
            if word.0.len() > LONGEST {
                return Err(self.error(format!("the word has more than {LONGEST} letters")));
            }
        }
        Ok(word)
    }

    fn factor(&mut self) -> Result<Word, MapError> {
        let base = self.base()?;
        let Some('^') = self.peek() else { return Ok(base) };
        self.at += 1;
        let exponent = self.exponent()?;
        if base.0.len().saturating_mul(exponent.unsigned_abs() as usize) > LONGEST {
            return Err(self.error(format!("the word has more than {LONGEST} letters")));
        }
        Ok(base.power(exponent))
    }

    fn base(&mut self) -> Result<Word, MapError> {
        let Some(c) = self.peek() else { return Err(self.error("a generator or bracket is missing")) };
        self.at += 1;
        match c {
            'R' => Ok(Word(vec![Letter::R])),
            'S' => Ok(Word(vec![Letter::S])),
            'T' => Ok(Word(vec![Letter::T])),
            '1' => Ok(Word::default()),
            'r' => match self.peek().and_then(Reflection::from_digit) {
                Some(reflection) => {
                    self.at += 1;
                    Ok(Word::of_reflections(&[reflection]))
                }
                None => Err(self.error("r must be followed by 0, 1 or 2")),
            },
            '(' => {
                let word = self.product()?;
                if self.peek() != Some(')') {
                    return Err(self.error("a closing bracket is missing"));
                }
                self.at += 1;
                Ok(word)
            }
            _ => {
                self.at -= 1;
                Err(self.error(format!("{c:?} is no generator")))
            }
        }
    }

    fn exponent(&mut self) -> Result<i64, MapError> {
        let bracket = self.peek() == Some('(');
        if bracket {
            self.at += 1;
        }
        let negative = self.peek() == Some('-');
        if negative {
            self.at += 1;
        }
        self.peek();
        let digits: String = self.chars[self.at..].iter().take_while(|c| c.is_ascii_digit()).collect();
        let value: i64 = match digits.parse() {
            Ok(value) if value <= LONGEST as i64 => value,
            Ok(_) => return Err(self.error(format!("the exponent is larger than {LONGEST}"))),
            Err(_) => return Err(self.error("a whole number was expected as exponent")),
        };
        self.at += digits.len();
        if bracket {
            if self.peek() != Some(')') {
                return Err(self.error("a closing bracket is missing"));
            }
            self.at += 1;
        }
        Ok(if negative { -value } else { value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_as_they_are_printed() {
        for text in ["R*S*R^2*S*R^-1", "T", "1", "S^-3*T*R^2"] {
            assert_eq!(Word::parse(text).unwrap().to_string(), text);
        }
        assert_eq!(Word::parse("(R S^-1)^2").unwrap().to_string(), "R*S^-1*R*S^-1");
        assert_eq!(Word::parse("(R*S)^-2").unwrap().to_string(), "S^-1*R^-1*S^-1*R^-1");
        assert_eq!(Word::parse("r0*r2").unwrap().to_string(), "R*S");
        assert_eq!(Word::parse("R^(-2)*R^2").unwrap().to_string(), "1");
    }

    #[test]
    fn a_word_that_cannot_be_read_is_an_error_with_its_place() {
        for (text, at) in [("R*Q", 3), ("R^", 3), ("(R*S", 5), ("R*", 3), ("", 1), ("R)", 2), ("r3", 2)] {
            match Word::parse(text) {
                Err(MapError::Syntax { at: found, .. }) => assert_eq!(found, at, "{text:?}"),
                other => panic!("{text:?} gave {other:?}"),
            }
        }
        assert!(Word::parse("R^99999999999999999999").is_err() && Word::parse("((R^999)^999)^999").is_err());
    }

    #[test]
    fn reflections_and_letters_name_the_same_elements() {
        let word = Word::parse("R*S^-1*T*R^2").unwrap();
        let again = Word::of_reflections(&word.reflections());
        assert_eq!(again.reflections(), word.reflections());
    }
}
