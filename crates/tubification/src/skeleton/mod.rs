//! The edge graph of a target map in space: what tubes are put around.
//!
//! In: a map, and where its vertices and edges go. Out: [`Skeleton`].
//! Holds, after [`Skeleton::check`]: around the normal of every vertex the edges leave in the cyclic order of the map.
//! Not: distances between edges; those decide how thick tubes can be.
//! Source: [Razafindrazaka2015] §9.2–9.4.
//!
//! Seen from the tip of the normal, the edges at a vertex are in counter-clockwise order those of the flags
//! f, fS, fS², … for an *upright* flag f. Upright is the smallest flag of a vertex and what rotations make of it; its
//! reflections are *overturned*. So the face of an upright flag is left of its edge, that of an overturned one right.

mod clearance;
pub mod relaxed;
mod ropes;
pub mod spherical;
mod starts;
pub mod symmetry;
pub mod torus;

pub use clearance::{clearance, extent};
pub use relaxed::{RelaxOptions, Relaxed, SkeletonError, Symmetry, relax, relaxed};
pub use spherical::spherical;
pub use symmetry::{Imposed, PointGroup, symmetries};
pub use torus::torus;

use glam::DVec3;
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::{FlagId, FlagMap, MapEdgeId, MapVertexId};
use quadloom_regular_maps::map::{Reflection, RegularMap};

/// A map's edge graph in space.
#[derive(Clone, Debug, PartialEq)]
pub struct Skeleton {
    /// Position of each vertex, by [`MapVertexId`].
    pub positions: Vec<DVec3>,
    /// Unit normal of the junction at each vertex.
    pub normals: Vec<DVec3>,
    /// Each edge as a polyline, by [`MapEdgeId`], from the vertex of the edge's smallest flag to the other end; the first
    /// and the last point are the vertices' positions.
    pub edges: Vec<Vec<DVec3>>,
}

/// What is wrong with a skeleton.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SkeletonDefect {
    /// Wrong number of vertices or edges, or a polyline that does not start and end at its vertices.
    #[error("the skeleton does not fit the map: {0}")]
    Shape(String),
    /// A coordinate is not finite, or a normal is not of length one.
    #[error("vertex {0} has a position that is not finite or a normal that is not of unit length")]
    NotFinite(MapVertexId),
    /// The edges at a vertex leave in another order than in the map.
    #[error("the edges at vertex {0} leave in another order than in the map")]
    Order(MapVertexId),
}

impl Skeleton {
    /// Checks the skeleton against the map's definition.
    ///
    /// # Cost       linear
    pub fn check(&self, map: &RegularMap) -> Result<(), SkeletonDefect> {
        self.check_shape(map)?;
        let upright = upright_flags(map);
        for (vertex, first) in first_flags(map) {
            let normal = self.normals[vertex.index()];
            let finite = self.positions[vertex.index()].is_finite() && (normal.length() - 1.0).abs() < 1e-9;
            if !finite {
                return Err(SkeletonDefect::NotFinite(vertex));
            }
            debug_assert!(upright[first]);
            if !self.in_order(map, vertex, first) {
                return Err(SkeletonDefect::Order(vertex));
            }
        }
        Ok(())
    }

    /// The polyline of a flag's edge, from the flag's vertex outwards.
    pub fn outward(&self, map: &RegularMap, flag: FlagId) -> Vec<DVec3> {
        let mut points = self.edges[map.edge(flag).index()].clone();
        if !starts_here(map, flag) {
            points.reverse();
        }
        points
    }

    fn check_shape(&self, map: &RegularMap) -> Result<(), SkeletonDefect> {
        let counts = [self.positions.len(), self.normals.len(), self.edges.len()];
        let wanted = [map.vertex_count(), map.vertex_count(), map.edge_count()];
        if counts != wanted {
            return Err(SkeletonDefect::Shape(format!("{counts:?} positions, normals and edges, not {wanted:?}")));
        }
        for flag in map.flags() {
            let line = self.outward(map, flag);
            let ends = [self.positions[map.vertex(flag).index()], self.positions[other_end(map, flag).index()]];
            let finite = line.iter().all(|p| p.is_finite());
            if line.len() < 2 || line[0] != ends[0] || line[line.len() - 1] != ends[1] || !finite {
                return Err(SkeletonDefect::Shape(format!("edge {} does not join its ends", map.edge(flag))));
            }
        }
        Ok(())
    }

    fn in_order(&self, map: &RegularMap, vertex: MapVertexId, first: FlagId) -> bool {
        let normal = self.normals[vertex.index()];
        let side = normal.any_orthonormal_vector();
        let up = normal.cross(side);
        let mut turn = 0.0;
        let mut before: Option<f64> = None;
        let mut flag = first;
        for _ in 0..=map.q() {
            let line = self.outward(map, flag);
            let leaving = line[1] - line[0];
            let angle = leaving.dot(up).atan2(leaving.dot(side));
            if let Some(last) = before {
                let step = (angle - last).rem_euclid(std::f64::consts::TAU);
                // Two edges in the same direction have no order.
                if !(step > 1e-6 || map.q() == 1) {
                    return false;
                }
                turn += step;
            }
            before = Some(angle);
            flag = map.walk(flag, &[Reflection::R1, Reflection::R2]);
        }
        (turn - std::f64::consts::TAU).abs() < 1e-6
    }
}

/// The skeleton of a map that has a model of its own: on the sphere or on a torus; none for other maps.
pub fn exact(map: &RegularMap) -> Option<Skeleton> {
    spherical(map).or_else(|| torus(map))
}

/// Whether a flag's edge is stored from the flag's vertex outwards: the edge's smallest flag and its mirror image r₂ start
/// there.
pub fn starts_here(map: &RegularMap, flag: FlagId) -> bool {
    let there = map.reflect(flag, Reflection::R0);
    let [a, b] = [flag, there].map(|f| f.min(map.reflect(f, Reflection::R2)));
    a < b
}

/// Whether each flag is upright at its vertex: reached from the vertex's smallest flag by an even number of r₁ and r₂.
pub fn upright_flags(map: &RegularMap) -> FlagMap<bool> {
    let mut upright = FlagMap::from_vec(vec![false; map.order()]);
    for (_, first) in first_flags(map) {
        let mut flag = first;
        for _ in 0..map.q() {
            upright[flag] = true;
            flag = map.walk(flag, &[Reflection::R1, Reflection::R2]);
        }
    }
    upright
}

/// The smallest flag of each vertex.
pub fn first_flags(map: &RegularMap) -> Vec<(MapVertexId, FlagId)> {
    let mut seen = vec![false; map.vertex_count()];
    let flags = map.flags().map(|flag| (map.vertex(flag), flag));
    flags.filter(|(vertex, _)| !std::mem::replace(&mut seen[vertex.index()], true)).collect()
}

/// The smallest flag of each edge, by [`MapEdgeId`].
pub fn edge_flags(map: &RegularMap) -> Vec<(MapEdgeId, FlagId)> {
    let mut seen = vec![false; map.edge_count()];
    let flags = map.flags().map(|flag| (map.edge(flag), flag));
    flags.filter(|(edge, _)| !std::mem::replace(&mut seen[edge.index()], true)).collect()
}

/// The vertex at the other end of a flag's edge.
pub fn other_end(map: &RegularMap, flag: FlagId) -> MapVertexId {
    map.vertex(map.reflect(flag, Reflection::R0))
}
