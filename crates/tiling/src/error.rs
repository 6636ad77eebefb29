//! What can be wrong with a surface, costs, or a wish for tiles.
//!
//! In: ids and numbers. Out: messages that say which condition of which algorithm fails, and what to use instead.

use quadloom_mesh::{Cancelled, EdgeId, MeshError, VertexId};

/// Why there is no tiling.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TilingError {
    /// A cost is no cost.
    #[error("edge {edge} costs {cost}; costs must be numbers that are not negative (infinite: no cut may run there)")]
    Cost {
        /// The edge.
        edge: EdgeId,
        /// Its cost.
        cost: f64,
    },
    /// The number of costs is not that of the edges.
    #[error("{found} costs for {edges} edges; give one per edge, in the order of their ids")]
    CostCount {
        /// Number of costs.
        found: usize,
        /// Number of edges.
        edges: usize,
    },
    /// An option is out of range.
    #[error("{what} must be {range}, not {value}")]
    Option {
        /// What it is.
        what: &'static str,
        /// The values that are allowed.
        range: &'static str,
        /// What was given.
        value: f64,
    },
    /// The surface has several components.
    #[error("the surface has {components} components; tile each on its own")]
    Components {
        /// Number of components.
        components: usize,
    },
    /// An algorithm for closed surfaces was given one with boundary.
    #[error(
        "{algorithm} needs a closed surface, and this one has {boundaries} boundary loops; use the shortest or the \
         intermediate cutting (Algorithms 1 and 3)"
    )]
    Boundary {
        /// The algorithm.
        algorithm: &'static str,
        /// Number of boundary loops.
        boundaries: usize,
    },
    /// An algorithm for surfaces with handles was given one without.
    #[error("{algorithm} needs a surface with handles, and this one has genus 0; {instead}")]
    NoHandle {
        /// The algorithm.
        algorithm: &'static str,
        /// What to use.
        instead: &'static str,
    },
    /// The surface is no pair of pants and has none in it.
    #[error(
        "pants need a surface of negative Euler characteristic, and this one has chi = {chi} (genus {genus}, \
         {boundaries} boundary loops); cut it into a disk instead"
    )]
    NoPants {
        /// Euler characteristic.
        chi: i64,
        /// Genus.
        genus: i64,
        /// Number of boundary loops.
        boundaries: usize,
    },
    /// A base point that does not exist.
    #[error("there is no vertex {vertex} to be the base point; the last one is {last}")]
    NoVertex {
        /// The vertex.
        vertex: VertexId,
        /// The largest id.
        last: usize,
    },
    /// A path of the user's is not valid in the cell.
    #[error("the path is not valid at its vertex number {at}: {why}")]
    Path {
        /// Index in the path.
        at: usize,
        /// What is wrong.
        why: &'static str,
    },
    /// Forbidden edges leave no way.
    #[error("{what}: the edges where no cut may run leave no way; forbid fewer")]
    NoWay {
        /// What was to be cut.
        what: &'static str,
    },
    /// The user's cut does not leave disks.
    #[error(
        "the cut edges leave {tiles} pieces, and piece {tile} has genus {genus} and {boundaries} boundaries instead of \
         being a disk; add edges to the cut"
    )]
    NotDisks {
        /// Number of pieces.
        tiles: usize,
        /// The first piece that is no disk.
        tile: usize,
        /// Its genus.
        genus: i64,
        /// Its number of boundaries.
        boundaries: usize,
    },
    /// The user's cut leaves more than one tile.
    #[error("the cut edges leave {tiles} pieces where one was wanted; remove edges from the cut, or merge the tiles")]
    SeveralTiles {
        /// Number of pieces.
        tiles: usize,
    },
    /// Tiles that were to be cut into quadrangles have no even number of sides.
    #[error("tile {tile} has {sides} sides; quadrangles need an even number of at least 4")]
    Sides {
        /// The tile.
        tile: usize,
        /// Its number of sides.
        sides: usize,
    },
    /// A tile has no map of the kind asked for.
    #[error("tile {tile}: {error}")]
    Map {
        /// The tile.
        tile: usize,
        /// Why.
        error: crate::maps::MapError,
    },
    /// More elements than ids.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The run was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A fault of this program.
    #[error("internal fault while cutting: {what}; please report it with the mesh")]
    Fault {
        /// What was found.
        what: &'static str,
    },
}

impl From<crate::cut_surface::Lost> for TilingError {
    fn from(lost: crate::cut_surface::Lost) -> Self {
        Self::Fault { what: lost.0 }
    }
}
