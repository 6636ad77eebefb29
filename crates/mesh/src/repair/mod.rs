//! From a face soup to a mesh: cures cheap dirt, reports it, and names what it cannot cure.
//!
//! In: [`FaceSoup`], anything a file may say. Out: [`Repaired`], or [`RepairError`] with ids and a cure.
//! Holds: a clean soup comes back with the same vertices and faces in the same order (unused vertices are
//! dropped); every face lies on the face it was made from; nothing is moved. Not: no holes filled, no
//! self-intersections removed, T-junctions stay open. Source: cutting and stitching [Gueziec2001]; ear clipping.
//!
//! Two vertices are one where their positions are equal and faces meet there along an edge; they stay two
//! where sheets merely touch. A vertex of the result is a fan of face corners, so it is manifold by construction.

mod degenerate;
mod glue;
mod polygons;
mod report;

pub use report::{Finding, FindingKind, RepairReport};

use crate::closest::segments_through;
use crate::ids::{FaceId, FaceMap, VertexId, VertexMap};
use crate::mesh::{MeshError, TriMesh};
use crate::soup::FaceSoup;
use crate::topology::components;
use glam::DVec3;

/// How a soup is repaired.
#[derive(Clone, Debug, PartialEq)]
pub struct RepairOptions {
    /// Height of a triangle over its longest side, relative to that side, from which it counts as one without
    /// area. Default 1e-8: rounding leaves 1e-16, and real needles down to 1e-6 are meant to be kept.
    pub zero_area_rel: f64,
    /// Distance from a boundary edge, relative to the size of the mesh, within which a boundary vertex is reported
    /// as a T-junction. Default 1e-7, what seven printed digits leave.
    pub t_junction_rel: f64,
}

impl Default for RepairOptions {
    fn default() -> Self {
        Self { zero_area_rel: 1e-8, t_junction_rel: 1e-7 }
    }
}

/// A repaired mesh and what happened to it.
#[derive(Clone, Debug)]
pub struct Repaired {
    /// The mesh.
    pub mesh: TriMesh,
    /// Vertex of the mesh for each vertex of the soup; of several copies the first; `None` if no face uses it.
    pub vertex_of_input: Vec<Option<VertexId>>,
    /// Face of the soup from which each face comes.
    pub input_face: FaceMap<u32>,
    /// What was cured or found.
    pub report: RepairReport,
}

/// Why a soup has no mesh; ids are those of the soup, counted from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RepairError {
    /// There is no face.
    #[error("there are {vertices} vertices but no face; export the model with its faces")]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} uses vertex {vertex}, but there are only {vertices} vertices; export the model again")]
    IndexOutOfRange {
        /// The face.
        face: u32,
        /// The index.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Faces use vertices with a coordinate that is NaN or infinite.
    #[error(
        "{count} vertices used by faces have coordinates that are not finite (first: {first:?}); \
         give them coordinates or delete their faces"
    )]
    NotFinite {
        /// The first of them.
        first: Vec<u32>,
        /// How many there are.
        count: usize,
    },
    /// The surface has one side only.
    #[error(
        "the surface is not orientable: faces {first} and {second} cannot agree at edge ({a}, {b}); \
         cut the surface along a curve through this edge"
    )]
    NotOrientable {
        /// One end of the edge.
        a: u32,
        /// The other end.
        b: u32,
        /// One face of it.
        first: u32,
        /// The other face.
        second: u32,
    },
    /// Every face was degenerate.
    #[error("none of the {faces} faces has an area; check the units and the precision of the export")]
    NothingLeft {
        /// Number of faces.
        faces: usize,
    },
    /// The repaired faces are still no mesh.
    #[error("the faces cannot be made a manifold: {0}")]
    Mesh(#[from] MeshError),
}

