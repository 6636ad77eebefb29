//! Polygonal schemas of surfaces as words.
//!
//! In: a polygon whose sides carry letters; sides with equal letters are glued. Out: what surface that is, the fewest
//! sides and the canonical word it can be brought to, the operations that do so, and every new letter as a path of
//! old ones. Holds: all of it is exact and combinatorial; every word with no letter more than twice is a surface.
//! Not: short paths; they are those of the operations, and meet every letter of the reduced word a few times.
//! Source: [Favreau2009] §3.3.1; the operations are those of Brahana 1921.
//!
//! ```text
//!               side k
//!   corner k ──────────────▶ corner k+1     x at side k:   tail corner k, head corner k+1
//!                                           x⁻¹ at side k: tail corner k+1, head corner k
//! ```
//!
//! | book | here | meaning |
//! |---|---|---|
//! | a1 b1 a1⁻¹ b1⁻¹ | a handle | closed curves through the base vertex that cross there once |
//! | a1 a1 | a cross-cap | a closed curve along which sides are exchanged |
//! | c1 d1 c1⁻¹ | a border on its stalk | c1 from the base vertex to the border, d1 once around it |
//! | the empty word | the sphere | the disk with all its border drawn to one point |

mod canonical;
mod operation;
mod path;
mod reduction;
mod text;
mod vertices;

pub use canonical::CanonicalForm;
pub use operation::{Operation, replay};
pub use path::Path;
pub use reduction::Reduction;
pub use vertices::{Invariants, VertexClass, Vertices};

use std::collections::BTreeMap;

/// What sides that are glued have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Letter(pub u32);

/// A corner of a polygon: the one at which the side of the same number starts when sides are walked forwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Corner(pub u32);

impl Corner {
    /// The corner of a position.
    pub(crate) fn at(position: usize) -> Self {
        Self(position as u32)
    }

    /// As a position in the list of sides.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A letter with a direction: a side of a polygon, or a step of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Side {
    /// Its letter.
    pub letter: Letter,
    /// Whether the letter is met from its head to its tail.
    pub inverse: bool,
}

impl Side {
    /// The letter in its own direction.
    pub fn forward(letter: Letter) -> Self {
        Self { letter, inverse: false }
    }

    /// The same letter in the other direction.
    pub fn inverted(self) -> Self {
        Self { inverse: !self.inverse, ..self }
    }

    /// Itself, or inverted.
    pub(crate) fn inverted_if(self, turn: bool) -> Self {
        Self { inverse: self.inverse != turn, ..self }
    }
}

/// What is wrong with a word, its text, or an operation on it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WordError {
    /// More than two sides with the same letter are glued to no surface.
    #[error("letter {letter} stands at sides {sides:?}; a letter may stand at two at most")]
    Thrice {
        /// The letter.
        letter: Letter,
        /// Its first three sides, by the corners at which they start.
        sides: [Corner; 3],
    },
    /// Corners are numbered with 32 bits.
    #[error("{0} sides are more than can be numbered; give at most 4294967295")]
    TooLong(usize),
    /// A text is no word.
    #[error("character {at}: found {found:?}; a side is a letter, digits or none, and ⁻¹, ^-1, ' or nothing")]
    Text {
        /// Position, in characters from 0.
        at: usize,
        /// What stands there; nothing at the end of the text.
        found: Option<char>,
    },
    /// The word has no such corner, or not in this order.
    #[error("corner {corner:?} is not one that the operation may name; the word has {sides} sides")]
    Corner {
        /// The corner.
        corner: Corner,
        /// Number of sides.
        sides: usize,
    },
    /// The sides at a corner do not cancel.
    #[error("the sides that meet at {corner:?} are not a letter and its inverse; nothing cancels there")]
    NotInverse {
        /// The corner.
        corner: Corner,
    },
    /// No side has the letter.
    #[error("letter {letter} is not in the word")]
    Missing {
        /// The letter.
        letter: Letter,
    },
    /// A letter for a new curve is one of the word.
    #[error("letter {letter} is in the word already; name a new one")]
    NotNew {
        /// The letter.
        letter: Letter,
    },
    /// A side that is drawn to a point must have two ends, and its head may not leave the border.
    #[error("letter {letter} cannot be drawn to a point: its ends are one vertex, or its head lies on the border")]
    NotContractible {
        /// The letter.
        letter: Letter,
    },
    /// Two parts are glued along a letter that both have.
    #[error("letter {letter} does not have one side in each of the two parts; they cannot be glued along it")]
    NotShared {
        /// The letter.
        letter: Letter,
    },
    /// New letters must stand for the letters of the word one to one.
    #[error("the new letters do not stand for the letters of the word one to one: {letter} is missing or twice")]
    NotOneToOne {
        /// A letter at which it fails.
        letter: Letter,
    },
}

/// A polygon with letters at its sides: a surface, possibly with border.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Word {
    sides: Vec<Side>,
}

impl Word {
    /// A word of sides.
    ///
    /// # Input      sides in the order of the polygon's border; one with no equal becomes border of the surface
    /// # Errors     [`WordError::Thrice`], [`WordError::TooLong`]
    pub fn new(sides: Vec<Side>) -> Result<Self, WordError> {
        if u32::try_from(sides.len()).is_err() {
            return Err(WordError::TooLong(sides.len()));
        }
        let mut found: BTreeMap<Letter, Vec<Corner>> = BTreeMap::new();
        for (k, side) in sides.iter().enumerate() {
            let at = found.entry(side.letter).or_default();
            at.push(Corner::at(k));
            if let &[a, b, c] = &at[..] {
                return Err(WordError::Thrice { letter: side.letter, sides: [a, b, c] });
            }
        }
        Ok(Self { sides })
    }

