//! Given singular vertices: whether a quad mesh can have them, where they are on a work mesh, whether the quads do.
//!
//! In: vertices of the input with indices in quarters. Out: an error before any work, or a [`SingularitySummary`].
//! Holds: a vertex counts as found only if the quads have an irregular one of that index there, or nearer than an edge
//! on a curve. Not: that a list that passes [`check_list`] has a quad mesh; what rules it out is only known in part.
//! Source: [Bommes2012] §8.2 (indices sum to the Euler characteristic), §8.6 (prescribed irregular vertices);
//! [Izmestiev2013] for the torus.

use crate::error::{RemeshError, Warning, WarningCode};
use crate::options::Elements;
use crate::part::{Part, PartRequest};
use crate::stages::WorkMesh;
use quadloom_extract::{Extraction, Placement};
use quadloom_mesh::metric::{angle_defects, corner_angles, edge_lengths};
use quadloom_mesh::topology::euler_characteristic;
use quadloom_mesh::{ClosestPoint, DVec3, MeshError, QuadConnectivity, QuadMesh, TriMesh, VertexId};
use serde::Serialize;
use std::collections::BTreeMap;

/// A singular vertex as it was asked for, on one component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SingularityRequest {
    /// Number of the input file, for messages.
    pub asked: u32,
    /// The vertex of the component.
    pub vertex: VertexId,
    /// Index in quarters: 1 for valence 3, 0 for a vertex that is to be regular.
    pub quarters: i32,
    /// Whether the user named it; else it only stands for a list that names none ([`SingularityRequest::of_no_vertex`]).
    pub named: bool,
}

impl SingularityRequest {
    /// What an empty list asks of a component: its flattest interior vertex is to be regular and, as with any list, all
    /// that are not on it, too. `None` where there is no interior vertex.
    pub fn of_no_vertex(mesh: &TriMesh) -> Option<Self> {
        let defect = angle_defects(mesh, &corner_angles(mesh, &edge_lengths(mesh)));
        let interior = mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v));
        let vertex = interior.min_by(|&a, &b| defect[a].abs().total_cmp(&defect[b].abs()).then(a.cmp(&b)))?;
        Some(Self { asked: vertex.0, vertex, quarters: 0, named: false })
    }
}

/// What became of a given vertex.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SingularityReport {
    /// Vertex of the input file.
    pub vertex: u32,
    /// Index that was given, quarters.
    pub quarters: i32,
    /// Whether the quads have it.
    pub found: bool,
    /// Distance to the irregular vertex of the quads, file units; `None` where there is none, or index 0 was given.
    pub distance: Option<f64>,
}

/// What became of all of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SingularitySummary {
    /// The given vertices, component by component.
    pub given: Vec<SingularityReport>,
    /// Irregular interior vertices besides, on components with given ones.
    pub others: usize,
}

/// Largest index, quarters: around a vertex of index 3 there would be one quad, glued to itself.
const MOST_QUARTERS: i32 = 2;

/// Distance between a given vertex and its irregular vertex, in mean quad edges, up to which it counts as found.
///
/// Those inside the surface are exactly there ([`pinned`]); those on curves may slide.
const FOUND_REL: f64 = 1.0;

/// Distance of the next irregular vertex, in mean quad edges, from which a vertex counts as regular.
const REGULAR_REL: f64 = 0.25;

/// What the list of singular vertices is called in messages.
const LIST: &str = "the list of singularities";

/// Refuses a list that no quad mesh has.
///
/// # Input      mesh: connected; others: whether there may be singular vertices that are not on the list
/// # Errors     [`RemeshError::Mismatch`] names the vertex, or the sum found and the sum needed
/// # Cost       linear, and sorting the list
pub fn check_list(mesh: &TriMesh, list: &[SingularityRequest], others: bool) -> Result<(), RemeshError> {
    let unfit = |why: String| Err(RemeshError::Mismatch { what: LIST, why });
    // 1. Each vertex by itself.
    let mut known: BTreeMap<VertexId, u32> = BTreeMap::new();
    for &SingularityRequest { asked, vertex, quarters, .. } in list {
        if mesh.is_boundary_vertex(vertex) {
            return unfit(format!(
                "vertex {asked} is on the boundary, where no index is defined; name interior vertices"
            ));
        }
        if quarters > MOST_QUARTERS {
            return unfit(format!(
                "vertex {asked} has index {quarters}, which means valence {}; {MOST_QUARTERS} is the largest index",
                4 - quarters
            ));
        }
        match known.insert(vertex, asked) {
            Some(before) if before == asked => return unfit(format!("vertex {asked} is there twice; name it once")),
            Some(before) => {
                return unfit(format!("vertices {before} and {asked} are one point of the surface; name one of them"));
            }
            None => {}
        }
    }
    // 2. All of them: what is left out must be regular.
    if list.is_empty() || others || mesh.vertices().any(|v| mesh.is_boundary_vertex(v)) {
        return Ok(());
    }
    let found: i64 = list.iter().map(|s| i64::from(s.quarters)).sum();
    let chi = euler_characteristic(mesh);
    let needed = 4 * chi as i64;
    if found != needed {
        return unfit(format!(
            "its indices sum to {found} quarters, but a closed surface of Euler characteristic {chi} needs {needed}; name \
             all singular vertices, or let the program add some (--other-singularities)"
        ));
    }
    match impossible(mesh, list.iter().map(|s| s.quarters)) {
        Some(why) => unfit(format!("{why}; name more vertices")),
        None => Ok(()),
    }
}

