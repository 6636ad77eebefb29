//! The search for regular maps, against published counts and against trying everything.
//!
//! In: nothing. Holds: numbers of maps per genus; the same list for any number of threads; for few darts the same maps as
//! from all ways to join faces along their edges; chiral maps where there are any, and not where there are none.

use quadloom_mesh::Progress;
use quadloom_regular_maps::enumerate::{FoundMap, enumerate_chiral_maps, enumerate_maps, enumerate_type};
use quadloom_regular_maps::{CosetLimit, MapError, Presentation, RegularMap};
use std::ops::RangeInclusive;
use std::time::Duration;

fn maps(genera: RangeInclusive<usize>) -> Vec<FoundMap> {
    enumerate_maps(genera, &Progress::none()).unwrap()
}

#[test]
fn each_genus_has_its_number_of_maps() {
    let found = maps(2..=15);
    let counts: Vec<usize> = (2..=15).map(|g| found.iter().filter(|m| m.map.genus() == g).count()).collect();
    assert_eq!(counts, [6, 12, 12, 16, 13, 12, 11, 32, 24, 14, 11, 22, 12, 23]);
    assert!(found.is_sorted_by(|a, b| a.list_order(b).is_lt()));
}

#[test]
fn maps_are_orientable_and_presentations_make_them() {
    for FoundMap { map, presentation } in maps(2..=7) {
        assert!(map.is_orientable() && map.p() <= map.q());
        assert_eq!(RegularMap::from_presentation(&presentation, CosetLimit::default()), Ok(map));
    }
}

#[test]
fn one_type_and_one_genus_are_part_of_the_whole() {
    let whole = maps(2..=8);
    let part: Vec<_> = whole.iter().filter(|m| (m.map.genus(), m.map.p(), m.map.q()) == (8, 3, 8)).cloned().collect();
    assert_eq!(part.len(), 2);
    assert_eq!(enumerate_type(3, 8, 8, &Progress::none()).unwrap(), part);
    assert_eq!(enumerate_type(3, 7, 4, &Progress::none()), Ok(vec![]));
    assert_eq!(enumerate_type(4, 4, 1, &Progress::none()), Ok(vec![]));
    assert_eq!(maps(7..=8), whole.into_iter().filter(|m| m.map.genus() >= 7).collect::<Vec<_>>());
}

#[test]
fn genera_below_two_are_passed_over() {
    assert!(maps(0..=1).is_empty());
    assert_eq!(maps(0..=2), maps(2..=2));
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", maps(2..=9)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn it_stops_when_it_is_told_to() {
    let limit = Progress::none().with_time_limit(Duration::ZERO);
    assert!(matches!(enumerate_maps(2..=24, &limit), Err(MapError::Cancelled(_))));
    assert!(matches!(enumerate_chiral_maps(2..=24, &limit), Err(MapError::Cancelled(_))));
}

#[test]
fn chiral_maps_are_where_they_are_known_to_be() {
    let found = enumerate_chiral_maps(2..=13, &Progress::none()).unwrap();
    let types: Vec<_> = found.iter().map(|m| (m.genus(), m.p, m.q)).filter(|t| t.0 <= 8).collect();
    assert_eq!(types, [(7, 6, 9), (7, 7, 7), (8, 6, 6)]);
    assert!(found.iter().all(|m| m.genus() != 9 && m.genus() != 13));
    for map in found {
        let error = RegularMap::from_table(&map.flags()).unwrap_err();
        assert!(error.to_string().contains("not all flags are alike"), "{map}: {error}");
    }
}

/// All ways to join faces with p corners so that q meet at each vertex, as tables of flags; far too many for many darts.
struct Everything {
    p: usize,
    q: usize,
    across: Vec<Option<usize>>,
    faces_used: usize,
    found: Vec<RegularMap>,
}

impl Everything {
    fn maps(p: usize, q: usize, darts: usize) -> Vec<RegularMap> {
        let mut all = Self { p, q, across: vec![None; darts], faces_used: 1, found: Vec::new() };
        all.join_next();
        all.found
    }

    fn next(&self, d: usize) -> usize {
        if d % self.p + 1 == self.p { d + 1 - self.p } else { d + 1 }
    }

    fn back(&self, d: usize) -> usize {
        if d.is_multiple_of(self.p) { d + self.p - 1 } else { d - 1 }
    }

    fn join_next(&mut self) {
        let known = self.faces_used * self.p;
        let Some(open) = (0..known).find(|&d| self.across[d].is_none()) else {
            if known == self.across.len() {
                self.keep();
            }
            return;
        };
        for other in open + 1..(known + 1).min(self.across.len()) {
            if self.across[other].is_some() {
                continue;
            }
            let new_face = usize::from(other == known);
            self.faces_used += new_face;
            (self.across[open], self.across[other]) = (Some(other), Some(open));
            if self.vertex_fits(open) && self.vertex_fits(other) {
                self.join_next();
            }
            (self.across[open], self.across[other]) = (None, None);
            self.faces_used -= new_face;
        }
    }

    /// Whether the vertex at this dart is closed with q corners, or still open with at most q.
    fn vertex_fits(&self, dart: usize) -> bool {
        let (mut at, mut corners) = (dart, 1);
        while let Some(over) = self.across[self.back(at)] {
            if over == dart {
                return corners == self.q;
            }
            at = over;
            corners += 1;
            if corners > self.q {
                return false;
            }
        }
        true
    }

    fn keep(&mut self) {
        let mut rows = Vec::new();
        for d in 0..self.across.len() {
            let over = |d: usize| self.across[d].unwrap_or(d);
            let (next, back) = (self.next(d), self.back(d));
            rows.push([2 * next + 1, 2 * d + 1, 2 * self.next(over(d)) + 1].map(|i| i as u32));
            rows.push([2 * back, 2 * d, 2 * over(back)].map(|i| i as u32));
        }
        let Ok(map) = RegularMap::from_table(&rows) else { return };
        let map = if map.p() == map.q() { first(map.dual(), map) } else { map };
        if !self.found.contains(&map) {
            self.found.push(map);
        }
    }
}

/// Of a map and its dual the one that lists have.
fn first(a: RegularMap, b: RegularMap) -> RegularMap {
    let [a, b] = [a, b].map(|map| FoundMap { presentation: Presentation::new(map.p(), map.q(), vec![]), map });
    if a.list_order(&b).is_le() { a.map } else { b.map }
}

#[test]
fn trying_everything_finds_the_same_small_maps() {
    let mut compared = 0;
    for genus in 2..=4usize {
        for (p, q) in (3..=18usize).flat_map(|p| (p..=18).map(move |q| (p, q))) {
            let excess = (p * q).saturating_sub(2 * (p + q));
            if excess == 0 || 2 * (genus - 1) * p * q % excess != 0 {
                continue;
            }
            let darts = 4 * (genus - 1) * p * q / excess;
            if darts > 18 || darts % p != 0 || darts % q != 0 {
                continue;
            }
            let mut all = Everything::maps(p, q, darts);
            let searched = enumerate_type(p, q, genus, &Progress::none()).unwrap();
            assert_eq!(all.len(), searched.len(), "{{{p},{q}}} genus {genus}");
            all.retain(|map| !searched.iter().any(|m| m.map == *map));
            assert_eq!(all, [], "{{{p},{q}}} genus {genus}");
            compared += 1;
        }
    }
    assert!(compared >= 10, "{compared}");
}
