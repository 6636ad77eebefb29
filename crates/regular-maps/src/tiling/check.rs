//! Does the polygon, glued, give the map?
//!
//! In: a [`FlatTiling`]. Out: what was counted, what is wrong.
//! Holds: gluing uses labels, arrows and triangles side by side alone, not the map's table.
//! Source: [Razafindrazaka2015] §9.3: correct identifications make Tri(G) a closed surface.

use super::{BoundaryEdge, FlatTiling, Model, Side};
use crate::ids::FlagId;
use crate::map::Reflection;
use crate::partition::Partition;
use quadloom_mesh::Id;
use std::collections::HashMap;

/// Largest distance between copies of a corner on the Jemisphere. Smaller: rounding far from the centre is reported.
const LARGEST_GAP: f64 = 1e-6;

/// What the glued polygon is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Glued {
    /// Points that corners V became.
    pub vertices: usize,
    /// Points that corners E became.
    pub edges: usize,
    /// Points that corners F became.
    pub faces: usize,
    /// Euler characteristic: points − sides + triangles.
    pub chi: i64,
    /// Whether all edges of the boundary are glued against each other.
    pub orientable: bool,
    /// Closed curves of the boundary before it is glued: 1 for a disc, 0 for a whole sphere.
    pub curves: usize,
}

/// What is wrong with a flat tiling.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TilingDefect {
    /// Two flags have the same place.
    #[error("the triangles of flags {0} and {1} lie on each other")]
    Overlap(FlagId, FlagId),
    /// Two triangles that should lie side by side do not.
    #[error("the corners that the triangles of flags {0} and {1} share are {2:e} apart")]
    Apart(FlagId, FlagId, f64),
    /// The triangles around a point that is not on the boundary do not close up.
    #[error("{found} triangles lie around corner {corner} of flag {flag}, not {wanted}")]
    Fan {
        /// A flag there.
        flag: FlagId,
        /// V, E or F.
        corner: usize,
        /// Triangles counted.
        found: usize,
        /// Triangles there should be.
        wanted: usize,
    },
    /// A label without its partner.
    #[error("boundary edge {0} does not match its partner")]
    Label(u32),
    /// The glued polygon is another surface or map.
    #[error("glued it has {found:?}, the map has {wanted:?}")]
    Counts {
        /// Counted.
        found: Glued,
        /// The map's.
        wanted: Glued,
    },
}

pub(super) fn check(tiling: &FlatTiling) -> Vec<TilingDefect> {
    let mut defects = Vec::new();
    defects.extend(overlaps(tiling));
    defects.extend(gaps(tiling));
    defects.extend(open_fans(tiling));
    defects
        .extend(tiling.boundary.iter().filter(|edge| !is_paired(tiling, edge)).map(|e| TilingDefect::Label(e.label)));
    defects.extend(wrong_counts(tiling));
    defects
}

/// Flags with the same element of the tiling's group: only then do two triangles overlap.
fn overlaps(tiling: &FlatTiling) -> Vec<TilingDefect> {
    let mut first = HashMap::new();
    let flags = tiling.map().flags();
    flags
        .filter_map(|g| {
            let other = *first.entry(tiling.elements[g]).or_insert(g);
            (other != g).then_some(TilingDefect::Overlap(other, g))
        })
        .collect()
}

/// Corners of neighbours that are not in the same place: this compares the exact elements with coordinates.
fn gaps(tiling: &FlatTiling) -> Vec<TilingDefect> {
    let corner = |g: FlagId, k: usize| Model::Jemisphere.project(tiling.isometries[g] * tiling.frame.corners[k]);
    let mut defects = Vec::new();
    for g in tiling.map().flags() {
        for by in Reflection::ALL.into_iter().filter(|&by| tiling.is_adjacent(g, by)) {
            let other = tiling.map().reflect(g, by);
            let shared = (0..3).filter(|&k| k != by as usize);
            let apart: Vec<f64> = shared.map(|k| corner(g, k).distance(corner(other, k))).collect();
            if !apart.iter().all(|&distance| distance < LARGEST_GAP) {
                defects.push(TilingDefect::Apart(g, other, apart.into_iter().fold(0.0, f64::max)));
            }
        }
    }
    defects
}