/// Why no quad mesh has exactly these interior irregular vertices, if that is known.
///
/// # Source     [Izmestiev2013]: no quad mesh of the torus has one vertex of valence 3, one of 5, and all others regular
pub fn impossible(mesh: &TriMesh, quarters: impl Iterator<Item = i32>) -> Option<&'static str> {
    let mut singular: Vec<i32> = quarters.filter(|&q| q != 0).collect();
    singular.sort_unstable();
    let is_torus = || euler_characteristic(mesh) == 0 && !mesh.vertices().any(|v| mesh.is_boundary_vertex(v));
    (singular == [-1, 1] && is_torus())
        .then_some("no quad mesh of a torus has one vertex of valence 3, one of valence 5 and no other irregular one")
}

/// The nearest interior vertices of a work mesh, of those around the nearest face.
///
/// # Output     without those beside which there is no interior vertex
/// # Errors     two of them are one vertex: the quads are too large to tell them apart
/// # Cost       a search tree, if any are given, and a query for each
pub fn on_work_mesh(work: &WorkMesh, request: &PartRequest) -> Result<Vec<(VertexId, i32)>, RemeshError> {
    let mesh = &work.mesh;
    if request.singularities.is_empty() {
        return Ok(Vec::new());
    }
    let tree = ClosestPoint::new(mesh);
    let nearest = |p: DVec3| {
        let corners = mesh.face_vertices(tree.query(p).point.face);
        let around = corners.into_iter().flat_map(|v| mesh.neighbours(v)).chain(corners);
        let distance = |v: VertexId| mesh.position(v).distance_squared(p);
        let interior = around.filter(|&v| !mesh.is_boundary_vertex(v));
        interior.min_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)))
    };
    let mut taken: BTreeMap<VertexId, u32> = BTreeMap::new();
    let mut placed = Vec::with_capacity(request.singularities.len());
    for &SingularityRequest { asked, vertex, quarters, .. } in &request.singularities {
        let Some(v) = nearest(request.mesh.position(vertex)) else { continue };
        if let Some(before) = taken.insert(v, asked) {
            let why = format!(
                "vertices {before} and {asked} are nearer to each other than quads of this size can be; name vertices \
                 that are farther apart, or ask for more quads"
            );
            return Err(RemeshError::Mismatch { what: LIST, why });
        }
        placed.push((v, quarters));
    }
    Ok(placed)
}

/// Looks for the given vertices in the quads of all components; `None` if none were given.
pub fn singularity_summary(requests: &[PartRequest], parts: &[Part]) -> Option<SingularitySummary> {
    let given: Vec<_> = requests.iter().zip(parts).filter(|(request, _)| !request.singularities.is_empty()).collect();
    let found = |(request, part): &(&PartRequest, &Part)| {
        let edge = (part.area / part.quads.face_count() as f64).sqrt();
        look_for(&request.singularities, request.mesh, &part.quads, edge)
    };
    let parts: Vec<SingularitySummary> = given.iter().map(found).collect();
    (!parts.is_empty()).then(|| SingularitySummary {
        others: parts.iter().map(|p| p.others).sum(),
        given: parts.into_iter().flat_map(|p| p.given).collect(),
    })
}

/// Irregular interior vertices of quads, to look for given ones among them.
struct Irregular {
    /// Place, vertex and index, along x.
    list: Vec<(DVec3, VertexId, i32)>,
    taken: Vec<bool>,
}

impl Irregular {
    fn new(quads: &QuadConnectivity, place: impl Fn(VertexId) -> DVec3) -> Self {
        let interior = quads.vertices().filter(|&v| !quads.is_boundary_vertex(v));
        let mut list: Vec<(DVec3, VertexId, i32)> = interior
            .map(|v| (v, 4 - quads.valence(v) as i32))
            .filter(|i| i.1 != 0)
            .map(|(v, quarters)| (place(v), v, quarters))
            .collect();
        list.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        let taken = vec![false; list.len()];
        Self { list, taken }
    }

