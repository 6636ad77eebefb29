//! All regular maps of one type up to a number of darts.
//!
//! In: p, q, the admissible numbers of darts. Out: [`Found`] maps: the darts' neighbours, and relators.
//! Holds: each rotary map of the type is met once (with mirror images imposed: each reflexible one); results come in an
//! order that depends on the input alone. Source: Sims' search for subgroups of low index, for normal subgroups as by
//! Conder and Dobcsányi (2005); differs: faces are whole from the start, and vertices are closed by counting.
//!
//! The first dart without another side gets every dart that it can have, in turn, and at last a new face. A dart is an
//! element of the group, so that c·x = d says that a word is 1; that word and its mirror image must then close from every
//! dart. What follows from this is joined at once; two darts are never one.

use super::partial::{Contradiction, Mark, NONE, PartialMap};
use super::relators::Relator;
use quadloom_mesh::{Cancelled, Progress};

/// What to look for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target<'a> {
    pub(super) p: usize,
    pub(super) q: usize,
    /// Admissible numbers of darts, ascending.
    pub(super) darts: &'a [usize],
    /// Only maps that are their own mirror image.
    pub(super) reflexible: bool,
}

/// A complete map.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Other side of each dart; R takes dart i to the next of its p.
    pub(super) across: Vec<u32>,
    /// Relators that, with R^p, x² and (xR)^q (and their mirror images, where imposed), make this group.
    pub(super) relators: Vec<Relator>,
}

/// Finds all maps.
///
/// # Errors     only that it was stopped
/// # Cost       grows fast with the number of darts, fastest for small p and q
pub(super) fn search(target: Target, progress: &Progress) -> Result<Vec<Found>, Cancelled> {
    let mut search = Search {
        target,
        most: target.darts.last().copied().unwrap_or(0),
        map: PartialMap::new(target.p, target.q),
        relators: Vec::new(),
        imposed: Vec::new(),
        found: Vec::new(),
        agenda: Vec::new(),
        tried: 0,
        progress,
    };
    if target.p <= search.most {
        search.branch(0)?;
    }
    Ok(search.found)
}

/// Candidates between two looks at the clock.
const PATIENCE: usize = 1 << 10;

struct Search<'a> {
    target: Target<'a>,
    most: usize,
    map: PartialMap,
    /// All relators that hold, mirror images among them.
    relators: Vec<Relator>,
    /// Those that were chosen.
    imposed: Vec<Relator>,
    found: Vec<Found>,
    agenda: Vec<u32>,
    tried: usize,
    progress: &'a Progress,
}

#[derive(Clone, Copy)]
struct Point {
    map: Mark,
    relators: usize,
    imposed: usize,
}

impl Search<'_> {
    /// All maps that contain this part.
    fn branch(&mut self, mut from: usize) -> Result<(), Cancelled> {
        let start = self.point();
        while let Some(open) = self.map.first_open(from) {
            from = open as usize;
            self.try_known_darts(open)?;
            if self.map.len() + self.target.p > self.most || self.extend(open).is_err() {
                self.undo(start);
                return Ok(());
            }
        }
        if self.target.darts.binary_search(&self.map.len()).is_ok() {
            let across = (0..self.map.len() as u32).map(|d| self.map.across(d).unwrap_or(d)).collect();
            self.found.push(Found { across, relators: self.imposed.clone() });
        }
        self.undo(start);
        Ok(())
    }

    fn try_known_darts(&mut self, open: u32) -> Result<(), Cancelled> {
        let mut next = open as usize + 1;
        while let Some(other) = self.map.first_open(next) {
            next = other as usize + 1;
            if !self.map.may_join(open, other) {
                continue;
            }
            self.tried += 1;
            if self.tried.is_multiple_of(PATIENCE) {
                self.progress.check()?;
            }
            let point = self.point();
            if self.impose(open, other).is_ok() {
                self.branch(open as usize)?;
            }
            self.undo(point);
        }
        Ok(())
    }

    fn extend(&mut self, open: u32) -> Result<(), Contradiction> {
        self.map.add_face(open)?;
        self.work_off()
    }

    /// Makes `open` and `other` sides of one edge, here and from every dart.
    fn impose(&mut self, open: u32, other: u32) -> Result<(), Contradiction> {
        let relator = Relator::joining(&self.map.word(open), &self.map.word(other), self.target.p as u32);
        let first = self.relators.len();
        let mirror = relator.mirror();
        if self.target.reflexible && !relator.says_the_same(&mirror) {
            self.relators.push(mirror);
        }
        self.relators.push(relator.clone());
        self.imposed.push(relator);
        self.map.join(open, other)?;
        for k in first..self.relators.len() {
            for dart in 0..self.map.len() as u32 {
                close(&mut self.map, &self.relators[k], 0, dart)?;
            }
        }
        self.work_off()
    }

    /// Follows every relator over every new edge, until nothing new follows.
    fn work_off(&mut self) -> Result<(), Contradiction> {
        self.agenda.clear();
        let mut next = 0;
        loop {
            self.map.take_joined(&mut self.agenda);
            let Some(&dart) = self.agenda.get(next) else { return Ok(()) };
            next += 1;
            let other = self.map.across(dart).unwrap_or(dart);
            for relator in &self.relators {
                for shift in 0..relator.period() {
                    close(&mut self.map, relator, shift, dart)?;
                    close(&mut self.map, relator, shift, other)?;
                }
            }
        }
    }

    fn point(&self) -> Point {
        Point { map: self.map.mark(), relators: self.relators.len(), imposed: self.imposed.len() }
    }

    fn undo(&mut self, point: Point) {
        self.map.undo(point.map);
        self.relators.truncate(point.relators);
        self.imposed.truncate(point.imposed);
    }
}

/// Follows a relator from a dart in both directions; where one edge is missing to close it, that edge is made.
fn close(map: &mut PartialMap, relator: &Relator, shift: usize, dart: u32) -> Result<(), Contradiction> {
    let turns = relator.shifted(shift);
    let p = relator.corners();
    let mut front = dart;
    let mut i = 0;
    while i < turns.len() {
        let next = map.across_and_turn(front, turns[i]);
        if next == NONE {
            break;
        }
        front = next;
        i += 1;
    }
    if i == turns.len() {
        return if front == dart { Ok(()) } else { Err(Contradiction) };
    }
    let mut back = map.turn(dart, p - turns[turns.len() - 1]);
    let mut j = turns.len() - 1;
    // The j-th x leads to `back`.
    while j > i {
        let before = map.across_and_turn(back, p - turns[j - 1]);
        if before == NONE {
            return Ok(());
        }
        back = before;
        j -= 1;
    }
    map.join(front, back)
}
