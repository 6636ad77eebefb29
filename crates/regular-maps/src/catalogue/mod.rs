//! The regular maps that have names, and how to find them.
//!
//! In: a name, a type, a genus, a map. Out: [`Entry`]s. Holds: all reflexible orientable regular maps of genus 2 to 24 up
//! to duality, and four larger ones; an entry's presentation has its order. Not: all names of Conder's list: where several
//! maps of a genus share a type, his order among them is known for some only.
//! Source: the maps are this crate's own search ([`crate::enumerate`], written down by the example `make_catalogue`);
//! names as in [Conder2009], whose order of types settles most; `data/conder_names.tsv` has the rest with sources.

mod entry;
mod error;
mod query;

pub use entry::Entry;
pub use error::CatalogueError;

use crate::enumerate::{ToroidalType, hosohedron, platonic, platonic_name, toroidal};
use crate::map::RegularMap;
use crate::presentation::Presentation;
use query::{Query, TypeQuery};
use std::ops::RangeInclusive;
use std::sync::OnceLock;

/// Genera of which the catalogue has all maps.
pub const COMPLETE: RangeInclusive<usize> = 2..=24;

/// One map a line: genus, p, q, Petrie length, order, multiplicities, whether it is self-dual, relators.
const MAPS: &str = include_str!("../../data/regular_maps.tsv");

/// Names that the order of types does not settle: name, identifier, source.
const NAMES: &str = include_str!("../../data/conder_names.tsv");

/// Which entries to list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    /// Genera, both ends included. Default: all.
    pub genus: Option<RangeInclusive<usize>>,
    /// {p, q} or its dual. Default: all.
    pub kind: Option<(usize, usize)>,
}

/// All entries: p ≤ q, by genus, p, q, Petrie length.
pub fn entries() -> &'static [Entry] {
    static ENTRIES: OnceLock<Vec<Entry>> = OnceLock::new();
    ENTRIES.get_or_init(|| entry::read(MAPS, NAMES))
}

/// The entries that pass a filter, in the catalogue's order.
pub fn list(filter: &Filter) -> Vec<&'static Entry> {
    let genus_fits = |e: &Entry| filter.genus.as_ref().is_none_or(|genera| genera.contains(&e.genus));
    let type_fits = |e: &Entry| filter.kind.is_none_or(|(p, q)| (e.p, e.q) == (p.min(q), p.max(q)));
    entries().iter().filter(|e| genus_fits(e) && type_fits(e)).collect()
}

/// The map of a name.
///
/// # Input      `R3.1`; `{3,7}_8#3.1`, or as much of it as tells maps apart: `{3,7}_8`, `{3,7}#3`, `{3,7}`; a Platonic
///   solid; `hosohedron 6` or `{2,6}`, `dihedron 6` or `{6,2}`; `{4,4}_(3,0)`, `{3,6}_(2,2)`, `{6,3}_(1,1)`.
///   A dash at the end (' or ′) means the dual; so does a type with p > q
/// # Errors     what is unknown or means several maps, with what there is instead
pub fn find(name: &str) -> Result<Entry, CatalogueError> {
    let (query, dual) = query::read(name)?;
    let entry = match query {
        Query::Conder { genus, index } => find_conder(name, genus, index)?,
        Query::Solid(presentation) => Entry::of(presentation)?,
        Query::Type(kind) => find_type(name, kind)?,
    };
    Ok(if dual { entry.dual() } else { entry })
}

/// The entry of a map or of its dual; also for orientable maps on the sphere and the torus.
///
/// # Cost       nothing for most maps; a coset enumeration for each entry with the same numbers, if there are several
pub fn identify(map: &RegularMap) -> Option<Entry> {
    if !map.is_orientable() {
        return None;
    }
    if map.genus() < 2 {
        return Entry::of(small_genus(map)?).ok();
    }
    let swapped = map.p() > map.q();
    let upright = if swapped { map.dual() } else { map.clone() };
    if let Some(entry) = among_equals(&upright) {
        return Some(if swapped { entry.dual() } else { entry.clone() });
    }
    (map.p() == map.q()).then(|| among_equals(&map.dual()).map(Entry::dual)).flatten()
}

