//! Presentations ⟨R, S, T | R^p, S^q, T², (RS)², (ST)², (RT)², …⟩ of the group of a regular map.
//!
//! In: text. Out: [`Presentation`]: p, q and the extra relators. Holds: the standard relators are always meant, whether
//! they were written or not. Source: [Razafindrazaka2015] §9.1, Def. 9.2, Eq. (9.1).

use crate::error::MapError;
use crate::map::Reflection;
use crate::word::{Letter, Word};
use std::fmt;

/// The group of a regular map of type {p, q}, by generators and relators.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presentation {
    /// Corners of a face: the order of R.
    pub p: usize,
    /// Faces at a vertex: the order of S.
    pub q: usize,
    /// Relators besides R^p, S^q, T², (RS)², (ST)², (RT)².
    pub extra: Vec<Word>,
}

impl Presentation {
    /// The presentation of type {p, q} with these extra relators.
    pub fn new(p: usize, q: usize, extra: Vec<Word>) -> Self {
        Self { p, q, extra }
    }

    /// Reads `⟨R, S, T | R^3, S^7, …⟩`; the angle brackets (also `<` and `>`) and what stands before `|` may be missing.
    ///
    /// # Output     p and q are taken from the relators that are powers of R and of S alone
    /// # Errors     what cannot be read; [`MapError::NoType`] where R^p or S^q is missing, [`MapError::TwoTypes`] where two
    ///   powers of one of them differ
    pub fn parse(text: &str) -> Result<Self, MapError> {
        let inner = text.trim().trim_start_matches(['⟨', '<']).trim_end_matches(['⟩', '>']);
        let relators = match inner.split_once('|') {
            Some((generators, relators)) => {
                check_generators(text, generators)?;
                relators
            }
            None => inner,
        };
        let words: Vec<Word> = relators
            .split(',')
            .filter(|part| !part.trim().is_empty())
            .map(|part| Word::parse(part.trim()))
            .collect::<Result<_, _>>()?;
        Self::from_relators(words)
    }

    /// Sorts relators into the type and the rest.
    pub fn from_relators(words: Vec<Word>) -> Result<Self, MapError> {
        let mut orders = [0usize; 2];
        let mut extra = Vec::new();
        for word in words {
            match word.as_power() {
                Some((Letter::R | Letter::RInverse, n)) => state(&mut orders[0], 'R', n)?,
                Some((Letter::S | Letter::SInverse, n)) => state(&mut orders[1], 'S', n)?,
                _ if is_standard(&word) => {}
                _ => extra.push(word),
            }
        }
        match orders {
            [0 | 1, _] => Err(MapError::NoType('R')),
            [_, 0 | 1] => Err(MapError::NoType('S')),
            [p, q] => Ok(Self { p, q, extra }),
        }
    }

    /// All relators but r₀², r₁², r₂², in reflections.
    pub fn relators(&self) -> Vec<Vec<Reflection>> {
        use Reflection::{R0, R1, R2};
        let turn = |a, b, n: usize| [a, b].repeat(n);
        let mut all = vec![turn(R0, R1, self.p), turn(R1, R2, self.q), turn(R0, R2, 2)];
        all.extend(self.extra.iter().map(Word::reflections).filter(|word| !word.is_empty()));
        all
    }

    /// The presentation of the dual map: faces and vertices change places.
    pub fn dual(&self) -> Self {
        let swap = |word: &Word| {
            let reflections: Vec<_> = word.reflections().into_iter().map(Reflection::dual).collect();
            Word::of_reflections(&reflections)
        };
        Self { p: self.q, q: self.p, extra: self.extra.iter().map(swap).collect() }
    }
}

impl fmt::Display for Presentation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "⟨R, S, T | R^{}, S^{}, T^2, (R*S)^2, (S*T)^2, (R*T)^2", self.p, self.q)?;
        for word in &self.extra {
            write!(f, ", {word}")?;
        }
        write!(f, "⟩")
    }
}

fn check_generators(text: &str, generators: &str) -> Result<(), MapError> {
    for name in generators.split(',').map(str::trim) {
        if !["R", "S", "T", "r0", "r1", "r2"].contains(&name) {
            let at = text.find(name).unwrap_or(0) + 1;
            return Err(MapError::Syntax { text: text.into(), at, what: format!("{name:?} is no generator of a map") });
        }
    }
    Ok(())
}

/// T², (RS)², (ST)², (RT)², which hold in every map: as reflections, squares of r₁, r₀r₂, r₂ and r₀.
fn is_standard(word: &Word) -> bool {
    let reflections = word.reflections();
    reflections.is_empty()
        || (reflections.len() == 4
            && reflections[0] == reflections[2]
            && reflections[1] == reflections[3]
            && !reflections.contains(&Reflection::R1))
}

/// Takes a power of R or S as p or q; who wrote two meant one of them.
fn state(order: &mut usize, letter: char, n: usize) -> Result<(), MapError> {
    match *order {
        0 => *order = n,
        stated if stated != n => return Err(MapError::TwoTypes(letter, stated, n)),
        _ => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cube_is_read() {
        let cube = Presentation::parse("⟨R, S, T | R^4, S^3, T^2, (R*S)^2, (S*T)^2, (R*T)^2⟩").unwrap();
        assert_eq!(cube, Presentation::new(4, 3, vec![]));
        assert_eq!(Presentation::parse(&cube.to_string()).unwrap(), cube);
    }

    #[test]
    fn a_presentation_without_a_type_is_refused() {
        assert_eq!(Presentation::parse("R^4, T^2"), Err(MapError::NoType('S')));
        assert_eq!(Presentation::parse("<R,S,T|S^3>"), Err(MapError::NoType('R')));
        assert!(matches!(Presentation::parse("<R,Q | R^3>"), Err(MapError::Syntax { .. })));
    }

    #[test]
    fn two_sizes_of_a_face_are_refused() {
        assert_eq!(Presentation::parse("R^6, S^4, R^3"), Err(MapError::TwoTypes('R', 6, 3)));
        assert_eq!(Presentation::parse("R^3, S^4, R^3, S^-4"), Ok(Presentation::new(3, 4, vec![])));
    }
}
