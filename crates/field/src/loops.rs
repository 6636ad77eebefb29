//! Loops around handles and around curves of fixed directions, as changes of period jumps.
//!
//! In: connectivity, edge lengths, fixed faces. Out: closed chains of edges: a generator of the surface's homology each,
//! or one side of a curve.
//! Holds: changing the jumps along a loop leaves every index alone; handle loops of a surface without handles are not
//! listed.
//! Source: tree-cotree decomposition [Eppstein2003]; loops around curves: own.

use quadloom_mesh::topology::{Summary, components};
use quadloom_mesh::{EdgeId, EdgeMap, FaceId, TriConnectivity, VertexId, VertexMap};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use crate::search::Key;
use crate::system::interior_edges;

/// Generators of the homology (with loops around holes where there are handles too), each with the changes of jumps
/// that carry a quarter of index once around it.
///
/// 1. A shortest-path tree of vertices over interior edges, per component.
/// 2. A dual spanning tree of faces over the other edges, long ones first.
/// 3. Each edge in neither closes a loop through the tree.
///
/// # Cost       O(E log E), plus the length of the loops
pub(crate) fn homology_loops(mesh: &TriConnectivity, length: &EdgeMap<f64>) -> Vec<Vec<(EdgeId, i32)>> {
    if Summary::of(mesh).genus == 0 {
        return Vec::new();
    }
    let via = shortest_path_forest(mesh, length);
    let mut in_tree = EdgeMap::filled(mesh.edge_count(), false);
    via.values().iter().flatten().for_each(|&e| in_tree[e] = true);
    let mut order: Vec<EdgeId> = mesh.edges().filter(|&e| !in_tree[e] && !mesh.is_boundary_edge(e)).collect();
    order.sort_by(|a, b| length[*b].total_cmp(&length[*a]).then(a.cmp(b)));
    let mut sets = DisjointSets((0..mesh.face_count() as u32).collect());
    let mut closing: Vec<EdgeId> = order
        .into_iter()
        .filter(|&e| {
            let (i, j) = mesh.edge_faces(e);
            j.is_some_and(|j| !sets.join(i.0, j.0))
        })
        .collect();
    closing.sort_unstable();
    closing.into_iter().map(|e| closed_loop(mesh, &via, e)).collect()
}

/// The loops that run beside the curves of fixed faces, each with the changes of jumps that turn the curve by a quarter
/// against what lies on the other side.
///
/// Between two curves that close around a tube the field may make any number of quarter turns, at hardly any energy if
/// the tube is long; a map has only fields without.
///
/// 1. The faces that touch a fixed one.
/// 2. Their outline, piece by piece. Pieces around faces that are all free change nothing and are listed, too.
///
/// # Cost       near linear
pub(crate) fn curve_loops(mesh: &TriConnectivity, is_fixed: impl Fn(FaceId) -> bool) -> Vec<Vec<(EdgeId, i32)>> {
    // 1. The faces along the curves.
    let mut is_on_curve = VertexMap::filled(mesh.vertex_count(), false);
    for f in mesh.faces().filter(|&f| is_fixed(f)) {
        mesh.face_vertices(f).into_iter().for_each(|v| is_on_curve[v] = true);
    }
    let touches = |f: FaceId| mesh.face_vertices(f).into_iter().any(|v| is_on_curve[v]);
    // 2. The edges to others. Index leaves the origin of a canonical half-edge when its jump falls.
    let side = |(i, j, e): (FaceId, FaceId, EdgeId)| match (touches(i), touches(j)) {
        (true, false) => Some((e, -1)),
        (false, true) => Some((e, 1)),
        _ => None,
    };
    let outline: Vec<(EdgeId, i32)> = interior_edges(mesh).filter_map(side).collect();
    let mut pieces = DisjointSets((0..mesh.vertex_count() as u32).collect());
    for &(e, _) in &outline {
        let [a, b] = mesh.ends(e);
        pieces.join(a.0, b.0);
    }
    let mut loops: BTreeMap<u32, Vec<(EdgeId, i32)>> = BTreeMap::new();
    for (e, amount) in outline {
        loops.entry(pieces.root(mesh.ends(e)[0].0)).or_default().push((e, amount));
    }
    loops.into_values().collect()
}

/// The edge over which each vertex is reached from its component's first one; `None` for the first.
fn shortest_path_forest(mesh: &TriConnectivity, length: &EdgeMap<f64>) -> VertexMap<Option<EdgeId>> {
    let mut distance = VertexMap::filled(mesh.vertex_count(), f64::INFINITY);
    let mut via = VertexMap::filled(mesh.vertex_count(), None);
    let parts = components(mesh);
    let mut rooted = vec![false; parts.count];
    let mut heap = BinaryHeap::new();
    for v in mesh.vertices() {
        if !std::mem::replace(&mut rooted[parts.of_vertex(mesh, v) as usize], true) {
            distance[v] = 0.0;
            heap.push(Reverse((Key(0.0), v.0)));
        }
    }
    while let Some(Reverse((Key(d), v))) = heap.pop() {
        let v = VertexId(v);
        if d > distance[v] {
            continue;
        }
        for e in mesh.vertex_edges(v).filter(|&e| !mesh.is_boundary_edge(e)) {
            let [a, b] = mesh.ends(e);
            let (w, next) = (if a == v { b } else { a }, d + length[e]);
            if next < distance[w] {
                distance[w] = next;
                via[w] = Some(e);
                heap.push(Reverse((Key(next), w.0)));
            }
        }
    }
    via
}

