//! Triangles become quads: the last resort where no integer-grid map is found, and the natural quads of a component of
//! a few triangles.
//!
//! In: a triangle mesh, its features, a count. Out: verified quads. Holds: same topology; no quad inverted or facing
//! against the surface. Not: few irregular vertices, though most vertices are regular.
//!
//! 1. An isotropic work mesh of about half as many triangles as quads are wanted.
//! 2. Its triangles are paired along the diagonals of a smooth cross field.
//! 3. Pairs are split into four quads, the triangles that are left into three, and finished on the surface.
//! 4. Where quads fail, the work mesh is made finer or takes over the surface's own triangles, and the whole is
//!    repeated.
//!
//! ```text
//!     ┌────┬────┐              /\
//!     │    │    │             /  \
//!     ├────┼────┤            /\  /\     the sides in the middle, so that any mixture of both fits together;
//!     │    │    │           /  \/  \    centres of triangles have valence 3, of pairs valence 4
//!     └────┴────┘          /___│____\
//! ```

use crate::count::{CountGoal, Tried, fit_count};
use crate::error::RemeshError;
use crate::ladder::Effort;
use crate::pairing::{Pairing, pair_corners, pair_triangles};
use crate::stages::no_result;
use crate::verify::{Verification, verify};
use quadloom_extract::{Extraction, FinishError, FinishOptions, Placement, Reference, finish, scaled_jacobian};
use quadloom_field::{CrossField, FieldConstraints, FieldOptions, Transport, solve_cross_field};
use quadloom_mesh::remesh::{RemeshOptions, Remeshed, TargetLength, isotropic};
use quadloom_mesh::{
    DVec3, EdgeId, EdgeMap, FaceId, FaceMap, FeatureGraph, HalfEdgeId, MeshError, PolylineIndex, Progress, QuadMesh,
    SurfacePoint, TriMesh, VertexId, VertexMap, metric,
};

/// Number of quads that [`split_triangles`] makes of each triangle.
pub const QUADS_PER_TRIANGLE: usize = 3;

/// Rounds in which the work mesh is made finer where quads fail: the third has edges of an eighth, the last of a
/// thousandth, for steps and ditches of solids that are so much smaller than the quads asked for.
const REFINEMENTS: usize = 10;

/// Factor on the work mesh's edges around quads that fail.
const REFINED_REL: f64 = 0.5;

/// Distance from a failed quad up to which the work mesh is made finer, relative to the quad's circumference.
const REFINED_REACH_REL: f64 = 0.5;

/// Share of failed quads up to which twice the effort is spent, as the next round is likely the last.
const FEW_REL: f64 = 1e-3;

/// Least scaled Jacobian of the quads of triangles that are taken over.
const KEPT_JACOBIAN: f64 = 0.1;

/// Makes quads of a surface without a map.
///
/// # Input      features: boundaries included; goal: the number of quads, reached as far as no quad fails
/// # Errors     no attempt passed verification, cancellation
/// # Cost       a remeshing, a linear cross field and a finish for each of at most a few attempts
/// # Guarantees the quads pass [`verify`]
pub fn split_surface(
    mesh: &TriMesh,
    features: &FeatureGraph,
    goal: CountGoal,
    progress: &Progress,
) -> Result<QuadMesh, RemeshError> {
    let reference = Reference::new(mesh, features);
    // 1. A work mesh of the right size.
    let uniform = VertexMap::filled(mesh.vertex_count(), Some(1.0));
    let pairs_of_quads = (0.5 * goal.quads).max(1.0);
    let equilateral = (mesh.area() / pairs_of_quads * 4.0 / 3.0_f64.sqrt()).sqrt();
    let fitted = fit_count(goal, equilateral, |edge| {
        let paired = Paired::new(mesh, features, &uniform, edge, progress)?;
        let quads = paired.quad_count() as f64;
        Ok::<_, RemeshError>(Some(Tried { solution: paired, quads, flaws: 0 }))
    })?;
    let fitted = fitted.ok_or_else(|| no_result("split", "there is no work mesh"))?;
    // 2. Finer where quads fail.
    let (mut paired, edge, mut relative) = (fitted.solution, fitted.size, uniform);
    let most_effort = progress.spent() + Effort::OF_SPLITS.most(goal.quads as usize);
    for round in 0..=REFINEMENTS {
        let quads = finished(&paired.split()?, &reference, progress)?;
        let verification = verify(&quads, &reference);
        if verification.passed() {
            return Ok(quads);
        }
        let few = verification.failed().count() as f64 <= FEW_REL * quads.face_count() as f64;
        if round == REFINEMENTS || progress.spent() > if few { 2 * most_effort } else { most_effort } {
            break;
        }
        refine_around(&mut relative, edge, &quads, &verification, mesh);
        paired = Paired::new(mesh, features, &relative, edge, progress)?;
    }
    // 3. The input's own triangles, whatever their number.
    let quads = split_triangles(mesh).map_err(|e| no_result("split", e))?;
    let verification = verify(&quads, &reference);
    if verification.passed() { Ok(quads) } else { Err(no_result("split", verification.complaint())) }
}

