//! Relators of a rotation group as cyclic words.
//!
//! In: two words R^i₀ x R^i₁ x … that are to be one element. Out: [`Relator`], its mirror image, and the shortest way to
//! write it in R and S. Holds: a relator is cyclically reduced; one of length m is x R^a₁ x R^a₂ … x R^a_m, 0 < aᵢ < p.

use crate::word::{Letter, Word};
use std::collections::VecDeque;

/// The exponents a₁ … a_m of x R^a₁ … x R^a_m.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Relator {
    /// The exponents twice, so that every cyclic shift is a slice.
    turns: Vec<u32>,
    period: usize,
    p: u32,
}

impl Relator {
    fn new(exponents: &[u32], p: u32) -> Self {
        Self { turns: exponents.repeat(2), period: period(exponents), p }
    }

    /// The relator that makes a·x and b one element.
    ///
    /// # Input      words as exponents of R, x between them
    pub(super) fn joining(a: &[u32], b: &[u32], p: u32) -> Self {
        let mut cycle: VecDeque<u32> = a[1..].iter().copied().collect();
        cycle.extend(b[1..].iter().rev().map(|&i| (p - i) % p));
        cycle.push_back((a[0] + p - b[0]) % p);
        while cycle.back() == Some(&0) && cycle.len() > 2 {
            cycle.pop_back();
            let turn = cycle.pop_back().unwrap_or(0) + cycle.pop_front().unwrap_or(0);
            cycle.push_back(turn % p);
        }
        Self::new(cycle.make_contiguous(), p)
    }

    /// p.
    pub(super) fn corners(&self) -> u32 {
        self.p
    }

    /// Number of letters x.
    pub(super) fn len(&self) -> usize {
        self.turns.len() / 2
    }

    /// Number of cyclic shifts that differ.
    pub(super) fn period(&self) -> usize {
        self.period
    }

    /// The exponents from the k-th on.
    #[inline]
    pub(super) fn shifted(&self, k: usize) -> &[u32] {
        &self.turns[k..k + self.len()]
    }

    /// The exponents.
    pub(super) fn exponents(&self) -> &[u32] {
        self.shifted(0)
    }

    /// The mirror image, R inverted: as a cyclic word and up to inversion, the exponents backwards.
    pub(super) fn mirror(&self) -> Self {
        let backwards: Vec<u32> = self.exponents().iter().rev().copied().collect();
        Self::new(&backwards, self.p)
    }

    /// The inverse.
    fn inverse(&self) -> Self {
        let inverse: Vec<u32> = self.exponents().iter().rev().map(|&a| self.p - a).collect();
        Self::new(&inverse, self.p)
    }

    /// Whether both say the same: one is a cyclic shift of the other, or of its inverse.
    pub(super) fn says_the_same(&self, other: &Self) -> bool {
        let shift = |a: &Self, b: &Self| a.len() == b.len() && (0..a.period).any(|k| a.shifted(k) == b.exponents());
        shift(self, other) || shift(&self.inverse(), other)
    }

    /// The same in R and S with as few letters as x = RS and x = S⁻¹R⁻¹ allow, beginning where that reads best.
    ///
    /// # Output     a block and its power
    pub(super) fn in_r_and_s(&self, q: u32) -> (Word, i64) {
        let block = &self.exponents()[..self.period];
        let power = (self.len() / self.period) as i64;
        let inverse = self.inverse();
        let shifts = (0..self.period).flat_map(|k| [self, &inverse].map(|relator| &relator.turns[k..k + block.len()]));
        let candidates = shifts.flat_map(|cycle| [false, true].map(|first| spelled(cycle, first, self.p, q)));
        let best = candidates.min_by_key(|word| (word.letters().len(), word.to_string().len(), word.clone()));
        (best.unwrap_or_default(), power)
    }
}

/// The smallest shift that leaves a cyclic word as it is.
fn period(cycle: &[u32]) -> usize {
    let n = cycle.len();
    (1..=n).find(|&k| n.is_multiple_of(k) && (k..n).all(|i| cycle[i] == cycle[i - k])).unwrap_or(n)
}

