//! What a file holds, before anything is done with it: its defects, its counts, its quality.
//!
//! In: a [`FaceSoup`]. Out: [`Inspection`]. Holds: nothing is repaired; every defect names an element and a cure.

use crate::measure::surface_report;
use crate::report::SurfaceReport;
use quadloom_extract::{IrregularVertices, QuadQuality, QualitySummary};
use quadloom_mesh::{Defect, FaceSoup, MeshError, PolygonMesh, QuadMesh, Summary};
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
}

/// Defects of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DefectReport {
    /// How many.
    pub count: usize,
    /// The first one, with its ids.
    pub first: String,
    /// What cures them.
    pub cure: &'static str,
}

/// Looks at a soup.
///
/// # Cost       linear
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
    };
    match PolygonMesh::new(soup.positions.clone(), &soup.faces) {
        Ok(mesh) => inspection.surface = Some(surface_report(&mesh)),
        Err(MeshError::Connectivity(defects)) => inspection.defects = grouped(&defects),
        Err(other) => {
            let cure = "give the vertex a position or delete its faces";
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

impl Inspection {
    /// Whether two surfaces have the same Euler characteristic, components and boundary loops.
    pub fn same_topology(&self, other: &Summary) -> bool {
        self.surface.is_some_and(|s| s.summary.same_topology(other))
    }
}

fn grouped(defects: &[Defect]) -> Vec<DefectReport> {
    let mut groups: Vec<(std::mem::Discriminant<Defect>, DefectReport)> = Vec::new();
    for defect in defects {
        let kind = std::mem::discriminant(defect);
        match groups.iter_mut().find(|(k, _)| *k == kind) {
            Some((_, group)) => group.count += 1,
            None => groups.push((kind, DefectReport { count: 1, first: defect.to_string(), cure: cure(defect) })),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

fn cure(defect: &Defect) -> &'static str {
    match defect {
        Defect::IndexOutOfRange { .. } => "export the model again: vertices are missing",
        Defect::TooLarge { .. } => "split or coarsen the model",
        Defect::UnusedVertex { .. } => "harmless; `quadloom remesh` drops them",
        Defect::NonManifoldEdge { .. } => "`quadloom remesh` keeps the flattest pair of faces and cuts the others off",
        _ => "`quadloom remesh` repairs this and says how",
    }
}
