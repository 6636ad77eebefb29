//! The components of a surface: their shares of the count, and their reunion as quads.
//!
//! In: components and a number of quads. Out: [`shares`], and [`join`]. Holds: shares sum to the count, up to
//! rounding, unless every component needs its minimum.

use quadloom_mesh::repair::Component;
use quadloom_mesh::topology::euler_characteristic;
use quadloom_mesh::{MeshError, QuadMesh, TriMesh};

/// Fewest quads that a component is asked for: twelve per handle and end on top of this.
///
/// Fewer leave no room for the eight singularities of a sphere; more would let crumbs of a scan eat the count.
const LEAST_QUADS: usize = 12;

/// Quads for each quarter of index that a component must have, where they are cheap: with fewer no map is looked for
/// on a closed surface whose field has the fewest singularities that there are.
const ROOMY_QUADS: usize = 6;

/// Part of the count that small components may have, together, for [`ROOMY_QUADS`].
///
/// More: crumbs of a scan eat the count. Less: a ball beside a large solid has triangles split into quads.
const ROOMY_REL: f64 = 0.1;

/// Distributes a count over parts by area, giving each at least a few quads; enough for a map, where that is cheap.
pub fn shares(parts: &[Component], quads: usize) -> Vec<usize> {
    if parts.len() == 1 {
        return vec![quads.max(1)];
    }
    let area: Vec<f64> = parts.iter().map(|p| p.mesh.area()).collect();
    let scarce: Vec<usize> = parts.iter().map(|p| least_quads(&p.mesh)).collect();
    let roomy: Vec<usize> = parts.iter().zip(&scarce).map(|(p, &least)| least.max(roomy_quads(&p.mesh))).collect();
    let (share, spent) = shares_with(&area, &roomy, quads);
    if spent as f64 <= ROOMY_REL * quads as f64 { share } else { shares_with(&area, &scarce, quads).0 }
}

/// Shares by area of at least so much each, and what those that have no more than that sum to.
fn shares_with(area: &[f64], least: &[usize], quads: usize) -> (Vec<usize>, usize) {
    let mut fixed = vec![false; area.len()];
    loop {
        let free_area: f64 = (0..area.len()).filter(|&i| !fixed[i]).map(|i| area[i]).sum();
        let spent: usize = (0..area.len()).filter(|&i| fixed[i]).map(|i| least[i]).sum();
        let free = quads.saturating_sub(spent) as f64;
        let share = |i: usize| (free * area[i] / free_area.max(f64::MIN_POSITIVE)).round() as usize;
        let short: Vec<usize> = (0..area.len()).filter(|&i| !fixed[i] && share(i) < least[i]).collect();
        if short.is_empty() {
            return ((0..area.len()).map(|i| if fixed[i] { least[i] } else { share(i) }).collect(), spent);
        }
        for i in short {
            fixed[i] = true;
        }
    }
}

fn least_quads(mesh: &TriMesh) -> usize {
    let complexity = (2 - euler_characteristic(mesh)).max(0) as usize;
    LEAST_QUADS * (1 + complexity)
}

/// Enough for the singular vertices that the Euler characteristic asks for.
fn roomy_quads(mesh: &TriMesh) -> usize {
    ROOMY_QUADS * 4 * euler_characteristic(mesh).unsigned_abs() as usize
}

/// One mesh of several, in their order.
///
/// # Errors     [`MeshError`] if there are more elements than ids
pub fn join(meshes: &[&QuadMesh]) -> Result<QuadMesh, MeshError> {
    let mut positions = Vec::new();
    let mut quads: Vec<[u32; 4]> = Vec::new();
    for mesh in meshes {
        let offset = positions.len() as u32;
        positions.extend_from_slice(mesh.positions().values());
        quads.extend(mesh.to_faces().iter().map(|q| q.map(|v| v + offset)));
    }
    QuadMesh::new(positions, &quads)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split::split_triangles;
    use quadloom_mesh::repair::split_components;
    use quadloom_mesh::{DVec3, Summary};

    /// Tetrahedra of the given sizes, apart, with interleaved faces.
    fn tetrahedra(sizes: &[f64]) -> TriMesh {
        let sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let mut positions = Vec::new();
        for (i, &s) in sizes.iter().enumerate() {
            let at = DVec3::new(10.0 * i as f64, 0.0, 0.0);
            positions.extend([at, at + DVec3::X * s, at + DVec3::Y * s, at + DVec3::Z * s]);
        }
        let faces: Vec<[u32; 3]> =
            sides.iter().flat_map(|t| (0..sizes.len() as u32).map(move |i| t.map(|v| v + 4 * i))).collect();
        TriMesh::new(positions, &faces).expect("tetrahedra")
    }

    #[test]
    fn joined_components_have_the_topology_of_the_whole() {
        let whole = tetrahedra(&[1.0, 2.0, 0.5]);
        let parts = split_components(&whole).expect("parts");
        let quads: Vec<QuadMesh> = parts.iter().map(|p| split_triangles(&p.mesh).expect("quads")).collect();
        let joined = join(&quads.iter().collect::<Vec<_>>()).expect("joined");
        assert!(Summary::of(&joined).same_topology(&Summary::of(&whole)));
    }

    #[test]
    fn shares_follow_area_with_a_minimum() {
        let parts = split_components(&tetrahedra(&[10.0, 10.0, 0.01])).expect("parts");
        let share = shares(&parts, 1000);
        assert_eq!(share, [476, 476, 48]);
        // Room for a map would be more than a tenth of it.
        assert_eq!(shares(&parts, 400), [194, 194, LEAST_QUADS]);
        assert_eq!(shares(&parts, 3), [LEAST_QUADS; 3]);
        assert_eq!(shares(&parts[..1], 77), [77]);
    }
}
