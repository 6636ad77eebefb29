//! Flat angles laid out in the plane.
//!
//! In: an angle per corner that sums to π in faces and to 2π about interior vertices, and meets the wheel conditions.
//! Out: places of all vertices, turned so that the first side starts at the origin along the x axis, with the area
//! of the surface. Holds: angles are met as well as they fit together; where they do not to [`CLOSURE`], places are
//! the least squares of all faces' sides. Source: breadth-first unfolding as in [ShefferDeSturler2001]; the
//! least squares in place of those of [Sheffer2005].

use super::conformal::factorized;
use super::disk::Disk;
use quadloom_mesh::{CornerMap, DVec2, FaceMap, HalfEdgeId, HalfEdgeMap, TriMesh, VertexId, VertexMap};
use quadloom_numeric::{CholeskyError, SparseSymmetric, Triplet};
use std::collections::VecDeque;

/// Largest difference of the two images of an edge, as a fraction of its length, that is left as it is.
///
/// Larger: places differ from the angles visibly. Smaller: sums of rounding along a thousand faces reach it, and the
/// least squares, whose error is relative to the whole map, blur the tip of a finger.
const CLOSURE: f64 = 1e-10;

/// Places of all vertices.
pub(super) fn lay_out(
    mesh: &TriMesh,
    disk: &Disk,
    angle: &CornerMap<f64>,
    area: f64,
) -> Result<VertexMap<DVec2>, CholeskyError> {
    let unfolded = Unfolded::new(mesh, angle);
    let mut place = unfolded.place;
    if misfit(mesh, &unfolded.side, &place) > CLOSURE {
        match relax(mesh, angle, &unfolded.side, &mut place) {
            // Needles whose cotangents cannot be summed: places stay as unfolded, and the exact tests judge them.
            Ok(()) | Err(CholeskyError::NotPositiveDefinite { .. }) => {}
            Err(other) => return Err(other),
        }
    }
    normalise(mesh, disk, area, &mut place);
    Ok(place)
}

/// Faces unfolded one by one.
struct Unfolded {
    /// Image of each half-edge, as its own face has it.
    side: HalfEdgeMap<DVec2>,
    place: VertexMap<DVec2>,
}

impl Unfolded {
    /// Breadth first from face 0, whose side 0 has length 1.
    fn new(mesh: &TriMesh, angle: &CornerMap<f64>) -> Self {
        let mut unfolded = Self {
            side: HalfEdgeMap::filled(mesh.half_edge_count(), DVec2::ZERO),
            place: VertexMap::filled(mesh.vertex_count(), DVec2::NAN),
        };
        let mut seen = FaceMap::filled(mesh.face_count(), false);
        let mut open = VecDeque::new();
        if let Some(first) = mesh.faces().next() {
            let h = mesh.first_half_edge(first);
            seen[first] = true;
            unfolded.place[mesh.origin(h)] = DVec2::ZERO;
            unfolded.unfold(mesh, angle, h, DVec2::X);
            open.push_back(first);
        }
        while let Some(f) = open.pop_front() {
            for h in mesh.sides(f) {
                let Some(twin) = mesh.twin(h) else { continue };
                if !std::mem::replace(&mut seen[mesh.face(twin)], true) {
                    unfolded.unfold(mesh, angle, twin, -unfolded.side[h]);
                    open.push_back(mesh.face(twin));
                }
            }
        }
        unfolded
    }

    /// Sets the sides of a face, one of which is known, and the places that are new.
    fn unfold(&mut self, mesh: &TriMesh, angle: &CornerMap<f64>, h: HalfEdgeId, side: DVec2) {
        let (next, prev) = (mesh.next(h), mesh.prev(h));
        // a → b is known; c lies at angle α to its left, at |ab| · sin β / sin γ.
        let (alpha, beta, gamma) = (angle[h], angle[next], angle[prev]);
        let ac = DVec2::from_angle(alpha).rotate(side) * (beta.sin() / gamma.sin());
        self.side[h] = side;
        self.side[next] = ac - side;
        self.side[prev] = -ac;
        let at = self.place[mesh.origin(h)];
        self.put(mesh.target(h), at + side);
        self.put(mesh.origin(prev), at + ac);
    }

    fn put(&mut self, v: VertexId, place: DVec2) {
        if self.place[v].is_nan() {
            self.place[v] = place;
        }
    }
}