/// Turns a face soup into an oriented manifold triangle mesh.
///
/// 1. Polygons are triangulated; repeated corners, faces without area and copies of faces are dropped.
/// 2. Faces are joined along edges: first where exactly two share an edge, then, flattest first, where more do
///    or where positions coincide. What is left over becomes boundary.
/// 3. Joined faces are oriented consistently: as most of them are, outwards if closed.
/// 4. Every fan of joined corners becomes one vertex.
/// 5. Triangles without area between different positions are flipped or collapsed away.
///
/// # Errors     [`RepairError`]
/// # Cost       O(n log n); polygons quadratic in their corners
/// # Guarantees deterministic; a soup that is a clean triangle mesh keeps its order
pub fn repair(soup: &FaceSoup, options: &RepairOptions) -> Result<Repaired, RepairError> {
    check_input(soup)?;
    let mut report = RepairReport::default();
    let unit = unit_positions(&soup.positions);
    // 1. Triangles.
    let class = position_classes(&soup.positions);
    let triangles = polygons::triangles(soup, &unit, &class, &mut report);
    if triangles.corners.is_empty() {
        return Err(RepairError::NothingLeft { faces: soup.faces.len() });
    }
    // 2, 3, 4. Joined, oriented, numbered.
    let glued = glue::glue(&triangles, &soup.positions, &unit, &class, &mut report)?;
    // 5. Triangles without area.
    let cleaned = degenerate::remove(glued, options.zero_area_rel, &mut report);
    finish(soup, cleaned, options, report)
}

/// Faces with their vertices as origins in the soup, on the way through the repair.
struct Draft {
    /// Positions, file units.
    positions: Vec<DVec3>,
    /// Vertex of the soup of each vertex; `None` for inserted ones.
    origin: Vec<Option<u32>>,
    faces: Vec<[u32; 3]>,
    /// Face of the soup of each face.
    input_face: Vec<u32>,
}

fn check_input(soup: &FaceSoup) -> Result<(), RepairError> {
    let vertices = soup.positions.len();
    if soup.faces.is_empty() {
        return Err(RepairError::NoFaces { vertices });
    }
    let mut used = vec![false; vertices];
    for (f, face) in soup.faces.iter().enumerate() {
        for &v in face {
            match used.get_mut(v as usize) {
                Some(used) => *used = true,
                None => return Err(RepairError::IndexOutOfRange { face: f as u32, vertex: v, vertices }),
            }
        }
    }
    let bad: Vec<u32> =
        (0..vertices).filter(|&v| used[v] && !soup.positions[v].is_finite()).map(|v| v as u32).collect();
    if bad.is_empty() {
        return Ok(());
    }
    Err(RepairError::NotFinite { count: bad.len(), first: bad.into_iter().take(5).collect() })
}

/// Positions moved and scaled into the unit cube, so that no product overflows; used for decisions only.
fn unit_positions(positions: &[DVec3]) -> Vec<DVec3> {
    let finite = positions.iter().filter(|p| p.is_finite());
    let (lo, hi) = finite.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let (centre, half) = (0.5 * lo + 0.5 * hi, (0.5 * hi - 0.5 * lo).max_element());
    let scale = if half > 0.0 { half } else { 1.0 };
    positions.iter().map(|&p| (p - centre) / scale).collect()
}

/// For every vertex the first one at exactly the same position.
fn position_classes(positions: &[DVec3]) -> Vec<u32> {
    // Adding zero makes -0 and 0 equal.
    let key = |v: u32| (positions[v as usize] + 0.0).to_array().map(f64::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (key(v), v));
    let mut class = vec![0; positions.len()];
    let mut first = 0;
    for &v in &order {
        if key(v) != key(first) || class.is_empty() {
            first = v;
        }
        class[v as usize] = first;
    }
    class
}

/// Drops unused vertices, builds the mesh, looks for T-junctions.
fn finish(
    soup: &FaceSoup,
    draft: Draft,
    options: &RepairOptions,
    mut report: RepairReport,
) -> Result<Repaired, RepairError> {
    let mut new_id = vec![u32::MAX; draft.positions.len()];
    for &v in draft.faces.as_flattened() {
        new_id[v as usize] = 0;
    }
    let (mut positions, mut origin) = (Vec::new(), Vec::new());
    for v in 0..draft.positions.len() {
        if new_id[v] == 0 {
            new_id[v] = positions.len() as u32;
            positions.push(draft.positions[v]);
            origin.push(draft.origin[v]);
        }
    }
    let faces: Vec<[u32; 3]> = draft.faces.iter().map(|f| f.map(|v| new_id[v as usize])).collect();
    if faces.is_empty() {
        return Err(RepairError::NothingLeft { faces: soup.faces.len() });
    }
    let mesh = TriMesh::new(positions, &faces)?;
    let vertex_of_input = vertex_of_input(soup, &origin, &mut report);
    t_junctions(&mesh, &origin, options.t_junction_rel, &mut report);
    Ok(Repaired { mesh, vertex_of_input, input_face: FaceMap::from_vec(draft.input_face), report })
}