    /// Number in the list of the nearest one that is wanted and not taken, and its distance.
    fn nearest(&self, p: DVec3, reach: f64, wanted: impl Fn(i32) -> bool) -> Option<(usize, f64)> {
        let first = self.list.partition_point(|i| i.0.x < p.x - reach);
        let slab = (first..self.list.len()).take_while(|&k| self.list[k].0.x <= p.x + reach);
        slab.filter(|&k| !self.taken[k] && wanted(self.list[k].2))
            .map(|k| (k, self.list[k].0.distance(p)))
            .filter(|&(_, distance)| distance <= reach)
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The nearest one of an index, which is taken by that.
    fn take(&mut self, p: DVec3, reach: f64, quarters: i32) -> Option<(VertexId, f64)> {
        let (k, distance) = self.nearest(p, reach, |q| q == quarters)?;
        self.taken[k] = true;
        Some((self.list[k].1, distance))
    }
}

/// The same extraction with the irregular vertices that stand for given ones at their places on the input, and fixed
/// there, so that finishing does not carry them away; those on curves stay free to slide.
///
/// # Input      edge: mean length of the quads' edges, file units
/// # Errors     none for positions that are finite
pub fn pinned(
    extraction: &Extraction,
    work: &WorkMesh,
    request: &PartRequest,
    edge: f64,
) -> Result<Extraction, MeshError> {
    let mut pinned = extraction.clone();
    let mut irregular = Irregular::new(&extraction.mesh, |v| extraction.origin[v].position(&work.mesh));
    let mut position = extraction.mesh.positions().clone();
    for s in request.singularities.iter().filter(|s| s.quarters != 0) {
        let place = request.mesh.position(s.vertex);
        let Some((v, _)) = irregular.take(place, edge, s.quarters) else { continue };
        if extraction.placement[v] == Placement::Free {
            pinned.placement[v] = Placement::Corner(s.vertex);
            position[v] = place;
        }
    }
    pinned.mesh = extraction.mesh.with_positions(position)?;
    Ok(pinned)
}

/// Looks for given vertices among the irregular interior vertices of quads; each of those is taken once.
///
/// # Input      edge: mean length of the quads' edges, file units
/// # Cost       sorting, and for each given vertex the irregular ones in a slab around it
fn look_for(list: &[SingularityRequest], mesh: &TriMesh, quads: &QuadMesh, edge: f64) -> SingularitySummary {
    let mut irregular = Irregular::new(quads, |v| quads.position(v));
    let mut given = Vec::with_capacity(list.len());
    // 1. Those with an index take theirs.
    for s in list.iter().filter(|s| s.named) {
        let mut report = SingularityReport { vertex: s.asked, quarters: s.quarters, found: true, distance: None };
        if s.quarters != 0 {
            let hit = irregular.take(mesh.position(s.vertex), FOUND_REL * edge, s.quarters);
            report.found = hit.is_some();
            report.distance = hit.map(|(_, distance)| distance);
        }
        given.push(report);
    }
    // 2. Those that are to be regular have no other one beside them.
    for (s, report) in list.iter().filter(|s| s.named).zip(&mut given).filter(|(s, _)| s.quarters == 0) {
        report.found = irregular.nearest(mesh.position(s.vertex), REGULAR_REL * edge, |_| true).is_none();
    }
    SingularitySummary { given, others: irregular.taken.iter().filter(|&&t| !t).count() }
}

/// Warnings about given vertices that the quads do not have, and about others where there should be none.
pub fn singularity_warnings(summary: &SingularitySummary, others_allowed: bool) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let missed: Vec<&SingularityReport> = summary.given.iter().filter(|s| !s.found).collect();
    if let [first, ..] = missed[..] {
        let message = format!(
            "{} of {} given singular vertices are not in the quads (first: vertex {} of index {}); name vertices that \
             are farther from features and from each other, or ask for more quads",
            missed.len(),
            summary.given.len(),
            first.vertex,
            first.quarters
        );
        let elements = Elements::Vertices(missed.iter().map(|s| s.vertex).collect());
        warnings.push(Warning::new(WarningCode::SingularitiesMissed, message).at(elements));
    }
    warnings.extend((!others_allowed).then(|| others_warning(summary.others)).flatten());
    warnings
}

