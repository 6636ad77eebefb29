//! The ladder of attempts on one surface: which there are, which are worth their time, and when it ends.
//!
//! In: what became of the attempts so far, and the effort spent. Out: whether the next one is made.
//! Holds: decisions depend on counted effort and on results alone, so that they are the same on any machine and for any
//! number of threads.

use crate::part::Passed;

/// Sizes of one attempt, relative to the first one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rung {
    /// Edge length of the work mesh.
    pub work_edge: f64,
    /// Number of quads.
    pub quads: f64,
    /// Whether sharp edges that nobody named are kept.
    pub sharp: bool,
}

/// Other work meshes move the singularities and the integers, slightly other counts stay within the usual tolerance;
/// then sharp edges that were only found, not named, are given up; only the last rung leaves the tolerance.
pub(crate) const LADDER: [Rung; 5] = [
    Rung { work_edge: 1.0, quads: 1.0, sharp: true },
    Rung { work_edge: 0.85, quads: 1.03, sharp: true },
    Rung { work_edge: 1.0, quads: 1.0, sharp: false },
    Rung { work_edge: 0.85, quads: 0.97, sharp: false },
    Rung { work_edge: 0.7, quads: 1.15, sharp: false },
];

/// Attempts that a component is worth which is one of several: models of a hundred loose pieces would else take minutes,
/// and split triangles of a few quads have hardly more irregular vertices than the best.
pub(crate) fn attempts_of_piece(quads: usize) -> usize {
    match quads {
        0..60 => 1,
        60..400 => 2,
        _ => usize::MAX,
    }
}

/// Effort, in counted operations, after which nothing more is begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Effort {
    /// That any surface may take.
    least: u64,
    /// As much more per quad.
    per_quad: u64,
}

impl Effort {
    /// Of attempts before triangles are split; the least is about fifteen seconds.
    ///
    /// Attempts that succeed take up to a third of that, but for a few; with less, those few are split too.
    pub const OF_ATTEMPTS: Self = Self { least: 28_000_000, per_quad: 500 };

    /// Of split triangles, over all refinements before the surface's own triangles are tried; the least is about ten
    /// seconds. Surfaces that fail everywhere would else be made finer and finer.
    pub const OF_SPLITS: Self = Self { least: 10_000_000, per_quad: 500 };

    /// The limit for so many quads.
    pub fn most(self, quads: usize) -> u64 {
        self.least + self.per_quad * quads as u64
    }
}

/// Share of inverted triangles in a map beyond which other sizes of about the same will not help either.
const HOPELESS_SHARE: f64 = 0.03;

/// What has become of the attempts so far.
#[derive(Debug)]
pub(crate) struct Climb {
    /// Whether there are sharp edges to give up.
    any_sharp: bool,
    most_effort: u64,
    /// Whether maps that give up the found sharp edges, and those that keep them, were inverted in many places.
    hopeless: [bool; 2],
    /// Whether there was a map with the found sharp edges that had no fold.
    sharp_fits: bool,
    /// Whether an attempt without the found sharp edges was begun.
    gave_up_sharp: bool,
    /// Whether one was left out for its effort.
    pub cut_short: bool,
    /// The best result that is not clear.
    pub reserve: Option<Passed>,
}

impl Climb {
    pub fn new(any_sharp: bool, most_effort: u64) -> Self {
        Self {
            any_sharp,
            most_effort,
            hopeless: [false; 2],
            sharp_fits: false,
            gave_up_sharp: false,
            cut_short: false,
            reserve: None,
        }
    }

    /// Whether an attempt is made, which then counts as begun.
    pub fn begins(&mut self, rung: &Rung, spent: u64) -> bool {
        let gives_up = !rung.sharp && self.any_sharp;
        let repeats_first = !rung.sharp && !self.any_sharp && Rung { sharp: true, ..*rung } == LADDER[0];
        if repeats_first || self.hopeless[usize::from(rung.sharp)] {
            return false;
        }
        // Other features are worth a try even late, unless all had a map: often it is one sharp edge that has none.
        let first_without = gives_up && !self.gave_up_sharp && !self.sharp_fits;
        if spent > if first_without { 2 * self.most_effort } else { self.most_effort } {
            self.cut_short = true;
            return false;
        }
        // Folds that were closed up and single vertices beside their feature are no reason to give up sharp edges.
        if gives_up && self.reserve.as_ref().is_some_and(Passed::faces_clearly) {
            return false;
        }
        self.gave_up_sharp |= gives_up;
        true
    }

    /// Whether so much was spent that an attempt, should it fail, is the last one.
    pub fn is_late(&self, spent: u64) -> bool {
        spent > self.most_effort
    }

    /// Remembers how many triangles of an attempt's map were inverted.
    pub fn folded(&mut self, rung: &Rung, inverted: usize, triangles: usize) {
        self.hopeless[usize::from(rung.sharp)] = inverted as f64 > HOPELESS_SHARE * triangles as f64;
        self.sharp_fits |= rung.sharp && inverted == 0;
    }

    /// Remembers that no attempt with an attempt's features has room.
    pub fn has_no_room(&mut self, rung: &Rung) {
        self.hopeless[usize::from(rung.sharp)] = true;
    }

    /// Keeps a result that is not clear, if it is better than the one that is kept.
    pub fn keep(&mut self, passed: Passed) {
        if self.reserve.as_ref().is_none_or(|kept| passed.clarity() > kept.clarity()) {
            self.reserve = Some(passed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun(any_sharp: bool, spent: u64) -> Vec<usize> {
        let mut climb = Climb::new(any_sharp, 10);
        (0..LADDER.len()).filter(|&k| climb.begins(&LADDER[k], spent)).collect()
    }

    #[test]
    fn sharp_edges_are_given_up_once_even_late_and_nothing_is_tried_twice() {
        assert_eq!(begun(true, 0), [0, 1, 2, 3, 4]);
        // The third would be the first once more.
        assert_eq!(begun(false, 0), [0, 1, 3, 4]);
        assert_eq!(begun(true, 15), [2]);
        assert!(begun(false, 15).is_empty() && begun(true, 25).is_empty());
    }

    #[test]
    fn sharp_edges_that_have_a_map_are_not_given_up_late() {
        for (inverted, begins) in [(1, true), (0, false)] {
            let mut climb = Climb::new(true, 10);
            assert!(climb.begins(&LADDER[0], 0));
            climb.folded(&LADDER[0], inverted, 1000);
            assert_eq!(climb.begins(&LADDER[2], 15), begins);
        }
    }

    #[test]
    fn maps_with_many_folds_end_the_rungs_with_their_features() {
        let mut climb = Climb::new(true, 10);
        climb.folded(&LADDER[0], 1, 1000);
        assert!(climb.begins(&LADDER[1], 0));
        climb.folded(&LADDER[1], 100, 1000);
        assert!(!climb.begins(&LADDER[0], 0) && climb.begins(&LADDER[2], 0));
    }
}
