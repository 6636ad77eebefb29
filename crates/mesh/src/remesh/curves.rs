//! The input's curves (feature chains, and boundaries that are no feature) by arc length.
//!
//! In: a mesh and its features. Out: [`Curves`], the curves and which vertices may slide along them.
//! Holds: the first curves are the chains of the feature graph, in their order and direction.

use super::work::Role;
use crate::features::{FeatureChain, FeatureGraph, FeatureKind, FeatureOptions};
use crate::ids::{EdgeMap, VertexMap};
use crate::mesh::TriMesh;
use glam::DVec3;

/// A polyline of input edges.
pub(super) struct Curve {
    /// Its points; a closed curve repeats the first one at the end.
    pub points: Vec<DVec3>,
    /// Arc length at every point, from 0.
    pub arc: Vec<f64>,
    /// Input half-edge between every two points, on either side.
    pub half_edge: Vec<u32>,
    /// Whether it has neither start nor end.
    pub closed: bool,
    /// Number of edges it has now.
    pub edges: u32,
    /// Number of edges below which it must not fall.
    pub min_edges: u32,
}

/// All curves of an input mesh.
pub(super) struct Curves {
    /// The chains of the feature graph, then the boundaries that no chain covers.
    pub curves: Vec<Curve>,
    /// Vertex lists of the curves.
    pub chains: Vec<FeatureChain>,
    /// Whether an edge lies on a curve.
    pub is_curve: EdgeMap<bool>,
    /// What may be done with each vertex.
    pub role: VertexMap<Role>,
}

/// Edges that a closed curve keeps: three would do for the topology, a fourth keeps it from being flat.
const MIN_CLOSED_EDGES: u32 = 4;

impl Curves {
    /// Collects chains and uncovered boundaries. A chain that names an edge the mesh does not have is left out.
    pub fn new(mesh: &TriMesh, features: &FeatureGraph) -> Self {
        // 1. Chains of the feature graph, then of the rest of the boundary.
        let mut chains = features.chains.clone();
        for chain in &mut chains {
            if !steps(chain).all(|[a, b]| mesh.find_edge(a, b).is_some()) {
                chain.vertices.clear();
            }
        }
        let mut is_curve = EdgeMap::filled(mesh.edge_count(), false);
        let mark = |chains: &[FeatureChain], is_curve: &mut EdgeMap<bool>| {
            for e in chains.iter().flat_map(steps).filter_map(|[a, b]| mesh.find_edge(a, b)) {
                is_curve[e] = true;
            }
        };
        mark(&chains, &mut is_curve);
        let uncovered = EdgeMap::from_fn(mesh.edge_count(), |e| {
            (mesh.is_boundary_edge(e) && !is_curve[e]).then_some(FeatureKind::Boundary)
        });
        let (boundary, _) = FeatureGraph::from_kinds(mesh, uncovered, &FeatureOptions::default());
        mark(&boundary.chains, &mut is_curve);
        chains.extend(boundary.chains);
        // 2. Roles.
        let role = roles(mesh, &chains, features, &boundary.is_corner);
        let curves = chains.iter().map(|chain| Curve::new(mesh, chain)).collect();
        Self { curves, chains, is_curve, role }
    }
}

/// Pairs of neighbouring vertices of a chain, in its direction.
pub(super) fn steps(chain: &FeatureChain) -> impl Iterator<Item = [crate::ids::VertexId; 2]> + '_ {
    let n = chain.vertices.len();
    let count = if chain.closed { n } else { n.saturating_sub(1) };
    (0..count).map(move |i| [chain.vertices[i], chain.vertices[(i + 1) % n]])
}

fn roles(
    mesh: &TriMesh,
    chains: &[FeatureChain],
    features: &FeatureGraph,
    boundary_corner: &VertexMap<bool>,
) -> VertexMap<Role> {
    let mut role = VertexMap::filled(mesh.vertex_count(), Role::Free);
    for chain in chains {
        for (i, &v) in chain.vertices.iter().enumerate() {
            let inner = chain.closed || (i > 0 && i + 1 < chain.vertices.len());
            // A vertex of two curves, or an end of one, slides along neither.
            role[v] = if inner && role[v] == Role::Free { Role::OnCurve } else { Role::Pinned };
        }
    }
    for v in mesh.vertices().filter(|&v| features.is_corner[v] || boundary_corner[v]) {
        role[v] = Role::Pinned;
    }
    role
}

impl Curve {
    fn new(mesh: &TriMesh, chain: &FeatureChain) -> Self {
        let mut points: Vec<DVec3> = chain.vertices.iter().map(|&v| mesh.position(v)).collect();
        if chain.closed {
            points.extend(points.first().copied());
        }
        let mut arc = vec![0.0];
        for pair in points.windows(2) {
            arc.push(arc[arc.len() - 1] + pair[0].distance(pair[1]));
        }
        let side = |[a, b]: [_; 2]| mesh.find_edge(a, b).map(|e| mesh.half_edge(e).0);
        let half_edge: Vec<u32> = steps(chain).filter_map(side).collect();
        let edges = half_edge.len() as u32;
        let min_edges = if chain.closed { MIN_CLOSED_EDGES.min(edges) } else { 1 };
        Self { points, arc, half_edge, closed: chain.closed, edges, min_edges }
    }

    /// Total length, file units.
    pub fn length(&self) -> f64 {
        self.arc[self.arc.len() - 1]
    }

    /// An arc length on a closed curve, brought back to 0..length.
    fn wrap(&self, t: f64) -> f64 {
        match (self.closed, self.length()) {
            (true, length) if t >= length => t - length,
            (true, length) if t < 0.0 => t + length,
            _ => t,
        }
    }

    /// The polyline piece at arc length `t` and the fraction along it.
    pub fn locate(&self, t: f64) -> (usize, f64) {
        let t = self.wrap(t);
        let i = self.arc.partition_point(|&s| s <= t).clamp(1, self.half_edge.len()) - 1;
        let piece = self.arc[i + 1] - self.arc[i];
        (i, if piece > 0.0 { ((t - self.arc[i]) / piece).clamp(0.0, 1.0) } else { 0.0 })
    }

    /// The point at arc length `t`, and the input half-edge beside it.
    pub fn point(&self, t: f64) -> (DVec3, u32) {
        let (i, fraction) = self.locate(t);
        (self.points[i].lerp(self.points[i + 1], fraction), self.half_edge[i])
    }

    /// Largest distance of the curve between two arc lengths from the chord between them.
    ///
    /// # Cost       linear in the polyline's points between them
    pub fn chord_deviation(&self, from: f64, to: f64) -> f64 {
        let (a, b) = (self.point(from).0, self.point(to).0);
        let (chord, n) = (b - a, self.half_edge.len());
        let inverse = 1.0 / chord.length_squared().max(f64::MIN_POSITIVE);
        let mut i = self.arc.partition_point(|&s| s <= from);
        let (mut turn, mut worst) = (0.0, 0.0f64);
        loop {
            if i > n {
                if !self.closed || turn > 0.0 {
                    break;
                }
                (i, turn) = (1, self.length());
            }
            if self.arc[i] + turn >= to {
                break;
            }
            let p = self.points[i] - a;
            worst = worst.max(p.distance_squared(chord * (p.dot(chord) * inverse).clamp(0.0, 1.0)));
            i += 1;
        }
        worst.sqrt()
    }
}