fn vertex_of_input(soup: &FaceSoup, origin: &[Option<u32>], report: &mut RepairReport) -> Vec<Option<VertexId>> {
    // Copies of a position share its vertex, though a fan remembers only the first of them.
    let class = position_classes(&soup.positions);
    let mut of_input: Vec<Option<VertexId>> = vec![None; soup.positions.len()];
    let mut of_class = of_input.clone();
    for (v, &input) in origin.iter().enumerate() {
        if let Some(i) = input {
            of_input[i as usize].get_or_insert(VertexId::new(v));
            of_class[class[i as usize] as usize].get_or_insert(VertexId::new(v));
        }
    }
    let mut used = vec![false; soup.positions.len()];
    for &v in soup.faces.iter().flatten() {
        used[v as usize] = true;
    }
    for v in 0..used.len() {
        if used[v] {
            of_input[v] = of_input[v].or(of_class[class[v] as usize]);
        } else {
            report.add(FindingKind::UnusedVertex, v as u32);
        }
    }
    of_input
}

/// Reports boundary vertices that lie inside a boundary edge of other vertices.
fn t_junctions(mesh: &TriMesh, origin: &[Option<u32>], tolerance_rel: f64, report: &mut RepairReport) {
    let edges: Vec<[VertexId; 2]> = mesh.edges().filter(|&e| mesh.is_boundary_edge(e)).map(|e| mesh.ends(e)).collect();
    let tolerance = tolerance_rel * mesh.diagonal();
    let boundary: Vec<VertexId> = mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)).collect();
    let segments: Vec<[DVec3; 2]> = edges.iter().map(|e| e.map(|v| mesh.position(v))).collect();
    let points: Vec<DVec3> = boundary.iter().map(|&v| mesh.position(v)).collect();
    for point in segments_through(&points, &segments, tolerance) {
        let v = boundary[point];
        report.add(FindingKind::TJunction, origin[v.index()].unwrap_or(v.0));
    }
}

/// A connected component as a mesh of its own.
#[derive(Clone, Debug)]
pub struct Component {
    /// The component.
    pub mesh: TriMesh,
    /// Vertex of the whole mesh for each of its vertices, ascending.
    pub vertex_of: VertexMap<VertexId>,
    /// Face of the whole mesh for each of its faces, ascending.
    pub face_of: FaceMap<FaceId>,
}

/// The connected components as meshes of their own, by their smallest face.
///
/// # Errors     none for a mesh within the range of ids
/// # Cost       linear
pub fn split_components(mesh: &TriMesh) -> Result<Vec<Component>, MeshError> {
    let parts = components(mesh.connectivity());
    let mut local = VertexMap::filled(mesh.vertex_count(), 0u32);
    let mut vertices: Vec<Vec<VertexId>> = vec![Vec::new(); parts.count];
    for v in mesh.vertices() {
        let list = &mut vertices[parts.of_vertex(mesh.connectivity(), v) as usize];
        local[v] = list.len() as u32;
        list.push(v);
    }
    let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); parts.count];
    for f in mesh.faces() {
        faces[parts.of_face[f] as usize].push(f);
    }
    vertices
        .into_iter()
        .zip(faces)
        .map(|(vertices, faces)| {
            let positions = vertices.iter().map(|&v| mesh.position(v)).collect();
            let corners: Vec<[u32; 3]> = faces.iter().map(|&f| mesh.face_vertices(f).map(|v| local[v])).collect();
            Ok(Component {
                mesh: TriMesh::new(positions, &corners)?,
                vertex_of: VertexMap::from_vec(vertices),
                face_of: FaceMap::from_vec(faces),
            })
        })
        .collect()
}
