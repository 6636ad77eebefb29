//! Single steps of integers after rounding, as long as the energy falls.
//!
//! In: a [`Ladder`] all of whose integers are fixed. Out: the same, where no step that was tried lowers the energy.
//! Holds: the energy only falls; ties are broken by index. Not: a minimum over pairs of steps.
//! Source: own; the neighbourhood is that of one-opt local search.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::error::{Failure, SolveError};
use crate::ladder::Ladder;

/// Pull on an integer, in units of it, from which a step is tried.
///
/// By itself a step pays from a half on; with all others following from a fraction of that. Smaller: more trials in vain.
const LEAST_PULL: f64 = 0.12;

/// Updates at most that one trial may take; what is not settled by then is far away.
const TRIAL_LIMIT: usize = 1500;

/// Trials at most, relative to the number of integers.
const TRIALS_REL: usize = 4;

/// Resolution of the order of trials, in units of the integers.
const PULL_NOISE: f64 = 1e-6;

/// Steps integers up or down by one, the most strongly drawn first, and keeps what lowers the energy.
///
/// # Output     number of steps kept
/// # Errors     cancellation; a matrix that is not positive definite
/// # Cost       a factorisation, and local updates around each trial
pub(crate) fn descend(ladder: &mut Ladder, integers: &[u32], cancelled: &dyn Fn() -> bool) -> Result<usize, Failure> {
    // 1. From the exact solution: errors of the updates so far would count as falls.
    ladder.fix_and_factorize(&[])?;
    ladder.take_moved();
    let mut trials = Trials::new(ladder, integers);
    // 2. The strongest first; whoever is near a step that was kept comes again.
    let mut kept = 0;
    for _ in 0..TRIALS_REL * integers.len() {
        let Some(i) = trials.next() else { break };
        if cancelled() {
            return Err(SolveError::Cancelled.into());
        }
        let step = ladder.pull(i as usize).signum();
        if ladder.step_down(i as usize, step, TRIAL_LIMIT) {
            kept += 1;
            for k in ladder.take_moved() {
                ladder.neighbours(k as usize).iter().for_each(|&j| trials.list_again(ladder, j));
            }
        }
    }
    Ok(kept)
}

/// Integers to be tried, the most strongly drawn first.
struct Trials {
    /// Strength in units of [`PULL_NOISE`], then the lower index.
    heap: BinaryHeap<(u64, Reverse<u32>)>,
    /// The strength under which an integer is to be tried, 0 if it is not; its other entries are void.
    listed: Vec<u64>,
    is_integer: Vec<bool>,
}

impl Trials {
    fn new(ladder: &Ladder, integers: &[u32]) -> Self {
        let n = ladder.y().len();
        let mut trials = Self { heap: BinaryHeap::new(), listed: vec![0; n], is_integer: vec![false; n] };
        for &i in integers {
            trials.is_integer[i as usize] = true;
            trials.list_again(ladder, i);
        }
        trials
    }

    /// Lists a variable under its present strength, if it is an integer and that is enough.
    fn list_again(&mut self, ladder: &Ladder, i: u32) {
        let strength = |pull: f64| (pull.abs() / PULL_NOISE).round() as u64;
        let now = strength(ladder.pull(i as usize));
        let is_tried = self.is_integer[i as usize] && now > strength(LEAST_PULL);
        let listed = &mut self.listed[i as usize];
        if is_tried && now != *listed {
            self.heap.push((now, Reverse(i)));
        }
        *listed = if is_tried { now } else { 0 };
    }

    fn next(&mut self) -> Option<u32> {
        while let Some((strength, Reverse(i))) = self.heap.pop() {
            if self.listed[i as usize] == strength {
                self.listed[i as usize] = 0;
                return Some(i);
            }
        }
        None
    }
}
