//! What a file holds, before anything is done with it: its defects, its counts, its quality.
//!
//! In: a [`FaceSoup`]. Out: [`Inspection`]. Holds: nothing is repaired; every defect names an element and a cure.

use crate::error::{RemeshError, Warning, WarningCode};
use crate::measure::surface_report;
use crate::report::{AsRead, SurfaceReport};
use quadloom_extract::{Distances, IrregularVertices, QuadQuality, QualitySummary, Reference};
use quadloom_mesh::repair::{FindingKind, RepairError, RepairOptions, Repaired, repair};
use quadloom_mesh::{Defect, FaceSoup, FeatureGraph, MeshError, PolygonMesh, QuadMesh, Summary, TriMesh};
use serde::Serialize;

/// What a file holds.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection {
    /// Vertices of the file.
    pub vertices: usize,
    /// Faces by number of corners, ascending.
    pub faces_by_degree: Vec<(usize, usize)>,
    /// What keeps it from being an oriented manifold.
    pub defects: Vec<DefectReport>,
    /// Counts, topology and size; `None` with defects.
    pub surface: Option<SurfaceReport>,
    /// Irregular vertices, if all faces are quads and there is no defect.
    pub irregular: Option<IrregularVertices>,
    /// Shapes, if all faces are quads and there is no defect.
    pub quality: Option<QualitySummary>,
    /// Distances to another surface, if they were asked for.
    pub distance: Option<DistanceReport>,
}

/// Distances with their unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DistanceReport {
    /// What the numbers are.
    pub unit: &'static str,
    /// The distances.
    #[serde(flatten)]
    pub distances: Distances,
}

/// Defects of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DefectReport {
    /// How many.
    pub count: usize,
    /// The first one, with its ids.
    pub first: String,
    /// What cures them.
    pub cure: String,
}

/// Looks at a soup.
///
/// # Cost       linear, and a repair if there are defects: what it cannot cure must not be promised
pub fn inspect(soup: &FaceSoup) -> Inspection {
    let mut by_degree = std::collections::BTreeMap::new();
    for face in &soup.faces {
        *by_degree.entry(face.len()).or_insert(0usize) += 1;
    }
    let mut inspection = Inspection {
        vertices: soup.positions.len(),
        faces_by_degree: by_degree.into_iter().collect(),
        defects: Vec::new(),
        surface: None,
        irregular: None,
        quality: None,
        distance: None,
    };
    match PolygonMesh::new(soup.positions.clone(), &soup.faces) {
        Ok(mesh) => inspection.surface = Some(surface_report(&mesh)),
        Err(MeshError::Connectivity(defects)) => inspection.defects = grouped(&defects, soup),
        Err(other) => {
            let cure = "give the vertex a position or delete its faces".into();
            inspection.defects = vec![DefectReport { count: 1, first: other.to_string(), cure }];
        }
    }
    if let Some(Ok(quads)) = as_quads(soup) {
        inspection.irregular = Some(IrregularVertices::of(&quads));
        inspection.quality = Some(QuadQuality::of(&quads).summary());
    }
    inspection
}

/// The quads of a soup, if all its faces have four corners.
pub fn as_quads(soup: &FaceSoup) -> Option<Result<QuadMesh, MeshError>> {
    let quads: Option<Vec<[u32; 4]>> = soup.faces.iter().map(|f| f.as_slice().try_into().ok()).collect();
    quads.map(|quads| QuadMesh::new(soup.positions.clone(), &quads))
}

/// Distances between the quads of a soup and a surface.
///
/// # Errors     a soup that is no mesh of quads
/// # Cost       about 100,000 closest-point queries
pub fn distances_to(soup: &FaceSoup, surface: &TriMesh) -> Result<DistanceReport, RemeshError> {
    let unfit = |why: String| RemeshError::Mismatch { what: "--reference", why };
    let quads =
        as_quads(soup).ok_or_else(|| unfit("distances are measured from quads, and not all faces are".into()))?;
    let quads = quads.map_err(|e| unfit(format!("{e}; `quadloom check` lists all defects")))?;
    let features = FeatureGraph::none(surface);
    let reference = Reference::new(surface, &features);
    let distances = Distances::measure(&quads, &reference).map_err(|e| unfit(e.to_string()))?;
    Ok(DistanceReport { unit: "percent of the diagonal of the reference's bounding box", distances })
}

