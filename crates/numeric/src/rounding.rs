//! The order in which integers are fixed: nearest first, singly or in blocks that cannot disturb each other.
//!
//! In: relaxed integers, as a [`Conditional`] or a [`Ladder`]. Out: the same, all integers fixed.
//! Holds: ties are broken by index, and values that differ by rounding noise are ties; no search.
//!
//! Source: [Bommes2012] §5.2.2, algorithm Iterative Greedy Rounding and paragraph Simultaneous Rounding.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::cholesky::CholeskyError;
use crate::conditional::Conditional;
use crate::error::{Failure, SolveError};
use crate::ladder::Ladder;

/// Values closer than this to a half count as halves, and deviations closer than this as equal.
///
/// Symmetric models put many integers exactly on halves; without it their noise of 1e-12 would decide.
pub(crate) const ROUNDING_NOISE: f64 = 1e-9;

/// How many integers were fixed, and in how many steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct RoundingCounts {
    pub roundings: usize,
    pub rounds: usize,
}

/// The nearest integer; halves go up, also those just below by rounding noise.
pub(crate) fn nearest_integer(x: f64) -> f64 {
    (x + 0.5 + ROUNDING_NOISE).floor()
}

/// |x − nearest integer| in units of [`ROUNDING_NOISE`].
fn deviation_key(x: f64) -> u64 {
    ((x - nearest_integer(x)).abs() / ROUNDING_NOISE).round() as u64
}

/// Rounds one integer after the other, each time the one nearest to an integer.
///
/// # Cost  k³/6 multiplications for k integers
pub(crate) fn round_conditional(
    integers: &mut Conditional,
    cancelled: &dyn Fn() -> bool,
) -> Result<RoundingCounts, SolveError> {
    let mut counts = RoundingCounts::default();
    while let Some(j) = integers.free().min_by_key(|&i| (deviation_key(integers.z(i)), i)) {
        if cancelled() {
            return Err(SolveError::Cancelled);
        }
        integers.fix(j, nearest_integer(integers.z(j)));
        counts.roundings += 1;
        counts.rounds += 1;
    }
    Ok(counts)
}

/// Rounds block after block, see [`Order::take_block`].
///
/// # Input  `update`: fixes a block and settles the rest, for instance [`Ladder::fix`]
pub(crate) fn round_ladder<'a>(
    ladder: &mut Ladder<'a>,
    integers: &[u32],
    block_limit: f64,
    cancelled: &dyn Fn() -> bool,
    mut update: impl FnMut(&mut Ladder<'a>, &[(usize, f64)]) -> Result<(), CholeskyError>,
) -> Result<RoundingCounts, Failure> {
    let mut order = Order::new(ladder.y(), integers);
    let mut counts = RoundingCounts::default();
    ladder.take_moved();
    loop {
        let block = order.take_block(ladder.y(), block_limit);
        if block.is_empty() {
            return Ok(counts);
        }
        if cancelled() {
            return Err(SolveError::Cancelled.into());
        }
        update(ladder, &block)?;
        counts.roundings += block.len();
        counts.rounds += 1;
        for i in ladder.take_moved() {
            order.refresh(i, ladder.y()[i as usize]);
        }
    }
}

/// Integers not yet fixed, nearest first.
///
/// Most integers that move stay far from being next, so a deviation that grows is corrected only when its
/// entry comes up.
struct Order {
    /// (deviation, variable), smallest first; the deviation may have grown since.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    /// Current deviation of each variable; [`Self::NONE`] for those fixed and for continuous ones.
    key: Vec<u64>,
    /// The smallest deviation under which each variable is in the heap; its other entries are void.
    listed: Vec<u64>,
}

impl Order {
    const NONE: u64 = u64::MAX;

    fn new(y: &[f64], integers: &[u32]) -> Self {
        let mut key = vec![Self::NONE; y.len()];
        integers.iter().for_each(|&i| key[i as usize] = deviation_key(y[i as usize]));
        let heap = integers.iter().map(|&i| Reverse((key[i as usize], i))).collect();
        Self { heap, listed: key.clone(), key }
    }

    fn refresh(&mut self, i: u32, value: f64) {
        let key = deviation_key(value);
        if self.key[i as usize] != Self::NONE {
            self.key[i as usize] = key;
            self.list(i, key);
        }
    }

    fn list(&mut self, i: u32, key: u64) {
        if key < self.listed[i as usize] {
            self.listed[i as usize] = key;
            self.heap.push(Reverse((key, i)));
        }
    }

    /// The integer nearest to its rounding, taken from the heap.
    fn pop(&mut self) -> Option<u32> {
        while let Some(Reverse((key, i))) = self.heap.pop() {
            if self.listed[i as usize] != key {
                continue;
            }
            self.listed[i as usize] = Self::NONE;
            let current = self.key[i as usize];
            if current == key {
                return Some(i);
            }
            self.list(i, current);
        }
        None
    }

    /// The nearest integers whose deviations sum to less than `limit`, at least one while any is left.
    ///
    /// If fixing one variable moves no other by more than it was moved itself, then with a limit of ½ no
    /// rounding in the block could have come out otherwise for the others of it ([Bommes2012] §5.2.2).
    fn take_block(&mut self, y: &[f64], limit: f64) -> Vec<(usize, f64)> {
        let mut block = Vec::new();
        let mut sum = 0.0;
        while let Some(i) = self.pop() {
            let value = y[i as usize];
            let target = nearest_integer(value);
            sum += (value - target).abs();
            if !block.is_empty() && sum >= limit {
                self.list(i, self.key[i as usize]);
                break;
            }
            self.key[i as usize] = Self::NONE;
            block.push((i as usize, target));
        }
        block
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_go_up_in_spite_of_noise() {
        assert_eq!(nearest_integer(0.5), 1.0);
        assert_eq!(nearest_integer(0.5 - 1e-12), 1.0);
        assert_eq!(nearest_integer(-0.5 - 1e-12), 0.0);
        assert_eq!(nearest_integer(-0.5 - 1e-6), -1.0);
        assert_eq!(nearest_integer(2.4999), 2.0);
    }

    #[test]
    fn blocks_stay_below_the_bound() {
        let y = [0.1, 7.0, 3.95, 0.7, -1.2, 9.9];
        let mut order = Order::new(&y, &[0, 2, 3, 4]);
        assert_eq!(order.take_block(&y, 0.5), vec![(2, 4.0), (0, 0.0), (4, -1.0)]);
        order.refresh(1, 0.0);
        assert_eq!(order.take_block(&y, 0.5), vec![(3, 1.0)]);
        assert!(order.take_block(&y, 0.5).is_empty());
        let mut single = Order::new(&y, &[0, 2, 3, 4]);
        assert_eq!(single.take_block(&y, 0.0), vec![(2, 4.0)]);
    }
}