/// The cyclic word in R and S. An x is written RS or S⁻¹R⁻¹ (`first` says whether the first one is S⁻¹R⁻¹); which, is
/// found from left to right (a shortest path).
fn spelled(cycle: &[u32], first: bool, p: u32, q: u32) -> Word {
    let (_, inverted) = forms(cycle, p, first);
    let mut word = Vec::new();
    for (i, &turn) in cycle.iter().enumerate() {
        let next = inverted[(i + 1) % cycle.len()];
        word.push((true, if inverted[i] { -1 } else { 1 }));
        word.push((false, turned(turn, inverted[i], next, p)));
    }
    written(&word, q)
}

/// Cheapest choice of forms (true: S⁻¹R⁻¹) beginning with this one, and its number of letters.
fn forms(cycle: &[u32], p: u32, first: bool) -> (u64, Vec<bool>) {
    let cost = |turn, form, next| turned(turn, form, next, p).unsigned_abs();
    let mut paths: Vec<(u64, Vec<bool>)> = vec![(0, vec![first])];
    for &turn in &cycle[..cycle.len() - 1] {
        paths = [false, true]
            .map(|next| {
                let longer = paths.iter().map(|(sum, path)| {
                    let form = path[path.len() - 1];
                    (sum + cost(turn, form, next), [path.as_slice(), &[next]].concat())
                });
                longer.min().unwrap_or_default()
            })
            .into();
    }
    let last = cycle[cycle.len() - 1];
    let closed = paths.into_iter().map(|(sum, path)| (sum + cost(last, path[path.len() - 1], first), path));
    closed.min().unwrap_or_default()
}

/// The exponent of R between two x in these forms, nearest to 0.
fn turned(turn: u32, form: bool, next: bool, p: u32) -> i64 {
    let turn = (i64::from(turn) - i64::from(form) + i64::from(!next)).rem_euclid(i64::from(p));
    if 2 * turn > i64::from(p) { turn - i64::from(p) } else { turn }
}

/// Syllables (S or not, exponent) as a word that begins with R where it can; powers of S are reduced by S^q.
fn written(syllables: &[(bool, i64)], q: u32) -> Word {
    let mut runs: Vec<(bool, i64)> = Vec::new();
    for &(s, n) in syllables.iter().filter(|(_, n)| *n != 0) {
        match runs.last_mut() {
            Some((last, m)) if *last == s => *m += n,
            _ => runs.push((s, n)),
        }
    }
    while runs.len() > 1 && runs[0].0 == runs[runs.len() - 1].0 {
        let (_, n) = runs.remove(0);
        if let Some((_, m)) = runs.last_mut() {
            *m += n;
        }
    }
    if runs.len() > 1 && runs[0].0 {
        runs.rotate_left(1);
    }
    let q = i64::from(q);
    Word::new(runs.iter().flat_map(|&(s, n)| {
        let reduced = n.rem_euclid(q);
        let n = if !s {
            n
        } else if 2 * reduced > q {
            reduced - q
        } else {
            reduced
        };
        let letter = match (s, n > 0) {
            (false, true) => Letter::R,
            (false, false) => Letter::RInverse,
            (true, true) => Letter::S,
            (true, false) => Letter::SInverse,
        };
        std::iter::repeat_n(letter, n.unsigned_abs() as usize)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_beginnings_cancel() {
        let relator = Relator::joining(&[1, 2, 3], &[1, 1, 2], 5);
        assert_eq!(relator.exponents(), [3, 3, 1]);
        assert_eq!(Relator::joining(&[2], &[0], 4).exponents(), [2]);
    }

    #[test]
    fn powers_have_short_periods() {
        let relator = Relator::joining(&[1, 1, 2, 1], &[0, 1], 3);
        assert_eq!(relator.exponents().len(), 5);
        assert_eq!(Relator::new(&[1, 2, 1, 2], 3).period(), 2);
    }

    #[test]
    fn mirror_images_are_known_by_their_cycle() {
        let palindrome = Relator::new(&[1, 2, 2], 4);
        assert!(palindrome.says_the_same(&palindrome.mirror()));
        let skew = Relator::new(&[1, 2, 4], 7);
        assert!(!skew.says_the_same(&skew.mirror()));
    }

    #[test]
    fn kleins_relator_is_short() {
        // (R S⁻²)⁴: S⁻¹ = xR, so R S⁻² = R x R x R, conjugate to x R x R².
        let relator = Relator::new(&[1, 2, 1, 2, 1, 2, 1, 2], 3);
        let (word, power) = relator.in_r_and_s(7);
        assert_eq!((word.letters().len(), power), (3, 4));
    }
}
