//! A map of which only a part is known yet.
//!
//! In: faces that are added, darts that are joined to edges. Out: the neighbour of each dart, or that it is not known.
//! Holds: every face has p darts; no vertex has more than q, and one that is closed has exactly q; what was done since a
//! mark can be undone. Not: that the whole is a regular map.
//!
//! ```text
//!        face 0          A dart is a side of a face, and an element of the rotation group. R takes a dart to the next
//!      ┌───0───┐         one of its face, x to the other side of its edge, S = R⁻¹x around its vertex.
//!      3       1 │ 4     Here p = 4, and x takes dart 1 to dart 4, the first of face 1.
//!      └───2───┘
//! ```

/// A dart that is not there.
pub(super) const NONE: u32 = u32::MAX;

/// The other side of an edge: a dart and its place in its face.
#[derive(Clone, Copy, Debug)]
struct Side {
    dart: u32,
    corner: u32,
}

const OPEN: Side = Side { dart: NONE, corner: 0 };

/// The darts that are known to follow each other around a vertex, noted at both ends of the row.
#[derive(Clone, Copy, Debug)]
struct Fan {
    other_end: u32,
    length: u32,
}

#[derive(Clone, Copy, Debug)]
enum Done {
    Joined(u32),
    Fan(u32, Fan),
}

/// How far back to undo.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    done: usize,
    faces: usize,
}

/// Two things that cannot both hold: this part belongs to no map of the type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contradiction;

/// Faces, and the edges known so far.
#[derive(Clone, Debug)]
pub(super) struct PartialMap {
    p: u32,
    q: u32,
    across: Vec<Side>,
    fans: Vec<Fan>,
    /// For each face the dart from whose other side it was made; unused for face 0.
    parents: Vec<u32>,
    done: Vec<Done>,
    joined: Vec<u32>,
    closing: Vec<(u32, u32)>,
}

impl PartialMap {
    /// One face, no edge.
    pub(super) fn new(p: usize, q: usize) -> Self {
        let mut map = Self {
            p: p as u32,
            q: q as u32,
            across: Vec::new(),
            fans: Vec::new(),
            parents: Vec::new(),
            done: Vec::new(),
            joined: Vec::new(),
            closing: Vec::new(),
        };
        map.push_face(NONE);
        map
    }

    /// Number of darts.
    pub(super) fn len(&self) -> usize {
        self.across.len()
    }

    /// The other side of a dart's edge.
    #[inline]
    pub(super) fn across(&self, dart: u32) -> Option<u32> {
        let side = self.across[dart as usize];
        (side.dart != NONE).then_some(side.dart)
    }

    /// The dart after the other side, R^turn further: dart·x·R^turn.
    #[inline]
    pub(super) fn across_and_turn(&self, dart: u32, turn: u32) -> u32 {
        let Side { dart, corner } = self.across[dart as usize];
        if dart == NONE {
            return NONE;
        }
        if corner + turn >= self.p { dart + turn - self.p } else { dart + turn }
    }

    /// dart·R^turn, turn below p.
    #[inline]
    pub(super) fn turn(&self, dart: u32, turn: u32) -> u32 {
        if dart % self.p + turn >= self.p { dart + turn - self.p } else { dart + turn }
    }

    /// The first dart from here on without another side.
    pub(super) fn first_open(&self, from: usize) -> Option<u32> {
        (from..self.len()).find(|&d| self.across[d].dart == NONE).map(|d| d as u32)
    }

    /// The exponents i₀, i₁, … of the word R^i₀ x R^i₁ x … that leads from dart 0 to this one over new faces.
    pub(super) fn word(&self, mut dart: u32) -> Vec<u32> {
        let mut word = vec![dart % self.p];
        while dart >= self.p {
            dart = self.parents[(dart / self.p) as usize];
            word.push(dart % self.p);
        }
        word.reverse();
        word
    }

    /// Makes a new face on the other side of an open dart.
    pub(super) fn add_face(&mut self, dart: u32) -> Result<(), Contradiction> {
        let new = self.len() as u32;
        self.push_face(dart);
        self.join(dart, new)
    }

    fn push_face(&mut self, parent: u32) {
        let first = self.len() as u32;
        self.parents.push(parent);
        self.across.extend((0..self.p).map(|_| OPEN));
        self.fans.extend((0..self.p).map(|i| Fan { other_end: first + i, length: 1 }));
    }

    /// False where the two darts can be seen not to be sides of one edge: a vertex would get the wrong degree.
    pub(super) fn may_join(&self, a: u32, b: u32) -> bool {
        a != b && self.may_follow(self.turn(a, 1), b) && self.may_follow(self.turn(b, 1), a)
    }

