//! Why a tile has no map.
//!
//! In: ids and numbers. Out: messages that say what is wrong with the tile or its corners, and what to do.

use super::MapMethod;
use quadloom_mesh::{Cancelled, EdgeId, FaceId, MeshError, VertexId};

/// Why there is no map of a tile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The mesh is no disk.
    #[error(
        "the mesh is no disk: {components} components, genus {genus}, {boundaries} boundary loops; cut it open \
         first, and map one tile at a time"
    )]
    NotDisk {
        /// Number of components.
        components: usize,
        /// Sum of the components' genera.
        genus: i64,
        /// Number of boundary loops.
        boundaries: usize,
    },
    /// A map with a fixed border was wanted and no corner given.
    #[error("a fixed border needs at least one corner; give a boundary vertex")]
    NoCorner,
    /// A corner is not a boundary vertex of the mesh.
    #[error("corner {vertex} is no boundary vertex of the mesh")]
    CornerNotOnBorder {
        /// The corner.
        vertex: VertexId,
    },
    /// A corner repeats or lies out of order.
    #[error("corner {vertex} does not follow the one before it counter-clockwise along the boundary, or repeats one")]
    CornerOrder {
        /// The corner.
        vertex: VertexId,
    },
    /// The number of parameters is not that of the vertices.
    #[error("{found} side parameters for {vertices} vertices; give one per vertex, in the order of their ids")]
    SideParameterCount {
        /// Number of parameters.
        found: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A parameter does not lie between those of its neighbours.
    #[error("side parameter {value} of {vertex} is not above that of the vertex before it and below 1")]
    SideParameter {
        /// The vertex.
        vertex: VertexId,
        /// Its parameter.
        value: f64,
    },
    /// An edge inside the tile has both ends on one straight side.
    #[error(
        "{count} edges inside the tile have both ends on one side, the first is {edge}: they would fall on the \
         border; split them first (split_side_edges)"
    )]
    EdgeOnSide {
        /// The first of them.
        edge: EdgeId,
        /// How many there are.
        count: usize,
    },
    /// An edge is too long for its square to be a number.
    #[error("edge {edge} is too long to be measured; scale the mesh down")]
    TooLong {
        /// The edge.
        edge: EdgeId,
    },
    /// The map folds.
    #[error("the {method} map folds {count} faces over, the first is {face}, after {rounds} rounds; {advice}")]
    Folded {
        /// The first folded face.
        face: FaceId,
        /// Number of folded faces.
        count: usize,
        /// How the tile was mapped.
        method: MapMethod,
        /// Number of rounds.
        rounds: usize,
        /// What to use instead.
        advice: &'static str,
    },
    /// An iteration did not reach its end.
    #[error("the {method} map did not converge: {residual:e} radians are left after {rounds} rounds")]
    NotConverged {
        /// How the tile was mapped.
        method: MapMethod,
        /// Number of rounds.
        rounds: usize,
        /// Largest error of a sum of angles, or of a wheel condition relative to its derivative.
        residual: f64,
    },
    /// A linear system could not be solved.
    #[error("the linear system of the {method} map could not be solved: {what}")]
    Solve {
        /// How the tile was mapped.
        method: MapMethod,
        /// What the solver says.
        what: String,
    },
    /// More elements than ids.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The run was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
