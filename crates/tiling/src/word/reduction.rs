//! The fewest sides.
//!
//! In: a word. Out: a word of the same surface with one vertex (with borders: one vertex and one side on each), the
//! operations, and what its letters are in letters of the first word. Holds: sides are then 4·genus, or 2·genus if
//! the surface is not orientable, and with borders 3·borders − 2 more; that is the minimum.
//! Source: [Favreau2009] §3.3.1: a side whose ends differ is taken out and its ends merged.

use super::{Corner, Letter, Operation, Path, Side, Vertices, Word};
use std::collections::{BTreeMap, BTreeSet};

/// A word of fewest sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reduction {
    /// The word.
    pub word: Word,
    /// How it was reached; [`replay`](super::replay) does it again.
    pub operations: Vec<Operation>,
    /// Its letters, rising, each as a path of letters of the first word.
    pub letters: Vec<(Letter, Path)>,
}

impl Word {
    /// A word of the same surface with as few sides as there can be.
    ///
    /// # Output     closed surface: one vertex; a sphere: the empty word, and the last operation is the one that
    /// cancels a a⁻¹, so that whoever needs a polygon with sides leaves that one out. With borders: one
    /// vertex and one side on each border and no vertex elsewhere; a disk: one side.
    /// # Cost       O(n² log n)
    /// # Guarantees every letter is a path along letters of the first word, through each of its vertices at most
    /// once before and once after that letter; a border's letter is the ring of its sides
    /// # Source     [Favreau2009] §3.3.1
    pub fn reduced(&self) -> Reduction {
        let mut steps = Steps::new(self);
        steps.contract_all(0);
        let letters = steps.word.letters().into_iter().map(|l| (l, steps.path(l))).collect();
        Reduction { word: steps.word, operations: steps.operations, letters }
    }
}

/// A word on its way, with all that led to it.
pub(super) struct Steps {
    pub(super) word: Word,
    pub(super) operations: Vec<Operation>,
    /// Letters that are no longer what they were named at first.
    paths: BTreeMap<Letter, Path>,
    /// Letters that new ones must differ from.
    taken: BTreeSet<Letter>,
    next: u32,
}

impl Steps {
    pub(super) fn new(word: &Word) -> Self {
        let taken = word.letters().into_iter().collect();
        Self { word: word.clone(), operations: Vec::new(), paths: BTreeMap::new(), taken, next: 0 }
    }

    /// What a letter is in letters of the first word.
    pub(super) fn path(&self, letter: Letter) -> Path {
        self.paths.get(&letter).cloned().unwrap_or_else(|| Path::new([Side::forward(letter)]))
    }

    /// A letter that the word never had.
    pub(super) fn new_letter(&mut self) -> Letter {
        while !self.taken.insert(Letter(self.next)) {
            self.next += 1;
        }
        Letter(self.next)
    }

    /// Does a step.
    pub(super) fn apply(&mut self, operation: Operation) {
        let next = operation.apply(&self.word).expect("every step of a reduction is a right one");
        let changed = operation.changes(&self.word);
        let paths: Vec<(Letter, Path)> =
            changed.into_iter().map(|(letter, path)| (letter, path.replaced(&self.paths))).collect();
        self.paths.extend(paths);
        self.word = next;
        self.operations.push(operation);
    }

    /// Contracts sides while there are any whose contraction leaves at least `kept` vertices inside the surface.
    pub(super) fn contract_all(&mut self, kept: usize) {
        while let Some(operation) = next_contraction(&self.word, kept) {
            self.apply(operation);
        }
    }

    /// Replaces the sides between two positions by one, glued along a letter that is there once.
    ///
    /// A single side stays as it is.
    pub(super) fn absorb(&mut self, from: usize, to: usize, along: Letter) {
        if to - from > 1 {
            let cut = self.new_letter();
            self.apply(Operation::CutAndGlue { from: Corner::at(from), to: Corner::at(to), cut, along });
        }
    }
}

/// A cancellation, or else the contraction of a side; none if nothing can be contracted.
fn next_contraction(word: &Word, kept: usize) -> Option<Operation> {
    let n = word.len();
    let vertices = word.vertices();
    let inside = vertices.iter().filter(|&v| !vertices.is_border(v)).count();
    let cancels = |k: &usize| n > 1 && word.sides()[*k] == word.sides()[(k + n - 1) % n].inverted();
    if inside > kept
        && let Some(k) = (0..n).find(cancels)
    {
        return Some(Operation::Cancel { corner: Corner::at(k) });
    }
    let partners = word.partners();
    (0..n).find_map(|k| contraction(word, &vertices, k, partners[k].is_none(), inside > kept))
}

/// How the side at a position can be contracted.
fn contraction(word: &Word, vertices: &Vertices, at: usize, is_border: bool, may_lose: bool) -> Option<Operation> {
    let [tail, head] = vertices.letter_ends(word, at);
    if tail == head || !(is_border || may_lose) {
        return None;
    }
    let side = Side::forward(word.sides()[at].letter);
    let [tail, head] = [tail, head].map(|v| is_border || !vertices.is_border(v));
    match (tail, head) {
        (_, true) => Some(Operation::Contract { side }),
        (true, false) => Some(Operation::Contract { side: side.inverted() }),
        (false, false) => None,
    }
}
