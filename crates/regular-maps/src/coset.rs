//! Coset enumeration: from a presentation to a multiplication table.
//!
//! In: relators in the three flag reflections (each an involution), generators of a subgroup, a limit. Out: the table of
//! right multiplication on cosets, numbered in the order in which a breadth-first search from coset 0 meets them.
//! Holds: the table is closed under all relators; equal input gives equal tables. Not: an answer for an infinite index,
//! which ends at the limit. Method: Todd and Coxeter's, a coset's relators scanned and filled one after the other, with
//! coincidences worked off at once.

use crate::error::MapError;
use crate::map::Reflection;

/// When to give up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CosetLimit {
    /// Most cosets alive at once, about 30 bytes each. Default 2 000 000. Larger: harder presentations, more memory.
    pub cosets: usize,
}

impl Default for CosetLimit {
    fn default() -> Self {
        Self { cosets: 2_000_000 }
    }
}

const NONE: u32 = u32::MAX;

/// The cosets of the subgroup in the group of three reflections with these relators.
///
/// # Input      relators besides r₀², r₁², r₂²; words generating the subgroup (none for the trivial one)
/// # Output     row c holds the cosets c·r₀, c·r₁, c·r₂
/// # Errors     [`MapError::TooLarge`]
/// # Cost       about (cosets met) × (length of all relators); no bound in terms of the index
pub fn enumerate_cosets(
    relators: &[Vec<Reflection>],
    subgroup: &[Vec<Reflection>],
    limit: CosetLimit,
) -> Result<Vec<[u32; 3]>, MapError> {
    let mut table = Table::new(limit.cosets);
    for word in subgroup {
        table.scan_and_fill(0, word)?;
    }
    let mut next = 0;
    while next < table.rows.len() {
        for word in relators {
            if !table.is_alive(next) {
                break;
            }
            table.scan_and_fill(next as u32, word)?;
        }
        if table.is_alive(next) {
            table.fill_row(next as u32)?;
        }
        next += 1;
    }
    Ok(table.standardised())
}

struct Table {
    rows: Vec<[u32; 3]>,
    /// A coset's own number while it is alive, else one that it equals.
    same_as: Vec<u32>,
    merged: Vec<(u32, u32)>,
    alive: usize,
    limit: usize,
}

impl Table {
    fn new(limit: usize) -> Self {
        Self { rows: vec![[NONE; 3]], same_as: vec![0], merged: Vec::new(), alive: 1, limit }
    }

    fn is_alive(&self, coset: usize) -> bool {
        self.same_as[coset] as usize == coset
    }

    fn define(&mut self, coset: u32, by: Reflection) -> Result<u32, MapError> {
        if self.alive >= self.limit || self.rows.len() >= 8 * self.limit {
            return Err(MapError::TooLarge(self.limit));
        }
        let new = self.rows.len() as u32;
        self.rows.push([NONE; 3]);
        self.same_as.push(new);
        self.alive += 1;
        self.link(coset, by, new);
        Ok(new)
    }

    fn link(&mut self, a: u32, by: Reflection, b: u32) {
        self.rows[a as usize][by as usize] = b;
        self.rows[b as usize][by as usize] = a;
    }

    fn fill_row(&mut self, coset: u32) -> Result<(), MapError> {
        for by in Reflection::ALL {
            if self.rows[coset as usize][by as usize] == NONE {
                self.define(coset, by)?;
            }
        }
        Ok(())
    }

    /// Follows the word around from both ends, defines what is missing, and closes the circle.
    fn scan_and_fill(&mut self, coset: u32, word: &[Reflection]) -> Result<(), MapError> {
        let (mut front, mut back) = (coset, coset);
        let (mut i, mut j) = (0, word.len());
        loop {
            while i < j && self.rows[front as usize][word[i] as usize] != NONE {
                front = self.rows[front as usize][word[i] as usize];
                i += 1;
            }
            while i < j && self.rows[back as usize][word[j - 1] as usize] != NONE {
                back = self.rows[back as usize][word[j - 1] as usize];
                j -= 1;
            }
            if i == j {
                if front != back {
                    self.coincide(front, back);
                }
                return Ok(());
            }
            if i + 1 == j {
                self.link(front, word[i], back);
                return Ok(());
            }
            front = self.define(front, word[i])?;
            i += 1;
        }
    }

