//! Canonical words.
//!
//! In: a word. Out: a1 b1 a1⁻¹ b1⁻¹ … or a1 a1 a2 a2 …, then c1 d1 c1⁻¹ … for borders; how it is reached; what its
//! letters are. Holds: replacing every letter of the canonical word by its path gives the border of the first polygon,
//! up to rotation, in the free group; all curves but borders start at one vertex. Not: curves that are short, or
//! disjoint before they are pushed apart.
//! Source: Brahana's cut and glue, as topology books have it; differs: what is finished is never cut again, so that
//! paths do not grow from handle to handle, and the last cross-cap is found by the intersection form modulo 2.
//!
//! ```text
//!   | finished handles | a U b V a⁻¹ X b⁻¹ Y | borders on stalks |
//!   0                start                  end                  n
//! ```

use super::reduction::Steps;
use super::{Corner, Invariants, Letter, Operation, Path, Side, VertexClass, Word};
use std::collections::BTreeSet;

/// The canonical word of a surface and the way to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanonicalForm {
    /// The word; letters 0, 1, … as in [`Invariants::canonical_word`].
    pub word: Word,
    /// How it was reached; [`replay`](super::replay) does it again.
    pub operations: Vec<Operation>,
    /// Its letters, rising, each as a path of letters of the first word.
    ///
    /// A stalk's path is empty if the first word has no vertex inside the surface: then its border passes through the
    /// vertex at which all curves start.
    pub letters: Vec<(Letter, Path)>,
    /// What surface it is, and names of letters.
    pub invariants: Invariants,
}

impl CanonicalForm {
    /// The word with names as in books.
    pub fn text(&self) -> String {
        self.word.to_text(|letter| self.invariants.name(letter))
    }
}

impl Word {
    /// Brings it to the canonical word of its surface.
    ///
    /// # Output     [`Invariants::canonical_word`]; a sphere: the empty word; a disk: c1 d1 c1⁻¹
    /// # Cost       O(n² log n), and the lengths of the paths: O(n) letters of the reduced word for each
    /// # Guarantees replacing letters by paths gives this word up to rotation, exactly in the free group
    /// # Source     [Brahana1921]; for meshes [Lazarus2001]
    pub fn canonical_form(&self) -> CanonicalForm {
        let borders = self.invariants().borders;
        let mut steps = Steps::new(self);
        steps.contract_all(usize::from(borders > 0));
        if borders > 0 {
            steps.take_base_inside();
            while let Some(stalk) = steps.crowded_border() {
                steps.clear_border(stalk);
            }
            steps.start_inside();
            steps.gather_borders();
        }
        let end = steps.word.len() - 3 * borders;
        let mut start = 0;
        while start < end {
            start += steps.finish_block(start, end);
        }
        steps.name_letters();
        let letters = steps.word.letters().into_iter().map(|l| (l, steps.path(l))).collect();
        let invariants = steps.word.invariants();
        CanonicalForm { word: steps.word, operations: steps.operations, letters, invariants }
    }
}

/// First part: every border on a stalk, at the end of the word.
impl Steps {
    /// Makes a vertex inside the surface if there is none: d becomes c d c⁻¹ for one border.
    fn take_base_inside(&mut self) {
        let vertices = self.word.vertices();
        if vertices.iter().any(|v| !vertices.is_border(v)) {
            return;
        }
        if let Some(k) = self.word.partners().iter().position(Option::is_none) {
            let letter = self.new_letter();
            self.apply(Operation::Expand { letter, from: Corner::at(k), to: Corner::at(k + 1) });
        }
    }

    /// A side from inside to a border at which more ends than the border's letter and one stalk.
    fn crowded_border(&self) -> Option<Side> {
        let vertices = self.word.vertices();
        (0..self.word.len()).find_map(|k| {
            let [tail, head] = vertices.letter_ends(&self.word, k);
            let is_crowded = |v: VertexClass| vertices.is_border(v) && vertices.corner_count(v) > 2;
            let stalk = Side::forward(self.word.sides()[k].letter);
            match [tail, head].map(|v| vertices.is_border(v)) {
                [false, true] if is_crowded(head) => Some(stalk),
                [true, false] if is_crowded(tail) => Some(stalk.inverted()),
                _ => None,
            }
        })
    }

    /// Moves all that ends at a border, but one stalk, along that stalk to its tail.
    ///
    /// One end per step: the neighbour y of the stalk s at its head becomes s y. The stalk's neighbours are then the
    /// border's letter on both sides: s d s⁻¹.
    fn clear_border(&mut self, stalk: Side) {
        while let Some((mut from, along)) = self.neighbour_at_head(stalk) {
            if from + 2 > self.word.len() {
                self.apply(Operation::Rotate { first: Corner::at(from) });
                from = 0;
            }
            self.absorb(from, from + 2, along);
        }
    }

    /// A glued letter that is next to a side at the side's head, and the position of the first of the two.
    fn neighbour_at_head(&self, side: Side) -> Option<(usize, Letter)> {
        let n = self.word.len();
        let is_glued = |letter: Letter| self.word.positions(letter).count() == 2;
        self.word.positions(side.letter).find_map(|k| {
            let runs_to_head = self.word.sides()[k] == side;
            let next = if runs_to_head { (k + 1) % n } else { (k + n - 1) % n };
            let letter = self.word.sides()[next].letter;
            is_glued(letter).then_some((if runs_to_head { k } else { next }, letter))
        })
    }

