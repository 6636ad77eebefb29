//! Moves of single singularities, each with the smoothest field that has it.
//!
//! In: a field and its constraints. Out: fields in which one singularity stands at a neighbouring vertex.
//! Holds: all other indices stay, hence their sum; hard directions and prescribed index sums are kept; angles are exact
//! minimisers. Not: that the energy falls, which is for the caller to judge.
//! Source: [Bommes2012] §8.2, local search singularity optimization: a move changes one period jump, hence only the
//! right-hand side of a system that is factorised once.

use crate::constraints::FieldConstraints;
use crate::cross_field::CrossField;
use crate::error::FieldError;
use crate::search::index_groups;
use crate::solve::turn_soft_directions;
use crate::system::{Roots, SmoothnessSystem};
use crate::transport::Transport;
use quadloom_mesh::{TriConnectivity, VertexId, VertexMap};

/// Moves on one mesh under fixed constraints.
pub struct FieldMoves<'a> {
    mesh: &'a TriConnectivity,
    transport: &'a Transport,
    system: SmoothnessSystem<'a>,
    /// Vertices of equal group may exchange index.
    group: VertexMap<u32>,
}

impl<'a> FieldMoves<'a> {
    /// Factorises the system.
    ///
    /// # Input      field: where components without a direction, and soft directions, take their branch from
    /// # Errors     constraints that do not fit the mesh
    /// # Cost       one sparse factorisation
    pub fn new(
        mesh: &'a TriConnectivity,
        transport: &'a Transport,
        constraints: &FieldConstraints,
        field: &CrossField,
    ) -> Result<Self, FieldError> {
        constraints.validate(mesh)?;
        let mut roots = Roots::new(mesh, constraints);
        for &f in &roots.anchors {
            roots.fixed[f] = Some(field.angle[f]);
        }
        turn_soft_directions(&mut roots, &field.angle);
        let group = index_groups(mesh, constraints.index_sums());
        Ok(Self { mesh, transport, system: SmoothnessSystem::new(mesh, transport, roots)?, group })
    }

    /// The smoothest field in which all index of one vertex is at a regular neighbour; `None` where they are no interior
    /// neighbours, the other one is singular, or constraints are in the way.
    ///
    /// # Cost       one back-solve
    pub fn moved(&self, field: &CrossField, from: VertexId, to: VertexId) -> Option<CrossField> {
        let mesh = self.mesh;
        // 1. The edge that index flows along.
        let e = mesh.find_edge(from, to)?;
        let (i, j) = mesh.edge_faces(e);
        let is_free = self.system.is_free(i) || self.system.is_free(j?);
        let is_interior = !mesh.is_boundary_vertex(from) && !mesh.is_boundary_vertex(to);
        let index = |v| field.index(mesh, self.transport, v);
        if !is_free || !is_interior || self.group[from] != self.group[to] || index(from) == 0 || index(to) != 0 {
            return None;
        }
        // 2. Index leaves the origin of the canonical half-edge when its jump falls.
        let mut period_jump = field.period_jump.clone();
        period_jump[e] += if mesh.ends(e)[0] == from { -index(from) } else { index(from) };
        // 3. The angles follow.
        Some(CrossField { angle: self.system.angles(&period_jump), period_jump })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::{FieldOptions, solve_cross_field};
    use quadloom_mesh::{Progress, metric, shapes};

    #[test]
    fn a_move_changes_two_indices_and_nothing_else() {
        let mesh = shapes::smooth_genus(1, 2);
        let (length, transport) = (metric::edge_lengths(&mesh), Transport::of(&mesh));
        let mut constraints = FieldConstraints::none(&mesh);
        constraints.indices = vec![(VertexId(0), 1), (VertexId(7), -1)];
        let options = FieldOptions::default();
        let solved = solve_cross_field(&mesh, &transport, &length, &constraints, &options, &Progress::none());
        let field = solved.expect("a field").0;
        let free = FieldConstraints::none(&mesh);
        let moves = FieldMoves::new(&mesh, &transport, &free, &field).expect("no constraint");
        let mut made = 0;
        for (v, index) in field.singularities(&mesh, &transport) {
            for w in mesh.neighbours(v) {
                let Some(moved) = moves.moved(&field, v, w) else { continue };
                assert!(moved.check(&mesh, &transport).is_empty());
                for x in mesh.vertices() {
                    let before = field.index(&mesh, &transport, x);
                    let by = if x == v { -index } else { i32::from(x == w) * index };
                    assert_eq!(moved.index(&mesh, &transport, x), before + by);
                }
                // And back, to the same energy.
                let back = moves.moved(&moved, w, v).expect("the way back");
                let (e, f) = (back.energy(&mesh, &transport), field.energy(&mesh, &transport));
                assert!((e - f).abs() < 1e-6 * f, "{e} {f}");
                made += 1;
            }
        }
        assert!(made > 0);
        // Prescribed vertices stay where they are.
        let kept = FieldMoves::new(&mesh, &transport, &constraints, &field).expect("constraints that fit");
        assert!(mesh.neighbours(VertexId(0)).all(|w| kept.moved(&field, VertexId(0), w).is_none()));
    }
}
