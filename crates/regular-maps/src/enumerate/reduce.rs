//! Presentations without relators that follow from the others.
//!
//! In: a presentation and the order of its group. Out: the same with fewer relators. Holds: the order is still the same.
//! Not: that none of the rest follows from the others where a short coset enumeration cannot see it.

use crate::coset::{CosetLimit, enumerate_cosets};
use crate::presentation::Presentation;

/// Cosets alive at once in a try, as a multiple of the group's order. Larger: slower, and now and then a relator fewer.
const ROOM: usize = 2;

/// Drops relators, the longest first, as long as the group's order stays.
pub(super) fn without_needless(mut presentation: Presentation, order: usize) -> Presentation {
    let mut by_length: Vec<usize> = (0..presentation.extra.len()).collect();
    by_length.sort_by_key(|&i| std::cmp::Reverse(presentation.extra[i].letters().len()));
    let mut kept = vec![true; presentation.extra.len()];
    for i in by_length {
        kept[i] = false;
        kept[i] = !has_order(&chosen(&presentation, &kept), order);
    }
    presentation = chosen(&presentation, &kept);
    presentation
}

fn chosen(presentation: &Presentation, kept: &[bool]) -> Presentation {
    let extra = presentation.extra.iter().zip(kept).filter(|(_, kept)| **kept).map(|(word, _)| word.clone());
    Presentation::new(presentation.p, presentation.q, extra.collect())
}

fn has_order(presentation: &Presentation, order: usize) -> bool {
    let limit = CosetLimit { cosets: ROOM * order + 100 };
    enumerate_cosets(&presentation.relators(), &[], limit).is_ok_and(|table| table.len() == order)
}
