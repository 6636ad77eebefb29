//! Noise on a work mesh is smoothed away before a field is solved on it.
//!
//! In: a [`WorkMesh`] and the number of quads it is for. Out: a work mesh of the same topology and curves, smoother where
//! the surface was rough. Holds: a surface whose curvature has room in its quads is not touched.
//! Not: that the vertices still lie on the input; finishing lays the quads onto it.
//! Source: [Taubin1995] (smoothing that does not shrink). A cross field turns with the curvature it is carried over, so
//! noise makes singularities of random sign at almost every vertex; [Bommes2012] Figure 8.9 has noise in the choice of
//! directions only.

use crate::error::RemeshError;
use crate::options::RemeshOptions;
use crate::stages::{WorkMesh, work_mesh};
use quadloom_mesh::metric::{angle_defects, corner_angles, edge_lengths};
use quadloom_mesh::{DVec3, Progress, TriMesh, VertexMap};
use std::f64::consts::FRAC_PI_2;

/// Quarter turns of curvature that are mere noise, per quad, from which a surface is smoothed.
///
/// A singularity needs about four quads around it, so more than a quarter leaves no room, and half of that makes the
/// field's search long. Scans have 0.01 to 0.08 where their triangles are no larger than half a quad.
const MOST_NOISE: f64 = 0.1;

/// Smoothing steps between two looks at the noise.
const STEPS: usize = 20;

/// Looks at the noise; what is left after eighty steps is larger than a few triangles and no noise.
const ROUNDS: usize = 4;

/// Faces whose vertices are smoothed by one step in a unit of effort.
const STEPPED_FACES: usize = 5;

/// Inward and outward step of Taubin's filter, parts of the way to the neighbours' mean: the pass band ends at
/// 1/λ + 1/μ = 0.1, waves of about fourteen edges.
const KEEPING: [f64; 2] = [0.5, -0.526];

/// Plain averaging: also shrinks, within [`STEPS`] by what a blur over two edges does. For meshes that are too fine,
/// where that is less than the wanted edge and [`KEEPING`] would keep noise that is coarser than its triangles.
const SHRINKING: [f64; 1] = [0.5];

/// Triangles, relative to equilateral ones of the wanted edge length, beyond which a smoothed mesh is made anew: noise
/// keeps the remesher from coarsening, and smoothing acts at the scale of the triangles.
const TOO_FINE: f64 = 1.4;

/// Smooths a work mesh until its noise leaves room for the singularities of the shape.
///
/// # Input      quads: number of quads that the mesh is for; edge: edge length that the work mesh was asked for, file units
/// # Output     whether anything was moved
/// # Errors     cancellation
/// # Cost       linear per step, and some remeshings; nothing but one look at the noise where there is none
pub fn calm(
    work: &mut WorkMesh,
    quads: f64,
    edge: f64,
    options: &RemeshOptions,
    progress: &Progress,
) -> Result<bool, RemeshError> {
    let mut moved = false;
    for _ in 0..ROUNDS {
        let fixed = work.features.feature_vertices(&work.mesh);
        if noise(&work.mesh, &fixed) <= MOST_NOISE * quads {
            break;
        }
        // 1. Smoother.
        let wanted = work.mesh.area() / (edge * edge * 3.0_f64.sqrt() / 4.0);
        let too_fine = work.mesh.face_count() as f64 > TOO_FINE * wanted;
        let filter: &[f64] = if too_fine { &SHRINKING } else { &KEEPING };
        let Ok(smooth) = work.mesh.with_positions(smoothed(&work.mesh, &fixed, filter)) else { break };
        work.mesh = smooth;
        moved = true;
        progress.spend(STEPS * filter.len() * work.mesh.face_count() / STEPPED_FACES);
        // 2. Coarser, now that it can be.
        if too_fine {
            *work = work_mesh(&work.mesh, &work.features, edge, options, progress)?;
        }
    }
    Ok(moved)
}

/// Curvature that cancels out within a vertex and its neighbours, quarter turns.
pub fn noise(mesh: &TriMesh, fixed: &VertexMap<bool>) -> f64 {
    let defect = angle_defects(mesh, &corner_angles(mesh, &edge_lengths(mesh)));
    let free = |v| !fixed[v] && !mesh.is_boundary_vertex(v);
    let excess = mesh.vertices().filter(|&v| free(v)).map(|v| {
        let (mut sum, mut count) = (defect[v], 1.0);
        for w in mesh.neighbours(v).filter(|&w| free(w)) {
            sum += defect[w];
            count += 1.0;
        }
        (defect[v].abs() - (sum / count).abs()).max(0.0)
    });
    excess.sum::<f64>() / FRAC_PI_2
}

/// Positions after some steps of a filter; fixed vertices and the boundary stay.
fn smoothed(mesh: &TriMesh, fixed: &VertexMap<bool>, filter: &[f64]) -> VertexMap<DVec3> {
    let mut position = mesh.positions().clone();
    for _ in 0..STEPS {
        for part in filter {
            let old = position.clone();
            for v in mesh.vertices().filter(|&v| !fixed[v] && !mesh.is_boundary_vertex(v)) {
                let (mut sum, mut count) = (DVec3::ZERO, 0.0);
                for w in mesh.neighbours(v) {
                    sum += old[w];
                    count += 1.0;
                }
                position[v] = old[v] + part * (sum / count - old[v]);
            }
        }
    }
    position
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadloom_mesh::shapes::{sample, with_noise};
    use quadloom_mesh::{FeatureGraph, Summary};

    /// A work mesh for 1,000 quads, what calming made of it, and whether that is something else.
    fn calmed(mesh: &TriMesh) -> (WorkMesh, WorkMesh, bool) {
        let (features, options, progress) = (FeatureGraph::none(mesh), RemeshOptions::default(), Progress::none());
        let edge = (mesh.area() / 4000.0).sqrt();
        let work = work_mesh(mesh, &features, edge, &options, &progress).expect("a work mesh");
        let mut calmer = work.clone();
        let moved = calm(&mut calmer, 1000.0, edge, &options, &progress).expect("not cancelled");
        (work, calmer, moved)
    }

    fn noise_of(mesh: &TriMesh) -> f64 {
        noise(mesh, &VertexMap::filled(mesh.vertex_count(), false))
    }

    #[test]
    fn clean_shapes_are_left_alone() {
        for name in ["sphere", "torus", "genus3"] {
            let mesh = sample(name).expect("a shape");
            let (before, after, moved) = calmed(&mesh);
            assert!(!moved && before.mesh.positions() == after.mesh.positions(), "{name}");
        }
    }

    #[test]
    fn noise_goes_and_the_shape_stays() {
        let clean = sample("torus").expect("a shape");
        let rough = with_noise(&clean, 0.01, 3);
        let (before, after, moved) = calmed(&rough);
        assert!(moved && noise_of(&before.mesh) > 300.0, "{}", noise_of(&before.mesh));
        assert!(noise_of(&after.mesh) <= 100.0, "{}", noise_of(&after.mesh));
        assert!((after.mesh.diagonal() - clean.diagonal()).abs() < 0.03 * clean.diagonal());
        assert!(Summary::of(&after.mesh).same_topology(&Summary::of(&clean)));
    }
}