/// A work mesh with the pairs of its triangles.
struct Paired {
    work: Remeshed,
    pairing: Pairing,
}

impl Paired {
    /// # Input      relative: edge lengths at the vertices of `mesh`, in `edge`; those without one stay
    fn new(
        mesh: &TriMesh,
        features: &FeatureGraph,
        relative: &VertexMap<Option<f64>>,
        edge: f64,
        progress: &Progress,
    ) -> Result<Self, RemeshError> {
        let length = VertexMap::from_fn(mesh.vertex_count(), |v| relative[v].map(|r| r * edge));
        let options = RemeshOptions::default();
        let work = isotropic(mesh, features, TargetLength::PerVertex(&length), &options, progress)?;
        let field = smooth_field(&work, progress)?;
        let single =
            FaceMap::from_fn(work.mesh.face_count(), |f| work.mesh.face_vertices(f).iter().all(|&v| work.kept[v]));
        let pairing = pair_triangles(&work.mesh, &work.features, &single, field.as_ref());
        Ok(Self { work, pairing })
    }

    fn quad_count(&self) -> usize {
        QUADS_PER_TRIANGLE * self.work.mesh.face_count() - 2 * self.pairing.pairs
    }

    /// Splits pairs and single triangles at the midpoints of their sides and at their centres.
    ///
    /// # Output     quads on the work mesh; vertices come first, then midpoints by edge, then centres by face
    fn split(&self) -> Result<Extraction, RemeshError> {
        let Self { work: Remeshed { mesh, features, .. }, pairing: Pairing { joined, .. } } = self;
        let mut points: Vec<(SurfacePoint, Placement)> =
            mesh.vertices().map(|v| (at_vertex(mesh, v), vertex_placement(mesh, features, v))).collect();
        // 1. Midpoints.
        let mut midpoint = EdgeMap::filled(mesh.edge_count(), 0);
        for e in mesh.edges().filter(|&e| !joined[e]) {
            midpoint[e] = points.len() as u32;
            let on_chain = |chain| Placement::Chain { chain, edge: e, parameter: 0.5 };
            points.push((at_middle(mesh, e), features.chain_of[e].map_or(Placement::Free, on_chain)));
        }
        // 2. Centres, and the quads around them.
        let (mut quads, mut chain_of_side) = (Vec::new(), Vec::new());
        for f in mesh.faces() {
            let inner = mesh.face_half_edges(f).map(|h| mesh.edge(h)).into_iter().find(|&e| joined[e]);
            if inner.is_some_and(|e| mesh.face(mesh.half_edge(e)) != f) {
                continue;
            }
            let centre = points.len() as u32;
            let sides: Vec<HalfEdgeId> = match inner.and_then(|e| pair_corners(mesh, e)) {
                Some(sides) => sides.to_vec(),
                None => mesh.face_half_edges(f).to_vec(),
            };
            let place = inner.map_or(SurfacePoint { face: f, weights: [1.0 / 3.0; 3] }, |e| at_middle(mesh, e));
            points.push((place, Placement::Free));
            for (k, &h) in sides.iter().enumerate() {
                let [before, after] = [sides[(k + sides.len() - 1) % sides.len()], h].map(|side| mesh.edge(side));
                quads.push([mesh.origin(h).0, midpoint[after], centre, midpoint[before]]);
                chain_of_side.push([features.chain_of[after], features.chain_of[before]]);
            }
        }
        // 3. The quad mesh and what goes with it.
        let positions = points.iter().map(|(place, _)| place.position(mesh)).collect();
        let quad_mesh = QuadMesh::new(positions, &quads).map_err(|e| no_result("split", e))?;
        let mut feature_edges = EdgeMap::filled(quad_mesh.edge_count(), None);
        for (f, [after, before]) in quad_mesh.faces().zip(chain_of_side) {
            let [first, _, _, last] = quad_mesh.face_half_edges(f);
            feature_edges[quad_mesh.edge(first)] = after;
            feature_edges[quad_mesh.edge(last)] = before;
        }
        Ok(Extraction {
            grid: FaceMap::filled(quad_mesh.face_count(), None),
            mesh: quad_mesh,
            origin: points.iter().map(|p| p.0).collect(),
            placement: points.iter().map(|p| p.1).collect(),
            feature_edges,
            report: quadloom_extract::ExtractReport::default(),
        })
    }
}

