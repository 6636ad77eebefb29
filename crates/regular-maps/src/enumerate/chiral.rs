//! Maps with all rotations but no reflection.
//!
//! In: genera. Out: [`ChiralMap`]s. Holds: none is its own mirror image; one of each map, its mirror image and their
//! duals.

use super::over_types;
use super::rotary::RotaryTable;
use super::search::{Target, search};
use super::types::SearchType;
use crate::error::MapError;
use crate::word::Word;
use quadloom_mesh::Progress;
use std::fmt;
use std::ops::RangeInclusive;

/// An orientable map that rotations make regular and no reflection preserves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChiralMap {
    /// Corners of a face.
    pub p: usize,
    /// Faces at a vertex, at least p.
    pub q: usize,
    /// Order of the rotation group: two per edge.
    pub rotations: usize,
    /// Relators in R and S besides R^p, S^q and (RS)².
    pub relators: Vec<Word>,
    table: RotaryTable,
}

impl ChiralMap {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.rotations / self.q
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        self.rotations / 2
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.rotations / self.p
    }

    /// Genus of the surface.
    pub fn genus(&self) -> usize {
        (2 + self.edge_count() - self.vertex_count() - self.face_count()) / 2
    }

    /// The flags and their neighbours along r₀, r₁, r₂.
    pub fn flags(&self) -> Vec<[u32; 3]> {
        self.table.flags()
    }
}

impl fmt::Display for ChiralMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "⟨R, S | R^{}, S^{}, (R*S)^2", self.p, self.q)?;
        for word in &self.relators {
            write!(f, ", {word}")?;
        }
        write!(f, "⟩")
    }
}

/// All chiral maps of these genera, up to duality and mirror image.
///
/// # Input      genera; those below 2 are passed over
/// # Output     sorted by genus, p, q, then the darts' neighbours
/// # Errors     only [`MapError::Cancelled`]
/// # Cost       more than [`super::enumerate_maps`]: nothing can be concluded from mirror images
pub fn enumerate_chiral_maps(genera: RangeInclusive<usize>, progress: &Progress) -> Result<Vec<ChiralMap>, MapError> {
    let mut maps = over_types(&genera, progress, |kind| of_type(kind, progress))?;
    maps.sort_by(|a, b| (a.genus(), a.p, a.q, &a.table).cmp(&(b.genus(), b.p, b.q, &b.table)));
    Ok(maps)
}

fn of_type(kind: &SearchType, progress: &Progress) -> Result<Vec<ChiralMap>, MapError> {
    let target = Target { p: kind.p, q: kind.q, darts: &kind.darts, reflexible: false };
    let mut maps = Vec::new();
    for found in search(target, progress)? {
        let table = RotaryTable::of(&found, kind.p);
        if !is_chosen(&table, kind.p == kind.q) {
            continue;
        }
        let words = found.relators.iter().map(|relator| relator.in_r_and_s(kind.q as u32));
        let relators = words.map(|(block, power)| block.power(power)).collect();
        maps.push(ChiralMap { p: kind.p, q: kind.q, rotations: found.across.len(), relators, table });
    }
    Ok(maps)
}

/// Whether the map is chiral and no other of its mirror image and duals comes first.
fn is_chosen(table: &RotaryTable, with_dual: bool) -> bool {
    let mirror = table.mirror();
    if mirror <= *table {
        return false;
    }
    !with_dual || [table.dual(), mirror.dual()].iter().all(|other| table <= other)
}

#[cfg(test)]
mod tests {
    use super::super::types::hyperbolic_types;
    use super::*;

    /// Without mirror images imposed: the maps that have them are the same, and the others come in pairs.
    #[test]
    fn a_search_without_mirror_images_finds_the_same_reflexible_maps() {
        for kind in hyperbolic_types(&(2..=8)) {
            let tables = |reflexible| -> Vec<RotaryTable> {
                let target = Target { p: kind.p, q: kind.q, darts: &kind.darts, reflexible };
                let found = search(target, &Progress::none()).unwrap();
                found.iter().map(|found| RotaryTable::of(found, kind.p)).collect()
            };
            let all = tables(false);
            let mut own_mirror: Vec<_> = all.iter().filter(|table| table.mirror() == **table).cloned().collect();
            let mut imposed = tables(true);
            own_mirror.sort();
            imposed.sort();
            assert_eq!(own_mirror, imposed, "{kind:?}");
            assert!(all.iter().all(|table| all.contains(&table.mirror())), "{kind:?}");
            assert!(kind.p < kind.q || all.iter().all(|table| all.contains(&table.dual())), "{kind:?}");
        }
    }
}
