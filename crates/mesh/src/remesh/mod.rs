//! Isotropic, feature-preserving remeshing: the work mesh on which field and map are solved.
//!
//! In: a triangle mesh of any tessellation, its features, a target edge length. Out: [`Remeshed`]: nearly
//! equilateral triangles of that size on the same surface, with the same chains and corners.
//! Holds: components, Euler characteristic and boundary loops are kept; corners stay, chains keep number, order
//! and direction; no face has two feature edges and no other edge joins two feature vertices; deterministic.
//! Not guaranteed: angles near corners sharper than 60°, the target length where curvature, narrow gaps or topology
//! need shorter edges. Source: Botsch, Kobbelt, A remeshing approach to multiresolution modeling (2004) §4, after a
//! decimation by edge length; limits and the treatment of curves are our own.

mod collapse;
mod curves;
mod finish;
mod flip;
mod guard;
mod relax;
mod sizing;
mod split;
mod surface;
mod work;

#[cfg(test)]
mod tests;

use crate::features::FeatureGraph;
use crate::ids::{FaceId, VertexId, VertexMap};
use crate::mesh::TriMesh;
use crate::progress::{Cancelled, Progress};
use crate::surface_point::SurfacePoint;
use curves::{Curve, Curves};
use flip::Goal;
use glam::DVec3;
use guard::{LIMITS, Limits};
use surface::Surface;
use work::{NONE, Role, Segment, Vertex, Work};

/// Target edge length, file units.
#[derive(Clone, Copy, Debug)]
pub enum TargetLength<'a> {
    /// The same everywhere.
    Uniform(f64),
    /// One length per input vertex; vertices without one stay, and so do all edges and faces between such.
    PerVertex(&'a VertexMap<Option<f64>>),
}

/// How the work mesh is made.
#[derive(Clone, Debug, PartialEq)]
pub struct RemeshOptions {
    /// Rounds of split, collapse, flip, relax. Default 5: fewer leave irregular vertices, more change little.
    pub rounds: usize,
    /// Height of the surface over an edge, relative to the target length, above which edges are made shorter.
    /// Default 0.1: a tube keeps about eight edges around. Larger: fewer triangles on thin parts.
    pub max_deviation_rel: f64,
    /// Distance of an input chain from the new one, relative to the target length. Default 0.04: a circle of four
    /// target lengths radius is still sampled at the target length.
    pub max_chain_deviation_rel: f64,
    /// Least length to which curvature and gaps may lower the target, relative to it. Default 0.3: ten times as many
    /// triangles there.
    pub min_length_rel: f64,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self { rounds: 5, max_deviation_rel: 0.1, max_chain_deviation_rel: 0.04, min_length_rel: 0.3 }
    }
}

/// A remeshed surface and how it lies on the input.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// The new mesh.
    pub mesh: TriMesh,
    /// Its features: chain i is chain i of the input.
    pub features: FeatureGraph,
    /// Where each vertex lies on the input mesh (for the few that would fold a face there: the nearest point seen).
    pub origin: VertexMap<SurfacePoint>,
    /// Whether a vertex is one of the input's that was to stay.
    pub kept: VertexMap<bool>,
    /// What was done and what came out.
    pub report: RemeshReport,
}

/// What remeshing did and what came out; angles in degrees.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RemeshReport {
    /// Number of splits.
    pub splits: usize,
    /// Number of collapses.
    pub collapses: usize,
    /// Number of flips.
    pub flips: usize,
    /// Number of vertices moved, counted once a round.
    pub moves: usize,
    /// Number of moves that would have folded or degenerated a face.
    pub refused_moves: usize,
    /// Vertices that stay off the input's surface, because a face would fold there.
    pub off_surface: usize,
    /// Smallest angle, degrees.
    pub min_angle: f64,
    /// Largest angle, degrees.
    pub max_angle: f64,
    /// Share of angles in 30°..=110°, 0..=1.
    pub good_angles: f64,
    /// Share of vertices with six edges (four on the boundary), 0..=1.
    pub regular_vertices: f64,
    /// Edges that are longer than twice the local target, because splitting them would fold a face.
    pub long_edges: usize,
    /// Vertices at which curvature or a gap lowered the target length.
    pub reduced_vertices: usize,
}

