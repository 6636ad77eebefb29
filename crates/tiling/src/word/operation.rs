//! Operations on words that keep the surface.
//!
//! In: a word and an operation. Out: the next word, and every letter that changed as a path of letters of the word
//! before. Holds: an operation that is not refused keeps the Euler characteristic, orientability and the number of
//! borders; the border of the polygon stays the same path up to rotation, in the free group, when letters are
//! replaced by their paths.
//! Source: [Favreau2009] §3.3.1 (contraction); Brahana 1921 (cut and glue).
//!
//! ```text
//!   Contract x    a side with two ends is drawn back to its tail            … p x q … x⁻¹ r …  ▶  … p q … r …
//!   CutAndGlue    x := L y M, cut through the polygon; y glued              … L y M … y⁻¹ …    ▶  … x … M x⁻¹ L …
//! ```

use super::{Corner, Letter, Path, Side, Word, WordError, inverted};
use std::collections::{BTreeMap, BTreeSet};

/// A step from one word of a surface to another.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Operation {
    /// Reads the polygon from another corner.
    Rotate {
        /// The corner that becomes the first.
        first: Corner,
    },
    /// Glues the two sides at a corner, a letter and its inverse; their common end is then inside the polygon.
    Cancel {
        /// The corner between them.
        corner: Corner,
    },
    /// Draws a side back to its tail; what ended at its head ends at its tail then.
    Contract {
        /// The letter, and the direction in which it is walked to the end that moves.
        side: Side,
    },
    /// Splits the vertex of two corners in two, joined by a new letter: what a contraction of that letter undoes.
    Expand {
        /// The new letter.
        letter: Letter,
        /// The corner at which it is inserted forwards.
        from: Corner,
        /// The corner at which it is inserted backwards, not before the other.
        to: Corner,
    },
    /// Cuts the polygon from corner to corner and glues the two parts along another letter.
    CutAndGlue {
        /// Where the cut starts.
        from: Corner,
        /// Where the cut ends; later than its start. The last corner may be named by the number of sides.
        to: Corner,
        /// The letter of the cut, new, in that direction: it stands for the sides between.
        cut: Letter,
        /// The letter that has one side between the corners and the other beyond.
        along: Letter,
    },
    /// Gives new names and directions to all letters.
    Reletter {
        /// Each new letter with the side it stands for.
        letters: Vec<(Letter, Side)>,
    },
}

/// Does operations one after the other.
///
/// # Errors     the first one that is refused
pub fn replay(word: &Word, operations: &[Operation]) -> Result<Word, WordError> {
    operations.iter().try_fold(word.clone(), |word, operation| operation.apply(&word))
}

impl Operation {
    /// The word after the operation.
    ///
    /// # Errors     [`WordError`] if the operation would change the surface, or names what is not there
    /// # Cost       linear; O(n log n) for a contraction or an expansion
    pub fn apply(&self, word: &Word) -> Result<Word, WordError> {
        match self {
            Self::Rotate { first } => word.rotated(*first),
            Self::Cancel { corner } => cancel(word, *corner),
            Self::Contract { side } => contract(word, *side),
            Self::Expand { letter, from, to } => expand(word, *letter, *from, *to),
            &Self::CutAndGlue { from, to, cut, along } => cut_and_glue(word, from, to, cut, along),
            Self::Reletter { letters } => reletter(word, letters),
        }
    }

    /// The letters of the next word that are other paths than before, in letters of this word.
    ///
    /// # Output     letters that are not named are what they were. An expansion's letter is an empty path: its two
    /// ends were one vertex.
    /// # Errors     those of [`Operation::apply`]
    pub fn new_letters(&self, word: &Word) -> Result<Vec<(Letter, Path)>, WordError> {
        self.apply(word)?;
        Ok(self.changes(word))
    }

    /// The changed letters of an operation that is a right one.
    pub(crate) fn changes(&self, word: &Word) -> Vec<(Letter, Path)> {
        match self {
            Self::Rotate { .. } | Self::Cancel { .. } => Vec::new(),
            Self::Contract { side } => drawn_back(word, *side),
            Self::Expand { letter, .. } => vec![(*letter, Path::default())],
            Self::CutAndGlue { from, to, cut, .. } => {
                vec![(*cut, Path::new(word.sides()[from.index()..to.index()].iter().copied()))]
            }
            Self::Reletter { letters } => letters.iter().map(|&(new, old)| (new, Path::new([old]))).collect(),
        }
    }
}

/// Takes out the sides before and after a corner.
fn cancel(word: &Word, corner: Corner) -> Result<Word, WordError> {
    let n = word.len();
    if corner.index() >= n {
        return Err(WordError::Corner { corner, sides: n });
    }
    let (before, after) = ((corner.index() + n - 1) % n, corner.index());
    if word.sides()[before] != word.sides()[after].inverted() {
        return Err(WordError::NotInverse { corner });
    }
    let kept = |k: &usize| *k != before && *k != after;
    Ok(Word::of((0..n).filter(kept).map(|k| word.sides()[k]).collect()))
}