fn among_equals(map: &RegularMap) -> Option<&'static Entry> {
    let candidates: Vec<_> = entries().iter().filter(|entry| entry.has_numbers_of(map)).collect();
    match candidates[..] {
        [only] if COMPLETE.contains(&map.genus()) && map.p() < map.q() => Some(only),
        _ => candidates.into_iter().find(|entry| entry.map().is_ok_and(|found| found == *map)),
    }
}

fn small_genus(map: &RegularMap) -> Option<Presentation> {
    let (p, q) = (map.p(), map.q());
    let Some(kind) = ToroidalType::of(p, q) else { return Some(Presentation::new(p, q, Vec::new())) };
    let (b, c) = kind.step_of(map);
    toroidal(kind, b, c).ok()
}

fn find_conder(name: &str, genus: usize, index: usize) -> Result<Entry, CatalogueError> {
    let wanted = format!("R{genus}.{index}");
    if let Some(entry) = entries().iter().find(|entry| entry.name.as_ref() == Some(&wanted)) {
        return Ok(entry.clone());
    }
    let of_genus = list(&Filter { genus: Some(genus..=genus), kind: None });
    let place = index.checked_sub(1).filter(|_| COMPLETE.contains(&genus)).and_then(|i| of_genus.get(i));
    let Some(place) = place else {
        return Err(CatalogueError::Unknown { name: name.trim().into(), help: error::maps_of_genus(genus, &of_genus) });
    };
    let tied = of_genus.iter().filter(|e| e.name.is_none() && (e.p, e.q) == (place.p, place.q));
    Err(CatalogueError::Ambiguous { name: wanted, candidates: tied.map(|e| e.identifier.clone()).collect() })
}

fn find_type(name: &str, kind: TypeQuery) -> Result<Entry, CatalogueError> {
    let unknown = |help: String| CatalogueError::Unknown { name: name.trim().into(), help };
    let (p, q) = (kind.p, kind.q);
    if let Some((b, c)) = kind.torus {
        let Some(torus) = ToroidalType::of(p, q) else {
            return Err(unknown(format!(
                "_(b,c) is for types of the torus, {{4,4}}, {{3,6}} and {{6,3}}, not {{{p},{q}}}"
            )));
        };
        return Ok(Entry::of(toroidal(torus, b, c)?)?);
    }
    // Compares 1/p + 1/q with 1/2.
    match (2 * (p + q)).cmp(&(p * q)) {
        std::cmp::Ordering::Greater => {
            let entry = Entry::of(spherical(p, q)?)?;
            if kind.fits(&entry) {
                Ok(entry)
            } else {
                Err(unknown(format!("the map {{{p},{q}}} is {}", entry.identifier)))
            }
        }
        std::cmp::Ordering::Equal => Err(unknown(format!(
            "type {{{p},{q}}} has infinitely many maps, on the torus: say {{{p},{q}}}_(b,0) or {{{p},{q}}}_(b,b)"
        ))),
        std::cmp::Ordering::Less => find_hyperbolic(name, kind),
    }
}

fn spherical(p: usize, q: usize) -> Result<Presentation, CatalogueError> {
    let solid = platonic_name(p, q).and_then(platonic);
    Ok(match solid {
        Some(solid) => solid,
        None if p == 2 => hosohedron(q)?,
        None => hosohedron(p)?.dual(),
    })
}

fn find_hyperbolic(name: &str, kind: TypeQuery) -> Result<Entry, CatalogueError> {
    let swapped = kind.p > kind.q;
    let upright = if swapped { TypeQuery { p: kind.q, q: kind.p, ..kind } } else { kind };
    let fitting: Vec<_> = entries().iter().filter(|entry| upright.fits(entry)).collect();
    match fitting[..] {
        [entry] if swapped => Ok(entry.dual()),
        [entry] => Ok(entry.clone()),
        [] => Err(CatalogueError::Unknown { name: name.trim().into(), help: error::maps_of_type(upright) }),
        _ => {
            let dash = if swapped { "'" } else { "" };
            let candidates = fitting.iter().map(|entry| format!("{}{dash}", entry.identifier)).collect();
            Err(CatalogueError::Several { name: name.trim().into(), candidates })
        }
    }
}
