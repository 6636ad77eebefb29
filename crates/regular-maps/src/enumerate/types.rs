//! Which types and sizes regular maps of a genus can have.
//!
//! In: genera. Out: [`SearchType`]s. Holds: V = 2E/q, E, F = 2E/p are whole and V − E + F = 2 − 2g; p ≤ q.

use std::ops::RangeInclusive;

/// One type {p, q} with all the sizes to look for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SearchType {
    pub(super) p: usize,
    pub(super) q: usize,
    /// Orders of the rotation group, ascending: two per edge.
    pub(super) darts: Vec<usize>,
}

/// All types of these genera, from 2 on.
pub(super) fn hyperbolic_types(genera: &RangeInclusive<usize>) -> Vec<SearchType> {
    let most = genera.end().saturating_mul(4).saturating_add(2);
    let mut types = Vec::new();
    for p in 3..=most {
        for q in p..=most {
            let darts: Vec<usize> = genera.clone().filter_map(|g| dart_count(g, p, q)).collect();
            if !darts.is_empty() {
                types.push(SearchType { p, q, darts });
            }
        }
    }
    types
}

/// Order of the rotation group of a map of genus g and type {p, q}, if the numbers allow one.
pub(super) fn dart_count(genus: usize, p: usize, q: usize) -> Option<usize> {
    let excess = (p * q).checked_sub(2 * (p + q)).filter(|&e| e > 0 && genus > 1)?;
    let edges = exact(2 * (genus - 1) * p * q, excess)?;
    exact(2 * edges, p)?;
    exact(2 * edges, q)?;
    Some(2 * edges)
}

fn exact(a: usize, b: usize) -> Option<usize> {
    a.is_multiple_of(b).then_some(a / b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn klein_and_bolza_have_possible_sizes() {
        assert_eq!((dart_count(3, 3, 7), dart_count(2, 3, 8), dart_count(2, 3, 7)), (Some(168), Some(48), Some(84)));
        assert_eq!((dart_count(1, 4, 4), dart_count(2, 4, 4), dart_count(2, 3, 11)), (None, None, None));
    }

    #[test]
    fn the_largest_types_of_a_genus_are_those_with_one_face() {
        let types = hyperbolic_types(&(2..=2));
        assert_eq!(types.last().map(|t| (t.p, t.q, t.darts.clone())), Some((8, 8, vec![8])));
        assert!(types.contains(&SearchType { p: 5, q: 10, darts: vec![10] }));
    }
}