#[derive(Debug, Default)]
struct Tally {
    splits: usize,
    collapses: usize,
    flips: usize,
    moves: usize,
    refused_moves: usize,
    off_surface: usize,
}

/// Everything the passes share.
struct Remesher<'a> {
    work: Work,
    surface: Surface<'a>,
    curves: Vec<Curve>,
    size: TargetLength<'a>,
    options: &'a RemeshOptions,
    limits: Limits,
    progress: &'a Progress,
    ticks: u32,
    tally: Tally,
    scratch: Vec<u32>,
}

/// Remeshes a surface isotropically, keeping topology and features.
///
/// # Input      mesh: any; features: its chains and corners, boundaries are kept whether or not they are features;
/// size: target edge length, positive, file units, or vertices that stay
/// # Output     the new mesh, its features (chain i is chain i of the input, corners are exact), where its vertices lie
/// on the input, a report
/// # Errors     [`Cancelled`]
/// # Cost       near-linear in the larger of input and output; about 10 µs a triangle of either
/// # Guarantees topology, corners, chains; chain vertices lie on the input's chains, other vertices on its surface
/// except where that would fold a face; no face turns by more than 60° from the input; the same result
/// for the same input
/// # Source     Botsch, Kobbelt (2004) §4; differs: decimation first, curves by arc length, sizes lowered where
/// curvature or gaps need it
pub fn isotropic(
    mesh: &TriMesh,
    features: &FeatureGraph,
    size: TargetLength<'_>,
    options: &RemeshOptions,
    progress: &Progress,
) -> Result<Remeshed, Cancelled> {
    let mut remesher = Remesher::new(mesh, features, size, options, progress);
    // 1. Fine input becomes as coarse as the target.
    progress.report("remesh", 0.0);
    remesher.decimate()?;
    remesher.work.compact();
    // 2. Sizes and room between features.
    remesher.adapt_sizes();
    remesher.flip_edges(Goal::Angle)?;
    remesher.separate_features()?;
    remesher.refine_coarse()?;
    // 3.
    for round in 0..options.rounds {
        progress.report("remesh", (round as f64 + 1.0) / (options.rounds as f64 + 1.0));
        remesher.round(round)?;
    }
    remesher.separate_features()?;
    remesher.settle();
    progress.spend(EFFORT * remesher.ticks as usize);
    let unchanged = || Remeshed::unchanged(mesh, features, size);
    Ok(remesher.finish(features).unwrap_or_else(|_| unchanged()))
}

/// Effort of looking at an edge or a vertex.
const EFFORT: usize = 3;

impl Remeshed {
    /// The input as its own result, with an empty report.
    fn unchanged(mesh: &TriMesh, features: &FeatureGraph, size: TargetLength) -> Self {
        let origin = VertexMap::from_fn(mesh.vertex_count(), |v| {
            let h = mesh.outgoing_half_edge(v);
            let corner = h.index() - mesh.first_half_edge(mesh.face(h)).index();
            SurfacePoint { face: mesh.face(h), weights: std::array::from_fn(|k| f64::from(u8::from(k == corner))) }
        });
        let kept = VertexMap::from_fn(mesh.vertex_count(), |v| size.keeps(v));
        Self { mesh: mesh.clone(), features: features.clone(), origin, kept, report: RemeshReport::default() }
    }
}