/// Counts of a soup as it was read, before anything was cured.
///
/// # Input      repaired: the same soup, repaired; one without a finding has the counts already
/// # Cost       sorting positions, faces and edges, if there was anything to repair
pub fn as_read(soup: &FaceSoup, repaired: &Repaired) -> AsRead {
    let faces = soup.faces.len();
    if repaired.report.is_clean() {
        let Summary { components, boundary_loops, .. } = Summary::of(&repaired.mesh);
        return AsRead { faces, components, boundary_loops, non_manifold_edges: 0 };
    }
    // 1. Faces on positions, each once.
    let class = position_classes(soup);
    let mut distinct: Vec<(Vec<u32>, Vec<u32>)> = Vec::with_capacity(faces);
    for face in &soup.faces {
        let corners: Vec<u32> = face.iter().filter_map(|&v| class.get(v as usize).copied()).collect();
        let mut key = corners.clone();
        key.sort_unstable();
        key.dedup();
        if key.len() > 2 {
            distinct.push((key, corners));
        }
    }
    distinct.sort_unstable();
    distinct.dedup_by(|a, b| a.0 == b.0);
    // 2. Edges with their faces.
    let mut sides: Vec<([u32; 2], u32)> = Vec::new();
    for (f, (_, corners)) in distinct.iter().enumerate() {
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            if a != b {
                sides.push(([a.min(b), a.max(b)], f as u32));
            }
        }
    }
    sides.sort_unstable();
    // 3. What hangs together.
    let mut pieces = Groups::of(distinct.len());
    let mut boundary = Groups::of(soup.positions.len());
    let mut on_boundary = vec![false; soup.positions.len()];
    let mut non_manifold_edges = 0;
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        let ([a, b], first) = edge[0];
        edge.iter().for_each(|side| pieces.join(first, side.1));
        if edge.len() == 1 {
            boundary.join(a, b);
            on_boundary[a as usize] = true;
            on_boundary[b as usize] = true;
        }
        non_manifold_edges += usize::from(edge.len() > 2);
    }
    let boundary_loops = (0..on_boundary.len() as u32).filter(|&v| on_boundary[v as usize] && boundary.is_root(v));
    AsRead {
        faces,
        components: (0..distinct.len() as u32).filter(|&f| pieces.is_root(f)).count(),
        boundary_loops: boundary_loops.count(),
        non_manifold_edges,
    }
}

/// A warning where the repaired surface has other components or boundaries than the input seems to have.
pub fn topology_warning(read: &AsRead, repaired: &Repaired) -> Option<Warning> {
    let found = Summary::of(&repaired.mesh);
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let change = |what: &str, before: usize, after: usize| {
        (before != after).then(|| format!("{} instead of {before}", count(after, what)))
    };
    let loops = change("boundary loop", read.boundary_loops, found.boundary_loops);
    let pieces = change("component", read.components, found.components);
    // Loops that touch at a vertex look like one and are two: nothing was changed there.
    let touching = repaired.report.count(FindingKind::NonManifoldVertex) > 0;
    if pieces.is_none() && (loops.is_none() || touching && read.non_manifold_edges == 0) {
        return None;
    }
    let cause = match read.non_manifold_edges {
        0 => "the input was repaired".to_string(),
        n => format!("the input was cut open at {} with more than two faces", count(n, "edge")),
    };
    let changes: Vec<String> = loops.into_iter().chain(pieces).collect();
    let message = format!("{cause}: the result has {}", changes.join(" and "));
    Some(Warning::new(WarningCode::TopologyRepaired, message))
}

/// For every vertex the first one at exactly the same position.
fn position_classes(soup: &FaceSoup) -> Vec<u32> {
    // Adding zero makes -0 and 0 equal.
    let key = |v: u32| (soup.positions[v as usize] + 0.0).to_array().map(f64::to_bits);
    let mut order: Vec<([u64; 3], u32)> = (0..soup.positions.len() as u32).map(|v| (key(v), v)).collect();
    order.sort_unstable();
    let mut class: Vec<u32> = (0..soup.positions.len() as u32).collect();
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        same.iter().for_each(|&(_, v)| class[v as usize] = same[0].1);
    }
    class
}

/// Elements in groups that are joined; the smallest of each is its root.
struct Groups(Vec<u32>);

impl Groups {
    fn of(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let above = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = above;
            i = above;
        }
        i
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    fn is_root(&self, i: u32) -> bool {
        self.0[i as usize] == i
    }
}

impl Inspection {
    /// Whether two surfaces have the same Euler characteristic, components and boundary loops.
    pub fn same_topology(&self, other: &Summary) -> bool {
        self.surface.is_some_and(|s| s.summary.same_topology(other))
    }
}

