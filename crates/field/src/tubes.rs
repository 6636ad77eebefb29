//! Tubes between two curves, along which a field must not spiral.
//!
//! In: a cross field and the curves that it follows. Out: period jumps without spirals.
//! Holds: indices stay as they are. Not: tubes with singularities, or between curves with corners, are left alone; tubes
//! of one row of faces, too.
//! Source: own. Where a field makes a quarter turn between the two ends of a tube, the way around it is along a
//! u-line at one end and along a v-line at the other, hence of length zero: all quads collapse. After half a turn it
//! equals its own opposite, with the same end. Energy (8.1) does not tell: on a long tube a turn costs next to nothing.

use crate::cross_field::CrossField;
use crate::transport::Transport;
use quadloom_mesh::{EdgeMap, FaceId, FaceMap, FeatureGraph, HalfEdgeId, TriConnectivity, VertexId, VertexMap};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Quarter turns by which a field may miss the directions of the ends: faces between two edges of an end follow one.
const ALIGNED: f64 = 0.25;

/// Period jumps of a field that does not spiral along any tube; `None` if it does not anyway.
///
/// # Input      features: followed by the field at the faces on both of their sides
/// # Output     angles that belong to the jumps are to be solved for
/// # Cost       linear
pub fn unspiralled(
    mesh: &TriConnectivity,
    transport: &Transport,
    features: &FeatureGraph,
    field: &CrossField,
) -> Option<EdgeMap<i32>> {
    let patches = Patches::new(mesh, features);
    let on_feature = features.feature_vertices(mesh);
    // 1. Patches with two ends and no handle, where nothing is singular.
    let mut is_tube = patches.are_annuli(mesh, &on_feature);
    for v in mesh.vertices().filter(|&v| !on_feature[v] && field.index(mesh, transport, v) != 0) {
        patches.around(mesh, v).for_each(|p| is_tube[p] = false);
    }
    // 2. What each of them lacks.
    let mut jumps = field.period_jump.clone();
    let mut any = false;
    for patch in (0..is_tube.len()).filter(|&p| is_tube[p]) {
        let tube = Tube { mesh, transport, field, patches: &patches, ends: patches.ends(mesh, patch) };
        if let Some(turns) = tube.spiral().filter(|&turns| turns != 0) {
            any |= tube.turn_first_end(-turns, &mut jumps);
        }
    }
    any.then_some(jumps)
}

/// The faces between features.
struct Patches<'a> {
    features: &'a FeatureGraph,
    of_face: FaceMap<usize>,
    faces: Vec<Vec<FaceId>>,
}

impl<'a> Patches<'a> {
    fn new(mesh: &TriConnectivity, features: &'a FeatureGraph) -> Self {
        let mut patches = Self { features, of_face: FaceMap::filled(mesh.face_count(), usize::MAX), faces: Vec::new() };
        for start in mesh.faces() {
            if patches.of_face[start] != usize::MAX {
                continue;
            }
            let patch = patches.faces.len();
            patches.of_face[start] = patch;
            let mut faces = vec![start];
            let mut next = 0;
            while let Some(&f) = faces.get(next) {
                next += 1;
                for h in mesh.face_half_edges(f) {
                    let Some(g) = patches.across(mesh, h).filter(|&g| patches.of_face[g] == usize::MAX) else {
                        continue;
                    };
                    patches.of_face[g] = patch;
                    faces.push(g);
                }
            }
            patches.faces.push(faces);
        }
        patches
    }

    /// The face across a half-edge, if it is of the same patch by that.
    fn across(&self, mesh: &TriConnectivity, h: HalfEdgeId) -> Option<FaceId> {
        let crossed = mesh.twin(h).filter(|_| !self.features.is_feature(mesh.edge(h)));
        crossed.map(|t| mesh.face(t))
    }

    fn around<'b>(&'b self, mesh: &'b TriConnectivity, v: VertexId) -> impl Iterator<Item = usize> + 'b {
        mesh.outgoing(v).map(|h| self.of_face[mesh.face(h)])
    }

    /// The patches of two border curves and Euler characteristic 0, without their border.
    fn are_annuli(&self, mesh: &TriConnectivity, on_feature: &VertexMap<bool>) -> Vec<bool> {
        let mut chi: Vec<i64> = self.faces.iter().map(|faces| faces.len() as i64).collect();
        for e in mesh.edges().filter(|&e| !self.features.is_feature(e)) {
            chi[self.of_face[mesh.edge_faces(e).0]] -= 1;
        }
        for v in mesh.vertices().filter(|&v| !on_feature[v]) {
            if let Some(patch) = self.around(mesh, v).next() {
                chi[patch] += 1;
            }
        }
        (0..chi.len()).map(|p| chi[p] == 0 && self.ends(mesh, p).len() == 2).collect()
    }

