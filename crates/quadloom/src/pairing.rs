//! Pairing triangles: which edges of a triangle mesh are taken away so that most faces have four sides.
//!
//! In: a triangle mesh, its features, a cross field to follow. Out: [`Pairing`].
//! Holds: no face loses two sides; features stay; every pair is a convex quad that is nearly flat; every vertex keeps
//! so many faces that none of them needs an angle near 180 degrees. Not: that every triangle is paired.
//! Source: greedy matching in the dual graph, then augmenting paths [Edmonds1965] without blossoms.

use quadloom_extract::scaled_jacobian;
use quadloom_field::CrossField;
use quadloom_mesh::{CornerMap, DVec3, EdgeId, EdgeMap, FaceId, FaceMap, FeatureGraph, HalfEdgeId, TriMesh};
use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_4, PI};

/// Scaled Jacobian below which a pair of triangles is no quad to start from.
const LEAST_JACOBIAN: f64 = 0.3;

/// Cosine of the angle between two triangles from which they are one quad: 45 degrees.
const LEAST_FLATNESS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Angle that one face may take at a vertex: a sector between features keeps a face for each such angle.
const WIDEST_CORNER: f64 = 5.0 / 6.0 * PI;

/// Faces that a vertex off the features keeps: with two, one of them would have an angle of 180 degrees.
const LEAST_FACES: u32 = 3;

/// Triangles visited in search of one path: paths that are longer leave poor quads behind.
const PATH_LIMIT: usize = 200;

/// Rounds of searching paths from all single triangles.
const PATH_ROUNDS: usize = 3;

/// Which triangles are joined.
#[derive(Clone, Debug)]
pub(crate) struct Pairing {
    /// Whether an edge is taken away.
    pub joined: EdgeMap<bool>,
    /// Number of such edges.
    pub pairs: usize,
}

/// Pairs triangles, first those whose common edge runs most diagonally to the crosses.
///
/// # Input      single: triangles that stay by themselves
/// # Cost       O(n log n), and a bounded search for every triangle that is left
pub(crate) fn pair_triangles(
    mesh: &TriMesh,
    features: &FeatureGraph,
    single: &FaceMap<bool>,
    field: Option<&CrossField>,
) -> Pairing {
    let mut matching = Matching::new(mesh, features, single);
    // 1. Greedily.
    let mut order: Vec<(f64, EdgeId)> = mesh
        .edges()
        .filter(|&e| matching.allowed[e])
        .map(|e| (shape_cost(mesh, e) + field.map_or(0.0, |field| turn_from_diagonal(mesh, field, e)), e))
        .collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (_, e) in order {
        let (f, g) = matching.faces(e);
        if matching.mate[f].is_none() && matching.mate[g].is_none() && matching.has_room(e) {
            matching.join(e);
        }
    }
    // 2. What is left, along alternating paths.
    for _ in 0..PATH_ROUNDS {
        let single: Vec<FaceId> = mesh.faces().filter(|&f| matching.mate[f].is_none()).collect();
        let found = single.into_iter().filter(|&f| matching.mate[f].is_none() && matching.augment(f)).count();
        if found == 0 {
            break;
        }
    }
    let joined = EdgeMap::from_fn(mesh.edge_count(), |e| {
        matching.allowed[e] && matching.mate[mesh.face(mesh.half_edge(e))] == Some(e)
    });
    let pairs = joined.values().iter().filter(|&&j| j).count();
    Pairing { joined, pairs }
}

/// Corners of the quad that two triangles make, counter-clockwise from the origin of the edge's half-edge.
///
/// ```text
///       c
///     /   \
///    a──e──b      a, d, b, c
///     \   /
///       d
/// ```
pub(crate) fn pair_corners(mesh: &TriMesh, e: EdgeId) -> Option<[HalfEdgeId; 4]> {
    let h = mesh.half_edge(e);
    let t = mesh.twin(h)?;
    Some([mesh.next(t), mesh.prev(t), mesh.next(h), mesh.prev(h)])
}

/// How far a pair is from a square, 0..=1.
fn shape_cost(mesh: &TriMesh, e: EdgeId) -> f64 {
    pair_corners(mesh, e).map_or(1.0, |corner| 1.0 - scaled_jacobian(corner.map(|h| mesh.position(mesh.origin(h)))))
}

