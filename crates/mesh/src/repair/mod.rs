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
use crate::connectivity::TriConnectivity;
use crate::ids::{FaceId, FaceMap, VertexId, VertexMap};
use crate::mesh::{MeshError, TriMesh};
use crate::soup::FaceSoup;
use crate::topology::components;
use glam::DVec3;

/// How a soup is repaired.
#[derive(Clone, Debug, PartialEq)]
pub struct RepairOptions {
    /// Height of a triangle over its longest side, relative to that side, from which it counts as one without
    /// area. Default 1e-7: rounding leaves 1e-16, and real needles down to 1e-6 are meant to be kept.
    pub zero_area_rel: f64,
    /// Faces up to which a piece that hangs on an edge with more than two faces, and nowhere else, is dropped.
    /// Default 8: such fins are modelling slips; larger pieces are somebody's design.
    pub max_fin_faces: usize,
    /// Distance from a boundary edge, relative to the size of the mesh, within which a boundary vertex is reported
    /// as a T-junction. Default 1e-7, what seven printed digits leave.
    pub t_junction_rel: f64,
}

impl Default for RepairOptions {
    fn default() -> Self {
        Self { zero_area_rel: 1e-7, max_fin_faces: 8, t_junction_rel: 1e-7 }
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
/// 2. Faces are joined along edges: first where exactly two share an edge, then where more do or where positions
///    coincide: flattest first, but, where the input is oriented, such as face alike before all others, so that solids
///    that touch along an edge stay solids. What is left over becomes boundary; scraps that hung there are dropped.
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
    let glued = if let Some(clean) = clean_draft(soup, &class) {
        clean
    } else {
        let triangles = polygons::triangles(soup, &unit, &class, &mut report);
        if triangles.corners.is_empty() {
            return Err(RepairError::NothingLeft { faces: soup.faces.len() });
        }
        // 2, 3, 4. Joined, oriented, numbered.
        glue::glue(&triangles, &soup.positions, &unit, &class, options.max_fin_faces, &mut report)?
    };
    // 5. Triangles without area.
    let cleaned = degenerate::remove(glued, options.zero_area_rel, &mut report);
    finish(soup, &class, cleaned, options, report)
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
    /// Connectivity of the faces on the vertices, where it is known.
    connectivity: Option<TriConnectivity>,
}

/// The soup itself, where steps 1 to 4 would change nothing but drop unused vertices; a short cut for clean input.
fn clean_draft(soup: &FaceSoup, class: &[u32]) -> Option<Draft> {
    let mut new_id = vec![u32::MAX; soup.positions.len()];
    for &v in soup.faces.iter().flatten() {
        new_id[v as usize] = 0;
    }
    let origin: Vec<u32> = (0..new_id.len() as u32).filter(|&v| new_id[v as usize] == 0).collect();
    for (i, &v) in origin.iter().enumerate() {
        new_id[v as usize] = i as u32;
    }
    let mut faces = Vec::with_capacity(soup.faces.len());
    for face in &soup.faces {
        let &[a, b, c] = &face[..] else { return None };
        let [i, j, k] = [a, b, c].map(|v| class[v as usize]);
        if i == j || j == k || k == i {
            return None;
        }
        faces.push([a, b, c].map(|v| new_id[v as usize]));
    }
    let connectivity = TriConnectivity::from_faces(origin.len(), &faces).ok()?;
    // Boundaries that coincide are to be stitched.
    let mut has_boundary = vec![false; class.len()];
    for v in connectivity.vertices().filter(|&v| connectivity.is_boundary_vertex(v)) {
        if std::mem::replace(&mut has_boundary[class[origin[v.index()] as usize] as usize], true) {
            return None;
        }
    }
    Some(Draft {
        positions: origin.iter().map(|&v| soup.positions[v as usize]).collect(),
        origin: origin.into_iter().map(Some).collect(),
        input_face: (0..faces.len() as u32).collect(),
        faces,
        connectivity: Some(connectivity),
    })
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
    // Adding zero makes -0 and 0 equal; ties in x alone are few.
    let key = |v: u32| (positions[v as usize] + 0.0).to_array().map(f64::to_bits);
    let mut order: Vec<(u64, u32)> = (0..positions.len() as u32).map(|v| (key(v)[0], v)).collect();
    order.sort_unstable();
    let mut class: Vec<u32> = (0..positions.len() as u32).collect();
    for group in order.chunk_by_mut(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
        group.sort_unstable_by_key(|&(_, v)| (key(v), v));
        for same in group.chunk_by(|a, b| key(a.1) == key(b.1)) {
            for &(_, v) in same {
                class[v as usize] = same[0].1;
            }
        }
    }
    class
}

/// Drops unused vertices, builds the mesh, looks for T-junctions.
fn finish(
    soup: &FaceSoup,
    class: &[u32],
    draft: Draft,
    options: &RepairOptions,
    mut report: RepairReport,
) -> Result<Repaired, RepairError> {
    if draft.faces.is_empty() {
        return Err(RepairError::NothingLeft { faces: soup.faces.len() });
    }
    let (mesh, origin) = match draft.connectivity {
        Some(connectivity) => (TriMesh::from_parts(connectivity, VertexMap::from_vec(draft.positions))?, draft.origin),
        None => compact(&draft)?,
    };
    let vertex_of_input = vertex_of_input(soup, class, &origin, &mut report);
    t_junctions(&mesh, &origin, options.t_junction_rel, &mut report);
    Ok(Repaired { mesh, vertex_of_input, input_face: FaceMap::from_vec(draft.input_face), report })
}

/// The draft without unused vertices, and the origins of those that are left.
fn compact(draft: &Draft) -> Result<(TriMesh, Vec<Option<u32>>), MeshError> {
    let mut new_id = vec![u32::MAX; draft.positions.len()];
    for &v in draft.faces.as_flattened() {
        new_id[v as usize] = 0;
    }
    let (mut positions, mut origin) = (Vec::new(), Vec::new());
    for (v, id) in new_id.iter_mut().enumerate().filter(|(_, id)| **id == 0) {
        *id = positions.len() as u32;
        positions.push(draft.positions[v]);
        origin.push(draft.origin[v]);
    }
    let faces: Vec<[u32; 3]> = draft.faces.iter().map(|f| f.map(|v| new_id[v as usize])).collect();
    Ok((TriMesh::new(positions, &faces)?, origin))
}

fn vertex_of_input(
    soup: &FaceSoup,
    class: &[u32],
    origin: &[Option<u32>],
    report: &mut RepairReport,
) -> Vec<Option<VertexId>> {
    // Copies of a position share its vertex, though a fan remembers only the first of them.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;
    use crate::topology::{Summary, component_summaries};
    use proptest::prelude::*;

    fn soup_of(mesh: &TriMesh) -> FaceSoup {
        FaceSoup {
            positions: mesh.positions().values().to_vec(),
            faces: mesh.to_faces().iter().map(|f| f.to_vec()).collect(),
            ..FaceSoup::default()
        }
    }

    fn run(soup: &FaceSoup) -> Repaired {
        repair(soup, &RepairOptions::default()).unwrap()
    }

    fn counts(mesh: &TriMesh) -> (usize, usize, usize, usize, i64) {
        let s = Summary::of(mesh.connectivity());
        (s.vertices, s.faces, s.components, s.boundary_loops, s.genus)
    }

    /// Coplanar faces of two cubes that touch along an edge face opposite ways: joining those would turn sides over.
    #[test]
    fn cubes_that_touch_along_an_edge_stay_cubes() {
        let cube = shapes::cube(1.0, 1);
        let along = cube.positions().values().iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p))
            - cube.positions().values().iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
        let mut soup = soup_of(&cube);
        let count = soup.positions.len() as u32;
        // Welded: vertices of the other cube that lie on the first one are the same.
        let moved: Vec<DVec3> = soup.positions.iter().map(|&p| p + along * DVec3::new(1.0, 1.0, 0.0)).collect();
        let number = |i: usize| {
            let same = (0..count).find(|&k| soup.positions[k as usize].distance(moved[i]) < 1e-9);
            same.unwrap_or(count + i as u32)
        };
        let faces: Vec<Vec<u32>> = soup.faces.iter().map(|f| f.iter().map(|&v| number(v as usize)).collect()).collect();
        soup.positions.extend(moved.iter().copied());
        soup.faces.extend(faces);
        let repaired = run(&soup);
        let volume = |mesh: &TriMesh| {
            let corner = |f| mesh.face_vertices(f).map(|v| mesh.position(v));
            mesh.faces().map(corner).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum::<f64>()
        };
        assert!((volume(&repaired.mesh) - 2.0 * volume(&cube)).abs() < 1e-9);
        assert!(repaired.report.findings().all(|f| f.kind != FindingKind::FlippedFace));
        assert_eq!(counts(&repaired.mesh), (16, 24, 2, 0, 0));
    }

    #[test]
    fn clean_meshes_come_back() {
        for (name, _) in shapes::sample_names() {
            let mesh = shapes::sample(name).unwrap();
            let repaired = run(&soup_of(&mesh));
            assert_eq!(repaired.mesh, mesh, "{name}");
            assert!(repaired.report.is_clean(), "{name}");
            assert_eq!(repaired.input_face.values(), (0..mesh.face_count() as u32).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_short_cut_changes_nothing() {
        for (name, _) in shapes::sample_names() {
            let mesh = shapes::sample(name).unwrap();
            let mut soup = soup_of(&mesh);
            soup.positions.insert(7, DVec3::ONE * 77.0);
            soup.faces.iter_mut().flatten().for_each(|v| *v += u32::from(*v >= 7));
            let short = run(&soup);
            // A degenerate face sends it the long way.
            soup.faces.push(vec![3, 3, 4]);
            let long = run(&soup);
            assert_eq!((&short.mesh, &short.vertex_of_input), (&long.mesh, &long.vertex_of_input), "{name}");
            assert_eq!(short.input_face, long.input_face);
            assert_eq!(short.report.count(FindingKind::UnusedVertex), 1);
            assert_eq!(long.report.findings().count(), 2);
        }
    }

    #[test]
    fn loose_triangles_are_stitched_where_they_meet() {
        for mesh in [shapes::torus(1.0, 0.4, 12, 9), shapes::bracket(0.7), shapes::cylinder(1.0, 2.0, 9, 4)] {
            let mut soup = FaceSoup::default();
            for f in mesh.to_faces() {
                soup.faces.push((soup.positions.len() as u32..).take(3).collect());
                soup.positions.extend(f.map(|v| mesh.positions().values()[v as usize]));
            }
            let repaired = run(&soup);
            assert_eq!(counts(&repaired.mesh), counts(&mesh));
            let welded = repaired.report.count(FindingKind::WeldedVertex);
            assert_eq!(welded, soup.positions.len() - mesh.vertex_count());
            assert!(repaired.vertex_of_input.iter().all(Option::is_some));
        }
    }

    #[test]
    fn touching_sheets_stay_two() {
        // Two cubes that share a face's positions, and two that share an edge: closed sheets are not welded.
        for offset in [DVec3::X, DVec3::X + DVec3::Y] {
            let cube = shapes::cube(1.0, 2);
            let moved = cube.with_positions(cube.positions().map(|&p| p + offset)).unwrap();
            let both = shapes::join(&[cube, moved]);
            assert_eq!(run(&soup_of(&both)).mesh, both);
        }
    }

    #[test]
    fn dirt_is_cured_and_counted() {
        let mesh = shapes::torus(1.0, 0.4, 12, 9);
        let clean = counts(&mesh);
        let mut soup = soup_of(&mesh);
        let n = soup.faces.len() as u32;
        // A repeated face, a face with a repeated corner, two corners only, an unused vertex, a fin.
        soup.faces.push(soup.faces[5].clone());
        soup.faces.push(vec![4, 4, 7]);
        soup.faces.push(vec![2, 3]);
        soup.positions.push(DVec3::splat(9.0));
        soup.positions.push(DVec3::splat(8.0));
        let side = mesh.ends(crate::ids::EdgeId(10));
        soup.faces.push(vec![side[0].0, side[1].0, soup.positions.len() as u32 - 1]);
        soup.faces[3].reverse();
        soup.faces[20].reverse();
        let repaired = run(&soup);
        assert_eq!(counts(&repaired.mesh), clean);
        let found: Vec<(FindingKind, usize, Vec<u32>)> =
            repaired.report.findings().map(|f| (f.kind, f.count, f.first.clone())).collect();
        let vertices = mesh.vertex_count() as u32;
        assert_eq!(
            found,
            [
                (FindingKind::DegenerateFace, 2, vec![n + 1, n + 2]),
                (FindingKind::DuplicateFace, 1, vec![n]),
                (FindingKind::FlippedFace, 2, vec![3, 20]),
                (FindingKind::NonManifoldEdge, 1, vec![n + 3]),
                (FindingKind::DroppedFin, 1, vec![n + 3]),
                (FindingKind::UnusedVertex, 1, vec![vertices]),
            ]
        );
        // The torus looks outwards as before.
        for f in repaired.mesh.faces() {
            let original = FaceId(repaired.input_face[f]);
            assert!(repaired.mesh.face_normal(f).dot(mesh.face_normal(original)) > 0.999);
        }
    }

    #[test]
    fn pinched_vertices_are_duplicated() {
        let (a, b) = (shapes::sphere(1.0, 1), shapes::sphere(2.0, 1));
        let mut soup = soup_of(&shapes::join(&[a.clone(), b.clone()]));
        // The last vertex of one sphere becomes the first of the other.
        let (from, to) = (a.vertex_count() as u32 - 1, a.vertex_count() as u32);
        for v in soup.faces.iter_mut().flatten() {
            if *v == from {
                *v = to;
            }
        }
        let repaired = run(&soup);
        assert_eq!(repaired.report.count(FindingKind::NonManifoldVertex), 1);
        let parts: Vec<(i64, usize)> =
            component_summaries(repaired.mesh.connectivity()).iter().map(|s| (s.chi, s.vertices)).collect();
        assert_eq!(parts, [(2, a.vertex_count()), (2, b.vertex_count())]);
    }

    #[test]
    fn one_sided_surfaces_are_refused_with_an_edge() {
        // A Moebius strip of seven triangles.
        let positions = (0..7).map(|i| DVec3::new(f64::from(i), f64::from(i * i % 5), f64::from(i % 3))).collect();
        let faces = (0..7u32).map(|i| vec![i, (i + 1) % 7, (i + 2) % 7]).collect();
        let soup = FaceSoup { positions, faces, ..FaceSoup::default() };
        assert!(matches!(repair(&soup, &RepairOptions::default()), Err(RepairError::NotOrientable { .. })));
    }

    #[test]
    fn unusable_soups_say_why() {
        let options = RepairOptions::default();
        let faces = vec![vec![0, 1, 2]];
        let soup = |positions: Vec<DVec3>| FaceSoup { positions, faces: faces.clone(), ..FaceSoup::default() };
        assert_eq!(repair(&FaceSoup::default(), &options).unwrap_err(), RepairError::NoFaces { vertices: 0 });
        let out = repair(&soup(vec![DVec3::X; 2]), &options).unwrap_err();
        assert_eq!(out, RepairError::IndexOutOfRange { face: 0, vertex: 2, vertices: 2 });
        let nan = repair(&soup(vec![DVec3::X, DVec3::NAN, DVec3::Y]), &options).unwrap_err();
        assert_eq!(nan, RepairError::NotFinite { first: vec![1], count: 1 });
        let point = repair(&soup(vec![DVec3::X; 3]), &options).unwrap_err();
        assert_eq!(point, RepairError::NothingLeft { faces: 1 });
    }

    /// Splits edges with vertices exactly in their middle and fills the T-junctions with flat triangles, again and
    /// again on the same edges, so that stacks of collinear triangles arise.
    fn with_flat_triangles(mesh: &TriMesh, per_edge: usize, edges: usize) -> FaceSoup {
        let mut soup = soup_of(mesh);
        for k in 0..edges {
            let e = crate::ids::EdgeId::new(k * mesh.edge_count() / edges);
            let h = mesh.half_edge(e);
            let (mut a, b) = (mesh.origin(h).0, mesh.target(h).0);
            let mut face = mesh.face(h).index();
            for _ in 0..per_edge {
                // Face (.., a, b, ..) becomes (a, m, c) and (m, b, c); the flat triangle is (a, b, m).
                let m = soup.positions.len() as u32;
                soup.positions.push(0.5 * (soup.positions[a as usize] + soup.positions[b as usize]));
                let old = soup.faces[face].clone();
                soup.faces[face] = old.iter().map(|&v| if v == b { m } else { v }).collect();
                soup.faces.push(old.iter().map(|&v| if v == a { m } else { v }).collect());
                face = soup.faces.len() - 1;
                soup.faces.push(vec![a, b, m]);
                a = m;
            }
        }
        soup
    }

    #[test]
    fn flat_triangles_are_flipped_away() {
        for (mesh, per_edge, edges) in [
            (shapes::sphere(1.0, 3), 1, 100),
            (shapes::bracket(0.5), 1, 50),
            (shapes::bracket(0.5), 8, 12),
            (shapes::cylinder(1.0, 2.0, 12, 6), 3, 9),
        ] {
            let soup = with_flat_triangles(&mesh, per_edge, edges);
            let repaired = run(&soup);
            let (_, _, components, loops, genus) = counts(&repaired.mesh);
            let (_, _, c, l, g) = counts(&mesh);
            assert_eq!((components, loops, genus), (c, l, g));
            assert!((repaired.mesh.area() - mesh.area()).abs() < 1e-9 * mesh.area());
            assert_eq!(repaired.report.count(FindingKind::ZeroAreaKept), 0);
            assert_eq!(repaired.report.count(FindingKind::ZeroAreaFace), per_edge * edges);
            let smallest = repaired.mesh.faces().map(|f| repaired.mesh.vector_area(f).length());
            assert!(smallest.fold(f64::INFINITY, f64::min) > 1e-7);
        }
    }

    #[test]
    fn needles_collapse() {
        // A vertex of a sphere becomes two at nearly the same place.
        let mesh = shapes::sphere(1.0, 2);
        let mut soup = soup_of(&mesh);
        let h = mesh.half_edge(crate::ids::EdgeId(40));
        let v = mesh.origin(h);
        let new = soup.positions.len() as u32;
        soup.positions.push(mesh.position(v) + DVec3::splat(1e-12));
        let ring: Vec<_> = mesh.outgoing(v).collect();
        // Two fans of faces around v and its copy, with needles between them at spokes 0 and 3.
        for &g in &ring[0..3] {
            for w in &mut soup.faces[mesh.face(g).index()] {
                *w = if *w == v.0 { new } else { *w };
            }
        }
        soup.faces.push(vec![v.0, mesh.target(ring[0]).0, new]);
        soup.faces.push(vec![new, mesh.target(ring[3]).0, v.0]);
        let repaired = run(&soup);
        assert_eq!(counts(&repaired.mesh), counts(&mesh));
        assert_eq!(repaired.report.count(FindingKind::ZeroAreaFace), 2);
    }

    #[test]
    fn polygons_keep_their_area() {
        // A comb: as far from convex as polygons get, and a ring-shaped cap around nothing.
        let mut outline = vec![DVec3::new(0.0, -1.0, 0.0), DVec3::new(10.0, -1.0, 0.0)];
        for i in (0..10).rev() {
            outline.push(DVec3::new(f64::from(i) + 0.9, 2.0, 0.0));
            outline.push(DVec3::new(f64::from(i) + 0.1, 0.0, 0.0));
        }
        let area: f64 = (0..outline.len()).map(|i| outline[i].cross(outline[(i + 1) % outline.len()]).z / 2.0).sum();
        let n = outline.len() as u32;
        let soup = FaceSoup { positions: outline, faces: vec![(0..n).collect()], ..FaceSoup::default() };
        let mesh = run(&soup).mesh;
        assert_eq!(mesh.face_count() as u32, n - 2);
        assert!((mesh.area() - area).abs() < 1e-12, "{} of {area}", mesh.area());
        assert!(mesh.faces().all(|f| mesh.vector_area(f).z > 0.0));
    }

    #[test]
    fn t_junctions_are_reported() {
        let positions = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [1.0, 0.0], [0.0, -1.0], [2.0, -1.0]];
        let positions = positions.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let faces = vec![vec![0, 1, 2], vec![3, 0, 4], vec![1, 3, 5], vec![3, 4, 5]];
        let repaired = run(&FaceSoup { positions, faces, ..FaceSoup::default() });
        let finding = repaired.report.findings().find(|f| f.kind == FindingKind::TJunction).unwrap();
        assert_eq!((finding.count, finding.first.clone()), (1, vec![3]));
    }

    #[test]
    fn components_split_and_cover() {
        let mesh = shapes::sample("two_spheres").unwrap();
        let parts = split_components(&mesh).unwrap();
        assert_eq!(parts.len(), 2);
        for part in &parts {
            for f in part.mesh.faces() {
                let whole = mesh.face_vertices(part.face_of[f]);
                assert_eq!(part.mesh.face_vertices(f).map(|v| part.vertex_of[v]), whole);
            }
        }
        assert_eq!(parts.iter().map(|p| p.mesh.face_count()).sum::<usize>(), mesh.face_count());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_soup_becomes_a_mesh_or_an_error(
            faces in proptest::collection::vec(proptest::collection::vec(0u32..14, 0..6), 1..40),
            grid in proptest::collection::vec([0i8..3, 0i8..3, 0i8..3], 14),
        ) {
            let positions: Vec<DVec3> = grid.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
            let soup = FaceSoup { positions, faces, ..FaceSoup::default() };
            match repair(&soup, &RepairOptions::default()) {
                Ok(repaired) => {
                    let mesh = &repaired.mesh;
                    prop_assert_eq!(repaired.input_face.len(), mesh.face_count());
                    for (i, v) in repaired.vertex_of_input.iter().enumerate() {
                        prop_assert!(v.is_none_or(|v| mesh.position(v) == soup.positions[i]));
                    }
                }
                Err(RepairError::NotOrientable { .. } | RepairError::NothingLeft { .. }) => {}
                Err(e) => prop_assert!(false, "{}", e),
            }
        }

        #[test]
        fn reversed_faces_are_turned_back(turned in proptest::collection::vec(0usize..216, 0..80)) {
            let mesh = shapes::torus(1.0, 0.4, 12, 9);
            let mut soup = soup_of(&mesh);
            for &f in &turned {
                soup.faces[f].swap(0, 1);
            }
            let repaired = run(&soup);
            for f in mesh.faces() {
                prop_assert!(repaired.mesh.face_normal(f).dot(mesh.face_normal(f)) > 0.999);
            }
        }
    }
}