    /// The border curves of a patch, each with the patch to its left.
    fn ends(&self, mesh: &TriConnectivity, patch: usize) -> Vec<Vec<HalfEdgeId>> {
        let borders = |h: &HalfEdgeId| self.across(mesh, *h).is_none();
        let all: Vec<HalfEdgeId> =
            self.faces[patch].iter().flat_map(|&f| mesh.face_half_edges(f)).filter(borders).collect();
        let mut seen = BTreeSet::new();
        let mut ends = Vec::new();
        for start in all {
            let mut end = Vec::new();
            let mut h = start;
            while seen.insert(h) {
                end.push(h);
                h = self.fan(mesh, h).0;
            }
            if !end.is_empty() {
                ends.push(end);
            }
        }
        ends
    }

    /// The border half-edge that follows one, and the half-edges that are crossed on the way around the vertex.
    fn fan(&self, mesh: &TriConnectivity, h: HalfEdgeId) -> (HalfEdgeId, Vec<HalfEdgeId>) {
        let mut crossed = Vec::new();
        let mut at = mesh.next(h);
        while self.across(mesh, at).is_some() {
            let Some(twin) = mesh.twin(at) else { break };
            crossed.push(at);
            at = mesh.next(twin);
        }
        (at, crossed)
    }
}

/// A patch with two ends.
struct Tube<'a> {
    mesh: &'a TriConnectivity,
    transport: &'a Transport,
    field: &'a CrossField,
    patches: &'a Patches<'a>,
    ends: Vec<Vec<HalfEdgeId>>,
}