    /// A word of sides that are known to be one.
    pub(crate) fn of(sides: Vec<Side>) -> Self {
        debug_assert!(Self::new(sides.clone()).is_ok());
        Self { sides }
    }

    /// Its sides.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// Number of sides.
    pub fn len(&self) -> usize {
        self.sides.len()
    }

    /// Whether it has no sides: the sphere.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// Its letters, rising.
    pub fn letters(&self) -> Vec<Letter> {
        let mut letters: Vec<Letter> = self.sides.iter().map(|s| s.letter).collect();
        letters.sort_unstable();
        letters.dedup();
        letters
    }

    /// For every side the position of the one it is glued to; none at the border.
    ///
    /// # Cost       O(n log n)
    pub(crate) fn partners(&self) -> Vec<Option<usize>> {
        let mut order: Vec<(Letter, usize)> = self.sides.iter().enumerate().map(|(k, s)| (s.letter, k)).collect();
        order.sort_unstable();
        let mut partners = vec![None; self.len()];
        for pair in order.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            partners[pair[0].1] = Some(pair[1].1);
            partners[pair[1].1] = Some(pair[0].1);
        }
        partners
    }

    /// The positions of a letter.
    pub(crate) fn positions(&self, letter: Letter) -> impl Iterator<Item = usize> {
        self.sides.iter().enumerate().filter(move |(_, s)| s.letter == letter).map(|(k, _)| k)
    }

    /// The same polygon read from another corner.
    ///
    /// # Errors     [`WordError::Corner`] beyond the last one
    pub fn rotated(&self, first: Corner) -> Result<Self, WordError> {
        if first.index() > self.len() {
            return Err(WordError::Corner { corner: first, sides: self.len() });
        }
        let mut sides = self.sides.clone();
        sides.rotate_left(first.index());
        Ok(Self { sides })
    }

    /// The same polygon seen from below.
    pub fn inverted(&self) -> Self {
        Self { sides: inverted(&self.sides) }
    }

    /// The same polygon with letters 0, 1, … in the order in which they are met first, each forwards then.
    pub fn relettered(&self) -> Self {
        let mut names: BTreeMap<Letter, Side> = BTreeMap::new();
        let mut sides = Vec::with_capacity(self.len());
        for side in &self.sides {
            let fresh = Letter(names.len() as u32);
            let name = names.entry(side.letter).or_insert(Side { letter: fresh, inverse: side.inverse });
            sides.push(Side { letter: name.letter, inverse: name.inverse != side.inverse });
        }
        Self { sides }
    }

    /// The word that stands for all that differ from this one by rotation, inversion and names of letters.
    ///
    /// # Output     letters 0, 1, … in the order in which they are met first; equal for two words just if they are
    /// the same polygon with the same gluing
    /// # Cost       O(n log n)
    pub fn representative(&self) -> Self {
        [self.clone(), self.inverted()]
            .map(|word| {
                let mut gaps = word.gaps();
                let first = least_rotation(&gaps);
                gaps.rotate_left(first);
                let mut sides = word.sides;
                sides.rotate_left(first);
                (gaps, Self { sides })
            })
            .into_iter()
            .min_by(|a, b| a.0.cmp(&b.0))
            .map_or_else(Self::default, |(_, word)| word.relettered())
    }

    /// Whether two words are one up to rotation, inversion and names of letters.
    pub fn is_same_schema(&self, other: &Self) -> bool {
        self.len() == other.len() && self.representative() == other.representative()
    }

    /// Whether it is the canonical word of its surface, up to names and directions of letters.
    ///
    /// # Guarantees read from corner 0, handles or cross-caps first, then borders; not up to rotation
    pub fn is_canonical(&self) -> bool {
        self.relettered() == self.invariants().canonical_word()
    }

    /// For every side how far ahead its partner is, and whether it points the same way; (0, false) at the border.
    ///
    /// These numbers rotate with the word and know nothing of names; the word follows from them.
    fn gaps(&self) -> Vec<(usize, bool)> {
        let n = self.len();
        let gap = |k: usize, m: usize| ((m + n - k) % n, self.sides[k].inverse == self.sides[m].inverse);
        self.partners().iter().enumerate().map(|(k, m)| m.map_or((0, false), |m| gap(k, m))).collect()
    }
}

/// The sides of a path walked backwards.
pub(crate) fn inverted(sides: &[Side]) -> Vec<Side> {
    sides.iter().rev().map(|s| s.inverted()).collect()
}

/// Where the least of all rotations of a list starts.
///
/// Two starts i and j run against each other; the one that loses at distance k is beaten together with the k starts
/// after it. Linear.
fn least_rotation<T: Ord>(list: &[T]) -> usize {
    let n = list.len();
    let (mut i, mut j, mut k) = (0, 1, 0);
    while i < n && j < n && k < n {
        match list[(i + k) % n].cmp(&list[(j + k) % n]) {
            std::cmp::Ordering::Equal => {
                k += 1;
                continue;
            }
            std::cmp::Ordering::Less => j += k + 1,
            std::cmp::Ordering::Greater => i += k + 1,
        }
        j += usize::from(i == j);
        k = 0;
    }
    i.min(j).min(n.saturating_sub(1))
}
