//! What a file holds, before anything is done with it: its defects, its counts, its quality.
//!
//! In: a [`FaceSoup`]. Out: [`Inspection`]. Holds: nothing is repaired; every defect names an element and a cure.

use crate::error::RemeshError;
use crate::measure::surface_report;
use crate::report::SurfaceReport;
use quadloom_extract::{Distances, IrregularVertices, QuadQuality, QualitySummary, Reference};
use quadloom_mesh::repair::{RepairError, RepairOptions, repair};
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
    use quadloom_mesh::DVec3;

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