/// Angle between an edge and the nearest diagonal of the crosses beside it, in eighths of a turn, 0..=1.
fn turn_from_diagonal(mesh: &TriMesh, field: &CrossField, e: EdgeId) -> f64 {
    let h = mesh.half_edge(e);
    let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
    let turn = |h: HalfEdgeId| {
        let f = mesh.face(h);
        let frame = quadloom_mesh::metric::FaceFrame::of(mesh, f);
        let from_arm = (frame.angle_of(b - a) - field.angle[f]).rem_euclid(2.0 * FRAC_PI_4);
        (from_arm - FRAC_PI_4).abs() / FRAC_PI_4
    };
    let sides = [Some(h), mesh.twin(h)];
    sides.iter().flatten().map(|&h| turn(h)).sum::<f64>() / sides.iter().flatten().count() as f64
}

/// The pairs found so far, and how many faces every corner's sector has.
struct Matching<'a> {
    mesh: &'a TriMesh,
    /// Whether the triangles beside an edge may be joined.
    allowed: EdgeMap<bool>,
    /// The edge across which a triangle is joined.
    mate: FaceMap<Option<EdgeId>>,
    /// The sector between features of each corner.
    sector: CornerMap<u32>,
    /// Faces in each sector.
    faces: Vec<u32>,
    /// Faces that each sector keeps.
    least: Vec<u32>,
}

impl<'a> Matching<'a> {
    fn new(mesh: &'a TriMesh, features: &FeatureGraph, single: &FaceMap<bool>) -> Self {
        let joins = |e: EdgeId| {
            let h = mesh.half_edge(e);
            !single[mesh.face(h)] && mesh.twin(h).is_none_or(|t| !single[mesh.face(t)])
        };
        let allowed = EdgeMap::from_fn(mesh.edge_count(), |e| !features.is_feature(e) && joins(e) && is_quad(mesh, e));
        let mate = FaceMap::filled(mesh.face_count(), None);
        let sector = CornerMap::filled(mesh.half_edge_count(), 0);
        let mut matching = Self { mesh, allowed, mate, sector, faces: Vec::new(), least: Vec::new() };
        let opens = |h: HalfEdgeId| features.is_feature(mesh.edge(h)) || mesh.is_boundary_edge(mesh.edge(h));
        for v in mesh.vertices() {
            let mut around: Vec<HalfEdgeId> = mesh.outgoing(v).collect();
            let first = around.iter().position(|&h| opens(h));
            around.rotate_left(first.unwrap_or(0));
            let mut rest = &around[..];
            while let Some((&h, after)) = rest.split_first() {
                let count = 1 + after.iter().position(|&h| opens(h)).unwrap_or(after.len());
                let angle: f64 = rest[..count].iter().map(|&h| corner_angle(mesh, h)).sum();
                let kept = if first.is_some() { (angle / WIDEST_CORNER).ceil().max(1.0) as u32 } else { LEAST_FACES };
                debug_assert_eq!(mesh.origin(h), v);
                for &h in &rest[..count] {
                    matching.sector[h] = matching.faces.len() as u32;
                }
                matching.faces.push(count as u32);
                matching.least.push(kept);
                rest = &rest[count..];
            }
        }
        matching
    }

    fn faces(&self, e: EdgeId) -> (FaceId, FaceId) {
        let (f, g) = self.mesh.edge_faces(e);
        (f, g.unwrap_or(f))
    }

    /// The sectors at the two ends of an edge.
    fn sectors(&self, e: EdgeId) -> [usize; 2] {
        let h = self.mesh.half_edge(e);
        [h, self.mesh.next(h)].map(|corner| self.sector[corner] as usize)
    }

    /// Whether an edge's sectors can lose a face.
    fn has_room(&self, e: EdgeId) -> bool {
        self.sectors(e).iter().all(|&s| self.faces[s] > self.least[s])
    }

    fn join(&mut self, e: EdgeId) {
        let (f, g) = self.faces(e);
        self.mate[f] = Some(e);
        self.mate[g] = Some(e);
        self.sectors(e).iter().for_each(|&s| self.faces[s] -= 1);
    }

    fn part(&mut self, e: EdgeId) {
        let (f, g) = self.faces(e);
        self.mate[f] = None;
        self.mate[g] = None;
        self.sectors(e).iter().for_each(|&s| self.faces[s] += 1);
    }

    /// The triangle on the other side of an edge.
    fn across(&self, e: EdgeId, f: FaceId) -> FaceId {
        let (a, b) = self.faces(e);
        if a == f { b } else { a }
    }

