//! The remesher's result: a checked mesh, its feature graph, where its vertices lie on the input, a report.
//!
//! In: the remesher's final state. Out: [`Remeshed`]. Holds: chains keep their numbers, order and direction.

use super::work::{NONE, Role, Segment};
use super::{RemeshReport, Remeshed, Remesher};
use crate::features::{ChainId, FeatureChain, FeatureGraph};
use crate::ids::{EdgeMap, HalfEdgeId, VertexId, VertexMap};
use crate::mesh::{MeshError, TriMesh};
use crate::metric::{corner_angles, edge_lengths};
use crate::surface_point::SurfacePoint;

impl Remesher<'_> {
    /// Builds the result from the compacted work mesh.
    pub(super) fn finish(mut self, features: &FeatureGraph) -> Result<Remeshed, MeshError> {
        self.work.compact();
        let positions = self.work.vertices.iter().map(|v| v.position).collect();
        let faces: Vec<[u32; 3]> = self.work.origin.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
        let mesh = TriMesh::new(positions, &faces)?;
        let origin = VertexMap::from_fn(mesh.vertex_count(), |v| self.surface_point(v.0));
        let kept = VertexMap::from_fn(mesh.vertex_count(), |v| self.work.vertices[v.index()].kept);
        let features = self.feature_graph(&mesh, features);
        let report = self.report(&mesh);
        Ok(Remeshed { mesh, features, origin, kept, report })
    }

    /// Where a vertex lies on the input.
    fn surface_point(&self, v: u32) -> SurfacePoint {
        let vertex = &self.work.vertices[v as usize];
        let face = match vertex.role {
            Role::Pinned => {
                let out = self.surface.mesh.outgoing_half_edge(VertexId(vertex.source));
                self.surface.mesh.face(out).0
            }
            Role::OnCurve => self.surface.mesh.face(HalfEdgeId(vertex.source)).0,
            Role::Free => vertex.hint,
        };
        let foot = self.surface.foot_on_face(vertex.position, face);
        SurfacePoint { face: crate::ids::FaceId(foot.face), weights: foot.weights }
    }

    fn feature_graph(&self, mesh: &TriMesh, input: &FeatureGraph) -> FeatureGraph {
        // 1. Segments of every curve in the order of arc length.
        let mut pieces: Vec<&Segment> = self.work.segments.iter().collect();
        pieces.sort_by(|x, y| x.curve.cmp(&y.curve).then(x.arc[0].total_cmp(&y.arc[0])));
        // 2. Chains; curves beyond the feature graph are boundaries the caller did not ask for.
        let empty = |chain: &FeatureChain| FeatureChain { vertices: Vec::new(), ..*chain };
        let mut chains: Vec<FeatureChain> = input.chains.iter().map(empty).collect();
        let mut chain_of = EdgeMap::filled(mesh.edge_count(), None);
        for piece in &pieces {
            let Some(chain) = chains.get_mut(piece.curve as usize) else { continue };
            let [a, b] = piece.ends.map(VertexId);
            chain.vertices.push(a);
            if let Some(e) = mesh.find_edge(a, b) {
                chain_of[e] = Some(piece.curve as ChainId);
            }
        }
        for chain in chains.iter_mut().enumerate().filter(|(_, chain)| !chain.closed) {
            let last = pieces.partition_point(|piece| piece.curve as usize <= chain.0);
            if !chain.1.vertices.is_empty() {
                chain.1.vertices.push(VertexId(pieces[last - 1].ends[1]));
            }
        }
        // 3. Corners.
        let is_corner = VertexMap::from_fn(mesh.vertex_count(), |v| {
            let vertex = &self.work.vertices[v.index()];
            vertex.role == Role::Pinned && input.is_corner[VertexId(vertex.source)]
        });
        FeatureGraph { chain_of, chains, is_corner }
    }

    /// Whether an edge is longer than twice its target, and not one that was to stay.
    fn is_long(&self, h: u32) -> bool {
        self.work.ratio(h) > 1.5 * super::collapse::LONG && !self.work.stays(h)
    }

    fn report(&self, mesh: &TriMesh) -> RemeshReport {
        let angles = corner_angles(mesh, &edge_lengths(mesh));
        let degrees = || angles.values().iter().map(|angle| angle.to_degrees());
        let regular = mesh.vertices().filter(|&v| mesh.valence(v) == if mesh.is_boundary_vertex(v) { 4 } else { 6 });
        let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
        RemeshReport {
            splits: self.tally.splits,
            collapses: self.tally.collapses,
            flips: self.tally.flips,
            moves: self.tally.moves,
            refused_moves: self.tally.refused_moves,
            off_surface: self.tally.off_surface,
            min_angle: degrees().fold(180.0, f64::min),
            max_angle: degrees().fold(0.0, f64::max),
            good_angles: share(degrees().filter(|a| (30.0..=110.0).contains(a)).count(), angles.len()),
            regular_vertices: share(regular.count(), mesh.vertex_count()),
            long_edges: self.work.edges().filter(|&h| self.is_long(h)).count(),
            reduced_vertices: (0..self.work.vertices.len())
                .filter(|&v| self.work.vertices[v].size < 0.99 * self.base_size(v as u32))
                .count(),
        }
    }
}

/// The input's target length at a vertex, before it was lowered.
impl Remesher<'_> {
    pub(super) fn base_size(&self, v: u32) -> f64 {
        let vertex = &self.work.vertices[v as usize];
        let face = if vertex.hint == NONE { 0 } else { vertex.hint };
        self.size.at_face(self.surface.mesh, crate::ids::FaceId(face))
    }
}