/// Takes out a side with two ends.
fn contract(word: &Word, side: Side) -> Result<Word, WordError> {
    let letter = side.letter;
    let at: Vec<usize> = word.positions(letter).collect();
    let &first = at.first().ok_or(WordError::Missing { letter })?;
    let vertices = word.vertices();
    let mut ends = vertices.letter_ends(word, first);
    if side.inverse {
        ends.reverse();
    }
    // Two borders, or two places of one, would meet at a point.
    let pinches = at.len() == 2 && vertices.is_border(ends[1]);
    if ends[0] == ends[1] || pinches {
        return Err(WordError::NotContractible { letter });
    }
    Ok(Word::of(word.sides().iter().copied().filter(|s| s.letter != letter).collect()))
}

/// The letters that ended where a contracted side's head was: they go back along it.
fn drawn_back(word: &Word, side: Side) -> Vec<(Letter, Path)> {
    let vertices = word.vertices();
    let Some(first) = word.positions(side.letter).next() else { return Vec::new() };
    let moved = vertices.letter_ends(word, first)[usize::from(!side.inverse)];
    let mut seen: BTreeSet<Letter> = BTreeSet::new();
    let mut changed = Vec::new();
    for k in (0..word.len()).filter(|&k| word.sides()[k].letter != side.letter) {
        let letter = word.sides()[k].letter;
        let [tail, head] = vertices.letter_ends(word, k).map(|v| v == moved);
        if (tail || head) && seen.insert(letter) {
            let before = tail.then_some(side);
            let after = head.then_some(side.inverted());
            changed.push((letter, Path::new(before.into_iter().chain([Side::forward(letter)]).chain(after))));
        }
    }
    changed
}

/// Puts a new letter and its inverse in at two corners.
fn expand(word: &Word, letter: Letter, from: Corner, to: Corner) -> Result<Word, WordError> {
    let n = word.len();
    for (corner, most) in [(from, to.index()), (to, n)] {
        if corner.index() > most {
            return Err(WordError::Corner { corner, sides: n });
        }
    }
    check_new(word, letter)?;
    let new = Side::forward(letter);
    let [head, rest] = [&word.sides()[..from.index()], &word.sides()[from.index()..]];
    let (middle, tail) = rest.split_at(to.index() - from.index());
    let wide = Word::of([head, &[new], middle, &[new.inverted()], tail].concat());
    // It is right just if it can be undone, on one side or the other.
    contract(&wide, new).or_else(|_| contract(&wide, new.inverted()))?;
    Ok(wide)
}

/// Cuts along a new letter and glues along one that is shared.
///
/// Leaves everything in its place: the sides between become the cut, and the glued letter's other side is replaced by
/// what it is now equal to.
fn cut_and_glue(word: &Word, from: Corner, to: Corner, cut: Letter, along: Letter) -> Result<Word, WordError> {
    let n = word.len();
    let (from, to) = (from.index(), to.index());
    if to > n {
        return Err(WordError::Corner { corner: Corner::at(to), sides: n });
    }
    if from >= to {
        return Err(WordError::Corner { corner: Corner::at(from), sides: n });
    }
    check_new(word, cut)?;
    let shared: Vec<usize> = word.positions(along).collect();
    let (inner, outer) = match shared[..] {
        [a, b] if (from..to).contains(&a) && !(from..to).contains(&b) => (a, b),
        [a, b] if (from..to).contains(&b) && !(from..to).contains(&a) => (b, a),
        [] => return Err(WordError::Missing { letter: along }),
        _ => return Err(WordError::NotShared { letter: along }),
    };
    let sides = word.sides();
    // cut = L y M, hence y = L⁻¹ cut M⁻¹.
    let mut other = inverted(&sides[from..inner]);
    other.push(Side::forward(cut));
    other.extend(inverted(&sides[inner + 1..to]));
    if sides[inner].inverse != sides[outer].inverse {
        other = inverted(&other);
    }
    let mut next = Vec::with_capacity(n);
    for k in (0..n).filter(|k| *k == from || !(from..to).contains(k)) {
        match k {
            _ if k == from => next.push(Side::forward(cut)),
            _ if k == outer => next.extend_from_slice(&other),
            _ => next.push(sides[k]),
        }
    }
    Ok(Word::of(next))
}

/// Renames the letters.
fn reletter(word: &Word, letters: &[(Letter, Side)]) -> Result<Word, WordError> {
    let mut names: BTreeMap<Letter, Side> = BTreeMap::new();
    let mut used: BTreeSet<Letter> = BTreeSet::new();
    for &(new, old) in letters {
        if !used.insert(new) || names.insert(old.letter, Side { letter: new, inverse: old.inverse }).is_some() {
            return Err(WordError::NotOneToOne { letter: new });
        }
    }
    let stray = letters.iter().find(|(_, old)| word.positions(old.letter).next().is_none());
    if let Some(&(_, Side { letter, .. })) = stray {
        return Err(WordError::Missing { letter });
    }
    let renamed = |side: &Side| {
        let name = names.get(&side.letter).ok_or(WordError::NotOneToOne { letter: side.letter })?;
        Ok(name.inverted_if(side.inverse))
    };
    Ok(Word::of(word.sides().iter().map(renamed).collect::<Result<_, WordError>>()?))
}

/// Refuses a letter that is taken.
fn check_new(word: &Word, letter: Letter) -> Result<(), WordError> {
    if word.positions(letter).next().is_some() { Err(WordError::NotNew { letter }) } else { Ok(()) }
}