    /// Joins a single triangle to another one along an alternating path; false, and nothing changes, if there is none.
    fn augment(&mut self, start: FaceId) -> bool {
        // Edge by which each visited triangle at an even distance was reached: across it lies the one before.
        let mut reached: Vec<(FaceId, Option<(EdgeId, usize)>)> = vec![(start, None)];
        let mut seen: Vec<FaceId> = vec![start];
        let mut open = VecDeque::from([0]);
        while let Some(i) = open.pop_front() {
            let f = reached[i].0;
            for h in self.mesh.face_half_edges(f) {
                let e = self.mesh.edge(h);
                let g = self.across(e, f);
                if !self.allowed[e] || self.mate[f] == Some(e) || seen.contains(&g) {
                    continue;
                }
                seen.push(g);
                let Some(pair) = self.mate[g] else {
                    if self.exchange(&reached, i, e) {
                        return true;
                    }
                    continue;
                };
                let beyond = self.across(pair, g);
                if seen.len() < PATH_LIMIT && !seen.contains(&beyond) {
                    seen.push(beyond);
                    reached.push((beyond, Some((e, i))));
                    open.push_back(reached.len() - 1);
                }
            }
        }
        false
    }

    /// Exchanges joined and other edges along the path that ends with `last`; false if a vertex would lose too many.
    fn exchange(&mut self, reached: &[(FaceId, Option<(EdgeId, usize)>)], end: usize, last: EdgeId) -> bool {
        let (mut joined, mut parted) = (vec![last], Vec::new());
        let mut i = end;
        while let (f, Some((e, before))) = reached[i] {
            parted.extend(self.mate[f]);
            joined.push(e);
            i = before;
        }
        parted.iter().for_each(|&e| self.part(e));
        joined.iter().for_each(|&e| self.join(e));
        let fits = joined.iter().all(|&e| self.sectors(e).iter().all(|&s| self.faces[s] >= self.least[s]));
        if !fits {
            joined.iter().for_each(|&e| self.part(e));
            parted.iter().for_each(|&e| self.join(e));
        }
        fits
    }
}

/// Whether the triangles beside an edge make a quad worth having.
fn is_quad(mesh: &TriMesh, e: EdgeId) -> bool {
    let (f, Some(g)) = mesh.edge_faces(e) else { return false };
    let Some(corner) = pair_corners(mesh, e) else { return false };
    let corner = corner.map(|h| mesh.position(mesh.origin(h)));
    let distinct = corner[1] != corner[3];
    distinct
        && mesh.face_normal(f).dot(mesh.face_normal(g)) > LEAST_FLATNESS
        && scaled_jacobian(corner) > LEAST_JACOBIAN
}

fn corner_angle(mesh: &TriMesh, h: HalfEdgeId) -> f64 {
    let [o, a, b]: [DVec3; 3] = [h, mesh.next(h), mesh.prev(h)].map(|c| mesh.position(mesh.origin(c)));
    (a - o).angle_between(b - o)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::shapes::sample;

    #[test]
    fn pairs_are_disjoint_and_keep_features_and_faces_around_vertices() {
        for name in ["sphere", "torus", "bracket", "plate"] {
            let Some(mesh) = sample(name) else { continue };
            let (features, _) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
            let Pairing { joined, pairs } =
                pair_triangles(&mesh, &features, &FaceMap::filled(mesh.face_count(), false), None);
            assert!(3 * pairs > mesh.face_count(), "{name}: {pairs} pairs of {} triangles", mesh.face_count());
            for f in mesh.faces() {
                assert!(mesh.face_half_edges(f).iter().filter(|&&h| joined[mesh.edge(h)]).count() <= 1);
            }
            for e in mesh.edges() {
                assert!(!joined[e] || !features.is_feature(e));
            }
            let on = features.feature_vertices(&mesh);
            for v in mesh.vertices().filter(|&v| !on[v]) {
                let lost = mesh.vertex_edges(v).filter(|&e| joined[e]).count();
                assert!(mesh.valence(v) - lost >= 3);
            }
        }
    }

    #[test]
    fn a_path_pairs_the_last_two_triangles_of_a_strip() {
        // Four triangles in a row; the middle pair, taken first, leaves both ends single.
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let at = vec![p(0.0, 0.0), p(1.0, 0.0), p(0.0, 1.0), p(1.0, 1.0), p(0.0, 2.0), p(1.0, 2.0)];
        let mesh = TriMesh::new(at, &[[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]).expect("a strip");
        let single = FaceMap::filled(mesh.face_count(), false);
        let mut matching = Matching::new(&mesh, &FeatureGraph::none(&mesh), &single);
        let middle = mesh.edges().find(|&e| mesh.ends(e).iter().all(|v| [2, 3].contains(&v.0))).expect("the edge");
        matching.least.fill(1);
        matching.join(middle);
        assert!(matching.augment(FaceId(0)));
        assert!(mesh.faces().all(|f| matching.mate[f].is_some()));
        assert_ne!(matching.mate[FaceId(0)], Some(middle));
    }
}