impl TargetLength<'_> {
    /// The length at an input vertex; at those that stay, the mean of their edges.
    fn at(&self, mesh: &TriMesh, v: VertexId) -> f64 {
        let present = || {
            let (sum, edges) = mesh
                .vertex_edges(v)
                .map(|e| mesh.ends(e).map(|end| mesh.position(end)))
                .fold((0.0, 0.0), |(sum, n), [a, b]| (sum + a.distance(b), n + 1.0));
            sum / f64::max(edges, 1.0)
        };
        match self {
            Self::Uniform(length) => *length,
            Self::PerVertex(map) => map[v].unwrap_or_else(present),
        }
    }

    /// Whether an input vertex stays.
    fn keeps(&self, v: VertexId) -> bool {
        matches!(self, Self::PerVertex(map) if map[v].is_none())
    }

    /// The mean length at the corners of an input face.
    fn at_face(&self, mesh: &TriMesh, f: FaceId) -> f64 {
        match self {
            Self::Uniform(length) => *length,
            _ => mesh.face_vertices(f).map(|v| self.at(mesh, v)).iter().sum::<f64>() / 3.0,
        }
    }
}

impl<'a> Remesher<'a> {
    fn new(
        mesh: &'a TriMesh,
        features: &FeatureGraph,
        size: TargetLength<'a>,
        options: &'a RemeshOptions,
        progress: &'a Progress,
    ) -> Self {
        let Curves { curves, chains, is_curve, role } = Curves::new(mesh, features);
        let mean_size = mesh.vertices().map(|v| size.at(mesh, v)).sum::<f64>() / mesh.vertex_count().max(1) as f64;
        let surface = Surface::new(mesh, &is_curve, mean_size);
        let vertices = mesh
            .vertices()
            .map(|v| {
                let face = mesh.face(mesh.outgoing_half_edge(v)).0;
                let around = || mesh.outgoing(v).map(|h| surface.normal[mesh.face(h).index()]).sum::<DVec3>();
                let normal = if role[v] == Role::Free { around().normalize_or_zero() } else { DVec3::ZERO };
                Vertex {
                    position: mesh.position(v),
                    normal,
                    size: size.at(mesh, v),
                    error: 0.0,
                    hint: face,
                    source: v.0,
                    role: role[v],
                    kept: size.keeps(v),
                    valence: 0,
                }
            })
            .collect();
        let mut work = Work::new(mesh, surface.patch.clone(), vertices);
        for (c, (chain, curve)) in chains.iter().zip(&curves).enumerate() {
            for (i, ends) in curves::steps(chain).enumerate() {
                let side = curve.half_edge[i];
                let segment = work.segments.len() as u32;
                work.segments.push(Segment {
                    curve: c as u32,
                    ends: ends.map(|v| v.0),
                    arc: [curve.arc[i], curve.arc[i + 1]],
                });
                for h in [side, work.twin(side)].into_iter().filter(|&h| h != NONE) {
                    work.segment[h as usize] = segment;
                }
                let start = &mut work.vertices[ends[0].index()];
                if start.role == Role::OnCurve {
                    start.source = side;
                }
            }
        }
        let limits = Limits { max_deviation: options.max_deviation_rel, ..LIMITS };
        let (tally, scratch) = (Tally::default(), Vec::new());
        Self { work, surface, curves, size, options, limits, progress, ticks: 0, tally, scratch }
    }

    /// One round; the first ones aim at regular valences, the last two at angles.
    fn round(&mut self, round: usize) -> Result<(), Cancelled> {
        let goal = if round + 2 < self.options.rounds { Goal::Valence } else { Goal::Angle };
        self.split_long()?;
        self.collapse_short()?;
        self.work.compact();
        if round == 0 {
            self.adapt_sizes();
        }
        for _ in 0..2 {
            self.flip_edges(goal)?;
            self.relax()?;
        }
        Ok(())
    }

    /// Counts an operation; now and then asks whether to stop.
    fn tick(&mut self) -> Result<(), Cancelled> {
        self.ticks = self.ticks.wrapping_add(1);
        if self.ticks.is_multiple_of(4096) { self.progress.check() } else { Ok(()) }
    }
}
