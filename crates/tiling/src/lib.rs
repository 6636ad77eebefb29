//! M-tiles: cutting a surface into tiles, a polygon, pants, cylinders and quadrangles.
#![warn(missing_docs)]

pub mod cells;
mod classes;
mod cost;
mod cut_surface;
pub mod cutting;
mod error;
pub mod given;
pub mod ids;
pub mod maps;
pub mod pants;
pub mod quads;
mod search;
pub mod single;
pub mod tile_mesh;
pub mod tiling;
pub mod word;

pub use cost::EdgeCosts;
pub use error::TilingError;
pub use cells::{Cell, CellComplex, Side};
pub use ids::{ArcId, ArcMap, NodeId, NodeMap, TileId, TileMap};
pub use tiling::{RefinedSurface, Tiling};
pub use cutting::{Cut, CutKind, CutOptions, Cutting, Method, SearchMode};
pub use single::{cut_intermediate, cut_shortest, cut_single_point, cut_to_disk};
pub use quads::{DiagonalChoice, QuadOptions, QuadReport};
pub use pants::{cut_into_cylinders, cut_into_pants};
pub use given::cut_given;
pub use tiling::{TilingDefect, tile_from_cut};
pub use tile_mesh::{OnFailure, TileMaps, TileMesh, map_tiles};