    fn may_follow(&self, last: u32, first: u32) -> bool {
        let (before, after) = (self.fans[last as usize], self.fans[first as usize]);
        if before.other_end == first { before.length == self.q } else { before.length + after.length <= self.q }
    }

    /// Makes two open darts the sides of one edge, and closes vertices that thereby have all their darts.
    pub(super) fn join(&mut self, a: u32, b: u32) -> Result<(), Contradiction> {
        self.closing.clear();
        self.join_one(a, b)?;
        while let Some((a, b)) = self.closing.pop() {
            if self.across(a) != Some(b) {
                self.join_one(a, b)?;
            }
        }
        Ok(())
    }

    fn join_one(&mut self, a: u32, b: u32) -> Result<(), Contradiction> {
        if a == b || self.across(a).is_some() || self.across(b).is_some() {
            return Err(Contradiction);
        }
        self.across[a as usize] = Side { dart: b, corner: b % self.p };
        self.across[b as usize] = Side { dart: a, corner: a % self.p };
        self.done.push(Done::Joined(a));
        self.joined.push(a);
        self.follow(self.turn(a, 1), b)?;
        self.follow(self.turn(b, 1), a)
    }

    /// Dart `first` comes after dart `last` around their vertex.
    fn follow(&mut self, last: u32, first: u32) -> Result<(), Contradiction> {
        if !self.may_follow(last, first) {
            return Err(Contradiction);
        }
        let (before, after) = (self.fans[last as usize], self.fans[first as usize]);
        if before.other_end == first {
            return Ok(());
        }
        let (start, end) = (before.other_end, after.other_end);
        let length = before.length + after.length;
        self.set_fan(start, Fan { other_end: end, length });
        self.set_fan(end, Fan { other_end: start, length });
        if length == self.q {
            self.closing.push((self.turn(end, self.p - 1), start));
        }
        Ok(())
    }

    fn set_fan(&mut self, at: u32, fan: Fan) {
        let old = std::mem::replace(&mut self.fans[at as usize], fan);
        self.done.push(Done::Fan(at, old));
    }

    /// Darts joined since this was last asked, one per edge, are appended to the list.
    pub(super) fn take_joined(&mut self, list: &mut Vec<u32>) {
        list.append(&mut self.joined);
    }

    /// What there is now.
    pub(super) fn mark(&self) -> Mark {
        Mark { done: self.done.len(), faces: self.parents.len() }
    }

    /// Back to the mark.
    pub(super) fn undo(&mut self, mark: Mark) {
        for done in self.done.drain(mark.done..).rev() {
            match done {
                Done::Joined(a) => {
                    let b = std::mem::replace(&mut self.across[a as usize], OPEN).dart;
                    self.across[b as usize] = OPEN;
                }
                Done::Fan(at, old) => self.fans[at as usize] = old,
            }
        }
        let darts = mark.faces * self.p as usize;
        self.parents.truncate(mark.faces);
        self.across.truncate(darts);
        self.fans.truncate(darts);
        self.joined.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vertex_that_has_all_its_darts_is_closed() {
        // Three triangles around a vertex of a tetrahedron: the third edge follows.
        let mut map = PartialMap::new(3, 3);
        map.add_face(0).unwrap();
        map.add_face(1).unwrap();
        assert!(map.across(4).is_some() || map.across(5).is_some());
    }

    #[test]
    fn what_was_done_is_undone() {
        let mut map = PartialMap::new(4, 5);
        map.add_face(0).unwrap();
        map.take_joined(&mut Vec::new());
        let before = format!("{map:?}");
        let mark = map.mark();
        map.add_face(1).unwrap();
        map.join(2, 6).unwrap();
        assert_eq!(map.join(2, 7), Err(Contradiction));
        map.undo(mark);
        assert_eq!(format!("{map:?}"), before);
    }

    #[test]
    fn a_vertex_of_too_small_a_degree_is_a_contradiction() {
        let mut map = PartialMap::new(4, 5);
        assert!(!map.may_join(2, 3) && map.may_join(0, 2));
        assert_eq!(map.join(2, 3), Err(Contradiction));
    }

    #[test]
    fn words_lead_over_new_faces() {
        let mut map = PartialMap::new(3, 7);
        map.add_face(1).unwrap();
        map.add_face(4).unwrap();
        assert_eq!((map.word(2), map.word(8)), (vec![2], vec![1, 1, 2]));
    }
}