    /// Rotates to a corner inside the surface.
    fn start_inside(&mut self) {
        let vertices = self.word.vertices();
        let first = (0..self.word.len()).map(Corner::at).find(|&c| !vertices.is_border(vertices.at(c)));
        if let Some(first) = first.filter(|&c| c != Corner(0)) {
            self.apply(Operation::Rotate { first });
        }
    }

    /// Moves the borders with their stalks to the end: c d c⁻¹ R becomes R c' d c'⁻¹ with c' = R⁻¹ c.
    fn gather_borders(&mut self) {
        let mut end = self.word.len();
        loop {
            let partners = self.word.partners();
            let Some(d) = (0..end).rev().find(|&k| partners[k].is_none()) else { return };
            self.absorb(d + 1, end, self.word.sides()[d + 1].letter);
            end -= 3;
        }
    }
}

/// Second part: handles and cross-caps, one after the other.
impl Steps {
    /// Makes the sides from `start` on a handle or a cross-cap; returns how many they are.
    fn finish_block(&mut self, start: usize, end: usize) -> usize {
        let partners = self.word.partners();
        let turned: Vec<usize> = (start..end).filter(|&k| self.is_turned(&partners, k)).collect();
        let Some(&first) = turned.first() else {
            self.finish_handle(start, &partners);
            return 4;
        };
        // At most one letter is not safe: the intersection form modulo 2 would have two equal rows.
        match turned.iter().copied().find(|&k| end - start == 2 || self.is_safe(start, end, &partners, k)) {
            Some(k) => self.finish_cross_cap(start, k, &partners),
            None => {
                self.spread_turn(start, end, first, &partners);
                return 0;
            }
        }
        2
    }

    /// Whether the side at a position is the first of two in the same direction.
    fn is_turned(&self, partners: &[Option<usize>], k: usize) -> bool {
        partners[k].is_some_and(|m| k < m && self.word.sides()[k].inverse == self.word.sides()[m].inverse)
    }

    /// Whether there will still be letters in the same direction after the cross-cap of one of them.
    ///
    /// It exchanges the kinds of the letters that alternate with it; no other may be left as the only kind.
    fn is_safe(&self, start: usize, end: usize, partners: &[Option<usize>], k: usize) -> bool {
        let Some(m) = partners[k] else { return false };
        (start..end).filter(|&i| i != k).any(|i| {
            let Some(j) = partners[i].filter(|&j| i < j) else { return false };
            let alternates = (k..m).contains(&i) != (k..m).contains(&j);
            alternates != self.is_turned(partners, i)
        })
    }

    /// a U b V a⁻¹ X b⁻¹ Y becomes a' b' a'⁻¹ b'⁻¹ X V U Y, with a' = a (X V)⁻¹ and b' = X V U b X⁻¹.
    fn finish_handle(&mut self, start: usize, partners: &[Option<usize>]) {
        let a_end = partners[start].expect("a letter of a closed part is there twice");
        let alternates = |k: &usize| partners[*k].is_some_and(|m| m > a_end);
        // With a single vertex every letter alternates with another one.
        let b = (start + 1..a_end).find(alternates).expect("a letter of a reduced word alternates with another");
        let b_end = partners[b].unwrap_or(b);
        let [a_name, b_name] = [start, b].map(|k| self.word.sides()[k].letter);
        let x = b_end - a_end - 1;
        let [u, xv] = [b - start - 1, x + a_end - b - 1];
        // 1. f := X b⁻¹:   a U f⁻¹ X V a⁻¹ f Y.
        self.absorb(a_end + 1, b_end + 1, b_name);
        // 2. g := X V a⁻¹: g⁻¹ X V U f⁻¹ g f Y.
        self.absorb(b + 1, b + 2 + xv, a_name);
        // 3. h := X V U f⁻¹: g⁻¹ h g h⁻¹ X V U Y.
        let f = start + 1 + xv + u;
        self.absorb(start + 1, f + 1, self.word.sides()[f].letter);
    }

    /// T a U a V becomes q q T U⁻¹ V, with q = T a U T⁻¹.
    fn finish_cross_cap(&mut self, start: usize, k: usize, partners: &[Option<usize>]) {
        let m = partners[k].unwrap_or(k);
        // 1. p := T a U: p T⁻¹ p U⁻¹ V.
        self.absorb(start, m, self.word.sides()[k].letter);
        // 2. q := p T⁻¹: q q T U⁻¹ V.
        self.absorb(start, start + 1 + (k - start), self.word.sides()[start].letter);
    }

    /// a b … b⁻¹ … a becomes x … b⁻¹ … x b⁻¹, with x = a b: two letters in the same direction instead of one.
    ///
    /// Otherwise the last cross-cap would be finished while there are handles left, and finished letters would have to
    /// be cut again.
    fn spread_turn(&mut self, start: usize, end: usize, k: usize, partners: &[Option<usize>]) {
        let m = partners[k].unwrap_or(k);
        let letter = self.word.sides()[k].letter;
        let from = match (k + 1 != m, m + 1 < end) {
            (true, _) => k,
            (_, true) => m,
            _ => k - 1,
        };
        debug_assert!(from >= start);
        self.absorb(from, from + 2, letter);
    }

    /// Gives letters 0, 1, … in the order in which they are met first, each forwards.
    fn name_letters(&mut self) {
        let mut met: BTreeSet<Letter> = BTreeSet::new();
        let firsts: Vec<Side> = self.word.sides().iter().copied().filter(|s| met.insert(s.letter)).collect();
        let letters: Vec<(Letter, Side)> = (0..).map(Letter).zip(firsts).collect();
        if letters.iter().any(|&(new, old)| old != Side::forward(new)) {
            self.apply(Operation::Reletter { letters });
        }
    }
}