    fn find(&mut self, coset: u32) -> u32 {
        let mut root = coset;
        while self.same_as[root as usize] != root {
            root = self.same_as[root as usize];
        }
        let mut at = coset;
        while self.same_as[at as usize] != root {
            at = std::mem::replace(&mut self.same_as[at as usize], root);
        }
        root
    }

    fn coincide(&mut self, a: u32, b: u32) {
        self.merged.push((a, b));
        while let Some((a, b)) = self.merged.pop() {
            let (a, b) = (self.find(a), self.find(b));
            let (keep, drop) = (a.min(b), a.max(b));
            if keep == drop {
                continue;
            }
            self.same_as[drop as usize] = keep;
            self.alive -= 1;
            for by in Reflection::ALL {
                self.move_link(keep, drop, by);
            }
        }
    }

    /// Takes the link of a dropped coset over to the one that it equals.
    fn move_link(&mut self, keep: u32, drop: u32, by: Reflection) {
        let mut other = std::mem::replace(&mut self.rows[drop as usize][by as usize], NONE);
        if other == NONE {
            return;
        }
        if other == drop {
            other = keep;
        } else {
            self.rows[other as usize][by as usize] = NONE;
        }
        let present = self.rows[keep as usize][by as usize];
        if present != NONE {
            self.merged.push((present, other));
        } else {
            let theirs = self.rows[other as usize][by as usize];
            if theirs != NONE {
                self.merged.push((theirs, keep));
            } else {
                self.link(keep, by, other);
            }
        }
    }

    fn standardised(&self) -> Vec<[u32; 3]> {
        let mut number = vec![NONE; self.rows.len()];
        let mut order = vec![0u32];
        number[0] = 0;
        let mut at = 0;
        while at < order.len() {
            for &to in &self.rows[order[at] as usize] {
                if number[to as usize] == NONE {
                    number[to as usize] = order.len() as u32;
                    order.push(to);
                }
            }
            at += 1;
        }
        order.iter().map(|&coset| self.rows[coset as usize].map(|to| number[to as usize])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presentation::Presentation;
    use crate::word::Word;

    fn order(p: usize, q: usize, extra: &[&str]) -> usize {
        let words = extra.iter().map(|w| Word::parse(w).unwrap()).collect();
        enumerate_cosets(&Presentation::new(p, q, words).relators(), &[], CosetLimit::default()).unwrap().len()
    }

    #[test]
    fn finite_reflection_groups_have_their_orders() {
        assert_eq!([order(3, 3, &[]), order(4, 3, &[]), order(3, 5, &[]), order(2, 7, &[])], [24, 48, 120, 28]);
        assert_eq!(order(3, 7, &["(R*S^-2)^4"]), 336);
    }

    #[test]
    fn cosets_of_a_vertex_rotation_are_half_as_many_as_twice_the_vertices() {
        let cube = Presentation::new(4, 3, vec![]).relators();
        let s = Word::parse("S").unwrap().reflections();
        assert_eq!(enumerate_cosets(&cube, &[s], CosetLimit::default()).unwrap().len(), 16);
    }

    #[test]
    fn an_infinite_group_ends_at_the_limit() {
        let plane = Presentation::new(4, 4, vec![]).relators();
        let limit = CosetLimit { cosets: 500 };
        assert_eq!(enumerate_cosets(&plane, &[], limit), Err(MapError::TooLarge(500)));
    }

    #[test]
    fn relators_that_contradict_each_other_collapse_the_group() {
        assert_eq!(order(3, 7, &["S^2"]), 2);
    }
}