/// Largest difference of a side and the places of its ends, relative to its length.
fn misfit(mesh: &TriMesh, side: &HalfEdgeMap<DVec2>, place: &VertexMap<DVec2>) -> f64 {
    let difference = |h: HalfEdgeId| (place[mesh.target(h)] - place[mesh.origin(h)] - side[h]).length();
    mesh.half_edges().map(|h| difference(h) / side[h].length()).fold(0.0, f64::max)
}

/// Moves places by the least squares of Σ cot · |p_j − p_i − side|² over all half-edges.
fn relax(
    mesh: &TriMesh,
    angle: &CornerMap<f64>,
    side: &HalfEdgeMap<DVec2>,
    place: &mut VertexMap<DVec2>,
) -> Result<(), CholeskyError> {
    // Vertex 0 stays.
    let n = mesh.vertex_count() - 1;
    let mut triplets: Vec<Triplet> = Vec::new();
    let mut pull = vec![0.0; 2 * n];
    for h in mesh.half_edges() {
        let w = 1.0 / angle[mesh.prev(h)].tan();
        let (i, j) = (mesh.origin(h), mesh.target(h));
        let missing = (side[h] - (place[j] - place[i])) * w;
        for (v, sign) in [(i, -1.0), (j, 1.0)] {
            if v.0 > 0 {
                triplets.push((v.0 - 1, v.0 - 1, w));
                pull[v.index() - 1] += sign * missing.x;
                pull[n + v.index() - 1] += sign * missing.y;
            }
        }
        if i.0 > 0 && j.0 > 0 {
            triplets.push((i.0 - 1, j.0 - 1, -w));
        }
    }
    factorized(&SparseSymmetric::from_triplets(n, &triplets))?.solve_columns(&mut pull, 2);
    for v in mesh.vertices().skip(1) {
        place[v] += DVec2::new(pull[v.index() - 1], pull[n + v.index() - 1]);
    }
    Ok(())
}

/// Scales to an area and moves the first side of the tile to the x axis.
fn normalise(mesh: &TriMesh, disk: &Disk, area: f64, place: &mut VertexMap<DVec2>) {
    let doubled: f64 = mesh
        .faces()
        .map(|f| {
            let [a, b, c] = mesh.face_vertices(f).map(|v| place[v]);
            (b - a).perp_dot(c - a)
        })
        .sum();
    let scale = if doubled > 0.0 { (2.0 * area / doubled).sqrt() } else { 1.0 };
    let origin = place[disk.at(0)];
    let direction = first_direction(disk, place, origin);
    place.values_mut().iter_mut().for_each(|p| *p = direction.rotate(*p - origin) * scale);
}

/// The conjugate of the unit vector from the first corner to the second, or along the first border edge.
fn first_direction(disk: &Disk, place: &VertexMap<DVec2>, origin: DVec2) -> DVec2 {
    let end = disk.corner_at.get(1).copied().unwrap_or(1);
    let along = (place[disk.at(end)] - origin).normalize_or(DVec2::X);
    DVec2::new(along.x, -along.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::shapes;

    #[test]
    fn angles_that_do_not_fit_are_met_by_least_squares() {
        // A flat square whose angles are off by up to 1e-4: unfolding adds errors up, least squares spread them.
        let n = 20u32;
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let places: Vec<DVec2> =
            (0..=n).flat_map(|j| (0..=n).map(move |i| DVec2::new(f64::from(i), f64::from(j)))).collect();
        let squares = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let faces: Vec<[u32; 3]> = squares
            .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
            .collect();
        let mesh = TriMesh::new(places.iter().map(|p| p.extend(0.0)).collect(), &faces).unwrap();
        let corners = [0, n, at(n, n), at(0, n)].map(VertexId);
        let disk = Disk::new(&mesh, &corners).unwrap();
        let angle = CornerMap::from_fn(mesh.half_edge_count(), |h| {
            let side = |h: HalfEdgeId| mesh.position(mesh.target(h)) - mesh.position(mesh.origin(h));
            side(h).angle_between(-side(mesh.prev(h))) + 1e-4 * (shapes::random(5, u64::from(h.0)) - 0.5)
        });
        let area = f64::from(n * n);
        let found = lay_out(&mesh, &disk, &angle, area).unwrap();
        let mut unfolded = Unfolded::new(&mesh, &angle).place;
        normalise(&mesh, &disk, area, &mut unfolded);
        let error =
            |uv: &VertexMap<DVec2>| mesh.vertices().map(|v| uv[v].distance(places[v.index()])).fold(0.0, f64::max);
        assert!(
            error(&found) < 2e-3 && 1.5 * error(&found) < error(&unfolded),
            "{} {}",
            error(&found),
            error(&unfolded)
        );
    }
}