/// A cross field that is smooth and no more; `None` where there is none.
fn smooth_field(work: &Remeshed, progress: &Progress) -> Result<Option<CrossField>, RemeshError> {
    let mesh = &work.mesh;
    let length = metric::edge_lengths(mesh);
    let transport = Transport::new(mesh, &length);
    let (constraints, _) = FieldConstraints::from_features(mesh, &transport, &length, &work.features);
    let options = FieldOptions { local_search: false, ..FieldOptions::default() };
    match solve_cross_field(mesh, &transport, &length, &constraints, &options, progress) {
        Ok((field, _)) => Ok(Some(field)),
        Err(quadloom_field::FieldError::Cancelled(c)) => Err(c.into()),
        Err(_) => Ok(None),
    }
}

fn at_vertex(mesh: &TriMesh, v: VertexId) -> SurfacePoint {
    on_side(mesh, mesh.outgoing_half_edge(v), 0.0)
}

fn at_middle(mesh: &TriMesh, e: EdgeId) -> SurfacePoint {
    on_side(mesh, mesh.half_edge(e), 0.5)
}

/// The point of a half-edge at `t` in 0..=1 from its origin.
fn on_side(mesh: &TriMesh, h: HalfEdgeId, t: f64) -> SurfacePoint {
    let face = mesh.face(h);
    let k = (h.0 - mesh.first_half_edge(face).0) as usize;
    let mut weights = [0.0; 3];
    (weights[k], weights[(k + 1) % 3]) = (1.0 - t, t);
    SurfacePoint { face, weights }
}

fn vertex_placement(mesh: &TriMesh, features: &FeatureGraph, v: VertexId) -> Placement {
    if features.is_corner[v] {
        return Placement::Corner(v);
    }
    let on = mesh.vertex_edges(v).find_map(|e| features.chain_of[e].map(|chain| (chain, e)));
    on.map_or(Placement::Free, |(chain, edge)| {
        let parameter = if mesh.ends(edge)[0] == v { 0.0 } else { 1.0 };
        Placement::Chain { chain, edge, parameter }
    })
}

fn finished(split: &Extraction, reference: &Reference, progress: &Progress) -> Result<QuadMesh, RemeshError> {
    match finish(split, reference, &FinishOptions::default(), progress) {
        Ok(finished) => Ok(finished.mesh),
        Err(FinishError::Cancelled(c)) => Err(c.into()),
        Err(other) => Err(no_result("finish", other)),
    }
}

/// Around quads that fail, on all sheets of the surface: lowers the relative edge length at its vertices where its
/// triangles are larger, and lets them stay where they are not, as a finer work mesh would be no closer to it.
fn refine_around(
    relative: &mut VertexMap<Option<f64>>,
    edge: f64,
    quads: &QuadMesh,
    verification: &Verification,
    mesh: &TriMesh,
) {
    let outline = |f: FaceId| (quads.face_vertices(f).map(|v| quads.position(v)), true);
    let outlines: Vec<([DVec3; 4], bool)> = verification.failed().map(outline).collect();
    let index = PolylineIndex::new(&outlines);
    for v in mesh.vertices() {
        let Some(nearest) = index.query_any(mesh.position(v)) else { continue };
        if nearest.distance <= REFINED_REACH_REL * index.length(nearest.chain) {
            let refined = relative[v].map(|r| r * REFINED_REL);
            relative[v] = refined.filter(|_| !may_stay(mesh, v, edge));
        }
    }
}

/// Whether the triangles around a vertex are no larger than those of the work mesh, and give quads that are good enough.
fn may_stay(mesh: &TriMesh, v: VertexId, edge: f64) -> bool {
    mesh.outgoing(v).map(|h| mesh.face(h)).all(|f| {
        let corner = mesh.face_vertices(f).map(|v| mesh.position(v));
        let centre = corner.iter().sum::<DVec3>() / 3.0;
        (0..3).all(|k| {
            let [before, at, after] = [corner[(k + 2) % 3], corner[k], corner[(k + 1) % 3]];
            at.distance(after) <= edge
                && scaled_jacobian([at, at.midpoint(after), centre, at.midpoint(before)]) >= KEPT_JACOBIAN
        })
    })
}