fn grouped(defects: &[Defect], soup: &FaceSoup) -> Vec<DefectReport> {
    let obstacle = repair(soup, &RepairOptions::default()).err();
    let mut groups: Vec<(std::mem::Discriminant<Defect>, DefectReport)> = Vec::new();
    for defect in defects {
        let kind = std::mem::discriminant(defect);
        match groups.iter_mut().find(|(k, _)| *k == kind) {
            Some((_, group)) => group.count += 1,
            None => {
                let cure = cure(defect, obstacle.as_ref());
                groups.push((kind, DefectReport { count: 1, first: defect.to_string(), cure }));
            }
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// What cures a defect; obstacle: why the input as a whole cannot be repaired.
fn cure(defect: &Defect, obstacle: Option<&RepairError>) -> String {
    match (defect, obstacle) {
        (Defect::IndexOutOfRange { .. }, _) => "export the model again: vertices are missing".into(),
        (Defect::TooLarge { .. }, _) => "split or coarsen the model".into(),
        (_, Some(obstacle)) => format!("`quadloom remesh` cannot repair this: {obstacle}"),
        (Defect::UnusedVertex { .. }, _) => "harmless; `quadloom remesh` drops them".into(),
        (Defect::NonManifoldEdge { .. }, _) => {
            "`quadloom remesh` keeps the flattest pair of faces and cuts the others off".into()
        }
        _ => "`quadloom remesh` repairs this and says how".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::{DVec3, shapes};

    fn soup_of(mesh: &TriMesh) -> FaceSoup {
        let faces = mesh.to_faces().iter().map(|f| f.to_vec()).collect();
        FaceSoup { positions: mesh.positions().values().to_vec(), faces, ..FaceSoup::default() }
    }

    fn seen(soup: &FaceSoup) -> (AsRead, String) {
        let repaired = repair(soup, &RepairOptions::default()).expect("a surface");
        let read = as_read(soup, &repaired);
        (read, topology_warning(&read, &repaired).map_or_else(String::new, |w| w.message))
    }

    #[test]
    fn a_surface_that_is_cut_open_is_told_from_one_that_is_only_stitched() {
        // 1. Three sheets that meet in the edge from the origin to z, each of 2 n² triangles.
        let n = 4;
        let mut soup = FaceSoup::default();
        for turn in 0..3 {
            let (sin, cos) = (f64::from(turn) * 2.0).sin_cos();
            let first = soup.positions.len() as u32;
            let at = |i: u32, j: u32| first + j * (n + 1) + i;
            for j in 0..=n {
                soup.positions.extend((0..=n).map(|i| {
                    let out = f64::from(i);
                    DVec3::new(out * cos, out * sin, f64::from(j))
                }));
            }
            for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
                soup.faces.push(vec![at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                soup.faces.push(vec![at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        let (read, message) = seen(&soup);
        assert_eq!((read.components, read.boundary_loops, read.non_manifold_edges), (1, 1, n as usize));
        assert!(
            message.contains("cut open at 4 edges") && message.contains("2 boundary loops instead of 1"),
            "{message}"
        );
        // 2. Loose triangles at equal positions are one sphere, as anyone can see.
        let sphere = shapes::sphere(1.0, 2);
        let mut loose = FaceSoup::default();
        for f in sphere.faces() {
            let first = loose.positions.len() as u32;
            loose.positions.extend(sphere.face_vertices(f).map(|v| sphere.position(v)));
            loose.faces.push(vec![first, first + 1, first + 2]);
        }
        let (read, message) = seen(&loose);
        assert_eq!((read.faces, read.components, read.boundary_loops), (sphere.face_count(), 1, 0));
        assert_eq!(message, "");
        // 3. So is a sphere with a copy of a face.
        let mut copied = soup_of(&sphere);
        copied.faces.push(copied.faces[7].clone());
        let (read, message) = seen(&copied);
        assert_eq!((read.components, read.boundary_loops, read.non_manifold_edges, message.as_str()), (1, 0, 0, ""));
    }

    #[test]
    fn no_repair_is_promised_that_does_not_exist() {
        let positions: Vec<DVec3> =
            (0..6).map(|i| DVec3::new(f64::from(i), f64::from(i * i % 4), f64::from(i % 3))).collect();
        // A strip of triangles, closed with and without a twist; one face of the second is turned over.
        let strip = |ring: [u32; 2]| -> Vec<Vec<u32>> {
            let row = [0, 1, 2, 3, 4, 5, ring[0], ring[1]];
            (0..6)
                .map(|i| {
                    if i % 2 == 0 { vec![row[i], row[i + 1], row[i + 2]] } else { vec![row[i + 1], row[i], row[i + 2]] }
                })
                .collect()
        };
        let soup = |faces| FaceSoup { positions: positions.clone(), faces, ..FaceSoup::default() };
        let cures = |faces| inspect(&soup(faces)).defects.into_iter().map(|d| d.cure).collect::<Vec<_>>().join(" ");
        let twisted = cures(strip([1, 0]));
        assert!(twisted.contains("cannot repair") && twisted.contains("not orientable"), "{twisted}");
        let mut ring = strip([0, 1]);
        assert_eq!(cures(ring.clone()), "");
        ring[2].swap(0, 1);
        assert!(cures(ring).contains("repairs this"));
    }
}
