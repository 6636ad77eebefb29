//! All regular maps of a range of genera.
//!
//! In: genera from 2 on, or one type. Out: reflexible maps ([`FoundMap`]) or chiral ones ([`ChiralMap`]), each with a
//! presentation. Holds: complete, and each map once, up to duality (p ≤ q; chiral maps also up to mirror image); sorted
//! by genus, p, q, Petrie length, multiplicities and flags; the same for any number of threads. Not: genus 0 and 1,
//! which have infinitely many maps: see [`classical`]. Source: [ConderDobcsanyi2001] for the problem and the kind of
//! search; `search.rs` says how it is done here.

mod chiral;
pub mod classical;
mod partial;
mod reduce;
mod relators;
mod rotary;
mod search;
mod types;

pub use chiral::{ChiralMap, enumerate_chiral_maps};
pub use classical::{ToroidalType, hosohedron, platonic, platonic_name, toroidal};

use crate::error::MapError;
use crate::map::RegularMap;
use crate::presentation::Presentation;
use quadloom_mesh::Progress;
use rayon::prelude::*;
use rotary::RotaryTable;
use search::{Found, Target, search};
use std::cmp::Ordering;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use types::{SearchType, hyperbolic_types};

/// A regular map and a presentation of its group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundMap {
    /// The map; p ≤ q, and of a map and its dual of the same type the one that sorts first.
    pub map: RegularMap,
    /// Type and relators in R and S. No relator can be left out, as far as a short coset enumeration shows.
    pub presentation: Presentation,
}

impl FoundMap {
    /// The order of lists: genus, p, q, Petrie length, multiplicities, then the flags' neighbours.
    pub fn list_order(&self, other: &Self) -> Ordering {
        let key = |m: &RegularMap| (m.genus(), m.p(), m.q(), m.petrie(), m.multiplicities());
        key(&self.map).cmp(&key(&other.map)).then_with(|| flags(&self.map).cmp(flags(&other.map)))
    }
}

fn flags(map: &RegularMap) -> impl Iterator<Item = u32> + '_ {
    map.flags().flat_map(|g| crate::map::Reflection::ALL.map(|by| map.reflect(g, by).0))
}

/// All reflexible orientable regular maps of these genera, up to duality.
///
/// # Input      genera; those below 2 are passed over
/// # Errors     only [`MapError::Cancelled`]
/// # Cost       genus 2..=15: half a second; 2..=24: a few seconds, most of them in type {3,7}; grows fast
pub fn enumerate_maps(genera: RangeInclusive<usize>, progress: &Progress) -> Result<Vec<FoundMap>, MapError> {
    let mut maps = over_types(&genera, progress, |kind| {
        let target = Target { p: kind.p, q: kind.q, darts: &kind.darts, reflexible: true };
        found_maps(target, progress)
    })?;
    maps.sort_by(FoundMap::list_order);
    Ok(maps)
}

/// All reflexible orientable regular maps of type {p, q} and one genus, up to duality where p = q.
///
/// # Errors     only [`MapError::Cancelled`]
/// # Cost       grows fast with the number of edges
pub fn enumerate_type(p: usize, q: usize, genus: usize, progress: &Progress) -> Result<Vec<FoundMap>, MapError> {
    let Some(darts) = types::dart_count(genus, p, q) else { return Ok(Vec::new()) };
    let mut maps = found_maps(Target { p, q, darts: &[darts], reflexible: true }, progress)?;
    maps.sort_by(FoundMap::list_order);
    Ok(maps)
}

/// What `find` finds in each type of these genera, types in parallel, the largest first.
fn over_types<T: Send>(
    genera: &RangeInclusive<usize>,
    progress: &Progress,
    find: impl Fn(&SearchType) -> Result<Vec<T>, MapError> + Sync,
) -> Result<Vec<T>, MapError> {
    let mut types = hyperbolic_types(genera);
    types.sort_by_key(|kind| std::cmp::Reverse(kind.darts.last().copied()));
    let (count, done) = (types.len(), AtomicUsize::new(0));
    let one = |kind: &SearchType| {
        progress.check()?;
        let maps = find(kind)?;
        progress.report("regular maps", (done.fetch_add(1, Relaxed) + 1) as f64 / count as f64);
        Ok(maps)
    };
    let lists: Vec<Vec<T>> = types.par_iter().with_max_len(1).map(one).collect::<Result<_, MapError>>()?;
    Ok(lists.into_iter().flatten().collect())
}

fn found_maps(target: Target, progress: &Progress) -> Result<Vec<FoundMap>, MapError> {
    let mut maps: Vec<FoundMap> = Vec::new();
    for found in search(target, progress)? {
        progress.check()?;
        let map = RegularMap::from_table(&RotaryTable::of(&found, target.p).flags())?;
        let one = FoundMap { presentation: Presentation::new(target.p, target.q, Vec::new()), map };
        if let Some(first) = first_of_duals(one) {
            maps.push(with_presentation(first, &found, target));
        }
    }
    Ok(maps)
}

/// The map, unless its dual has the same type and sorts before it: that is met as well.
fn first_of_duals(found: FoundMap) -> Option<FoundMap> {
    if found.map.p() != found.map.q() {
        return Some(found);
    }
    let dual = FoundMap { map: found.map.dual(), presentation: found.presentation.clone() };
    (found.list_order(&dual) != Ordering::Greater).then_some(found)
}

fn with_presentation(one: FoundMap, found: &Found, target: Target) -> FoundMap {
    let words = found.relators.iter().map(|relator| relator.in_r_and_s(target.q as u32));
    let words = words.map(|(block, power)| block.power(power)).collect();
    let presentation = reduce::without_needless(Presentation::new(target.p, target.q, words), one.map.order());
    FoundMap { presentation, ..one }
}
