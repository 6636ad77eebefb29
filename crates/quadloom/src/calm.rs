//! Noise on a work mesh is smoothed away before a field is solved on it.
//!
//! In: a [`WorkMesh`] and the number of quads it is for. Out: the same connectivity and curves, with free vertices
//! moved where the surface was rough. Holds: a surface whose curvature has room in its quads is not touched.
//! Not: that the vertices still lie on the input; finishing lays the quads onto it.
//! Source: [Taubin1995] (smoothing that does not shrink). A cross field turns with the curvature it is carried over, so
//! noise makes singularities of random sign at almost every vertex ([Bommes2012] Figure 8.9 has the same remedy in the
//! choice of directions; smoothing helps the map as well).

use crate::stages::WorkMesh;
use quadloom_mesh::metric::{angle_defects, corner_angles, edge_lengths};
use quadloom_mesh::{DVec3, TriMesh, VertexMap};
use std::f64::consts::FRAC_PI_2;

/// Quarter turns of curvature that are mere noise, per quad, from which a surface is smoothed.
///
/// A singularity needs about four quads around it, so more than a quarter leaves no room. Scans at their own
/// resolution have less than a tenth.
const MOST_NOISE: f64 = 0.2;

/// Smoothing steps between two looks at the noise.
const STEPS: usize = 4;

/// Looks at the noise; what is left after 80 steps is larger than a few triangles and no noise.
const ROUNDS: usize = 20;

/// Inward and outward step of Taubin's filter, parts of the way to the neighbours' mean: the pass band ends at
/// 1/λ + 1/μ = 0.1, waves of about twenty edges.
const FILTER: [f64; 2] = [0.5, -0.526];

/// Smooths a work mesh until its noise leaves room for the singularities of the shape.
///
/// # Input      quads: number of quads that the mesh is for
/// # Output     whether anything was moved
/// # Cost       linear per step; nothing but one look at the noise where there is none
pub fn calm(work: &mut WorkMesh, quads: f64) -> bool {
    let fixed = work.features.feature_vertices(&work.mesh);
    let mut moved = false;
    for _ in 0..ROUNDS {
        if noise(&work.mesh, &fixed) <= MOST_NOISE * quads {
            break;
        }
        let Ok(mesh) = work.mesh.with_positions(smoothed(&work.mesh, &fixed)) else { break };
        work.mesh = mesh;
        moved = true;
    }
    moved
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

/// Positions after a few steps of Taubin's filter; fixed vertices and the boundary stay.
fn smoothed(mesh: &TriMesh, fixed: &VertexMap<bool>) -> VertexMap<DVec3> {
    let mut position = mesh.positions().clone();
    for _ in 0..STEPS {
        for part in FILTER {
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
    use crate::options::RemeshOptions;
    use crate::stages::work_mesh;
    use quadloom_mesh::shapes::{sample, with_noise};
    use quadloom_mesh::{FeatureGraph, Progress};

    fn work(mesh: &TriMesh) -> WorkMesh {
        let features = FeatureGraph::none(mesh);
        let edge = (mesh.area() / 4000.0).sqrt();
        work_mesh(mesh, &features, edge, &RemeshOptions::default(), &Progress::none()).expect("a work mesh")
    }

    #[test]
    fn clean_shapes_are_left_alone() {
        for name in ["sphere", "torus", "genus3"] {
            let mesh = sample(name).expect("a shape");
            assert!(!calm(&mut work(&mesh), 1000.0), "{name}");
        }
    }

    #[test]
    fn noise_goes_and_the_shape_stays() {
        let clean = sample("torus").expect("a shape");
        let mut rough = work(&with_noise(&clean, 0.01, 3));
        let fixed = VertexMap::filled(rough.mesh.vertex_count(), false);
        assert!(noise(&rough.mesh, &fixed) > 300.0);
        let diagonal = rough.mesh.diagonal();
        assert!(calm(&mut rough, 1000.0));
        assert!(noise(&rough.mesh, &fixed) <= 200.0);
        assert!((rough.mesh.diagonal() - diagonal).abs() < 0.03 * diagonal);
    }
}
