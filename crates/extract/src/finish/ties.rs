//! Ties of quad vertices to the input: corners, curves, surface.
//!
//! In: an extraction and the reference surface. Out: [`Tie`] and position per vertex.
//! Holds: corners coincide with corners of the input; the order of vertices along a curve is that of the quads.
//! Source: own.

use crate::extraction::{Extraction, Placement};
use crate::reference::Reference;
use quadloom_mesh::{ChainId, DVec3, FaceId, QuadMesh, VertexId, VertexMap};

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tie {
    /// Nowhere.
    Fixed,
    /// Along a curve; `arc` is the length from the curve's start, file units.
    Curve { chain: ChainId, arc: f64 },
    /// On the surface; `face` carries it and has this unit normal. Where the vertex is beside the surface still, `face`
    /// is near it and the normal is zero.
    Surface { face: FaceId, normal: DVec3 },
}

impl Tie {
    /// The same for a vertex that is not there yet.
    pub fn off_surface(self) -> Self {
        match self {
            Self::Surface { face, .. } => Self::Surface { face, normal: DVec3::ZERO },
            other => other,
        }
    }
}

/// A place for a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Move {
    pub position: DVec3,
    pub tie: Tie,
}

impl Move {
    /// A place in a face of the surface.
    pub fn on(reference: &Reference, face: FaceId, position: DVec3) -> Self {
        let [a, b, c] = reference.mesh.face_vertices(face).map(|v| reference.mesh.position(v));
        Self { position, tie: Tie::Surface { face, normal: (b - a).cross(c - a).normalize_or_zero() } }
    }
}

/// Distance, relative to the mean quad edge, beyond which a vertex does not belong to the curve it names.
const CURVE_REACH_REL: f64 = 0.5;

/// Ties of all vertices, and their positions on the input.
pub(crate) struct Ties {
    pub position: VertexMap<DVec3>,
    pub tie: VertexMap<Tie>,
    /// The neighbours of a vertex along its curve.
    pub along: VertexMap<[Option<VertexId>; 2]>,
    /// Vertices whose corner or curve was not found on the input.
    pub mismatched: usize,
}

impl Ties {
    /// Puts every vertex onto what it is tied to.
    ///
    /// # Input      edge: mean edge length of the quads, file units
    pub fn new(quads: &Extraction, reference: &Reference, edge: f64) -> Self {
        let mesh = &quads.mesh;
        let mut ties = Self {
            position: mesh.positions().clone(),
            tie: VertexMap::filled(mesh.vertex_count(), Tie::Fixed),
            along: neighbours_along(quads),
            mismatched: 0,
        };
        let reach = CURVE_REACH_REL * edge;
        for v in mesh.vertices() {
            let p = mesh.position(v);
            ties.tie[v] = match quads.placement[v] {
                // Work mesh and input share their corners; one that is none here stays on the surface.
                Placement::Corner(_) if reference.closest.query(p).distance <= reach => Tie::Fixed,
                Placement::Chain { chain, .. } if (chain as usize) < reference.curves.len() => {
                    let c = reference.curves.query(chain, p);
                    if c.distance <= reach {
                        ties.position[v] = c.position;
                        Tie::Curve { chain, arc: c.arc }
                    } else {
                        ties.mismatched += 1;
                        ties.tie_to_surface(reference, mesh, v)
                    }
                }
                Placement::Free => ties.tie_to_surface(reference, mesh, v),
                _ => {
                    ties.mismatched += 1;
                    ties.tie_to_surface(reference, mesh, v)
                }
            };
        }
        ties
    }

    fn tie_to_surface(&mut self, reference: &Reference, mesh: &QuadMesh, v: VertexId) -> Tie {
        let normal: DVec3 = mesh.outgoing(v).map(|h| mesh.vector_area(mesh.face(h))).sum();
        let place = project(reference, mesh.position(v), normal, None).unwrap_or_else(|| {
            let face = reference.closest.query(mesh.position(v)).point.face;
            Move::on(reference, face, mesh.position(v))
        });
        self.position[v] = place.position;
        place.tie
    }
}

/// Steps along the normal that are tried where the nearest point lies on the other side of a thin sheet, relative to
/// the distance to that side.
const OTHER_SIDE_STEPS: [f64; 3] = [2.0, 6.0, 20.0];

/// The nearest point of the surface that faces like `normal`; `None` if the search near the point finds none.
pub(crate) fn project(reference: &Reference, p: DVec3, normal: DVec3, hint: Option<FaceId>) -> Option<Move> {
    let query = |q: DVec3| match hint {
        Some(f) => reference.closest.query_near(q, f),
        None => reference.closest.query(q),
    };
    let along = |m: &Move| matches!(m.tie, Tie::Surface { normal: n, .. } if n.dot(normal) >= 0.0);
    let nearest = query(p);
    let place = Move::on(reference, nearest.point.face, nearest.position);
    if along(&place) {
        return Some(place);
    }
    let direction = normal.normalize_or_zero();
    OTHER_SIDE_STEPS.iter().find_map(|&s| {
        let c = query(p + direction * (s * nearest.distance));
        Some(Move::on(reference, c.point.face, c.position)).filter(along)
    })
}

/// The two neighbours of each vertex along the chain it lies on.
fn neighbours_along(quads: &Extraction) -> VertexMap<[Option<VertexId>; 2]> {
    let mesh = &quads.mesh;
    let mut along = VertexMap::filled(mesh.vertex_count(), [None; 2]);
    for (e, chain) in quads.feature_edges.iter() {
        let Some(chain) = *chain else { continue };
        let [a, b] = mesh.ends(e);
        for (v, w) in [(a, b), (b, a)] {
            if matches!(quads.placement[v], Placement::Chain { chain: c, .. } if c == chain) {
                let slots: &mut [Option<VertexId>; 2] = &mut along[v];
                let k = usize::from(slots[0].is_some());
                slots[k] = Some(w);
            }
        }
    }
    along
}
