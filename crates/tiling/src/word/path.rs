//! Paths along the sides of a polygon.
//!
//! In: steps. Out: the path without steps that are taken back at once. Holds: freely reduced, always; hence two
//! paths are equal just if they are one in the free group of the letters.

use super::{Letter, Side, VertexClass, Word, inverted};
use std::collections::BTreeMap;

/// A path of letters, each any number of times; freely reduced.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Path {
    sides: Vec<Side>,
}

impl Path {
    /// The path of some steps, freely reduced.
    ///
    /// # Cost       linear
    pub fn new(steps: impl IntoIterator<Item = Side>) -> Self {
        let mut sides: Vec<Side> = Vec::new();
        for step in steps {
            if sides.last() == Some(&step.inverted()) {
                sides.pop();
            } else {
                sides.push(step);
            }
        }
        Self { sides }
    }

    /// Its steps.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.sides.len()
    }

    /// Whether it stays where it is.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// The path walked backwards.
    pub fn inverted(&self) -> Self {
        Self { sides: inverted(&self.sides) }
    }

    /// The path with every letter replaced by the path it stands for, freely reduced; other letters stay.
    ///
    /// # Cost       linear in the length before reduction
    pub fn replaced(&self, meaning: &BTreeMap<Letter, Path>) -> Self {
        Self::new(self.sides.iter().flat_map(|side| {
            let steps = meaning.get(&side.letter).map_or(vec![Side::forward(side.letter)], |path| path.sides.clone());
            if side.inverse { inverted(&steps) } else { steps }
        }))
    }

    /// Where it starts and ends on the surface of a word.
    ///
    /// # Output     none if it is empty, has a letter that the word has not, or a step that starts elsewhere than
    /// the one before it ended
    /// # Cost       O(n log n) for the word, then O(log n) per step
    pub fn ends(&self, word: &Word) -> Option<[VertexClass; 2]> {
        let vertices = word.vertices();
        let letters: BTreeMap<Letter, [VertexClass; 2]> =
            (0..word.len()).map(|k| (word.sides()[k].letter, vertices.letter_ends(word, k))).collect();
        let mut ends: Option<[VertexClass; 2]> = None;
        for side in &self.sides {
            let &[tail, head] = letters.get(&side.letter)?;
            let [from, to] = if side.inverse { [head, tail] } else { [tail, head] };
            ends = match ends {
                None => Some([from, to]),
                Some([start, at]) if at == from => Some([start, to]),
                Some(_) => return None,
            };
        }
        ends
    }
}

impl From<&Word> for Path {
    /// The border of the polygon.
    fn from(word: &Word) -> Self {
        Self::new(word.sides().iter().copied())
    }
}