impl Tube<'_> {
    /// Quarter turns that the field makes too many from the first end to the second; `None` where an end has corners.
    ///
    /// Counted against a curve that runs along the first end, turns into the tube, crosses it and turns into the second
    /// end: half a turn to the left in all, which a field without a spiral lags behind.
    fn spiral(&self) -> Option<i32> {
        if !self.ends.iter().all(|end| self.is_smooth(end)) {
            return None;
        }
        let path = self.path_across()?;
        let lead: f64 = path.windows(2).map(|pair| self.left_turn(pair[0], pair[1])).sum::<Option<f64>>()?;
        let quarters = lead / FRAC_PI_2 + 2.0;
        ((quarters - quarters.round()).abs() < ALIGNED).then_some(quarters.round() as i32)
    }

    /// Branch of a face's cross along one of its half-edges.
    fn branch(&self, h: HalfEdgeId) -> i32 {
        let off = self.transport.direction(h) - self.field.angle[self.mesh.face(h)];
        (off / FRAC_PI_2).round() as i32
    }

    /// The branch in the face across a half-edge that continues one here.
    fn crossed(&self, h: HalfEdgeId, branch: i32) -> i32 {
        branch - self.field.jump(self.mesh, h)
    }

    /// Whether one branch runs along a whole end.
    fn is_smooth(&self, end: &[HalfEdgeId]) -> bool {
        end.iter().all(|&h| {
            let (next, fan) = self.patches.fan(self.mesh, h);
            let carried = fan.iter().fold(self.branch(h), |branch, &h| self.crossed(h, branch));
            (carried - self.branch(next)).rem_euclid(4) == 0
        })
    }

    /// A half-edge of the first end, a path of edges across the patch, a half-edge of the second end; each begins where
    /// the one before ends, with the patch to its left. `None` if no such path keeps off the ends.
    fn path_across(&self) -> Option<Vec<HalfEdgeId>> {
        let mesh = self.mesh;
        let patch = self.patches.of_face[mesh.face(self.ends[0][0])];
        let leaves = |h: HalfEdgeId| self.patches.fan(mesh, h).1.into_iter().map(move |g| (g, h));
        let goal: BTreeSet<VertexId> = self.ends[1].iter().map(|&h| mesh.target(h)).collect();
        // 1. Breadth first, from all of the first end.
        let mut seen: BTreeSet<VertexId> = self.ends[0].iter().map(|&h| mesh.target(h)).collect();
        let mut from: BTreeMap<HalfEdgeId, HalfEdgeId> = self.ends[0].iter().flat_map(|&h| leaves(h)).collect();
        let mut queue: VecDeque<HalfEdgeId> = from.keys().copied().collect();
        let last = loop {
            let g = queue.pop_front()?;
            let v = mesh.target(g);
            if !seen.insert(v) {
                continue;
            }
            if goal.contains(&v) {
                break g;
            }
            for next in
                mesh.outgoing(v).filter(|&h| self.patches.of_face[mesh.face(h)] == patch && Some(h) != mesh.twin(g))
            {
                if !seen.contains(&mesh.target(next)) {
                    from.insert(next, g);
                    queue.push_back(next);
                }
            }
        };
        // 2. Back from where it arrived.
        let mut path = vec![self.patches.fan(mesh, last).0, last];
        while let Some(&before) = from.get(&path[path.len() - 1]) {
            path.push(before);
        }
        path.reverse();
        Some(path)
    }

    /// How far the field turns, less what the edges turn, on the way from one half-edge to the next, to its left,
    /// radians; `None` if that way leaves the patch.
    fn left_turn(&self, from: HalfEdgeId, to: HalfEdgeId) -> Option<f64> {
        let mesh = self.mesh;
        let (mut at, mut field) = (from, 0.0);
        let mut corners = 0.0;
        loop {
            let next = mesh.next(at);
            let exterior = self.transport.direction(next) - self.transport.direction(at);
            corners += PI - exterior.rem_euclid(TAU);
            if next == to {
                return Some(field - (PI - corners));
            }
            self.patches.across(mesh, next)?;
            field += self.field.turn(mesh, self.transport, next);
            at = mesh.twin(next)?;
        }
    }

    /// Turns the first end against the rest; not where the ends touch.
    fn turn_first_end(&self, turn: i32, jumps: &mut EdgeMap<i32>) -> bool {
        let mut end_of = VertexMap::filled(self.mesh.vertex_count(), 0u8);
        for (end, bit) in self.ends.iter().zip([1, 2]) {
            end.iter().for_each(|&h| end_of[self.mesh.origin(h)] |= bit);
        }
        let ends = |f: FaceId| self.mesh.face_vertices(f).into_iter().fold(0, |bits, v| bits | end_of[v]);
        let patch = self.patches.of_face[self.mesh.face(self.ends[0][0])];
        let faces = &self.patches.faces[patch];
        if faces.iter().any(|&f| ends(f) == 3) {
            return false;
        }
        for &f in faces.iter().filter(|&&f| ends(f) == 1) {
            for h in self.mesh.face_half_edges(f) {
                if self.patches.across(self.mesh, h).is_some_and(|g| ends(g) != 1) {
                    let e = self.mesh.edge(h);
                    jumps[e] -= if self.mesh.half_edge(e) == h { turn } else { -turn };
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::FieldConstraints;
    use crate::loops::curve_loops;
    use crate::solve::{FieldOptions, solve_cross_field};
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::metric::edge_lengths;
    use quadloom_mesh::{DVec3, Progress, TriMesh, shapes};

    /// Field of a mesh aligned with its boundary, for the jumps given, and the features.
    fn field_of(mesh: &TriMesh, start_from: Option<EdgeMap<i32>>) -> (CrossField, FeatureGraph) {
        let smooth = FeatureOptions { sharp_angle: None, ..FeatureOptions::default() };
        let features = FeatureGraph::detect(mesh, &smooth).0;
        let (length, transport) = (edge_lengths(mesh), Transport::of(mesh));
        let constraints = FieldConstraints::from_features(mesh, &transport, &length, &features).0;
        let options = FieldOptions { local_search: start_from.is_none(), start_from, ..FieldOptions::default() };
        let solved = solve_cross_field(mesh, &transport, &length, &constraints, &options, &Progress::none());
        (solved.expect("a field").0, features)
    }

    #[test]
    fn any_number_of_turns_along_a_tube_is_undone() {
        // A helix, as its field has reasons to turn; few faces around it.
        let pipe = shapes::cylinder(0.2, 20.0, 12, 240);
        let bent = |v: VertexId| {
            let p = pipe.position(v);
            let out = 1.0 + p.x;
            DVec3::new(out * p.z.cos(), out * p.z.sin(), p.y + 0.15 * p.z)
        };
        let mesh = TriMesh::new(pipe.vertices().map(bent).collect(), &pipe.to_faces()).expect("a helix");
        let transport = Transport::of(&mesh);
        let (field, features) = field_of(&mesh, None);
        assert!(field.singularities(&mesh, &transport).is_empty());
        let jumps = unspiralled(&mesh, &transport, &features, &field).unwrap_or(field.period_jump);
        let straight = field_of(&mesh, Some(jumps.clone())).0;
        assert_eq!(unspiralled(&mesh, &transport, &features, &straight), None);
        let ring = curve_loops(&mesh, |f| mesh.face_half_edges(f).iter().any(|&h| mesh.twin(h).is_none())).remove(0);
        for turns in [-5, -2, 1, 3, 4] {
            let mut twisted = jumps.clone();
            ring.iter().for_each(|&(e, amount)| twisted[e] += turns * amount);
            let twisted = field_of(&mesh, Some(twisted)).0;
            let undone = unspiralled(&mesh, &transport, &features, &twisted).expect("a spiral");
            let undone = field_of(&mesh, Some(undone)).0;
            let energy = |field: &CrossField| field.energy(&mesh, &transport);
            assert!((energy(&undone) - energy(&straight)).abs() < 1e-9, "{turns}");
        }
    }

    #[test]
    fn rings_and_plates_have_nothing_to_undo() {
        for mesh in [shapes::plate_with_holes(0.2), shapes::cylinder(1.0, 0.1, 20, 1), shapes::sphere(1.0, 2)] {
            let (field, features) = field_of(&mesh, None);
            assert_eq!(unspiralled(&mesh, &Transport::of(&mesh), &features, &field), None);
        }
    }
}
