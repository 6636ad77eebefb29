//! Fields on refined meshes.
//!
//! In: a cross field and a refinement of its mesh. Out: the same field on the finer mesh.
//! Holds: directions are the same vectors, old vertices keep their indices, new vertices are regular.

use crate::cross_field::{CrossField, nearest_jump};
use crate::transport::Transport;
use quadloom_mesh::{EdgeMap, FaceMap, Refined, TriMesh};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

impl CrossField {
    /// The same field on a refinement of its mesh.
    ///
    /// # Input      mesh: the one that was refined
    /// # Output     angles by the frames' turns; across pieces of an old edge the field turns as it did across the edge,
    /// across new edges it does not turn
    /// # Cost       linear
    pub fn carried_to(&self, refined: &Refined, mesh: &TriMesh) -> Self {
        let fine = &refined.mesh;
        let (old, new) = (Transport::of(mesh), Transport::of(fine));
        let angle = FaceMap::from_fn(fine.face_count(), |f| self.angle[refined.parent_face[f]] - refined.frame_turn[f]);
        let period_jump = EdgeMap::from_fn(fine.edge_count(), |e| {
            let h = fine.half_edge(e);
            let Some(twin) = fine.twin(h) else { return 0 };
            let Some((parent, across)) = refined.parent_half_edge[h].and_then(|p| Some((p, mesh.twin(p)?))) else {
                return nearest_jump(fine, &new, &angle, e);
            };
            // The field's turn across the edge does not depend on frames.
            let faces = [mesh.face(parent), mesh.face(across)].map(|f| self.angle[f]);
            let jump = FRAC_PI_2 * f64::from(self.jump(mesh, parent));
            let turn = faces[1] - faces[0] - old.kappa(mesh, parent) - jump;
            let between = angle[fine.face(twin)] - angle[fine.face(h)] - new.kappa(fine, h);
            ((between - turn) * FRAC_2_PI).round() as i32
        });
        Self { angle, period_jump }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FieldConstraints, FieldOptions, solve_cross_field};
    use quadloom_mesh::{FeatureGraph, Progress, metric, refine, shapes};

    #[test]
    fn a_refined_field_has_the_old_singularities_and_turns() {
        let mesh = shapes::smooth_genus(2, 2);
        let length = metric::edge_lengths(&mesh);
        let transport = Transport::new(&mesh, &length);
        let (constraints, options) = (FieldConstraints::none(&mesh), FieldOptions::default());
        let (field, _) = solve_cross_field(&mesh, &transport, &length, &constraints, &options, &Progress::none())
            .expect("a closed surface has a field");
        let split: Vec<_> = mesh.edges().filter(|e| e.0 % 3 != 1).map(|e| (e, 0.4)).collect();
        let refined = refine::split_edges(&mesh, &FeatureGraph::none(&mesh), &split).expect("few elements");
        let carried = field.carried_to(&refined, &mesh);
        let fine = Transport::of(&refined.mesh);
        assert_eq!(carried.check(&refined.mesh, &fine), []);
        assert_eq!(carried.singularities(&refined.mesh, &fine), field.singularities(&mesh, &transport));
    }
}