/// Around each point inside the domain there are 2q, 4 or 2p triangles, on its boundary fewer.
fn open_fans(tiling: &FlatTiling) -> Vec<TilingDefect> {
    let full = [2 * tiling.map().q(), 4, 2 * tiling.map().p()];
    let mut fans = vec![(0, true, FlagId(0), 0); tiling.positions.len()];
    for g in tiling.map().flags() {
        for corner in 0..3 {
            let (count, inner, flag, k) = &mut fans[tiling.point(g, corner).0 as usize];
            *count += 1;
            *inner &= super::layout::around(corner).iter().all(|&by| tiling.is_adjacent(g, by));
            (*flag, *k) = (g, corner);
        }
    }
    let wrong = |&(found, inner, _, corner): &(usize, bool, FlagId, usize)| (found == full[corner]) != inner;
    fans.into_iter()
        .filter(wrong)
        .map(|(found, _, flag, corner)| TilingDefect::Fan { flag, corner, found, wanted: full[corner] })
        .collect()
}

/// The sides of an edge and those of its partner, in the order in which their labels and arrows glue them.
fn glued_sides<'a>(tiling: &'a FlatTiling, edge: &'a BoundaryEdge) -> impl Iterator<Item = [Side; 2]> + 'a {
    let partner = &tiling.boundary[edge.partner];
    let n = partner.sides.len();
    let against = edge.forward != partner.forward;
    let there = move |k: usize| if against { n - 1 - k } else { k };
    edge.sides.iter().enumerate().take(n).map(move |(k, &side)| [side, partner.sides[there(k)]])
}

fn is_paired(tiling: &FlatTiling, edge: &BoundaryEdge) -> bool {
    let Some(partner) = tiling.boundary.get(edge.partner) else { return false };
    let twice = tiling.boundary.iter().filter(|e| e.label == edge.label).count() == 2;
    twice
        && partner.label == edge.label
        && partner.sides.len() == edge.sides.len()
        && !std::ptr::eq(partner, edge)
        && glued_sides(tiling, edge).all(|[a, b]| tiling.partner(a) == b)
}

pub(super) fn glued(tiling: &FlatTiling) -> Glued {
    let mut sets = Partition::new(tiling.positions.len());
    let mut sides = 0;
    let mut orientable = true;
    for edge in &tiling.boundary {
        let against = edge.forward != tiling.boundary[edge.partner].forward;
        orientable &= against;
        for [a, b] in glued_sides(tiling, edge) {
            let [start, end] = tiling.ends(a).map(|k| tiling.point(a.flag, k).0 as usize);
            let [other_start, other_end] = tiling.ends(b).map(|k| tiling.point(b.flag, k).0 as usize);
            let (to_start, to_end) = if against { (other_end, other_start) } else { (other_start, other_end) };
            sets.join(start, to_start);
            sets.join(end, to_end);
        }
        sides += edge.sides.len();
    }
    let inner =
        tiling.map().flags().flat_map(|g| Reflection::ALL.map(|by| tiling.is_adjacent(g, by))).filter(|&a| a).count();
    let [vertices, edges, faces] = counted(tiling, sets);
    let curves = tiling.boundary.iter().map(|edge| edge.curve + 1).max().unwrap_or(0);
    let chi = (vertices + edges + faces) as i64 - ((sides + inner) / 2) as i64 + tiling.order().len() as i64;
    Glued { vertices, edges, faces, chi, orientable, curves }
}

/// Glued points of each kind: a set that has corners of two kinds counts for both.
fn counted(tiling: &FlatTiling, sets: Partition) -> [usize; 3] {
    let (number, count) = sets.numbered();
    let mut kinds = vec![[false; 3]; count];
    for g in tiling.map().flags() {
        for corner in 0..3 {
            kinds[number[tiling.point(g, corner).0 as usize] as usize][corner] = true;
        }
    }
    [0, 1, 2].map(|k| kinds.iter().filter(|kind| kind[k]).count())
}

fn wrong_counts(tiling: &FlatTiling) -> Option<TilingDefect> {
    let map = tiling.map();
    let found = glued(tiling);
    let wanted = Glued {
        vertices: map.vertex_count(),
        edges: map.edge_count(),
        faces: map.face_count(),
        chi: map.euler_characteristic(),
        orientable: map.is_orientable(),
        curves: usize::from(!tiling.boundary.is_empty()),
    };
    (found != wanted || tiling.order().iter().map(|g| g.index()).max() != Some(map.order() - 1))
        .then_some(TilingDefect::Counts { found, wanted })
}