/// Splits every triangle into three quads at its centroid and the midpoints of its sides.
///
/// Vertices come first, then one per edge, then one per face.
///
/// # Errors     none for a triangle mesh; the constructor of the quad mesh is not bypassed
/// # Cost       linear
pub fn split_triangles(mesh: &TriMesh) -> Result<QuadMesh, MeshError> {
    let (vertices, edges) = (mesh.vertex_count(), mesh.edge_count());
    let mut positions: Vec<DVec3> = mesh.positions().values().to_vec();
    positions.extend(mesh.edges().map(|e| {
        let [a, b] = mesh.ends(e);
        mesh.position(a).midpoint(mesh.position(b))
    }));
    positions.extend(mesh.faces().map(|f| {
        let [a, b, c] = mesh.face_vertices(f).map(|v| mesh.position(v));
        (a + b + c) / 3.0
    }));
    let mut quads = Vec::with_capacity(QUADS_PER_TRIANGLE * mesh.face_count());
    for f in mesh.faces() {
        for h in mesh.face_half_edges(f) {
            let [before, after] = [mesh.prev(h), h].map(|side| (vertices + mesh.edge(side).index()) as u32);
            let centre = (vertices + edges + f.index()) as u32;
            quads.push([mesh.origin(h).index() as u32, after, centre, before]);
        }
    }
    QuadMesh::new(positions, &quads)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::{Summary, VertexId};

    fn features_of(mesh: &TriMesh) -> FeatureGraph {
        FeatureGraph::detect(mesh, &quadloom_mesh::features::FeatureOptions::default()).0
    }

    #[test]
    fn shapes_become_mostly_regular_quads_near_the_count() {
        for name in ["bracket", "plate", "genus2"] {
            let mesh = quadloom_mesh::shapes::sample(name).expect("a sample");
            let features = features_of(&mesh);
            let goal = CountGoal { quads: 1200.0, tolerance: 0.1, solves: 4 };
            let quads = split_surface(&mesh, &features, goal, &Progress::none()).expect("quads");
            assert!(verify(&quads, &Reference::new(&mesh, &features)).passed());
            assert!((quads.face_count() as f64 / 1200.0 - 1.0).abs() < 0.25, "{name}: {} quads", quads.face_count());
            let irregular = quads.vertices().filter(|&v| !quads.is_boundary_vertex(v) && quads.valence(v) != 4).count();
            assert!(4 * irregular < quads.vertex_count(), "{name}: {irregular} of {} vertices", quads.vertex_count());
        }
    }

    /// A sheet thinner than the quads: points of one side lie nearest to the other side.
    #[test]
    fn a_thin_sheet_has_quads_on_both_sides() {
        let square = quadloom_mesh::shapes::cube(1.0, 12);
        let flat = square.positions().values().iter().map(|p| DVec3::new(p.x, p.y, 0.01 * p.z)).collect();
        let sheet = TriMesh::new(flat, &square.to_faces()).expect("a sheet");
        let features = features_of(&sheet);
        let goal = CountGoal { quads: 400.0, tolerance: 0.1, solves: 4 };
        let quads = split_surface(&sheet, &features, goal, &Progress::none()).expect("quads");
        assert!(verify(&quads, &Reference::new(&sheet, &features)).passed());
    }

    /// Around quads that fail, fine triangles stay, and coarse ones ask for a finer work mesh.
    #[test]
    fn the_surface_is_taken_over_where_it_is_as_fine_as_the_work_mesh() {
        let quads = split_triangles(&quadloom_mesh::shapes::cube(1.0, 4)).expect("quads");
        let failed = |mesh: &TriMesh| {
            let mut verification = verify(&quads, &Reference::new(mesh, &FeatureGraph::none(mesh)));
            verification.inverted = vec![FaceId::new(0)];
            let mut relative = VertexMap::filled(mesh.vertex_count(), Some(1.0));
            refine_around(&mut relative, 0.25, &quads, &verification, mesh);
            let count = |wanted: Option<f64>| relative.values().iter().filter(|r| **r == wanted).count();
            (count(None), count(Some(REFINED_REL)), count(Some(1.0)))
        };
        let (stay, finer, unchanged) = failed(&quadloom_mesh::shapes::cube(1.0, 12));
        assert!(stay > 0 && finer == 0 && unchanged > stay);
        let (stay, finer, unchanged) = failed(&quadloom_mesh::shapes::cube(1.0, 3));
        assert!(stay == 0 && finer > 0 && unchanged > finer);
    }

    #[test]
    fn an_open_and_a_closed_mesh_keep_their_topology() {
        let corner = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let closed =
            TriMesh::new(corner.to_vec(), &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]).expect("a tetrahedron");
        let open = TriMesh::new(corner.to_vec(), &[[0, 2, 1], [0, 1, 3]]).expect("two triangles");
        for mesh in [closed, open] {
            let quads = split_triangles(&mesh).expect("quads");
            assert!(Summary::of(&quads).same_topology(&Summary::of(&mesh)));
            assert_eq!(quads.face_count(), 3 * mesh.face_count());
            assert!((quads.area() - mesh.area()).abs() < 1e-12);
            for v in mesh.vertices() {
                assert_eq!(quads.position(VertexId::new(v.index())), mesh.position(v));
                assert_eq!(quads.valence(v), mesh.valence(v));
            }
        }
    }
}
