//! What is known about maps without any geometry: lists, facts, matches, searches.
//!
//! In: genera and types, or a map. Out: reports. Holds: lists name each map once, p ≤ q, without its dual.

use super::report::{MapReport, MatchReport};
use super::request::{NamedMap, labels, name_of};
use crate::error::RemeshError;
use quadloom_mesh::Progress;
use quadloom_regular_maps::catalogue::{self, Filter};
use quadloom_regular_maps::enumerate::{ChiralMap, FoundMap, enumerate_chiral_maps, enumerate_maps, enumerate_type};
use quadloom_regular_maps::{MapError, MatchOptions, find_matches};
use serde::Serialize;
use std::ops::RangeInclusive;

/// The maps of the catalogue of these genera and of type {p, q} or {q, p}; all of both, where none is given.
///
/// # Output     reflexible maps, p ≤ q, no duals, by genus, p, q, Petrie length
/// # Errors     [`RemeshError::Argument`] for genera below 2 alone: those maps go by names and types instead
pub fn list(
    genera: Option<RangeInclusive<usize>>,
    kind: Option<(usize, usize)>,
) -> Result<Vec<MapReport>, RemeshError> {
    genera.iter().try_for_each(check_genera)?;
    let report = |entry: &&catalogue::Entry| {
        let [name, identifier] = labels(entry);
        MapReport {
            name,
            identifier,
            p: entry.p,
            q: entry.q,
            petrie: entry.petrie,
            order: entry.order,
            genus: entry.genus,
            orientable: true,
            vertices: entry.vertices,
            edges: entry.edges,
            faces: entry.faces,
            multiplicities: entry.multiplicities,
            self_dual: entry.self_dual,
            presentation: Some(entry.presentation.to_string()),
        }
    };
    Ok(catalogue::list(&Filter { genus: genera, kind }).iter().map(report).collect())
}

fn check_genera(genera: &RangeInclusive<usize>) -> Result<(), RemeshError> {
    if *genera.end() >= 2 {
        return Ok(());
    }
    let why = "lists begin at genus 2: on the sphere and the torus there are infinitely many maps, which go by names (cube, \
               hosohedron 6, {4,4}_(3,0))";
    Err(RemeshError::Argument { option: "genus", why: why.into() })
}

/// What is known about a map.
pub fn info(source: &NamedMap) -> MapReport {
    let report = MapReport::named(&source.map, [&source.name, &source.identifier].map(Clone::clone));
    MapReport { presentation: Some(source.presentation.to_string()), ..report }
}

/// All targets of a source, by number of junctions from the largest.
///
/// # Errors     [`MapError::NotOrientable`]
/// # Cost       that of [`find_matches`]
/// # Source     [Razafindrazaka2015] §9.5
pub fn matches(source: &NamedMap) -> Result<Vec<MatchReport>, RemeshError> {
    if !source.map.is_orientable() {
        return Err(MapError::NotOrientable(source.name.clone()).into());
    }
    Ok(find_matches(&source.map, &MatchOptions::default()).iter().map(MatchReport::of).collect())
}

/// Searches all reflexible orientable maps of these genera (of type {p, q} or {q, p}, where one is given) anew.
///
/// # Output     as [`list`], with the names of maps that are in the catalogue
/// # Errors     [`RemeshError::Argument`] for genera below 2 alone; [`RemeshError::Cancelled`]
/// # Cost       half a second up to genus 15, seconds up to 24; grows fast
pub fn search(
    genera: RangeInclusive<usize>,
    kind: Option<(usize, usize)>,
    progress: &Progress,
) -> Result<Vec<MapReport>, RemeshError> {
    check_genera(&genera)?;
    let found = match kind {
        None => enumerate_maps(genera, progress)?,
        Some((p, q)) => {
            let one = |genus| enumerate_type(p.min(q), p.max(q), genus, progress);
            genera.map(one).collect::<Result<Vec<_>, MapError>>()?.concat()
        }
    };
    let report = |found: &FoundMap| {
        let report = MapReport::named(&found.map, name_of(&found.map));
        MapReport { presentation: Some(found.presentation.to_string()), ..report }
    };
    Ok(found.iter().map(report).collect())
}

/// A chiral map by its numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChiralReport {
    /// Corners of a face.
    pub p: usize,
    /// Faces at a vertex, at least p.
    pub q: usize,
    /// Order of the rotation group, which is all there is: two per edge.
    pub rotations: usize,
    /// Genus.
    pub genus: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// The rotation group.
    pub presentation: String,
}

impl ChiralReport {
    fn of(map: &ChiralMap) -> Self {
        Self {
            p: map.p,
            q: map.q,
            rotations: map.rotations,
            genus: map.genus(),
            vertices: map.vertex_count(),
            edges: map.edge_count(),
            faces: map.face_count(),
            presentation: map.to_string(),
        }
    }
}

/// Searches all chiral maps of these genera, up to duality and mirror image.
///
/// # Errors     as [`search`]
pub fn search_chiral(
    genera: RangeInclusive<usize>,
    kind: Option<(usize, usize)>,
    progress: &Progress,
) -> Result<Vec<ChiralReport>, RemeshError> {
    check_genera(&genera)?;
    let fits = |map: &&ChiralMap| kind.is_none_or(|(p, q)| (map.p, map.q) == (p.min(q), p.max(q)));
    Ok(enumerate_chiral_maps(genera, progress)?.iter().filter(fits).map(ChiralReport::of).collect())
}