/// A warning about singular vertices that were not given, if there are some.
pub fn others_warning(others: usize) -> Option<Warning> {
    let message = format!(
        "there are {others} singular vertices besides the given ones, which features, boundaries or the map need; name \
         them too, or let them be (--other-singularities)"
    );
    (others > 0).then(|| Warning::new(WarningCode::SingularitiesMissed, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split::split_triangles;
    use quadloom_mesh::shapes;

    fn list(entries: &[(u32, i32)]) -> Vec<SingularityRequest> {
        entries
            .iter()
            .map(|&(v, quarters)| SingularityRequest { asked: v, vertex: VertexId(v), quarters, named: true })
            .collect()
    }

    fn complaint(mesh: &TriMesh, entries: &[(u32, i32)], others: bool) -> String {
        check_list(mesh, &list(entries), others).err().map_or_else(String::new, |e| e.to_string())
    }

    #[test]
    fn sums_are_those_of_the_surface() {
        let (torus, cube) = (shapes::torus(1.0, 0.4, 24, 12), shapes::cube(1.0, 2));
        assert!(complaint(&torus, &[(4, 1), (9, 1)], false).contains("sum to 2 quarters"));
        assert!(complaint(&torus, &[(4, 1), (9, 1)], false).contains("characteristic 0 needs 0"));
        assert_eq!(complaint(&torus, &[(4, 1), (9, 1)], true), "");
        assert_eq!(complaint(&torus, &[(4, 1), (9, 1), (20, -2)], false), "");
        assert_eq!(complaint(&torus, &[], false), "");
        assert!(complaint(&cube, &[(0, 1)], false).contains("characteristic 2 needs 8"));
        // Far beyond 32 bits.
        assert!(complaint(&cube, &[(0, i32::MIN), (1, i32::MIN)], false).contains("-4294967296"));
    }

    #[test]
    fn no_vertex_is_a_list_for_a_torus_only() {
        let (torus, cube) = (shapes::torus(1.0, 0.4, 24, 12), shapes::cube(1.0, 4));
        let none = |mesh: &TriMesh| SingularityRequest::of_no_vertex(mesh).expect("an interior vertex");
        assert!(check_list(&torus, &[none(&torus)], false).is_ok());
        let refused = check_list(&cube, &[none(&cube)], false).expect_err("a sphere").to_string();
        assert!(refused.contains("sum to 0 quarters") && refused.contains("needs 8"), "{refused}");
        // It is not reported as if somebody had named it, and is not at a corner of the cube.
        let quads = split_triangles(&cube).expect("quads");
        assert!(look_for(&[none(&cube)], &cube, &quads, 0.1).given.is_empty());
        let from_centre = (cube.position(none(&cube).vertex) - DVec3::splat(0.5)).abs();
        assert!(from_centre.min_element() < 0.49);
    }

    #[test]
    fn a_torus_has_no_single_pair_of_valence_3_and_5() {
        let torus = shapes::torus(1.0, 0.4, 24, 12);
        assert!(complaint(&torus, &[(4, 1), (90, -1)], false).contains("no quad mesh of a torus"));
        assert_eq!(complaint(&torus, &[(4, 1), (90, -1)], true), "");
        assert_eq!(complaint(&torus, &[(4, 2), (90, -2)], false), "");
    }

    #[test]
    fn single_entries_are_checked_on_any_surface() {
        let tube = shapes::cylinder(1.0, 1.0, 12, 6);
        let on =
            |boundary: bool| tube.vertices().find(|&v| tube.is_boundary_vertex(v) == boundary).expect("a vertex").0;
        assert!(complaint(&tube, &[(on(true), 1)], true).contains("boundary"));
        assert!(complaint(&tube, &[(on(false), 3)], true).contains("valence 1"));
        assert!(complaint(&tube, &[(on(false), 1), (on(false), 1)], true).contains("twice"));
        assert_eq!(complaint(&tube, &[(on(false), 1)], false), "");
    }

    #[test]
    fn what_quads_have_is_found_and_the_rest_counted() {
        // Split at the centres of edges and faces, vertices of the cube keep their place and their number of faces: two
        // have six.
        let cube = shapes::cube(1.0, 1);
        let quads = split_triangles(&cube).expect("quads");
        let irregular = quads.vertices().filter(|&v| quads.valence(v) != 4).count();
        let valence = |v: VertexId| {
            let there = quads.vertices().find(|&q| quads.position(q).distance(cube.position(v)) < 1e-9);
            quads.valence(there.expect("a vertex of the cube")) as i32
        };
        let entry = |v: VertexId| SingularityRequest { asked: v.0, vertex: v, quarters: 4 - valence(v), named: true };
        let mut entries: Vec<_> = cube.vertices().map(entry).filter(|s| s.quarters != 0).collect();
        let summary = look_for(&entries, &cube, &quads, 0.1);
        assert!(entries.len() == 2 && summary.given.iter().all(|s| s.found && s.distance < Some(1e-9)), "{summary:?}");
        assert_eq!(summary.others, irregular - entries.len());
        // Another index, or none, is not what is there.
        for wrong in [entries[0].quarters - 7, 0] {
            entries[0].quarters = wrong;
            let summary = look_for(&entries, &cube, &quads, 0.1);
            assert!(!summary.given[0].found && summary.given[1].found, "{summary:?}");
            assert_eq!(singularity_warnings(&summary, true).len(), 1);
        }
    }
}