/// The loop that `closing` closes with the tree: down to its target and back to its origin, common part removed.
fn closed_loop(mesh: &TriConnectivity, via: &VertexMap<Option<EdgeId>>, closing: EdgeId) -> Vec<(EdgeId, i32)> {
    let [origin, target] = mesh.ends(closing);
    // Index leaves the origin of a canonical half-edge when its jump falls.
    let mut changes = BTreeMap::from([(closing, -1)]);
    for (start, sign) in [(target, 1), (origin, -1)] {
        let mut at = start;
        while let Some(e) = via[at] {
            let [a, b] = mesh.ends(e);
            *changes.entry(e).or_insert(0) += if at == a { -sign } else { sign };
            at = if at == a { b } else { a };
        }
    }
    changes.into_iter().filter(|&(_, amount)| amount != 0).collect()
}

struct DisjointSets(Vec<u32>);

impl DisjointSets {
    fn root(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            self.0[k as usize] = self.0[self.0[k as usize] as usize];
            k = self.0[k as usize];
        }
        k
    }

    /// Joins two sets; false if they were one already.
    fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::FieldConstraints;
    use crate::solve::{FieldOptions, solve_cross_field};
    use crate::transport::Transport;
    use quadloom_mesh::features::FeatureOptions;
    use quadloom_mesh::metric::edge_lengths;
    use quadloom_mesh::{FeatureGraph, Progress, TriMesh, shapes};

    /// Whether there are changes, and as much index comes to every vertex as leaves it.
    fn leaves_indices_alone(mesh: &TriMesh, changes: &[(EdgeId, i32)]) -> bool {
        let mut index = VertexMap::filled(mesh.vertex_count(), 0);
        for &(e, amount) in changes {
            let [a, b] = mesh.ends(e);
            index[a] += amount;
            index[b] -= amount;
        }
        !changes.is_empty() && index.values().iter().all(|&q| q == 0)
    }

    #[test]
    fn loops_are_closed_and_two_per_handle() {
        for (mesh, expected) in [
            (shapes::torus(1.0, 0.3, 20, 9), 2),
            (shapes::smooth_genus(3, 1), 6),
            (shapes::join(&[shapes::torus(1.0, 0.3, 12, 7), shapes::sphere(1.0, 1)]), 2),
            (shapes::sphere(1.0, 2), 0),
        ] {
            let loops = homology_loops(&mesh, &edge_lengths(&mesh));
            assert_eq!(loops.len(), expected);
            assert!(loops.iter().all(|changes| leaves_indices_alone(&mesh, changes)));
        }
    }

    /// A long tube, and directions along both of its rims.
    fn tube() -> (TriMesh, FieldConstraints) {
        let mesh = shapes::cylinder(0.25, 24.0, 9, 160);
        let features =
            FeatureGraph::detect(&mesh, &FeatureOptions { sharp_angle: None, ..FeatureOptions::default() }).0;
        let (length, transport) = (edge_lengths(&mesh), Transport::of(&mesh));
        let constraints = FieldConstraints::from_features(&mesh, &transport, &length, &features).0;
        (mesh, constraints)
    }

    #[test]
    fn loops_beside_curves_leave_all_indices_alone() {
        let (mesh, constraints) = tube();
        assert_eq!(Summary::of(&*mesh).boundary_loops, 2);
        let loops = curve_loops(&mesh, |f| constraints.angle[f].is_some());
        assert_eq!(loops.len(), 2);
        assert!(loops.iter().all(|changes| leaves_indices_alone(&mesh, changes)));
    }

    #[test]
    fn a_field_that_spirals_along_a_tube_is_untwisted() {
        let (mesh, constraints) = tube();
        let (length, transport) = (edge_lengths(&mesh), Transport::of(&mesh));
        let solve = |options: &FieldOptions| {
            solve_cross_field(&mesh, &transport, &length, &constraints, options, &Progress::none()).expect("a field")
        };
        let (straight, report) = solve(&FieldOptions::default());
        assert_eq!(report.singularities, 0);
        // Two quarter turns along the tube: hardly any energy more, and no map at all.
        let mut jumps = straight.period_jump.clone();
        for &(e, amount) in &curve_loops(&mesh, |f| constraints.angle[f].is_some())[0] {
            jumps[e] += 2 * amount;
        }
        let twisted = FieldOptions { start_from: Some(jumps), ..FieldOptions::default() };
        let (field, report) = solve(&twisted);
        assert!(report.start_energy > report.energy && report.twists == 2, "{report:?}");
        assert!((field.energy(&mesh, &transport) - straight.energy(&mesh, &transport)).abs() < 1e-9);
    }
}
